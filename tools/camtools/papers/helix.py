"""The paper on quadratic ellipse and variable cross-section helix, S3: the 16V240ZJ skirt.

>>> matrix = point_matrix(4, 2.0)
>>> matrix.shape, matrix[:3, 2].round(6).tolist()
((505, 8), [0.0, 5.0, 10.0])
"""

from __future__ import annotations

from functools import cache

import numpy as np

from camtools.base.csv_text import csv_text
from camtools.base.quantities import Floats
from camtools.cut.path import ToolPath
from camtools.papers import helix_plots as plots
from camtools.papers.rows import Chapter, Maker, Row, part_of, png, um
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart

FEED_MM = 2.0  # distance of the sections of the point matrix
FEW_MM = 10.0  # of the pictures in which single points are seen
SECTIONS_MM = (20.0, 190.0)
N_POINTS = 72  # of a turn
BLEND_MM = 0.2  # distance of sections at which both ways to the helix points are compared
_COLUMNS = ("turn", "is_helix", "c_deg", "z_mm", "radius_mm", "x_mm", "y_mm", "u_mm")


@cache
def geometry() -> Geometry:
    """Return the geometry of the skirt; its corner as drawn is that of `geometry().corner`."""
    return make_geometry(part_of("16v240zj", SkirtPart))


def reduction_mm(phi_rad: Floats, z_mm: Floats) -> Floats:
    """Return the reduction of the radius as drawn, before any refit."""
    corner = geometry().corner
    assert corner is not None
    return np.asarray(corner.delta(phi_rad, z_mm).delta, dtype=np.float64)


def path_of_rings(feed_mm: float, n_rings: int | None = None) -> ToolPath:
    """Return the ring-helix as printed, without ramps, from the lowest height up."""
    low, high = geometry().z_first_mm, geometry().z_last_mm
    top = high if n_rings is None else min(high, low + feed_mm * (n_rings - 1))
    return ToolPath("ring-helix", low, top, feed_mm)


def point_matrix(n_rings: int | None = None, feed_mm: float = FEED_MM) -> Floats:
    """Return the points of the path, a row each; columns as `_COLUMNS`.

    m rings of N points and the turns between them are (2 m - 1) N + 1 points.
    """
    path = path_of_rings(feed_mm, n_rings)
    n = N_POINTS
    j = np.arange(round(path.turns) * n + 1)
    turn = np.minimum(j // n, round(path.turns) - 1)
    turns = j / n
    z = path.height_mm(turns)
    phi = 2 * np.pi * np.mod(turns, 1)
    u = reduction_mm(phi, z)
    rho = geometry().radius_mm(z) - u
    columns = (turn, turn % 2, 360 * turns, z, rho, rho * np.cos(phi), rho * np.sin(phi), u)
    return np.stack([np.asarray(one, dtype=np.float64) for one in columns], axis=1)


def blend_nm() -> float:
    """Return how far helix points from ring points are off those of the section itself [nm].

    The paper computes rho = (1 - s) rho_k + s rho_(k+1), linearly between two rings.
    """
    path = path_of_rings(BLEND_MM)
    worst = 0.0
    for turn in range(1, round(path.turns), 2):
        s = np.arange(0, N_POINTS + 1) / N_POINTS
        phi = 2 * np.pi * s
        low, high = (float(path.height_mm(np.array([turn + one]))[0]) for one in (0.0, 1.0))

        def rho(z_mm: Floats, phi: Floats = phi) -> Floats:
            return geometry().radius_mm(z_mm) - reduction_mm(phi, z_mm)

        straight = (1 - s) * rho(np.full(s.size, low)) + s * rho(np.full(s.size, high))
        exact = rho(low + s * (high - low))
        worst = max(worst, float(np.abs(straight - exact).max()) * 1e6)
    return worst


def diameters_mm(z_mm: float) -> tuple[Floats, Floats]:
    """Return angles [degrees] and reductions of the diameter of a section [mm]."""
    deg = np.arange(0.0, 91.0)
    return deg, 2 * reduction_mm(np.radians(deg), np.full(deg.size, z_mm))


def _matrix_csv() -> bytes:
    columns = zip(_COLUMNS, point_matrix().T, (0, 0, *(len(_COLUMNS) - 2) * (6,)), strict=True)
    return csv_text({name: (values, decimals) for name, values, decimals in columns}).encode()


def _sections_csv() -> bytes:
    columns: dict[str, tuple[Floats, int]] = {"angle_deg": (np.arange(91.0), 0)}
    for z in SECTIONS_MM:
        columns[f"reduction_of_diameter_mm_at_{z:g}"] = (diameters_mm(z)[1], 6)
    return csv_text(columns).encode()


def _spline_csv() -> bytes:
    z = np.arange(geometry().z_first_mm, geometry().z_last_mm + 0.5, 5.0)
    return csv_text(
        {
            "height_mm": (z, "g"),
            "long_axis_mm": (2 * geometry().radius_mm(z), 6),
            "ovality_mm": (geometry().ovality_mm(z), 6),
        }
    ).encode()


def _files() -> dict[str, Maker]:
    def part() -> SkirtPart:
        return part_of("16v240zj", SkirtPart)

    return {
        "s3_figs_4_5.csv": _spline_csv,
        "s3_fig_8.csv": _matrix_csv,
        "s3_fig_9.csv": _sections_csv,
        "s3_figs_1_2_4_5.png": png(lambda: plots.draw_splines(part(), geometry())),
        "s3_fig_3.png": png(lambda: plots.draw_section(geometry(), 20.0)),
        "s3_fig_6.png": png(lambda: plots.draw_sketch(point_matrix(4, FEW_MM))),
        "s3_fig_7.png": png(lambda: plots.draw_points(point_matrix(4, FEW_MM), is_part=True)),
        "s3_fig_8.png": png(lambda: plots.draw_points(point_matrix(None, FEW_MM), is_part=False)),
        "s3_fig_9.png": png(
            lambda: plots.draw_reduction({z: diameters_mm(z) for z in SECTIONS_MM})
        ),
        "s3_fig_10.png": png(lambda: plots.draw_unrolled(point_matrix(None, FEW_MM))),
    }


def _curve_rows() -> list[Row]:
    here, z = geometry(), np.array([65.0, 125.0])
    long_mm, oval_mm = 2 * here.radius_mm(z), here.ovality_mm(z)
    ends = here.radius_mm([20.0, 190.0]), here.ovality_mm([20.0, 190.0])
    corner = here.corner
    assert corner is not None
    arc = corner.joint(20.0).arc()
    file = "s3_figs_1_2_4_5.png"
    return [
        Row(
            *("Fig 1", "profile: long axis against height", "bore 240 mm; a curve"),
            f"{2 * ends[0][0]:.3f} mm at 20, {2 * ends[0][1]:.3f} mm at 190",
            *("the printed table is a picture, ours is invented to fit", file),
        ),
        Row(
            *("Fig 2", "ovality against height", "larger at the top"),
            f"{ends[1][0]:.2f} mm at 20, {ends[1][1]:.2f} mm at 190",
            *("as Fig 1", file),
        ),
        Row(
            *("Fig 3", "section: oval and eccentric circle", "R = D/2 - G/2 - a + e"),
            f"at 20: e = {float(arc.eccentricity_mm):.6f} mm, R = {float(arc.radius_mm):.6f} mm",
            "none; e follows from D, G, trim and joint, which the paper does not say",
            "s3_fig_3.png",
        ),
        Row(
            *("Fig 4", "spline of the profile", "a smooth curve"),
            f"{long_mm[0]:.6f} mm at 65, {long_mm[1]:.6f} mm at 125",
            *("none: not-a-knot, as `spline(H, D, HH)`", file),
        ),
        Row(
            *("Fig 5", "spline of the ovality", "a smooth curve"),
            f"{oval_mm[0]:.6f} mm at 65, {oval_mm[1]:.6f} mm at 125",
            *("none", file),
        ),
    ]


def _path_rows() -> list[Row]:
    path, few = path_of_rings(FEED_MM), path_of_rings(0.2)
    turns = np.array([0.0, 1.0, 1.5, 2.0, 3.5])
    heights = ", ".join(f"{z:.1f}" for z in few.height_mm(turns))
    part, whole = point_matrix(4, FEW_MM), point_matrix(None, FEW_MM)
    rings = int((whole[:, 1] == 0).sum())
    return [
        Row(
            *("Fig 6", "sketch of ring, helix, ring", "A-B-A a ring, A-C-D a helix, D-E-D a ring"),
            f"dZ 0.2 mm: z = {heights} mm after 0, 1, 1.5, 2, 3.5 turns",
            f"drawn with dZ {FEW_MM:g} mm; Z's speed jumps twice in two turns: a machine needs "
            "ramps ([PATHS.md](PATHS.md#ring-helix))",
            "s3_fig_6.png",
        ),
        Row(
            *("Fig 7", "part of the path: its points", "a picture"),
            f"dZ {FEW_MM:g} mm: the first 4 rings and the turns between, {len(part)} points",
            *("dZ of the paper is not printed", "s3_fig_7.png"),
        ),
        Row(
            *("Fig 8", "the whole path: its points", "m rings take 2 m - 1 turns"),
            f"picture: dZ {FEW_MM:g} mm, {len(whole)} points; table: dZ {FEED_MM:g} mm, "
            f"{path.n_rings} rings, {path.turns:.0f} turns of {N_POINTS}: "
            f"{len(point_matrix())} points",
            f"helix points from the ring points, as the paper has it, are off by at most "
            f"{blend_nm():.2f} nm at dZ {BLEND_MM:g} mm; ours are of the section itself",
            "s3_fig_8.csv` `s3_fig_8.png",
        ),
        Row(
            *("Fig 10", "points of rings and of helices in two colours", "a picture"),
            f"dZ {FEW_MM:g} mm: {rings} on rings, {len(whole) - rings} on helices",
            *("unrolled; the paper's dZ is not printed", "s3_fig_10.png"),
        ),
    ]


def _section_row() -> Row:
    low, high = (float(diameters_mm(z)[1][-1]) for z in SECTIONS_MM)
    return Row(
        *("Fig 9", "reduction of the diameter at 20 and 190 mm"),
        "0.10 .. 0.50 mm of radius between top and bottom",
        f"at the short axis {low:.6f} and {high:.6f} mm, {um((high - low) / 2, 1)} of radius "
        "between them",
        *("within what the paper says", "s3_fig_9.png"),
    )


def chapter() -> Chapter:
    """Return the paper on the variable cross-section helix."""
    title = "quadratic ellipse, eccentric circle and variable cross-section helix (16V240ZJ)"
    return Chapter("S3", title, (*_curve_rows(), *_path_rows(), _section_row()), _files())
