"""Ring-helix beside helices and steps: turns, time, Z, scallops, MATHS.md (40) .. (43), (100).

>>> study = make_study(0.0, 62.0, 0.2, 1000.0, 0.8, MachineLimits())
>>> [(one.path.turns, f"{one.scallop_um.max():.4f}") for one in study.rows]
[(621.0, '6.2500'), (620.0, '1.5625'), (310.0, '6.2500')]
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.csv_text import csv_text
from camtools.base.quantities import Floats
from camtools.cut.path import ToolPath, highest_rpm, highest_step_rpm, ramp_of, step_of
from camtools.part.common import MachineLimits

N_ANGLES, N_HEIGHTS = 240, 401
_SECTIONS = 4  # of the map
_UM_PER_MM = 1000.0


class PathRow(NamedTuple):
    """A path of the part with what theory says of it."""

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


def _row(name: str, path: ToolPath, rpm: float, z_mm: Floats, nose_mm: float) -> PathRow:
    per_s, r = rpm / 60 / (path.step or 1.0), path.ramp  # of what moves Z: a turn, or a step
    acceleration = path.feed_mm * per_s**2 / (r * (1 - r)) if r > 0 else 0.0
    angles = np.arange(N_ANGLES) / N_ANGLES
    scallop = np.stack([path.scallop_mm(float(angle), z_mm, nose_mm) for angle in angles])
    speed = path.feed_mm * per_s / (1 - r)
    return PathRow(name, path, rpm, speed, acceleration, scallop * _UM_PER_MM)


def make_study(
    z_first_mm: float,
    z_last_mm: float,
    feed_mm: float,
    rpm: float,
    nose_mm: float,
    limits: MachineLimits,
) -> PathStudy:
    """Return the comparison of a ring-helix with helices of as many turns and of the same lead.

    Parameters
    ----------
    feed_mm : float
        Section distance and lead of the ring-helix, at most the height range.
    rpm : float
        Wanted speed; the ring-helix is turned more slowly where Z cannot follow [r/min].
    """
    ring_rpm = min(rpm, highest_rpm(feed_mm, limits) * (1 - 1e-9))
    ramp = ramp_of(feed_mm, ring_rpm, limits)
    middle = round((z_last_mm - z_first_mm) / feed_mm / 2 - _SECTIONS / 2)
    low = z_first_mm + feed_mm * max(0, middle)
    z_mm = np.linspace(low, min(low + _SECTIONS * feed_mm, z_last_mm), N_HEIGHTS)
    ends = z_first_mm, z_last_mm
    step_rpm = min(rpm, highest_step_rpm(feed_mm, limits) * (1 - 1e-9))
    step, step_ramp = step_of(feed_mm, step_rpm, limits)
    steps = ToolPath("stepped", *ends, feed_mm, step_ramp, step)
    rows = (
        _row("ring-helix", ToolPath("ring-helix", *ends, feed_mm, ramp), ring_rpm, z_mm, nose_mm),
        _row("helix, half the feed", ToolPath("helix", *ends, feed_mm / 2), rpm, z_mm, nose_mm),
        _row("helix", ToolPath("helix", *ends, feed_mm), rpm, z_mm, nose_mm),
    )
    stepped = _row("stepped", steps, step_rpm, z_mm, nose_mm)
    return PathStudy(rows, z_mm, nose_mm, stepped)


def csv(study: PathStudy, slope: float) -> str:
    """Return the comparison as CSV.

    Parameters
    ----------
    slope : float
        Largest slope of the profile, |da/dz|: times a step it is the edge that the step leaves.
    """
    rows = (*study.rows, study.stepped)
    paths = [one.path for one in rows]
    edges = [slope * one.feed_mm * _UM_PER_MM if one.kind == "stepped" else 0.0 for one in paths]
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
