"""Drawings of the papers that are more than columns of a table.

>>> import numpy as np
>>> from camtools.skirt.geometry.sections import Joint
>>> joint = Joint(45.46, 0.38, 0.4, np.radians(48.0))
>>> len(draw_section(joint, "a section").axes)
2
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from camtools.base.quantities import UM_PER_MM, Floats
from camtools.cut.removal import TURN_RAD
from camtools.papers.corner import fig_8, fold_deg, measured, records
from camtools.papers.declared import geometry_of, part_of
from camtools.papers.helix import IS_HELIX, TURN, C, X, Y, Z
from camtools.papers.lobe import LobeStudy
from camtools.papers.pictures import fill_panels
from camtools.papers.section import Analysis, tables
from camtools.plots.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PALE,
    RED,
    around,
    new_figure,
    plane,
    side_by_side,
    space,
)
from camtools.skirt.geometry.sections import Joint
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.part.part_file import SkirtPart

_HEIGHT = "height, mm"
_ENLARGED, _CHIP = 25.0, 0.35  # of the reduction in a section; chip, of the radius
_POLAR_UM = 1500.0  # radius of the records


def title_of(study: Analysis, subject: str) -> str:
    """Return the title of a picture of an analysis."""
    return f"{study.name}, height {study.height_mm:g} mm: {subject}"


def _outline(axes: Axes, study: Analysis, borders_rad: Floats) -> None:
    """Draw blank and section, the chip enlarged, with borders between steps or parts."""
    phi = np.linspace(0, study.cut.pattern_rad, 721)
    factor = _CHIP / study.chip_mm[1]
    inner, foot = (1 - factor * study.cut.depth_mm(at) for at in (phi, borders_rad))
    axes.plot(*around(np.ones_like(phi), phi), color=GREY)
    axes.plot(*around(inner, phi), color=BLUE)
    ring = np.r_[np.ones_like(phi), inner[::-1]]
    axes.fill(*around(ring, np.r_[phi, phi[::-1]]), color=PALE)
    ends = np.stack([foot, np.ones_like(foot)])
    axes.plot(*around(ends, borders_rad[None]), color=BLUE, lw=0.7)
    plane(axes)
    times = factor * study.cut.blank_mm
    axes.set_title(f"chip between blank and part, enlarged {times:.0f} times", fontsize=9.5)


def draw_steps(study: Analysis) -> Figure:
    """Return the equal steps of angle on the section."""
    figure = new_figure(6, 6)
    figure.suptitle(title_of(study, f"a step every {study.wishes.step_deg:g} degrees"))
    _outline(figure.subplots(), study, study.steps.phi_rad)
    return figure


def draw_parts(study: Analysis) -> Figure:
    """Return the parts of equal area on the section: their width, angle and depth."""
    figure = new_figure(11, 8)
    figure.suptitle(title_of(study, f"{study.parts.phi_rad.size} parts of equal area"))
    halves: Any = figure.subfigures(1, 2, width_ratios=[1, 1.2])
    left, right = halves
    _outline(left.subplots(), study, np.append(0.0, study.parts.phi_rad))
    fill_panels(right, "parts", {"": tables(study)["equal_parts"]})
    return figure


def draw_section(joint: Joint, title: str) -> Figure:
    """Return the section all round, its reduction enlarged, and the reduction over a quarter."""
    figure, (left, right) = side_by_side(2, title, (10.5, 5))
    phi, a, corner = np.linspace(0, 2 * np.pi, 2881), float(joint.a_mm), float(joint.joint_rad)
    quarter = np.abs(np.mod(phi + np.pi / 2, np.pi) - np.pi / 2)
    drawn = joint.reduction(quarter).delta
    oval = joint.law(quarter, joint.a_mm, joint.ovality_mm).delta
    circle = joint.arc().reduction(quarter, joint.a_mm).delta
    left.plot(*around(np.full(phi.size, a), phi), color=GREY, ls=":", label="long half axis")
    for values, some, colour, name in (
        (oval, quarter <= corner, BLUE, "oval"),
        (circle, quarter >= corner, ORANGE, "eccentric circle"),
    ):
        for shown, width, dash, label in ((some, 2.0, "-", name), (~some, 0.8, ":", "_")):
            radius = np.where(shown, a - _ENLARGED * values, np.nan)
            left.plot(*around(radius, phi), color=colour, lw=width, ls=dash, label=label)
    for angle in (corner, -corner, np.pi - corner, np.pi + corner):
        left.plot(*around(np.array([0.0, a]), np.full(2, angle)), color=GREY, lw=0.7)
    left.legend(frameon=False, loc="center")
    left.set_title(f"reduction enlarged {_ENLARGED:.0f} times")
    plane(left)
    first = phi <= np.pi / 2
    right.plot(np.degrees(phi[first]), drawn[first] * 1000, color=GREEN)
    right.axvline(float(np.degrees(corner)), color=GREY, ls=":")
    right.set(xlabel="angle from the long axis, degrees", ylabel="reduction of the radius, µm")
    return figure


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


def draw_design(name: str, title: str) -> Figure:
    """Return the points of a drawing, long axis and ovality, and the splines through them."""
    piston, geometry = part_of(name, SkirtPart).piston, geometry_of(name)
    profile, ovality = piston.profile, piston.ovality
    assert ovality is not None
    z = np.linspace(geometry.z_first_mm, geometry.z_last_mm, 801)
    figure, (left, right) = side_by_side(2, title, (10, 4.2))
    left.plot(z, 2 * geometry.radius_mm(z), color=GREY)
    left.plot(profile.height_mm, profile.diameter_mm, "o", color=BLUE)
    right.plot(z, geometry.ovality_mm(z), color=GREY)
    right.plot(ovality.height_mm, ovality.ovality_mm, "o", color=ORANGE)
    left.set(xlabel=_HEIGHT, ylabel="long axis, mm")
    right.set(xlabel=_HEIGHT, ylabel="ovality, mm")
    return figure


def draw_profile(geometry: Geometry, widest_mm: float) -> Figure:
    """Return the fitted profile, and its top enlarged."""
    figure, (left, right) = side_by_side(2, "fitted middle-convex profile", (9, 4.2))
    z = np.linspace(geometry.z_first_mm, geometry.z_last_mm, 1001)
    nodes, near = geometry.radius.x, widest_mm + np.linspace(-0.02, 0.02, 401)
    left.plot(z, 2 * geometry.radius_mm(z), color=BLUE)
    left.plot(nodes, 2 * geometry.radius_mm(nodes), "o", color=ORANGE, ms=4)
    right.plot(near, (geometry.radius_mm(near) - geometry.radius_mm(20.0)) * 2e9, color=BLUE)
    right.plot([20.0], [0.0], "o", color=ORANGE)
    left.set(xlabel=_HEIGHT, ylabel="long axis, mm")
    right.set(xlabel=_HEIGHT, ylabel="long axis over that of the node, pm")
    return figure


def draw_skirts(skirts: Mapping[str, Geometry]) -> Figure:
    """Return skirts in space from the points that the tool runs through."""
    figure = new_figure(5.5 * len(skirts), 5.5)
    phi = np.linspace(0, TURN_RAD, 121)
    style = {"rstride": 1, "cstride": 1, "linewidth": 0, "shade": False, "antialiased": False}
    for i, (name, geometry) in enumerate(skirts.items(), start=1):
        z = np.linspace(geometry.z_first_mm, geometry.z_last_mm, 63)
        rho = np.stack(
            [float(geometry.radius_mm(h)) - geometry.delta(phi, float(h)).delta for h in z]
        )
        axes = space(figure, 100 + 10 * len(skirts) + i, 0.7)
        shade = colormaps["viridis"](Normalize(float(rho.min()), float(rho.max()))(rho))
        height = np.broadcast_to(z[:, None], rho.shape)
        axes.plot_surface(*around(rho, phi[None, :]), height, facecolors=shade, **style)
        axes.set_title(f"{name}: radius {rho.min():.3f} .. {rho.max():.3f} mm", y=0.95)
    return figure


def draw_records() -> Figure:
    """Return the roundness records: the closed sections enlarged, and their distance as drawn."""
    figure = new_figure(11, 7)
    figure.suptitle("roundness before, corrected by hand, after the refit; green: drawing")
    halves: Any = figure.subfigures(1, 2, width_ratios=[1, 2.2])
    left, right = halves
    deg = np.linspace(0, 360, 1441)
    phi, quarter_deg = np.radians(deg), fold_deg(deg / 360)
    drawn = UM_PER_MM * measured().reduction(np.radians(quarter_deg)).delta
    for record, axes in zip(records(), left.subplots(3, 1), strict=True):
        cut = np.interp(quarter_deg, record.deg, record.reduction_um)
        for values, colour in ((drawn, GREEN), (cut, BLUE)):
            axes.plot(*around(_POLAR_UM - values, phi), color=colour, lw=1)
        plane(axes)
        axes.set_title(record.name, fontsize=9)
    fill_panels(right, "records", {"": fig_8()})
    return figure


def draw_follower(study: LobeStudy, i: int) -> Figure:
    """Return lobe, roller and tool or wheel for a direction of the follower, as the paper does."""
    touch, is_turned = study.touch, study.operation == "turning"
    theta, gamma, p = float(touch.theta[i]), float(touch.gamma[i]), float(touch.p[i])
    normal, out = (1j * complex(np.exp(1j * angle)) for angle in (theta - gamma, theta))
    at = {  # the zero of the law points upwards
        "O": 0j,
        "C": 1j * float(touch.radius[i]) * complex(np.exp(1j * float(touch.alpha[i]))),
        "Q": p * out - p * np.cos(gamma) * normal,
        "O'" if is_turned else "O2": p * out,
    }
    tool = p * out + (study.lobe.follower_mm - touch.roller) * normal
    more = {"x = 0": (study.lobe.base_mm + touch.roller) * out}
    lines = [("O", "O'", BLUE), ("Q", "O'", RED), ("O", "Q", GREY)]
    if not is_turned:
        more = {"O1": tool, "P": 1j * complex(-float(touch.p1[i]) * out)}
        lines = [("O", "O2", BLUE), ("Q", "O1", RED), ("O", "Q", GREY), ("O", "P", ORANGE)]
        lines.append(("O", "O1", BLUE))
    at |= more
    phi, lift = float(np.degrees(study.path.phi[i])), float(study.path.lift[i])
    figure = new_figure(7.5, 7)
    title = f"{study.operation}: theta {study.theta_deg[i]:g}, phi {phi:.3f} degrees"
    figure.suptitle(f"{title}, lift {lift:.4f} mm, swing {np.degrees(gamma):.3f} degrees")
    axes, turn = figure.subplots(), np.linspace(-np.pi, np.pi, 1441)
    all_round, _ = study.lobe.contacts(turn + study.lobe.phase_rad)
    shape = 1j * all_round.radius * np.exp(1j * all_round.alpha)
    axes.fill(shape.real, shape.imag, fc=PALE, ec=GREY, lw=1.5)
    circles = [(0j, study.lobe.base_mm, GREY), (p * out, touch.roller, ORANGE)]
    circles += [] if is_turned else [(tool, study.lobe.follower_mm, RED)]
    for centre, radius, colour in circles:
        circle = centre + radius * np.exp(1j * turn)
        axes.plot(circle.real, circle.imag, color=colour, lw=1)
    for first, last, colour in lines:
        ends = np.array([at[first], at[last]])
        axes.plot(ends.real, ends.imag, color=colour, lw=1)
    if is_turned:  # the tool, from the contact along the normal
        ends = np.array([at["C"], at["C"] + 22 * normal])
        axes.plot(ends.real, ends.imag, color=RED, lw=3)
    for name, point in at.items():
        axes.plot([point.real], [point.imag], "k.", ms=5)
        axes.annotate(name, (point.real, point.imag), (7, 7), textcoords="offset points")
    plane(axes)
    if not is_turned:
        reach = 0.15 * study.lobe.follower_mm
        axes.set(
            xlim=(min(-40.0, tool.real - 20), max(60.0, tool.real + 20)),
            ylim=(-30, tool.imag + reach),
        )
    return figure
