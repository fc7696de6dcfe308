"""Pictures of the paper on the variable cross-section helix.

>>> draw_reduction({20.0: (np.array([0.0, 90.0]), np.array([0.0, 0.8]))}).axes[0].get_ylabel()
'reduction of the diameter, mm'
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.quantities import Floats
from camtools.plots.panels import around, plane, points, side_by_side, space
from camtools.plots.style import BLUE, GREY, ORANGE, new_figure
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.part.part_file import SkirtPart

_TURN, _IS_HELIX, _C, _Z, _RHO, _X, _Y = range(7)  # columns of the point matrix
_FEW_TURNS = 3


def draw_splines(part: SkirtPart, geometry: Geometry) -> Figure:
    """Return the points of profile and ovality, and the splines through them."""
    figure = new_figure(10, 7.5)
    panels = figure.subplots(2, 2)
    profile, ovality = part.piston.profile, part.piston.ovality
    assert ovality is not None
    z = np.linspace(geometry.z_first_mm, geometry.z_last_mm, 801)
    drawn = (
        (panels[0, 0], np.array(profile.height_mm), np.array(profile.diameter_mm), BLUE),
        (panels[0, 1], np.array(ovality.height_mm), np.array(ovality.ovality_mm), ORANGE),
    )
    for (axes, height, value, colour), n, name in zip(
        drawn, (1, 2), ("long axis, mm", "ovality, mm"), strict=True
    ):
        points(axes, height, value, colour)
        axes.set_ylabel(name)
        axes.set_title(f"Fig {n}: the drawing")
    panels[1, 0].plot(z, 2 * geometry.radius_mm(z), color=BLUE)
    panels[1, 0].set_title("Fig 4: spline of the profile")
    panels[1, 1].plot(z, geometry.ovality_mm(z), color=ORANGE)
    panels[1, 1].set_title("Fig 5: spline of the ovality")
    for axes, name in zip(panels[1], ("long axis, mm", "ovality, mm"), strict=True):
        axes.set_ylabel(name)
    for axes in panels.ravel():
        axes.grid(alpha=0.3)
        axes.set_xlabel("height, mm")
    return figure


def draw_section(geometry: Geometry, z_mm: float) -> Figure:
    """Return one section all round, its reduction enlarged, with centre and joint."""
    corner = geometry.corner
    assert corner is not None
    times, joint = 60.0, corner.joint(z_mm)
    phi = np.linspace(0, 2 * np.pi, 2881)
    a = float(joint.a_mm)
    figure, (axes,) = side_by_side(1, f"section at {z_mm:g} mm", (6.5, 6))
    rho = a - times * joint.reduction(phi).delta
    axes.plot(*around(np.full(phi.size, a), phi), color=GREY, ls=":", label="long half axis")
    quadrant = np.abs(np.mod(phi + np.pi / 2, np.pi) - np.pi / 2)
    is_oval = quadrant < float(joint.joint_rad)
    for some, colour, name in ((is_oval, BLUE, "oval"), (~is_oval, ORANGE, "eccentric circle")):
        shown = np.where(some, rho, np.nan)
        axes.plot(*around(shown, phi), color=colour, lw=2, label=name)
    for angle in np.array([1, -1, 1, -1]) * float(joint.joint_rad) + np.array([0, 0, np.pi, np.pi]):
        axes.plot(*around(np.array([0.0, a]), angle), color=GREY, lw=0.7)
    axes.legend(frameon=False, loc="upper right", bbox_to_anchor=(1.1, 1.08))
    axes.set_title(f"reduction enlarged {times:.0f} times")
    plane(axes)
    return figure


def _kinds(matrix: Floats) -> list[tuple[Floats, str, str]]:
    is_helix = matrix[:, _IS_HELIX] == 1
    return [
        (matrix[~is_helix], BLUE, "points of the rings"),
        (matrix[is_helix], ORANGE, "points of the helices"),
    ]


def draw_sketch(matrix: Floats) -> Figure:
    """Return ring, helix and ring in space, with the letters of the paper."""
    few = matrix[matrix[:, _TURN] < _FEW_TURNS]
    figure = new_figure(7, 6)
    axes = space(figure, 111, 0.6)
    for kind, colour, name in _kinds(few):
        for turn in np.unique(kind[:, _TURN]):
            one = few[(few[:, _TURN] == turn)]
            behind = matrix[int(np.flatnonzero(matrix[:, _TURN] == turn)[-1]) + 1][None, :]
            one = np.concatenate([one, behind])
            label = name if turn == kind[0, _TURN] else None
            axes.plot(one[:, _X], one[:, _Y], one[:, _Z], color=colour, label=label)
    n = int((matrix[:, _TURN] == 0).sum())
    letters = {"A": 0, "B": n // 2, "C": n + n // 2, "D": 2 * n, "E": 2 * n + n // 2}
    for letter, i in letters.items():
        axes.text(matrix[i, _X] * 1.1, matrix[i, _Y] * 1.1, matrix[i, _Z], letter)
        axes.plot(matrix[i : i + 1, _X], matrix[i : i + 1, _Y], matrix[i : i + 1, _Z], "k.")
    axes.legend(frameon=False, loc="upper left")
    return figure


def draw_points(matrix: Floats, *, is_part: bool) -> Figure:
    """Return the points in space in two colours."""
    figure = new_figure(7, 7)
    axes = space(figure, 111, 0.5 if is_part else 0.9)
    for kind, colour, name in _kinds(matrix):
        size = 12 if is_part else 3
        axes.scatter(kind[:, _X], kind[:, _Y], kind[:, _Z], c=colour, s=size, label=name)
    axes.legend(frameon=False, loc="upper left")
    name = "Fig 7: part of the path" if is_part else "Fig 8: the whole path"
    axes.set_title(f"{name}, {len(matrix)} points", y=0.95)
    return figure


def draw_unrolled(matrix: Floats) -> Figure:
    """Return all points over angle and height, and a corner of it enlarged."""
    figure, (left, right) = side_by_side(2, "points of rings and helices, unrolled", (10, 5.5))
    for axes in (left, right):
        _unrolled(axes, matrix, 4.0 if axes is left else 12.0)
    low = float(matrix[0, _Z])
    right.set_xlim(0, 90)
    right.set_ylim(low - 1, low + 35)
    left.set_ylabel("height, mm")
    left.set_xticks(range(0, 361, 90))
    return figure


def _unrolled(axes: Axes, matrix: Floats, size: float) -> None:
    for kind, colour, name in _kinds(matrix):
        axes.scatter(np.mod(kind[:, _C], 360), kind[:, _Z], s=size, color=colour, label=name)
    axes.set_xlabel("angle from the long axis, degrees")
    axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize=8, ncols=2)


def draw_reduction(sections: dict[float, tuple[Floats, Floats]]) -> Figure:
    """Return the reduction of the diameter against the angle, a curve for each height."""
    figure, (axes,) = side_by_side(1, "reduction of the diameter", (7, 4.5))
    for (z_mm, (deg, values)), colour in zip(sections.items(), (BLUE, ORANGE), strict=False):
        axes.plot(deg, values, color=colour, label=f"height {z_mm:g} mm")
    axes.set_xlabel("angle from the long axis, degrees")
    axes.set_ylabel("reduction of the diameter, mm")
    axes.legend(frameon=False)
    return figure
