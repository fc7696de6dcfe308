"""Pictures of the papers on equal removal.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> len(draw_skirts({"as drawn": make_geometry(example_part())}).axes)
1
"""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from camtools.cut.removal import TURN_RAD
from camtools.plots.panels import around, plane, points, side_by_side, space, stacked
from camtools.plots.style import BLUE, GREY, ORANGE, PALE, RED, new_figure
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.study.section import Analysis

_ENLARGED = 100.0  # chip of the quadrant
_UM_PER_MM = 1000.0


def _panels(title: str, height_in: float, *names: str) -> tuple[Figure, list[Axes]]:
    figure = new_figure(8, height_in)
    figure.suptitle(title)
    return figure, stacked(figure, names)


def draw_design(part: SkirtPart) -> Figure:
    """Return the points of the drawing: long axis and ovality against height."""
    figure, (left, right) = side_by_side(2, "design points of the skirt", (9, 4.2))
    profile, ovality, geometry = part.piston.profile, part.piston.ovality, make_geometry(part)
    assert ovality is not None
    z = np.linspace(geometry.z_first_mm, geometry.z_last_mm, 401)
    left.plot(2 * geometry.radius_mm(z), z, color=GREY, lw=1)
    left.plot(profile.diameter_mm, profile.height_mm, "o", color=BLUE)
    left.set_xlabel("long axis, mm")
    left.set_ylabel("height, mm")
    right.plot(geometry.ovality_mm(z), z, color=GREY, lw=1)
    right.plot(ovality.ovality_mm, ovality.height_mm, "o", color=ORANGE)
    right.set_xlabel("ovality, mm")
    return figure


def draw_quadrant(study: Analysis) -> Figure:
    """Return the first quadrant of blank and part, the chip enlarged, with all steps."""
    figure, (axes,) = side_by_side(1, "first quadrant, a step every 3 degrees", (6, 6))
    phi = np.linspace(0, np.pi / 2, 721)
    blank = study.cut.blank_mm
    inner = blank - _ENLARGED * study.cut.depth_mm(phi)
    x, y = around(np.concatenate([np.full(phi.size, blank), inner[::-1]]), np.r_[phi, phi[::-1]])
    axes.fill(x, y, color=PALE)
    axes.plot(*around(inner, phi), color=BLUE)
    axes.plot(*around(np.full(phi.size, blank), phi), color=GREY)
    for angle in study.steps.phi_rad:
        low = blank - _ENLARGED * float(study.cut.depth_mm(angle[None])[0])
        axes.plot(*around(np.array([low, blank]), angle), color=BLUE, lw=0.7)
    for angle in np.radians([0, 30, 60, 90]):
        x, y = around(np.array([blank + 2.0]), angle)
        axes.text(x[0], y[0], f"{np.degrees(angle):.0f}°", ha="center", va="center")
    plane(axes)
    axes.set_title(f"depth of cut enlarged {_ENLARGED:.0f} times")
    return figure


def draw_steps(study: Analysis) -> Figure:
    """Return depth, its change and area, step by step."""
    steps, deg = study.steps, np.degrees(study.steps.phi_rad)
    names = ("Fig 6: depth, mm", "Fig 7: change of depth, µm", "Fig 8: area, mm²")
    figure, (one, two, three) = _panels("in equal steps of angle", 7.5, *names)
    points(one, deg, steps.depth_mm)
    points(two, deg[1:], steps.change_mm[1:] * _UM_PER_MM, ORANGE)
    points(three, deg[1:], steps.area_mm2[1:])
    three.set_xlabel("angle from the long axis, degrees; a step ends at its point")
    return figure


def draw_profile(geometry: Geometry, widest_mm: float) -> Figure:
    """Return the fitted profile, and its top enlarged."""
    figure, (left, right) = side_by_side(2, "fitted middle-convex profile", (9, 4.2))
    z = np.linspace(geometry.z_first_mm, geometry.z_last_mm, 1001)
    left.plot(z, 2 * geometry.radius_mm(z), color=BLUE)
    nodes = geometry.radius.x
    left.plot(nodes, 2 * geometry.radius_mm(nodes), "o", color=ORANGE, ms=4)
    left.set_ylabel("long axis, mm")
    near = widest_mm + np.linspace(-0.02, 0.02, 401)
    high = (geometry.radius_mm(near) - geometry.radius_mm(20.0)) * 2e9
    right.plot(near, high, color=BLUE)
    right.plot([20.0], [0.0], "o", color=ORANGE)
    right.set_ylabel("long axis over that of the node, pm")
    for axes in (left, right):
        axes.set_xlabel("height, mm")
    return figure


def draw_parts(study: Analysis) -> Figure:
    """Return angle per part, angle turned, change of depth and depth of the equal parts."""
    parts = study.parts
    number = np.arange(1.0, parts.phi_rad.size + 1)
    angles = ("Fig 10: angle\nof the part, degrees", "Fig 11: angle\nturned, degrees")
    depths = ("Fig 12: change\nof depth, µm", "Fig 13: depth, mm")
    figure, axes = _panels("30 parts of equal area", 9, *angles, *depths)
    points(axes[0], number, np.degrees(parts.width_rad))
    points(axes[1], number, np.degrees(parts.phi_rad))
    points(axes[2], number, parts.change_mm * _UM_PER_MM, ORANGE)
    points(axes[3], number, parts.depth_mm)
    axes[3].set_xlabel("number of the part, counted from 1")
    return figure


def draw_skirts(skirts: dict[str, Geometry]) -> Figure:
    """Return skirts in space from the points that the tool runs through."""
    figure = new_figure(5.5 * len(skirts), 5.5)
    phi = np.linspace(0, TURN_RAD, 121)
    for i, (name, geometry) in enumerate(skirts.items(), start=1):
        z = np.linspace(geometry.z_first_mm, geometry.z_last_mm, 63)
        rho = np.stack(
            [float(geometry.radius_mm(h)) - geometry.delta(phi, float(h)).delta for h in z]
        )
        axes = space(figure, 100 + 10 * len(skirts) + i, 0.7)
        x, y = around(rho, phi[None, :])
        shade = colormaps["viridis"](Normalize(float(rho.min()), float(rho.max()))(rho))
        height = np.broadcast_to(z[:, None], rho.shape)
        style = {"rstride": 1, "cstride": 1, "linewidth": 0, "shade": False, "antialiased": False}
        axes.plot_surface(x, y, height, facecolors=shade, **style)
        axes.set_title(f"{name}: radius {rho.min():.3f} .. {rho.max():.3f} mm", y=0.95)
    return figure


def draw_force(study: Analysis) -> Figure:
    """Return the force over a turn, uniform and equal volume, in both models."""
    title = f"force over a turn, kc = {study.kc_n_mm2:g} N/mm²"
    figure, (above, below) = _panels(title, 6, "force, N", "force, N")
    deg = np.linspace(0, 360, 1441)
    phi = np.radians(deg)
    area, n = study.cut.area_rate_mm2(phi), study.parts.phi_rad.size
    rate = study.kc_n_mm2 * area * (np.pi / 2) / n
    above.plot(deg, rate, color=GREY, ls="--", label="uniform")
    above.plot(deg, rate * study.cut.speed_ratio(phi), color=BLUE, label="equal volume")
    above.set_title("the paper's: proportional to the area cut in equal times")
    chip = study.kc_n_mm2 * study.feed_mm * study.cut.depth_mm(phi)
    below.plot(deg, chip, color=RED, label="uniform and equal volume alike")
    below.set_title("section of the chip")
    for axes in (above, below):
        axes.set_ylim(bottom=0)
        axes.legend(frameon=False, loc="lower right")
    below.set_xticks(range(0, 361, 45))
    below.set_xlabel("spindle angle from the long axis, degrees")
    return figure
