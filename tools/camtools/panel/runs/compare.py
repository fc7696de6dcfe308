"""What differs between runs: part files, what they were cut with, figures, errors as curves.

>>> same = ComparedFigure("form error", "um", (0.25, 0.5))
>>> same.difference(1), same.text(0)
('+0.25', '0.25')
"""

import difflib
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from camtools.base.quantities import DEG_PER_TURN, Floats
from camtools.base.text import Json
from camtools.panel.runs.store import PART, Run, summary_of
from camtools.panel.views.echart import COLOURS, INK, TURN, Options, axis, line, titled
from camtools.sim.results import (
    CUTTING,
    SURFACE,
    TRACE,
    GaugedSurface,
    read_surface,
    read_trace,
)

_DIFF_CONTEXT = 2
_MAX_PART_BYTES = 1_000_000
N_HEIGHTS, N_ANGLES = 60, 120  # cells of a map, points of a curve
_REMEMBERED = 4  # files of runs that are compared


class ComparedFigure(NamedTuple):
    """A number of each run."""

    name: str
    unit: str
    values: tuple[float | None, ...]

    def text(self, i: int) -> str:
        """Return the number of a run."""
        value = self.values[i]
        return "none" if value is None else f"{value:.5g}"

    def difference(self, i: int) -> str:
        """Return by how much a run differs from the first one."""
        first, value = self.values[0], self.values[i]
        return "" if first is None or value is None else f"{value - first:+.4g}"


class DiffLine(NamedTuple):
    """A line of what differs between two texts."""

    kind: str  # " ", "-", "+" or "@"
    text: str


def _text_of(path: Path) -> str | None:
    if path.is_symlink() or not path.is_file() or path.stat().st_size > _MAX_PART_BYTES:
        return None
    return path.read_text(encoding="utf-8", errors="replace")


def part_text(run: Run) -> str | None:
    """Return the part file of a run, nothing where it is not kept."""
    return _text_of(run.folder / PART)


def machine_text_of(run: Run) -> str | None:
    """Return the machine file that a run was cut on."""
    texts = map(_text_of, sorted(run.folder.glob("*_machine.toml")))
    return next((text for text in texts if text is not None), None)


def differing(first: str | None, second: str | None) -> list[DiffLine]:
    """Return the lines that differ between two texts, with their neighbours; nothing: alike."""
    if first is None or second is None:
        missing = "the first" if first is None else "the other"
        return [] if first == second else [DiffLine("@", f"{missing} run does not have it")]
    texts = first.splitlines(), second.splitlines()
    rows = list(difflib.unified_diff(*texts, n=_DIFF_CONTEXT, lineterm=""))[2:]
    return [DiffLine("@", row) if row[0] == "@" else DiffLine(row[0], row[1:]) for row in rows]


def settings_rows(runs: Sequence[Run]) -> list[tuple[str, list[str]]]:
    """Return what runs were cut with: a row for each setting, a text for each run."""
    summaries = [summary_of(run.folder) or {} for run in runs]
    cuts = [summary.get("cut", {}) for summary in summaries]
    return [
        ("part", [run.part for run in runs]),
        ("machine", [run.machine or run.options.machine or "of the part" for run in runs]),
        ("speed / r/min", [_text(cut.get("spindle_rpm")) for cut in cuts]),
        ("feed / mm", [_text(cut.get("feed_mm")) for cut in cuts]),
        ("learning", [_learning(summary) for summary in summaries]),
        ("seed", [_text(summary.get("seed")) for summary in summaries]),
        ("table", [_text(summary.get("table_bytes")) + " bytes" for summary in summaries]),
        ("CRC of the table", [_text(summary.get("table_crc32"), "08x") for summary in summaries]),
        ("verdict", [run.verdict or run.status for run in runs]),
    ]


def _text(value: object, form: str = "g") -> str:
    return f"{value:{form}}" if isinstance(value, int | float) else "?"


def _learning(summary: Json) -> str:
    about = summary.get("learning", {})
    if not about:
        return "?"
    return f"on, {about.get('turns', 0):g} turns" if about.get("is_on") else "off"


_FIGURES: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("form error, largest", "um", ("form_error_um", "max")),
    ("form error, rms", "um", ("form_error_um", "rms")),
    ("roundness error", "um", ("form_error_um", "roundness")),
    ("tolerance", "um", ("form_error_um", "tolerance")),
    ("following error, largest", "um", ("following_error_um", "max")),
    ("following error, rms", "um", ("following_error_um", "rms")),
    ("height of the largest form error", "mm", ("form_error_um", "max_at_z_mm")),
    ("U speed needed", "mm/s", ("feasibility", "u_speed_mm_s", "needed")),
    ("U acceleration needed", "mm/s2", ("feasibility", "u_acceleration_mm_s2", "needed")),
    ("highest feasible speed", "r/min", ("feasibility", "highest_rpm")),
    ("turns", "", ("cut", "turns")),
    ("machine time", "s", ("machine_time_s",)),
    ("computing time of the cut", "s", ("wall_time_s",)),
)


def figures_of(runs: Sequence[Run]) -> list[ComparedFigure]:
    """Return the figures of runs, from their summaries."""
    summaries = [summary_of(run.folder) or {} for run in runs]
    figures = (
        ComparedFigure(name, unit, tuple(_number(summary, path) for summary in summaries))
        for name, unit, path in _FIGURES
    )
    return [figure for figure in figures if any(value is not None for value in figure.values)]


def _number(summary: Json, path: tuple[str, ...]) -> float | None:
    value: Any = summary
    for step in path:
        value = value.get(step) if isinstance(value, dict) else None
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if is_number else None


class ErrorCurves(NamedTuple):
    """Errors of a run, ready to be drawn."""

    z_mm: Floats  # shape (N_HEIGHTS,): middles of bands of the height
    worst_um: Floats  # largest magnitude of the form error in each band
    map_um: Floats  # shape (N_HEIGHTS, N_ANGLES): of each cell the error of largest magnitude
    angle_deg: Floats  # shape (N_ANGLES,): middles
    following_um: Floats | None  # shape (N_ANGLES,): mean of the following error while cutting


def cells_of(surface: GaugedSurface, heights_mm: tuple[float, float]) -> Floats:
    """Return the form error of largest magnitude in each cell of a map, NaN where nothing is."""
    low, high = heights_mm
    row = np.floor((surface.z_mm - low) / max(high - low, 1e-9) * N_HEIGHTS).astype(np.int64)
    column = np.floor(np.mod(surface.turn, 1.0) * N_ANGLES).astype(np.int64)
    inside = (row >= 0) & (row <= N_HEIGHTS)
    cell = np.minimum(row, N_HEIGHTS - 1) * N_ANGLES + np.minimum(column, N_ANGLES - 1)
    found = np.full(N_HEIGHTS * N_ANGLES, np.nan)
    order = np.argsort(np.abs(surface.error_um[inside]), kind="stable")  # the largest comes last
    found[cell[inside][order]] = surface.error_um[inside][order]
    return found.reshape(N_HEIGHTS, N_ANGLES)


def _stamp(path: Path) -> int | None:
    return None if path.is_symlink() or not path.is_file() else path.stat().st_mtime_ns


@lru_cache(maxsize=_REMEMBERED)
def _surface(path: Path, _written_ns: int) -> GaugedSurface:
    """Read a surface once for all curves and sections."""
    return read_surface(path)


def _surface_of(folder: Path) -> GaugedSurface | None:
    path = folder / SURFACE
    written_ns = _stamp(path)
    return None if written_ns is None else _surface(path, written_ns)


def heights_of(folder: Path) -> list[float]:
    """Return the lowest and the highest height of a run [mm], none where it cut nothing."""
    surface = _surface_of(folder)
    if surface is None or surface.turn.size == 0:
        return []
    return [float(surface.z_mm.min()), float(surface.z_mm.max())]


def error_curves(folder: Path, ends: tuple[float, float]) -> ErrorCurves | None:
    """Return the errors of a run as curves between two heights, nothing where it cut nothing."""
    surface = _surface_of(folder)
    if surface is None or surface.turn.size == 0:
        return None
    cells = cells_of(surface, ends)
    with np.errstate(all="ignore"):
        worst = np.nanmax(np.where(np.isnan(cells), -np.inf, np.abs(cells)), axis=1)
    worst = np.where(np.isfinite(worst), worst, np.nan)
    middles = ends[0] + (ends[1] - ends[0]) * (np.arange(N_HEIGHTS) + 0.5) / N_HEIGHTS
    angles = (np.arange(N_ANGLES, dtype=np.float64) + 0.5) * (DEG_PER_TURN / N_ANGLES)
    return ErrorCurves(middles, worst, cells, angles, following_over_angle(folder))


def following_over_angle(folder: Path) -> Floats | None:
    """Return the mean following error over the drawing's angle while cutting."""
    path = folder / TRACE
    written_ns = _stamp(path)
    return None if written_ns is None else _following(path, written_ns)


@lru_cache(maxsize=_REMEMBERED)
def _following(path: Path, _written_ns: int) -> Floats | None:
    trace = read_trace(path)
    cut = trace.pick(np.asarray(trace.state == CUTTING))
    if cut.turn.size == 0:
        return None
    column = np.floor(np.mod(cut.turn, 1.0) * N_ANGLES).astype(np.int64) % N_ANGLES
    count = np.bincount(column, minlength=N_ANGLES)
    with np.errstate(all="ignore"):
        return np.bincount(column, weights=cut.following_um, minlength=N_ANGLES) / count


def section_error(folder: Path, z_mm: float, band_mm: float) -> tuple[Floats, Floats] | None:
    """Return angles [degrees] and form errors [um] of a band of the height, by angle."""
    surface = _surface_of(folder)
    if surface is None:
        return None
    near = np.abs(surface.z_mm - z_mm) <= band_mm / 2
    if not near.any():
        return None
    angle, error = np.mod(surface.turn[near], 1.0) * DEG_PER_TURN, surface.error_um[near]
    order = np.argsort(angle)
    return angle[order], error[order]


# From metal taken too much to metal left, with the tolerance of the eye in the middle.
_MAP_COLOURS = ["#08306b", "#2171b5", "#9ecae1", "#f7f7f7", "#fdae6b", "#d94801", "#7f2704"]
_STYLES = ("solid", "dashed", "dotted", "solid")


def _points(x: Floats, y: Floats) -> list[list[float | None]]:
    """Return points for a line, a hole where a number is missing."""
    return [
        [round(float(a), 5), None if not np.isfinite(b) else round(float(b), 6)]
        for a, b in zip(x, y, strict=True)
    ]


def _lines(
    name: str, axes: tuple[Options, Options], named: Sequence[tuple[str, list[Any]]]
) -> Options:
    series = [
        line(run, data, colour, lineStyle={"color": colour, "width": 2, "type": style})
        for (run, data), colour, style in zip(named, COLOURS, _STYLES, strict=False)
    ]
    return titled(
        name,
        legend={"bottom": 0, "textStyle": {"color": INK}},
        tooltip={"trigger": "axis"},
        grid={"left": 72, "right": 24, "top": 40, "bottom": 76},
        xAxis=axes[0],
        yAxis=axes[1],
        series=series,
    )


def over_height(curves: Sequence[tuple[str, ErrorCurves]]) -> Options:
    """Return the largest form error of each band of the height, of runs by their names."""
    named = [(name, _points(curve.z_mm, curve.worst_um)) for name, curve in curves]
    axes = axis("height / mm", 28), axis("largest |form error| / µm", 52, scale=False)
    return _lines("form error over the height", axes, named)


def _around(y_name: str) -> tuple[Options, Options]:
    return axis("drawing's angle / °", 28, **TURN), axis(y_name, 52)


def over_angle(curves: Sequence[tuple[str, ErrorCurves]]) -> Options:
    """Return the mean following error while cutting, over the drawing's angle."""
    named = [
        (name, _points(curve.angle_deg, curve.following_um))
        for name, curve in curves
        if curve.following_um is not None
    ]
    return _lines("following error over the angle", _around("mean following error / µm"), named)


def sections(found: Sequence[tuple[str, tuple[Floats, Floats]]], z_mm: float) -> Options:
    """Return the form error of one band of the height, over the drawing's angle."""
    named = [(name, _points(*section)) for name, section in found]
    text = f"form error of the section at {z_mm:.4g} mm"
    return _lines(text, _around("form error / µm"), named)


def scale_of(maps: Sequence[Floats]) -> float:
    """Return the largest magnitude of all maps, which the colours of all of them end at [um]."""
    largest = max((float(np.nanmax(np.abs(cells))) for cells in maps if cells.size), default=0.0)
    return float(f"{largest:.3g}") if np.isfinite(largest) and largest > 0 else 1.0


def error_map(name: str, curves: ErrorCurves, scale_um: float) -> Options:
    """Return a map of the form error over angle and height; its colours end at the scale."""
    cells = [
        [int(column), int(row), round(float(curves.map_um[row, column]), 5)]
        for row, column in np.argwhere(np.isfinite(curves.map_um))
    ]
    angles = [f"{angle - curves.angle_deg[0]:.0f}°" for angle in curves.angle_deg]
    heights = [f"{z:.1f}" for z in curves.z_mm]
    named = {"name": "height / mm", "nameLocation": "middle", "nameGap": 44}
    colours = {
        "min": -scale_um,
        "max": scale_um,
        "precision": 3,
        "calculable": False,
        "orient": "horizontal",
        "left": "center",
        "bottom": 4,
        "text": [f"+{scale_um:g} µm: metal left", f"{-scale_um:g} µm"],
        "textStyle": {"color": INK},
        "inRange": {"color": _MAP_COLOURS},
    }
    return titled(
        name,
        grid={"left": 64, "right": 20, "top": 40, "bottom": 96},
        tooltip={"formatter": "{c}"},
        xAxis=_categories(angles, len(angles) // 8 - 1),
        yAxis=_categories(heights, len(heights) // 6) | named | {"nameTextStyle": {"color": INK}},
        visualMap=colours,
        series=[{"type": "heatmap", "data": cells, "silent": False, "progressive": 0}],
    )


def _categories(data: list[str], interval: int) -> Options:
    return {"type": "category", "data": data, "axisLabel": {"color": INK, "interval": interval}}
