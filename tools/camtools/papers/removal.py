"""The papers on equal removal, S0 and S1: the Perkins skirt.

>>> z_mm, diameter_mm = widest_mm()
>>> f"{diameter_mm:.9f} mm at {z_mm:.6f} mm"
'92.000000004 mm at 20.005220 mm'
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from scipy.optimize import brentq

from camtools.base.text import Columns
from camtools.cut.removal import TURN_RAD, SectionCut
from camtools.papers import section
from camtools.papers.declared import csv, declared, part_of, png
from camtools.papers.section import Analysis, AnalysisWishes, make_analysis
from camtools.plots.style import BLUE, GREY, ORANGE, around, new_figure, side_by_side, space
from camtools.skirt.geometry.sections import double_ellipse
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart

_HEIGHT = "height, mm"
KEY = "S0, S1"
_CASE = declared(KEY).case
_N_ROWS = 31  # of Table 5, the first quarter turn


@cache
def analysis() -> Analysis:
    """Return the analysis of the papers' section: height 20 mm, 30 parts."""
    return make_analysis(part_of(_CASE["part"], SkirtPart), AnalysisWishes(rpm=_CASE["rpm"]))


@cache
def _geometry(name: str) -> Geometry:
    return make_geometry(part_of(_CASE[name], SkirtPart))


def widest_mm() -> tuple[float, float]:
    """Return height and diameter where the fitted profile is widest."""
    geometry = _geometry("part")
    z_mm = float(brentq(lambda z: float(geometry.radius_mm(z, 1)), 19.5, 20.5, xtol=1e-13))
    return z_mm, 2 * float(geometry.radius_mm(z_mm))


def _table(name: str, n_rows: int | None = None) -> section.Table:
    """Return a table of the analysis, or its first rows."""
    columns = section.tables(analysis())[name]
    return {key: (values[:n_rows], form) for key, (values, form) in columns.items()}


def quantities() -> dict[str, Any]:
    """Return the quantities of the rows."""
    found, height_mm, top_mm = analysis(), _CASE["height_mm"], _CASE["top_mm"]
    cut, steps, parts, peaks = found.cut, found.steps, found.parts, found.peaks
    skirts = [_geometry(name) for name in ("part", "ovality_x30", "all_x30")]
    tops = [float(one.radius_mm(top_mm)) for one in skirts]
    ovals = [float(one.ovality_mm(top_mm)) for one in skirts]
    long_mm = 2 * float(skirts[0].radius_mm(height_mm))
    ovality_mm = float(skirts[0].ovality_mm(height_mm))
    cosine = SectionCut(
        lambda phi: double_ellipse(phi, cut.a_mm, ovality_mm), cut.a_mm, cut.blank_mm
    )
    widest, step_deg = int(np.argmax(steps.change_mm)), np.degrees(steps.phi_rad)
    widest_z_mm, diameter_mm = widest_mm()
    axes = {name: values[-1] for name, (values, _) in _table("axes_equal_volume", _N_ROWS).items()}
    return {
        "long_mm": long_mm,
        "top_mm": [2 * one for one in tops],
        "least_mm": long_mm - 2 * tops[0],
        "ovality_mm": ovality_mm,
        "top_ovality_mm": ovals,
        "largest_ovality_mm": ovals[0],
        "stroke_mm": ovals[0] / 2,
        "n_steps": steps.phi_rad.size - 1,
        "area_mm2": cut.total_mm2,
        "cosine_area_mm2": cosine.total_mm2,
        "step_mm2": (steps.area_mm2[1], steps.area_mm2[-1]),
        "step_ratio": steps.area_mm2[-1] / steps.area_mm2[1],
        "depth_mm": (steps.depth_mm[0], steps.depth_mm[-1]),
        "change_um": 1000 * steps.change_mm[widest],
        "change_deg": (step_deg[widest - 1], step_deg[widest]),
        "largest_change_deg": step_deg[widest],
        "widest_mm": diameter_mm,
        "widest_z_mm": widest_z_mm,
        "n_parts": parts.phi_rad.size,
        "part_mm2": cut.total_mm2 / parts.phi_rad.size,
        "width_deg": np.degrees((parts.width_rad[0], parts.width_rad[-1])),
        "part_deg": np.degrees((parts.phi_rad[0], parts.phi_rad[-1])),
        "part_um": 1000 * parts.change_mm.max(),
        "at_part": found.at_part,
        "at_part_0": found.at_part - 1,
        "at_part_deg": found.at_part_deg,
        "part_depth_mm": (parts.depth_mm[0], parts.depth_mm[-1]),
        "last": axes | {"t_ms": 1000 * axes["t_s"]},
        "range": found.range,
        "least_rpm": found.rpm * peaks.ratio_min,
        "largest_rpm": found.rpm * peaks.ratio_max,
        "alpha_rad_s2": peaks.alpha * found.omega_rad_s**2,
        "papers_turns": top_mm / 0.001,
        "papers_min": top_mm / 0.001 / 2500,
        "feed_mm": found.feed_mm,
        "time_s": top_mm / found.feed_mm / 2500 * 60,
        "rate_ratio": found.rates.largest_to_least,
        "chip_ratio": found.chip_mm[1] / found.chip_mm[0],
    }


def _design() -> Columns:
    skirt = _geometry("part")
    z = np.array(part_of(_CASE["part"], SkirtPart).piston.profile.height_mm, dtype=np.float64)
    columns = {"height_mm": (z, 3), "long_axis_mm": (2 * skirt.radius_mm(z), 3)}
    return {**columns, "ovality_mm": (skirt.ovality_mm(z), 6)}


def draw_design(part: SkirtPart, title: str) -> Figure:
    """Return the points of the drawing, long axis and ovality, and the splines through them."""
    profile, ovality, geometry = part.piston.profile, part.piston.ovality, make_geometry(part)
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


def files() -> dict[str, Callable[[], bytes]]:
    """Return the makers of the papers' tables and figures."""

    def skirts(**names: str) -> Callable[[], bytes]:
        return png(lambda: draw_skirts({v: _geometry(k) for k, v in names.items()}))

    part, drawers = part_of(_CASE["part"], SkirtPart), section.drawers(analysis())
    title, all_30 = "design points of the skirt", "ovality and profile times 30 (S1)"
    return {
        "s0_tables_2_3.csv": csv(_design),
        "s0_table_1.csv": csv(partial(_table, "depth_and_area")),
        "s0_table_4.csv": csv(partial(_table, "equal_parts")),
        "s0_table_5.csv": csv(partial(_table, "axes_equal_volume", _N_ROWS)),
        "s1_fig_6.csv": csv(partial(_table, "forces")),
        "s0_fig_1.png": png(partial(draw_design, part, title)),
        "s0_fig_5.png": png(lambda: section.draw_steps(analysis())),
        "s0_figs_6_8.png": png(drawers["area"]),
        "s0_fig_9.png": png(lambda: draw_profile(_geometry("part"), widest_mm()[0])),
        "s0_figs_10_13.png": png(drawers["parts"]),
        "s0_fig_14.png": skirts(part="as drawn"),
        "s0_fig_15.png": skirts(ovality_x30="ovality times 30 (S0)", all_x30=all_30),
        "s1_fig_6.png": png(drawers["forces"]),
    }
