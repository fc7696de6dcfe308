"""Pictures of the paper on cams: turning, swing, grinding.

>>> from camtools.lobe.motion import example_lobe
>>> from camtools.study.lobe import LobeWishes, study_lobes
>>> [study] = study_lobes(example_lobe(), LobeWishes(step_deg=5.0))
>>> len(draw_turning(study, 28).axes)
1
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.plots.panels import plane, stacked
from camtools.plots.style import BLUE, GREY, ORANGE, PALE, RED, new_figure
from camtools.study.lobe import LobeStudy

_UP = 1j  # the zero of the law points upwards
_AROUND = np.exp(1j * np.linspace(0, 2 * np.pi, 721))


def _line(axes: Axes, start: complex, end: complex, colour: str, width: float = 1.0) -> None:
    axes.plot([start.real, end.real], [start.imag, end.imag], color=colour, lw=width)


def _circle(axes: Axes, centre: complex, radius: float, colour: str) -> None:
    circle = centre + radius * _AROUND
    axes.plot(circle.real, circle.imag, color=colour, lw=1)


def _mark(axes: Axes, place: complex, name: str, towards: complex = 1 + 1j) -> None:
    axes.plot([place.real], [place.imag], "k.", ms=5)
    axes.annotate(
        name,
        (place.real, place.imag),
        xytext=(9 * towards.real, 9 * towards.imag),
        textcoords="offset points",
        ha="center",
        va="center",
    )


class _Places:
    """The points of the figures in the plane, for one direction of the follower."""

    def __init__(self, study: LobeStudy, i: int) -> None:
        touch = study.touch
        theta, gamma = float(touch.theta[i]), float(touch.gamma[i])
        self.normal = complex(np.exp(1j * (theta - gamma)) * _UP)
        self.roller = complex(float(touch.p[i]) * np.exp(1j * theta) * _UP)
        self.contact = complex(float(touch.radius[i]) * np.exp(1j * float(touch.alpha[i])) * _UP)
        self.foot = self.roller - float(touch.p[i] * np.cos(gamma)) * self.normal
        self.wheel = self.roller + (study.lobe.follower_mm - touch.roller) * self.normal


def _base_figure(study: LobeStudy, i: int, title: str) -> tuple[Figure, Axes, _Places]:
    figure = new_figure(7.5, 7)
    figure.suptitle(title)
    axes, at = figure.add_subplot(), _Places(study, i)
    touch, _ = study.lobe.contacts(np.linspace(-np.pi, np.pi, 1441) + study.lobe.phase_rad)
    shape = touch.radius * np.exp(1j * touch.alpha) * _UP
    axes.fill(shape.real, shape.imag, fc=PALE, ec=GREY, lw=1.5)
    base = study.lobe.base_mm * _AROUND
    axes.plot(base.real, base.imag, color=GREY, lw=0.7, ls=":")
    _circle(axes, at.roller, study.touch.roller, ORANGE)
    _line(axes, 0j, at.roller, BLUE)
    _mark(axes, 0j, "O", -1 - 1j)
    _mark(axes, at.contact, "C", -1 - 1j)
    _mark(axes, at.foot, "Q", 1 - 1j)
    plane(axes)
    return figure, axes, at


def draw_turning(study: LobeStudy, i: int) -> Figure:
    """Return the contact, the roller's centre and the tool for one direction of the follower."""
    gamma = float(np.degrees(study.touch.gamma[i]))
    title = f"turning at {study.theta_deg[i]:g} degrees: x {study.touch.lift[i]:.4f} mm, "
    figure, axes, at = _base_figure(study, i, title + f"swing {gamma:.3f} degrees")
    out = at.roller / abs(at.roller)
    _line(axes, at.foot, at.roller, RED)
    _line(axes, 0j, at.foot, GREY, 0.7)
    _line(axes, at.contact, at.contact + 22 * at.normal, RED, 3)
    _line(axes, at.roller, at.roller + 14 * out, BLUE)
    _mark(axes, at.roller, "O'")
    _mark(axes, (study.lobe.base_mm + study.touch.roller) * out, "x = 0", -2 + 1j)
    return figure


def draw_swing(study: LobeStudy) -> Figure:
    """Return travel, its speed and the swing over the follower's direction."""
    figure = new_figure(8, 7)
    figure.suptitle(f"tool at {study.rpm:g} r/min")
    one, two, three = stacked(figure, ("travel x, mm", "speed v, mm/s", "swing, degrees"))
    omega, deg = study.omega_rad_s, study.theta_deg
    one.plot(deg, study.touch.lift, color=BLUE)
    two.plot(deg, study.touch.p1 * omega, color=ORANGE)
    three.plot(deg, np.degrees(study.touch.gamma), color=RED)
    three.set_xticks(range(-180, 181, 30))
    three.set_xlabel("direction of the follower from the zero of the law, degrees")
    return figure


def draw_grinding(study: LobeStudy, i: int) -> Figure:
    """Return wheel and roller on the same normal, with the angles of both from the axis."""
    phi, lift = float(np.degrees(study.path.phi[i])), float(study.path.lift[i])
    title = f"grinding: theta {study.theta_deg[i]:g}, phi {phi:.3f} degrees, S {lift:.4f} mm"
    figure, axes, at = _base_figure(study, i, title)
    _circle(axes, at.wheel, study.lobe.follower_mm, RED)
    _line(axes, at.foot, at.wheel, RED)
    _line(axes, 0j, at.wheel, BLUE)
    _line(axes, 0j, at.foot, GREY, 0.7)
    p = complex(-float(study.touch.p1[i]) * at.roller / abs(at.roller) * _UP)
    _line(axes, 0j, p, ORANGE)
    _mark(axes, p, "P", -1 + 1j)
    _mark(axes, at.roller, "O2")
    _mark(axes, at.wheel, "O1")
    reach = study.lobe.follower_mm
    axes.set_xlim(min(-40.0, at.wheel.real - 20), max(60.0, at.wheel.real + 20))
    axes.set_ylim(-30, at.wheel.imag + 0.15 * reach)
    return figure
