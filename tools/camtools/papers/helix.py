"""The paper on quadratic ellipse and variable cross-section helix, S3: the 16V240ZJ skirt.

>>> matrix = point_matrix(2.0, 4)
>>> matrix.shape, matrix[:3, 2].round(6).tolist()
((505, 8), [0.0, 5.0, 10.0])
"""

from typing import Any

import numpy as np

from camtools.base.quantities import Floats
from camtools.base.text import Columns
from camtools.cut.path import ToolPath
from camtools.papers.declared import corner_of, declared, geometry_of

TURN, IS_HELIX, C, Z, RHO, X, Y = range(7)  # columns of a point matrix
KEY = "S3"
CASE = declared(KEY).case
PART: str = CASE["part"]
_N_POINTS: int = CASE["n_points"]  # of a turn
_COLUMNS = ("turn", "is_helix", "c_deg", "z_mm", "radius_mm", "x_mm", "y_mm", "u_mm")


def reduction_mm(phi_rad: Floats, z_mm: Floats) -> Floats:
    """Return the reduction of the radius as drawn, before any refit."""
    return np.asarray(corner_of(PART).delta(phi_rad, z_mm).delta, dtype=np.float64)


def _path(feed_mm: float, n_rings: int | None = None) -> ToolPath:
    """Return the ring-helix as printed, without ramps, from the lowest height up."""
    low, high = geometry_of(PART).z_first_mm, geometry_of(PART).z_last_mm
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
    rho = geometry_of(PART).radius_mm(z) - u
    columns = (turn, turn % 2, 360 * turns, z, rho, rho * np.cos(phi), rho * np.sin(phi), u)
    return np.stack([np.asarray(column, dtype=np.float64) for column in columns], axis=1)


def blend_nm() -> float:
    """Return how far helix points from ring points are off those of the section itself [nm].

    The paper computes rho = (1 - s) rho_k + s rho_(k+1), linearly between two rings.
    """
    path, worst = _path(CASE["blend_mm"]), 0.0
    s = np.arange(_N_POINTS + 1) / _N_POINTS
    for turn in range(1, round(path.turns), 2):
        low, high = path.height_mm(np.array([turn, turn + 1.0]))
        lower, upper, exact = (
            geometry_of(PART).radius_mm(z) - reduction_mm(2 * np.pi * s, z)
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
    z, arc = np.array([20.0, 65.0, 125.0, 190.0]), corner_of(PART).joint(20.0).arc()
    path, whole = _path(CASE["feed_mm"]), point_matrix(CASE["few_mm"])
    rings = int((whole[:, IS_HELIX] == 0).sum())
    short_mm = [float(diameters_mm(at)[-1]) for at in CASE["sections_mm"]]
    return {
        "long_mm": 2 * geometry_of(PART).radius_mm(z),
        "oval_mm": geometry_of(PART).ovality_mm(z),
        "e_mm": float(arc.eccentricity_mm),
        "r_mm": float(arc.radius_mm),
        "heights_mm": _path(CASE["blend_mm"]).height_mm(np.array([0.0, 1.0, 1.5, 2.0, 3.5])),
        "n_part": len(point_matrix(CASE["few_mm"], 4)),
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
    here = geometry_of(PART)
    z = np.arange(here.z_first_mm, here.z_last_mm + 0.5, 5.0)
    columns = {"long_axis_mm": (2 * here.radius_mm(z), 6), "ovality_mm": (here.ovality_mm(z), 6)}
    return {"height_mm": (z, "g"), **columns}


def _points() -> Columns:
    matrix = point_matrix(CASE["feed_mm"])
    return {name: (matrix[:, i], 0 if i < 2 else 6) for i, name in enumerate(_COLUMNS)}


def sections() -> Columns:
    """Return the reductions of the diameter of the compared sections."""
    columns: dict[str, tuple[Floats, int]] = {"angle_deg": (np.arange(91.0), 0)}
    for z in CASE["sections_mm"]:
        columns[f"reduction_of_diameter_mm_at_{z:g}"] = (diameters_mm(z), 6)
    return columns


TABLES = {"s3_figs_4_5.csv": _splines, "s3_fig_8.csv": _points, "s3_fig_9.csv": sections}
