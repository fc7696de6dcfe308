"""Ring-helix and plain helices of a part, cut on the simulator with a round nose, beside theory.

>>> grid(np.arange(N_ANGLES * N_HEIGHTS, dtype=np.float64)).shape == (N_ANGLES, N_HEIGHTS)
True
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pyarrow import csv as csv_file

from camtools.base.csv_text import csv_text
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.sim.camsim import Simulator, machine_text
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.report.summary import make_summary
from camtools.skirt.table.generate import GeneratedSkirt, generate
from camtools.study.path import N_ANGLES, N_HEIGHTS, PathRow, PathStudy, make_study
from camtools.table.summary import table_files

_MACHINE = "machine.toml"


def peak_to_valley(map_um: Floats) -> Floats:
    """Return the height of the scallops at every angle of a map."""
    return np.asarray(map_um.max(axis=1) - map_um.min(axis=1), dtype=np.float64)


class PathCut(NamedTuple):
    """A path of the part: what theory says of it, and what the simulator measured."""

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
    def mean_um(self) -> float:
        """Return the mean height above the deepest place of each angle."""
        return float((self.proud_um - self.proud_um.min(axis=1)[:, None]).mean())


def grid(column: Floats) -> Floats:
    """Return a column of camsim's table of the surface as a map."""
    return column.reshape(N_ANGLES, N_HEIGHTS)


def read_scallop(path: Path) -> Floats:
    """Return the map of a table that `camsim run --scallop` wrote [um]."""
    return grid(csv_file.read_csv(path).column(2).to_numpy())


def with_path(part: SkirtPart, path: str) -> SkirtPart:
    """Return the part along another path."""
    process = part.process.model_copy(update={"path": path, "mode": "uniform"})
    return part.model_copy(update={"process": process})


def with_nose(part: SkirtPart, nose_mm: float) -> SkirtPart:
    """Return the part turned with a nose of this radius."""
    tool = part.tool.model_copy(update={"nose_radius_mm": nose_mm})
    return part.model_copy(update={"tool": tool})


def _write_tables(generated: GeneratedSkirt, folder: Path) -> dict[str, Path]:
    """Write the table of each path into a folder of its own; return the tables."""
    found = {}
    for path in ("ring-helix", "helix"):
        one = replace(generated, part=with_path(generated.part, path))
        table = replace(generated.table, is_ring_helix=path == "ring-helix")
        (folder / path).mkdir()
        for name, data in table_files(table, make_summary(replace(one, table=table))).items():
            (folder / path / name).write_bytes(data)
        found[path] = Path(path) / f"{generated.table.part_name}.camtab"
    return found


def _cut(simulator: Simulator, study: PathStudy, row: PathRow) -> PathCut:
    """Cut along one path.

    Raises
    ------
    CamtoolsError
        The simulator refuses it, or it did not come to its end.
    """
    low, high = float(study.z_mm[0]), float(study.z_mm[-1])
    words = [
        *("--machine", _MACHINE, "--rpm", repr(row.rpm), "--feed", repr(row.path.feed_mm)),
        *("--nose-mm", repr(study.nose_mm), "--scallop-mm", f"{low:.9g}:{high:.9g}"),
        *("--scallop", "scallop.csv"),
    ]
    ending = simulator.run(words, is_quiet=True)
    if ending.status != 0:
        problem = f"{row.name}: {ending.message}"
        raise CamtoolsError([f"{problem}; change the part or give another --rpm"])
    summary = ending.summary
    done = summary["cut"]
    proud_um = read_scallop(simulator.folder / "scallop.csv")
    form_um = summary["form_error_um"]["max"]
    return PathCut(row, done["turns"], done["seconds"], form_um, proud_um)


def cut_paths(
    part: SkirtPart, nose_mm: float, folder: Path
) -> tuple[PathStudy, tuple[PathCut, ...]]:
    """Cut a part along a ring-helix and along helices of as many turns and of the same lead.

    Parameters
    ----------
    folder : Path
        Empty; tables and results of the simulator go there.

    Raises
    ------
    CamtoolsError
        The part is impossible, Z cannot follow the ring-helix, or a cut failed.
    """
    generated = generate(with_nose(with_path(part, "ring-helix"), nose_mm))
    geometry, process = generated.geometry, part.process
    study = make_study(
        *(geometry.z_first_mm, geometry.z_last_mm, process.feed_mm, process.spindle_rpm),
        *(nose_mm, part.machine.limits),
    )
    tables = _write_tables(generated, folder)
    (folder / _MACHINE).write_text(machine_text(part.machine.limits), encoding="ascii")
    cuts = [_cut(Simulator(folder, str(tables[row.path.kind])), study, row) for row in study.rows]
    return study, tuple(cuts)


def predicted_scallop_um(row: PathRow) -> Floats:
    """Return the predicted peak to valley at every angle."""
    return peak_to_valley(row.scallop_um)


def csv(cuts: Sequence[PathCut]) -> str:
    """Return both figures of every path as CSV."""
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
            "scallop_max_um": ([predicted_scallop_um(one).max() for one in rows], 4),
            "scallop_max_measured_um": ([one.scallop_um.max() for one in cuts], 4),
            "scallop_mean_um": ([one.scallop_um.mean() for one in rows], 4),
            "scallop_mean_measured_um": ([one.mean_um for one in cuts], 4),
            "form_error_um": ([one.form_error_um for one in cuts], 4),
        }
    )


def text(cuts: Sequence[PathCut]) -> str:
    """Return the table for people."""
    lines = [f"{'path':21s} {'turns':>8s} {'time':>8s} {'scallop, largest':>20s} {'mean':>16s}"]
    lines.append(f"{'':21s} {'cut':>8s} {'s':>8s} {'measured (worked out)':>23s} um")
    for one in cuts:
        row = one.row
        most, mean = predicted_scallop_um(row).max(), row.scallop_um.mean()
        lines.append(
            f"{row.name:21s} {one.turns:8.1f} {one.time_s:8.2f} "
            f"{one.scallop_um.max():10.3f} ({most:.3f}) {one.mean_um:10.3f} ({mean:.3f})"
        )
    return "\n".join(lines) + "\n"
