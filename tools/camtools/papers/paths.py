"""Ring-helix, helices and steps, in theory and cut, MATHS.md (40) .. (43), (100).

>>> study = make_study(0.0, 62.0, 0.2, 1000.0, 0.8, MachineLimits())
>>> [(one.path.turns, f"{one.scallop_um.max():.4f}") for one in study.rows]
[(621.0, '6.2500'), (620.0, '1.5625'), (310.0, '6.2500')]
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import UM_PER_MM, Floats
from camtools.base.text import Json, csv_text
from camtools.cut.path import ToolPath, highest_rpm, highest_step_rpm, ramp_of, step_of
from camtools.part.common import MachineLimits
from camtools.sim.machine_file import Machine, machine_text
from camtools.sim.simulate import Result, simulate
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.report.summary import make_summary
from camtools.skirt.table.generate import generate
from camtools.table.image import Table
from camtools.table.summary import table_files

N_ANGLES, N_HEIGHTS = 240, 401  # of a map of the surface
_SECTIONS = 4  # of the map
_NEARLY = 1 - 1e-9


class PathRow(NamedTuple):
    """A path of the part in theory."""

    name: str
    path: ToolPath
    rpm: float
    z_speed_mm_s: float  # largest
    z_acceleration_mm_s2: float  # within the path, its ends not counted
    scallop_um: Floats  # shape (N_ANGLES, N_HEIGHTS), from angle 0 on

    @property
    def time_s(self) -> float:
        """Return the duration of the path."""
        return self.path.turns * 60 / self.rpm


class PathStudy(NamedTuple):
    """The comparison, and the heights of its maps."""

    rows: tuple[PathRow, ...]
    z_mm: Floats  # shape (N_HEIGHTS,)
    nose_mm: float
    stepped: PathRow  # Z stands during each turn; no controller plays it


def make_study(
    z_first_mm: float,
    z_last_mm: float,
    feed_mm: float,
    rpm: float,
    nose_mm: float,
    limits: MachineLimits,
) -> PathStudy:
    """Return the comparison of a ring-helix with helices of as many turns and of the same lead.

    The feed is section distance and lead of the ring-helix, at most the height range; that is
    turned more slowly where Z cannot follow.
    """
    middle = round((z_last_mm - z_first_mm) / feed_mm / 2 - _SECTIONS / 2)
    low = z_first_mm + feed_mm * max(0, middle)
    z_mm = np.linspace(low, min(low + _SECTIONS * feed_mm, z_last_mm), N_HEIGHTS)

    def row(name: str, kind: str, feed_mm: float, rpm: float, ramp: float, step: float) -> PathRow:
        path = ToolPath(kind, z_first_mm, z_last_mm, feed_mm, ramp, step)
        per_s = rpm / 60 / (step or 1.0)  # of the motion of Z: a turn, or a step
        acceleration = feed_mm * per_s**2 / (ramp * (1 - ramp)) if ramp > 0 else 0.0
        speed = feed_mm * per_s / (1 - ramp)
        angles = np.arange(N_ANGLES) / N_ANGLES
        scallop = np.stack([path.scallop_mm(float(angle), z_mm, nose_mm) for angle in angles])
        return PathRow(name, path, rpm, speed, acceleration, scallop * UM_PER_MM)

    ring_rpm = min(rpm, highest_rpm(feed_mm, limits) * _NEARLY)
    step_rpm = min(rpm, highest_step_rpm(feed_mm, limits) * _NEARLY)
    step, step_ramp = step_of(feed_mm, step_rpm, limits)
    ramp = ramp_of(feed_mm, ring_rpm, limits)
    rows = (
        row("ring-helix", "ring-helix", feed_mm, ring_rpm, ramp, 0.0),
        row("helix, half the feed", "helix", feed_mm / 2, rpm, 0.0, 0.0),
        row("helix", "helix", feed_mm, rpm, 0.0, 0.0),
    )
    stepped = row("stepped", "stepped", feed_mm, step_rpm, step_ramp, step)
    return PathStudy(rows, z_mm, nose_mm, stepped)


def study_csv(study: PathStudy, slope: float) -> str:
    """Return the comparison as CSV; the largest slope of the profile times a step is its edge."""
    rows = (*study.rows, study.stepped)
    paths = [one.path for one in rows]
    edges = [slope * one.feed_mm * UM_PER_MM if one.kind == "stepped" else 0.0 for one in paths]
    return csv_text(
        {
            "path": ([f'"{one.name}"' for one in rows], ""),
            "feed_mm": ([one.feed_mm for one in paths], 6),
            "turns": ([one.turns for one in paths], 3),
            "rpm": ([one.rpm for one in rows], 3),
            "time_s": ([one.time_s for one in rows], 3),
            "z_ramp_turns": ([one.ramp * (one.step or 1.0) for one in paths], 6),
            "z_speed_mm_s": ([one.z_speed_mm_s for one in rows], 4),
            "z_acceleration_mm_s2": ([one.z_acceleration_mm_s2 for one in rows], 2),
            "scallop_max_um": ([one.scallop_um.max() for one in rows], 4),
            "scallop_mean_um": ([one.scallop_um.mean() for one in rows], 4),
            "step_turns": ([one.step for one in paths], 6),
            "edge_um": (edges, 4),
        }
    )


def cut_table(
    table: Table, summary: Json, machine: str, options: Sequence[str], *, scallop: bool = False
) -> Result:
    """Cut a table, gauged by its summary, on a machine of this text.

    Raises CamtoolsError where the simulator refuses it.
    """
    with tempfile.TemporaryDirectory(prefix="camturn-papers.") as name:
        for file, data in table_files(table, summary).items():
            Path(name, file).write_bytes(data)
        path = Path(name, f"{table.part_name}.camtab")
        return simulate(path, Machine("machine", machine), options=options, scallop=scallop)


def peak_to_valley(map_um: Floats) -> Floats:
    """Return the height of the scallops at every angle of a map."""
    return np.asarray(map_um.max(axis=1) - map_um.min(axis=1), dtype=np.float64)


class PathCut(NamedTuple):
    """A path of the part in theory, and as the simulator measured it."""

    row: PathRow
    turns: float  # of the state cutting
    time_s: float
    form_error_um: float
    proud_um: Floats  # shape (N_ANGLES, N_HEIGHTS), above the exact surface

    @property
    def scallop_um(self) -> Floats:
        """Return the measured peak to valley at every angle."""
        return peak_to_valley(self.proud_um)

    @property
    def predicted_um(self) -> Floats:
        """Return the predicted peak to valley at every angle."""
        return peak_to_valley(self.row.scallop_um)

    @property
    def mean_um(self) -> float:
        """Return the mean height above the deepest point of each angle."""
        return float((self.proud_um - self.proud_um.min(axis=1)[:, None]).mean())


def _turned(part: SkirtPart, path: str) -> SkirtPart:
    process = part.process.model_copy(update={"path": path, "mode": "uniform"})
    return part.model_copy(update={"process": process})


def cut_paths(part: SkirtPart, nose_mm: float) -> tuple[PathStudy, tuple[PathCut, ...]]:
    """Cut a part along a ring-helix and along helices of as many turns and of the same lead.

    Raises CamtoolsError where the part is impossible, Z cannot follow, or a cut failed.
    """
    tool = part.tool.model_copy(update={"nose_radius_mm": nose_mm})
    made = generate(_turned(part, "ring-helix").model_copy(update={"tool": tool}))
    geometry, process, limits = made.geometry, part.process, part.machine.limits
    ends = geometry.z_first_mm, geometry.z_last_mm
    study = make_study(*ends, process.feed_mm, process.spindle_rpm, nose_mm, limits)
    heights = f"{study.z_mm[0]:.9g}:{study.z_mm[-1]:.9g}"
    cuts = []
    for row in study.rows:
        kind = row.path.kind
        table = replace(made.table, is_ring_helix=kind == "ring-helix")
        summary = make_summary(replace(made, part=_turned(made.part, kind), table=table))
        options = ["--rpm", repr(row.rpm), "--feed", repr(row.path.feed_mm)]
        options += ["--nose-mm", repr(nose_mm), "--scallop-mm", heights]
        result = cut_table(table, summary, machine_text(limits), options, scallop=True)
        if result.status != 0:
            problem = f"{row.name}: {result.message}"
            raise CamtoolsError([f"{problem}; change the part or give another --rpm"])
        done, form_um = result.summary["cut"], result.summary["form_error_um"]["max"]
        proud_um = result.scallop["proud_um"].reshape(N_ANGLES, N_HEIGHTS)
        cuts.append(PathCut(row, done["turns"], done["seconds"], form_um, proud_um))
    return study, tuple(cuts)


def cuts_csv(cuts: Sequence[PathCut]) -> str:
    """Return theory and measurement of every path as CSV."""
    rows = [one.row for one in cuts]
    return csv_text(
        {
            "path": ([f'"{one.name}"' for one in rows], ""),
            "feed_mm": ([one.path.feed_mm for one in rows], 4),
            "rpm": ([one.rpm for one in rows], 4),
            "turns": ([one.path.turns for one in rows], 4),
            "turns_measured": ([one.turns for one in cuts], 4),
            "time_s": ([one.time_s for one in rows], 4),
            "time_measured_s": ([one.time_s for one in cuts], 4),
            "scallop_max_um": ([one.predicted_um.max() for one in cuts], 4),
            "scallop_max_measured_um": ([one.scallop_um.max() for one in cuts], 4),
            "scallop_mean_um": ([one.scallop_um.mean() for one in rows], 4),
            "scallop_mean_measured_um": ([one.mean_um for one in cuts], 4),
            "form_error_um": ([one.form_error_um for one in cuts], 4),
        }
    )


def cuts_text(cuts: Sequence[PathCut]) -> str:
    """Return the table for people."""
    lines = [f"{'path':21s} {'turns':>8s} {'time':>8s} {'scallop, largest':>20s} {'mean':>16s}"]
    lines.append(f"{'':21s} {'cut':>8s} {'s':>8s} {'measured (worked out)':>23s} um")
    lines += [
        f"{one.row.name:21s} {one.turns:8.1f} {one.time_s:8.2f} "
        f"{one.scallop_um.max():10.3f} ({one.predicted_um.max():.3f}) "
        f"{one.mean_um:10.3f} ({one.row.scallop_um.mean():.3f})"
        for one in cuts
    ]
    return "\n".join(lines) + "\n"
