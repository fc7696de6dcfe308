"""Pictures of the refit paper: section, motion with jerk, the best deletions, records.

>>> from camtools.skirt.geometry.composite import Joint
>>> len(draw_section(Joint(45.46, 0.38, 0.4, np.radians(48.0))).axes)
2
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import PPoly

from camtools.base.quantities import omega_rad_s
from camtools.papers.gauge import Record
from camtools.plots.panels import around, plane, side_by_side, stacked
from camtools.plots.style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, new_figure
from camtools.skirt.geometry.composite import Joint
from camtools.study.refit import Study

_COLOURS = (BLUE, ORANGE, PURPLE)
_UM_PER_MM = 1000.0
_N = 4001
_POLAR_UM = 1500.0  # radius of the records
_FIRST_DEG = 50.0  # from where the largest jerk is taken


class Named(Protocol):
    """A curve with its name."""

    @property
    def name(self) -> str:
        """What it is."""

    @property
    def curve(self) -> PPoly:
        """Reduction of the radius over the first quadrant [mm, rad]."""


def draw_section(joint: Joint) -> Figure:
    """Return the quadrant with oval and circle, deviations enlarged, and the reduction."""
    figure, (left, right) = side_by_side(2, "ellipse and eccentric circle", (10, 4.6))
    phi, times = np.linspace(0, np.pi / 2, 721), 25.0
    a, corner = float(joint.a_mm), float(joint.joint_rad)
    drawn = joint.reduction(phi).delta
    oval = joint.law.evaluate(phi, joint.a_mm, joint.ovality_mm).delta
    circle = joint.arc().reduction(phi, joint.a_mm).delta
    before, behind = phi <= corner, phi >= corner
    for values, some, colour, style, name in (
        (oval, before, BLUE, "-", "oval"),
        (circle, behind, ORANGE, "-", "eccentric circle"),
        (oval, behind, BLUE, ":", None),
        (circle, before, ORANGE, ":", None),
    ):
        left.plot(*around(a - times * values[some], phi[some]), color=colour, ls=style, label=name)
    at_joint = a - times * float(joint.reduction(corner).delta)
    left.plot(*around(np.array([0.0, at_joint]), np.full(2, corner)), color=GREY, lw=0.8)
    left.legend(frameon=False, loc="lower left")
    left.set_title(f"deviations from the long axis enlarged {times:.0f} times")
    plane(left)
    right.plot(np.degrees(phi), drawn * _UM_PER_MM, color=GREEN)
    right.axvline(float(np.degrees(corner)), color=GREY, ls=":")
    right.set_xlabel("angle from the long axis, degrees")
    right.set_ylabel("reduction of the radius, µm")
    return figure


def draw_motion(joint: Joint, traces: Sequence[Named], rpm: float) -> Figure:
    """Return displacement, velocity, acceleration and jerk of U over the first quadrant."""
    names = " and ".join(one.name for one in traces)
    figure = new_figure(8, 9)
    figure.suptitle(f"first quadrant at {rpm:g} r/min: {names}")
    units = ("displacement, mm", "velocity, mm/s", "acceleration, m/s²", "jerk, km/s³")
    axes = stacked(figure, units)
    omega, phi = omega_rad_s(rpm), np.linspace(0, np.pi / 2, _N)
    for n, panel in enumerate(axes):
        scale = omega**n / (1.0, 1.0, 1e3, 1e6)[n]
        for one, colour in zip(traces, _COLOURS, strict=False):
            panel.plot(np.degrees(phi), one.curve(phi, n) * scale, color=colour, label=one.name)
        panel.axvline(float(np.degrees(joint.joint_rad)), color=GREY, ls=":", lw=1)
    if len(traces) > 1:
        axes[0].legend(frameon=False)
    axes[-1].set_xlabel("angle from the long axis, degrees; dotted: the joint")
    return figure


def draw_best(found: Study, traces: Sequence[Named], rpm: float) -> Figure:
    """Return the largest jerk of all deletions, and the jerk of the three best, enlarged."""
    figure = new_figure(8, 7)
    above, below = figure.subplots(2, 1)
    figure.suptitle(f"jerk beyond the corner, {rpm:g} r/min")
    x = np.arange(len(found.as_paper))
    above.bar(x, [one.tail_jerk_mm_s3 for one in found.as_paper], color=BLUE)
    above.axhline(1e7, color=RED, ls="--", lw=1)
    above.set_yscale("log")
    above.set_xticks(x, [f"{one.s1}, {one.s2}" for one in found.as_paper])
    above.set_xlabel("points left out on the ellipse's side, on the circle's side")
    above.set_ylabel("largest jerk, mm/s³")
    omega, deg = omega_rad_s(rpm), np.linspace(_FIRST_DEG, 60, _N)
    for one, colour in zip(traces, _COLOURS, strict=True):
        jerk = one.curve(np.radians(deg), 3) * omega**3
        below.plot(deg, jerk / 1e6, color=colour, label=one.name)
    below.set_xlabel("angle from the long axis, degrees")
    below.set_ylabel("jerk, km/s³")
    below.set_ylim(-15, 15)
    below.legend(frameon=False)
    for axes in (above, below):
        axes.grid(alpha=0.3)
    return figure


def draw_records(joint: Joint, traces: Sequence[Named], cuts: Sequence[Record]) -> Figure:
    """Return the roundness records: the closed section enlarged, and its distance as drawn."""
    figure = new_figure(11, 6.6)
    title = "roundness before, corrected by hand, after the refit"
    figure.suptitle(f"{title}; green: drawing, grey: spline, blue: cut and gauged")
    phi = np.linspace(0, 2 * np.pi, 1441)
    quarter = np.abs(np.mod(phi + np.pi / 2, np.pi) - np.pi / 2)
    drawn = joint.reduction(quarter).delta * _UM_PER_MM
    for i, (one, cut) in enumerate(zip(traces, cuts, strict=True)):
        axes = figure.add_subplot(2, 3, i + 1)
        measured = np.interp(np.degrees(quarter), cut.deg, cut.reduction_um)
        for values, colour in ((drawn, GREEN), (measured, BLUE)):
            axes.plot(*around(_POLAR_UM - values, phi), color=colour, lw=1)
        plane(axes)
        axes.set_title(one.name, fontsize=9)
        below = figure.add_subplot(2, 3, i + 4)
        part = phi <= np.pi / 2
        off = one.curve(quarter[part]) * _UM_PER_MM - drawn[part]
        below.plot(np.degrees(phi[part]), off, color=GREY, lw=2.5, alpha=0.5)
        below.plot(cut.deg, cut.off_um, color=BLUE, lw=1)
        below.set_xlabel("angle from the long axis, degrees")
        below.set_ylabel("deeper than the drawing, µm")
        below.set_ylim(-4, 4)
        below.grid(alpha=0.3)
    return figure
