"""The paper on quadratic ellipse and variable cross-section helix, S3: the 16V240ZJ skirt.

>>> matrix = point_matrix(2.0, 4)
>>> matrix.shape, matrix[:3, 2].round(6).tolist()
((505, 8), [0.0, 5.0, 10.0])
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from camtools.base.quantities import Floats
from camtools.base.text import Columns
from camtools.cut.path import ToolPath
from camtools.papers import refit
from camtools.papers.declared import csv, declared, draw_table, part_of, png
from camtools.papers.removal import draw_design
from camtools.plots.style import BLUE, ORANGE, new_figure, side_by_side, space
from camtools.skirt.geometry.sections import Joint
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart

TURN, IS_HELIX, C, Z, RHO, X, Y = range(7)  # columns of a point matrix
_HEIGHT = "height, mm"
KEY = "S3"
_CASE = declared(KEY).case
_N_POINTS: int = _CASE["n_points"]  # of a turn
_COLUMNS = ("turn", "is_helix", "c_deg", "z_mm", "radius_mm", "x_mm", "y_mm", "u_mm")


def _part() -> SkirtPart:
    return part_of(_CASE["part"], SkirtPart)


@cache
def _geometry() -> Geometry:
    return make_geometry(_part())


def _joint(z_mm: float | Floats) -> Joint:
    corner = _geometry().corner
    assert corner is not None
    return corner.joint(z_mm)


def reduction_mm(phi_rad: Floats, z_mm: Floats) -> Floats:
    """Return the reduction of the radius as drawn, before any refit."""
    corner = _geometry().corner
    assert corner is not None
    return np.asarray(corner.delta(phi_rad, z_mm).delta, dtype=np.float64)


def _path(feed_mm: float, n_rings: int | None = None) -> ToolPath:
    """Return the ring-helix as printed, without ramps, from the lowest height up."""
    low, high = _geometry().z_first_mm, _geometry().z_last_mm
    top = high if n_rings is None else min(high, low + feed_mm * (n_rings - 1))
    return ToolPath("ring-helix", low, top, feed_mm)


def point_matrix(feed_mm: float, n_rings: int | None = None) -> Floats:
    """Return the points of the path, a row each; columns as `_COLUMNS`.

    m rings of N points and the turns between them are (2 m - 1) N + 1 points.
    """
    path = _path(feed_mm, n_rings)
    j = np.arange(round(path.turns) * _N_POINTS + 1)
    turn = np.minimum(j // _N_POINTS, round(path.turns) - 1)
    turns = j / _N_POINTS
    z = path.height_mm(turns)
    phi = 2 * np.pi * np.mod(turns, 1)
    u = reduction_mm(phi, z)
    rho = _geometry().radius_mm(z) - u
    columns = (turn, turn % 2, 360 * turns, z, rho, rho * np.cos(phi), rho * np.sin(phi), u)
    return np.stack([np.asarray(one, dtype=np.float64) for one in columns], axis=1)


def blend_nm() -> float:
    """Return how far helix points from ring points are off those of the section itself [nm].

    The paper computes rho = (1 - s) rho_k + s rho_(k+1), linearly between two rings.
    """
    path, worst = _path(_CASE["blend_mm"]), 0.0
    s = np.arange(_N_POINTS + 1) / _N_POINTS
    for turn in range(1, round(path.turns), 2):
        low, high = path.height_mm(np.array([turn, turn + 1.0]))
        lower, upper, exact = (
            _geometry().radius_mm(z) - reduction_mm(2 * np.pi * s, z)
            for z in (np.full(s.size, low), np.full(s.size, high), low + s * (high - low))
        )
        worst = max(worst, float(np.abs((1 - s) * lower + s * upper - exact).max()) * 1e6)
    return worst


def diameters_mm(z_mm: float) -> Floats:
    """Return the reductions of the diameter of a section at 0, 1 .. 90 degrees."""
    deg = np.arange(0.0, 91.0)
    return 2 * reduction_mm(np.radians(deg), np.full(deg.size, z_mm))


def quantities() -> dict[str, Any]:
    """Return the quantities of the rows."""
    z, arc = np.array([20.0, 65.0, 125.0, 190.0]), _joint(20.0).arc()
    path, whole = _path(_CASE["feed_mm"]), point_matrix(_CASE["few_mm"])
    rings = int((whole[:, IS_HELIX] == 0).sum())
    short_mm = [float(diameters_mm(at)[-1]) for at in _CASE["sections_mm"]]
    return {
        "long_mm": 2 * _geometry().radius_mm(z),
        "oval_mm": _geometry().ovality_mm(z),
        "e_mm": float(arc.eccentricity_mm),
        "r_mm": float(arc.radius_mm),
        "heights_mm": _path(_CASE["blend_mm"]).height_mm(np.array([0.0, 1.0, 1.5, 2.0, 3.5])),
        "n_part": len(point_matrix(_CASE["few_mm"], 4)),
        "n_whole": len(whole),
        "n_matrix": round(path.turns) * _N_POINTS + 1,
        "path": path,
        "blend_nm": blend_nm(),
        "n_rings": rings,
        "n_helices": len(whole) - rings,
        "short_mm": short_mm,
        "between_um": 1000 * (short_mm[1] - short_mm[0]) / 2,
    }


def _splines() -> Columns:
    here = _geometry()
    z = np.arange(here.z_first_mm, here.z_last_mm + 0.5, 5.0)
    columns = {"long_axis_mm": (2 * here.radius_mm(z), 6), "ovality_mm": (here.ovality_mm(z), 6)}
    return {"height_mm": (z, "g"), **columns}


def _points() -> Columns:
    matrix = point_matrix(_CASE["feed_mm"])
    return {name: (matrix[:, i], 0 if i < 2 else 6) for i, name in enumerate(_COLUMNS)}


def _sections() -> Columns:
    columns: dict[str, tuple[Floats, int]] = {"angle_deg": (np.arange(91.0), 0)}
    for z in _CASE["sections_mm"]:
        columns[f"reduction_of_diameter_mm_at_{z:g}"] = (diameters_mm(z), 6)
    return columns


def _kinds(matrix: Floats) -> list[tuple[Floats, str, str]]:
    is_helix = matrix[:, IS_HELIX] == 1
    return [
        (matrix[~is_helix], BLUE, "points of the rings"),
        (matrix[is_helix], ORANGE, "points of the helices"),
    ]


def draw_sketch(matrix: Floats) -> Figure:
    """Return ring, helix and ring in space, with the letters of the paper."""
    figure = new_figure(7, 6)
    axes = space(figure, 111, 0.6)
    n = int((matrix[:, TURN] == 0).sum())
    names = ("points of the rings", "points of the helices", None)
    for turn, (colour, name) in enumerate(zip((BLUE, ORANGE, BLUE), names, strict=True)):
        some = matrix[turn * n : (turn + 1) * n + 1]
        axes.plot(some[:, X], some[:, Y], some[:, Z], color=colour, label=name)
    letters = {"A": 0, "B": n // 2, "C": n + n // 2, "D": 2 * n, "E": 2 * n + n // 2}
    for letter, i in letters.items():
        x, y, z = matrix[i, X], matrix[i, Y], matrix[i, Z]
        axes.text(x * 1.1, y * 1.1, z, letter)
        axes.plot([x], [y], [z], "k.")
    axes.legend(frameon=False, loc="upper left")
    return figure


def draw_points(matrix: Floats, *, is_part: bool) -> Figure:
    """Return the points in space in two colours."""
    figure = new_figure(7, 7)
    axes = space(figure, 111, 0.5 if is_part else 0.9)
    for kind, colour, name in _kinds(matrix):
        size = 12 if is_part else 3
        axes.scatter(kind[:, X], kind[:, Y], kind[:, Z], c=colour, s=size, label=name)
    axes.legend(frameon=False, loc="upper left")
    name = "Fig 7: part of the path" if is_part else "Fig 8: the whole path"
    axes.set_title(f"{name}, {len(matrix)} points", y=0.95)
    return figure


def draw_unrolled(matrix: Floats) -> Figure:
    """Return all points over angle and height, and a corner of them enlarged."""
    figure, panels = side_by_side(2, "points of rings and helices, unrolled", (10, 5.5))
    for axes, size in zip(panels, (4.0, 12.0), strict=True):
        for kind, colour, name in _kinds(matrix):
            axes.scatter(np.mod(kind[:, C], 360), kind[:, Z], s=size, color=colour, label=name)
        axes.set_xlabel("angle from the long axis, degrees")
        place: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)}
        axes.legend(frameon=False, fontsize=8, ncols=2, **place)
    low = float(matrix[0, Z])
    panels[0].set(ylabel=_HEIGHT, xticks=range(0, 361, 90))
    panels[1].set(xlim=(0, 90), ylim=(low - 1, low + 35))
    return figure


def files() -> dict[str, Callable[[], bytes]]:
    """Return the makers of the paper's tables and figures."""
    few, title = _CASE["few_mm"], "reduction of the diameter, mm"
    return {
        "s3_figs_4_5.csv": csv(_splines),
        "s3_fig_8.csv": csv(_points),
        "s3_fig_9.csv": csv(_sections),
        "s3_figs_1_2_4_5.png": png(lambda: draw_design(_part(), "drawing and splines")),
        "s3_fig_3.png": png(lambda: refit.draw_section(_joint(20.0), "section at 20 mm")),
        "s3_fig_6.png": png(lambda: draw_sketch(point_matrix(few, 4))),
        "s3_fig_7.png": png(lambda: draw_points(point_matrix(few, 4), is_part=True)),
        "s3_fig_8.png": png(lambda: draw_points(point_matrix(few), is_part=False)),
        "s3_fig_9.png": png(lambda: draw_table("reduction", title, {"": _sections()})),
        "s3_fig_10.png": png(lambda: draw_unrolled(point_matrix(few))),
    }
