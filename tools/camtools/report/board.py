"""The part to turn over on the screen: map, section, unrolled section, profile and space, linked.

The numbers go into the page once, packed; report/page.js cuts every chart of the board from them.

>>> packed(np.array([1.0, 2.0]), "u1")
'AQI='
"""

from base64 import b64encode
from typing import Any, NamedTuple

import numpy as np

from camtools.base.quantities import UM_PER_MM, Floats, length_text, length_unit
from camtools.base.text import Json
from camtools.plots.style import GREEN, ORANGE, PURPLE, SKY, nice_floor, nice_limit
from camtools.report.surface import Cells, cells_of, map_rows
from camtools.sim.results import GaugedSurface

_NOT_CUT, _FULL = -32768, 32767  # of the quantised error
_TURN_STEPS = 65536  # in a column: where flanks are steep, less would show in the radius
_SPACE_ROWS, _SPACE_COLUMNS = 64, 180
_ROOM, _ROOM_FOR_SHAPE = 0.15, 0.35  # shares of the radius for errors and for the shape
_WORTH_ENLARGING = 5  # a shape enlarged by less looks like another part
# ColorBrewer's RdBu from blue to red.
_COLOURS = (
    *("#053061", "#2166ac", "#4393c3", "#92c5de", "#d1e5f0", "#f7f7f7"),
    *("#fddbc7", "#f4a582", "#d6604d", "#b2182b", "#67001f"),
)


class Magnification(NamedTuple):
    """By how much errors can be enlarged in the section, and what that is good for."""

    factor: float
    text: str


class Board(NamedTuple):
    """What the linked charts show."""

    cells: Cells  # worst points; its heights are the steps of the slider
    tolerance_um: float  # largest form error of a good part
    shape: int  # how often the shape of a section is enlarged, its deviation from a circle
    space: int  # the same of the part in space

    @property
    def largest_um(self) -> float:
        """Return the largest error [um]."""
        return float(np.nanmax(np.abs(self.cells.error_um)))

    @property
    def start(self) -> tuple[int, int]:
        """Return row and column of the largest error."""
        at = int(np.nanargmax(np.abs(self.cells.error_um)))
        row, column = np.unravel_index(at, self.cells.error_um.shape)
        return int(row), int(column)

    @property
    def magnifications(self) -> list[Magnification]:
        """Return the enlargement that shows the tolerance, and the one that shows the error."""
        room_um = _ROOM * float(np.nanmax(self.cells.radius_mm)) * UM_PER_MM
        texts = ("tolerance band in view", "error fills the picture")
        wanted = zip((self.tolerance_um, self.largest_um), texts, strict=True)
        found = [Magnification(nice_floor(room_um / um), text) for um, text in wanted if um > 0]
        return sorted(found, key=lambda magnification: magnification.factor)

    @property
    def sentence(self) -> str:
        """Return the map in words."""
        cells, (row, column) = self.cells, self.start
        where = f"{360 * cells.turn[row, column]:.1f}° and {cells.height_mm[row, column]:.2f} mm"
        worst = length_text(float(cells.error_um[row, column]))
        least, most = (length_text(float(f(cells.error_um))) for f in (np.nanmin, np.nanmax))
        return (
            f"Error of the surface over angle and height: {least} to {most}, the largest, "
            f"{worst}, at {where}; the tolerance is {length_text(self.tolerance_um)}."
        )


def _enlargement(radius_mm: float, deviation_mm: float) -> int:
    """Return by how much to enlarge a shape; 1 for one that can be seen as it is."""
    if deviation_mm <= 0:
        return 1
    factor = round(nice_floor(_ROOM_FOR_SHAPE * radius_mm / deviation_mm))
    return factor if factor >= _WORTH_ENLARGING else 1


def board_of(
    surface: GaugedSurface,
    z_range_mm: tuple[float, float],
    feed_mm: float,
    tolerance_um: float,
    space: int | None = None,
) -> Board | None:
    """Return the board of a surface, none if nothing was gauged; `space` enlarges it."""
    if not surface.turn.size or z_range_mm[1] <= z_range_mm[0]:
        return None
    rows = map_rows(z_range_mm[1] - z_range_mm[0], feed_mm)
    cells = cells_of(surface, z_range_mm, rows)
    radius = cells.radius_mm[np.isfinite(cells.radius_mm).any(axis=1)]
    deepest_mm = float((np.nanmax(radius, axis=1) - np.nanmin(radius, axis=1)).max())
    largest_mm, least_mm = float(np.nanmax(radius)), float(np.nanmin(radius))
    shape = _enlargement(least_mm, deepest_mm)
    whole = space or _enlargement(least_mm, largest_mm - least_mm)
    return Board(cells, tolerance_um, shape, whole)


def packed(values: Floats, kind: str) -> str:
    """Return numbers of a little-endian kind as base64."""
    return b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def board_data(board: Board) -> Json:
    """Return the numbers of a board for the page.

    Returns `error` int16 in steps of `error_step_um`, -32768 where nothing was cut; `radius`
    float32 in mm; `turn` uint16, the place of the point within its column in 65536th.
    """
    cells = board.cells
    n_rows, n_columns = cells.error_um.shape
    step_um = board.largest_um / _FULL or 1.0  # the largest error is met exactly
    steps = np.nan_to_num(np.round(cells.error_um / step_um), nan=_NOT_CUT)
    inside = np.nan_to_num(cells.turn * n_columns - np.arange(n_columns), nan=0.5)
    factor, unit = length_unit(board.largest_um)
    return {
        "rows": n_rows,
        "columns": n_columns,
        "z_mm": np.round(cells.z_mm, 4).tolist(),
        "error": packed(steps, "<i2"),
        "error_step_um": step_um,
        "radius": packed(cells.radius_mm, "<f4"),
        "turn": packed(np.floor(inside * _TURN_STEPS).clip(0, _TURN_STEPS - 1), "<u2"),
        "per_um": factor,
        "unit": unit,
        "tolerance_um": board.tolerance_um,
        "shape": board.shape,
        "colours": [SKY, ORANGE, PURPLE, GREEN],
    }


def array(values: Floats) -> Json:
    """Return numbers as plotly takes them packed."""
    shape = {"shape": ",".join(map(str, values.shape))} if values.ndim > 1 else {}
    return {"dtype": "f4", "bdata": packed(values, "<f4")} | shape


def _space_points(cells: Cells) -> GaugedSurface:
    """Return the worst points of the map in coarser cells, each of shape (rows, columns + 1)."""
    rows = np.isfinite(cells.error_um)
    flat = GaugedSurface(
        *(values[rows] for values in (cells.turn, cells.height_mm, cells.radius_mm, cells.error_um))
    )
    half_mm = (cells.z_mm[1] - cells.z_mm[0]) / 2 if cells.z_mm.size > 1 else 1.0
    ends = float(cells.z_mm[0] - half_mm), float(cells.z_mm[-1] + half_mm)
    found = cells_of(flat, ends, min(_SPACE_ROWS, cells.z_mm.size), _SPACE_COLUMNS)
    level = found._replace(height_mm=np.where(np.isnan(found.turn), np.nan, found.z_mm[:, None]))
    return GaugedSurface(*(np.column_stack([values, values[:, :1]]) for values in level[1:]))


def space_figure(board: Board) -> Json:
    """Return the part in space, its deviations from a cylinder enlarged, coloured by its error."""
    points = _space_points(board.cells)
    largest_mm = float(np.nanmax(points.radius_mm))
    shown_mm = largest_mm - board.space * (largest_mm - points.radius_mm)
    phi = 2 * np.pi * points.turn
    factor, unit = length_unit(board.largest_um)
    limit = nice_limit(board.largest_um) * factor
    surface = {
        "type": "surface",
        "x": array(shown_mm * np.cos(phi)),
        "y": array(shown_mm * np.sin(phi)),
        "z": array(points.z_mm),
        "surfacecolor": array(points.error_um * factor),
        "customdata": array(points.radius_mm),
        "cmin": -limit,
        "cmax": limit,
        "lighting": {"ambient": 0.85, "diffuse": 0.3, "specular": 0.02},
        "colorscale": colour_scale(),
        "colorbar": {"title": {"text": f"error, {unit}"}, "len": 0.7},
        "hovertemplate": f"height %{{z:.2f}} mm<br>error %{{surfacecolor:.4g}} {unit}"
        "<extra></extra>",
    }
    axes = {
        name: {"title": {"text": text}, "gridcolor": GRID, "showbackground": False}
        for name, text in (("xaxis", "mm"), ("yaxis", "mm"), ("zaxis", "height, mm"))
    }
    scene = axes | {"aspectmode": "manual", "aspectratio": {"x": 1, "y": 1, "z": 0.9}}
    eye, centre = {"x": 1.2, "y": -1.6, "z": 0.9}, {"x": 0, "y": 0, "z": -0.1}
    scene["camera"] = {"eye": eye, "center": centre}
    margin = {"l": 10, "r": 10, "t": 10, "b": 10}
    return {"data": [surface], "layout": layout(height=520, scene=scene, margin=margin)}


GRID = "rgba(128,128,128,0.35)"


def colour_scale() -> list[list[Any]]:
    """Return the colours of errors: blue too deep, red metal left."""
    return [[i / (len(_COLOURS) - 1), colour] for i, colour in enumerate(_COLOURS)]


def layout(**more: Any) -> Json:  # noqa: ANN401
    """Return what all charts share: no ground of their own, so that light and dark both do."""
    return {
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "margin": {"l": 70, "r": 20, "t": 40, "b": 55},
        "hovermode": "closest",
        "uirevision": "kept",
        "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
    } | more
