"""Ring-helix, helices and steps in theory and drawn, MATHS.md (40) .. (43), (100).

>>> study = make_study(0.0, 62.0, 0.2, 1000.0, 0.8, MachineLimits())
>>> [(row.path.turns, f"{row.scallop_um.max():.4f}") for row in study.rows]
[(621.0, '6.2500'), (620.0, '1.5625'), (310.0, '6.2500')]
>>> sorted(drawers("a", study))
['path_scallop', 'path_unrolled']
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.quantities import UM_PER_MM, Floats
from camtools.base.text import csv_text
from camtools.cut.path import ToolPath, highest_rpm, highest_step_rpm, ramp_of, step_of
from camtools.part.common import MachineLimits
from camtools.plots.style import BLUE, GREY, ORANGE, Drawers, angle_axis, legend_below, new_figure

N_ANGLES, N_HEIGHTS = 240, 401  # of a map of the surface
_SECTIONS = 4  # of the map
_NEARLY = 1 - 1e-9
_DEG = np.linspace(0, 360, 361)


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
    paths = [row.path for row in rows]
    edges = [slope * path.feed_mm * UM_PER_MM if path.kind == "stepped" else 0.0 for path in paths]
    return csv_text(
        {
            "path": ([f'"{row.name}"' for row in rows], ""),
            "feed_mm": ([path.feed_mm for path in paths], 6),
            "turns": ([path.turns for path in paths], 3),
            "rpm": ([row.rpm for row in rows], 3),
            "time_s": ([row.time_s for row in rows], 3),
            "z_ramp_turns": ([path.ramp * (path.step or 1.0) for path in paths], 6),
            "z_speed_mm_s": ([row.z_speed_mm_s for row in rows], 4),
            "z_acceleration_mm_s2": ([row.z_acceleration_mm_s2 for row in rows], 2),
            "scallop_max_um": ([row.scallop_um.max() for row in rows], 4),
            "scallop_mean_um": ([row.scallop_um.mean() for row in rows], 4),
            "step_turns": ([path.step for path in paths], 6),
            "edge_um": (edges, 4),
        }
    )


def _track(axes: Axes, path: ToolPath, low_mm: float, high_mm: float) -> None:
    """Draw every turn that touches the heights: rings blue, helix turns orange."""
    names = [("closed ring", BLUE), ("turn of a helix", ORANGE)]
    for turn in range(int(np.ceil(path.turns))):
        z = path.height_mm(turn + _DEG / 360)
        if z[-1] >= low_mm and z[0] <= high_mm:
            name, colour = names[not (path.kind == "ring-helix" and turn % 2 == 0)]
            label = "_" if name in axes.get_legend_handles_labels()[1] else name
            axes.plot(_DEG, z, color=colour, lw=1.8, label=label)
    angle_axis(axes)


def draw_unrolled(name: str, study: PathStudy) -> Figure:
    """Return the paths on the unrolled skirt, over the heights of the maps."""
    figure = new_figure(10, 5.2)
    figure.suptitle(f"{name}: two paths of as many turns, unrolled")
    panels = figure.subplots(1, 2, sharey=True)
    low, high = float(study.z_mm[0]), float(study.z_mm[-1])
    path = study.rows[0].path
    room = 0.1 * path.feed_mm
    for axes, row in zip(panels, study.rows, strict=False):
        _track(axes, row.path, low, high)
        axes.set(title=f"{row.name}, {row.path.feed_mm:g} mm", ylim=(low - room, high + room))
        axes.grid(alpha=0.3)
    straight = ToolPath(path.kind, path.z_first_mm, path.z_last_mm, path.feed_mm)
    first = 2 * round((low - straight.z_first_mm) / straight.feed_mm) + 1
    printed = straight.height_mm(first + _DEG / 360)
    panels[0].plot(_DEG, printed, color=GREY, ls="--", lw=1, label="as printed, without ramps")
    panels[0].set_ylabel("skirt height, mm")
    legend_below(figure, panels[0], 3)
    return figure


def draw_scallop(name: str, study: PathStudy) -> Figure:
    """Return maps of the metal left between the tracks."""
    rows = study.rows[:2]
    figure = new_figure(10, 5.2)
    nose = f"nose radius {study.nose_mm:g} mm, {study.rows[0].rpm:g} r/min"
    figure.suptitle(f"{name}: metal left between the tracks, {nose}")
    highest = max(float(row.scallop_um.max()) for row in rows)
    extent = (0.0, 360.0, float(study.z_mm[0]), float(study.z_mm[-1]))
    panels = figure.subplots(1, 2)
    for axes, row in zip(panels, rows, strict=True):
        map_um = np.r_[row.scallop_um, row.scallop_um[:1]].T
        image = axes.imshow(
            map_um, extent=extent, origin="lower", aspect="auto", vmin=0, vmax=highest
        )
        angle_axis(axes)
        axes.set_title(f"{row.name}, {row.path.feed_mm:g} mm: worked out")
    panels[0].set_ylabel("skirt height, mm")
    figure.colorbar(image, ax=panels, label="above the design, µm")
    return figure


def drawers(name: str, study: PathStudy) -> Drawers:
    """Return the makers of the pictures of the theory by topic."""
    return {
        "path_unrolled": partial(draw_unrolled, name, study),
        "path_scallop": partial(draw_scallop, name, study),
    }
