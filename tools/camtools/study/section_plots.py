"""Pictures of the analysis of one section.

>>> from camtools.study.section import AnalysisWishes, make_analysis
>>> from camtools.skirt.part.part_file import example_part
>>> sorted(draw_all(make_analysis(example_part(), AnalysisWishes())))[:2]
['area', 'forces']
"""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.quantities import Floats
from camtools.cut.removal import TURN_RAD, motion_at
from camtools.plots.panels import legend_below, pictures, stacked
from camtools.plots.style import BLUE, GREY, ORANGE, PALE, RED, angle_axis, new_figure
from camtools.study.section import Analysis

_TURN_DEG = np.linspace(0, 360, 1441)
_UM_PER_MM, _MM_PER_M = 1000.0, 1000.0


def _panels(study: Analysis, title: str, *names: str) -> tuple[Figure, list[Axes]]:
    """Return panels below each other under what is drawn of the section."""
    figure = new_figure(9, 8)
    figure.suptitle(_title(study, title))
    return figure, stacked(figure, names)


def _title(study: Analysis, what: str) -> str:
    return f"{study.name}, height {study.height_mm:g} mm: {what}"


def draw_area(study: Analysis) -> Figure:
    """Return depth, change of depth and area in equal steps of angle."""
    names = ("depth of cut, µm", "change of depth\nper step, µm", "area per step, mm²")
    figure, panels = _panels(study, "what is cut in equal steps of angle", *names)
    steps, deg = study.steps, np.degrees(study.steps.phi_rad)
    width = 0.8 * (deg[1] - deg[0])
    panels[0].plot(deg, steps.depth_mm * _UM_PER_MM, color=BLUE, marker="o", ms=3)
    middle = (deg[1:] + deg[:-1]) / 2
    panels[1].bar(middle, steps.change_mm[1:] * _UM_PER_MM, width=width, color=ORANGE)
    panels[2].bar(middle, steps.area_mm2[1:], width=width, color=BLUE)
    panels[-1].set_xlabel("angle from the long axis, degrees")
    return figure


def draw_parts(study: Analysis) -> Figure:
    """Return the parts of equal area on the section, and their width and depth."""
    figure = new_figure(10, 5)
    figure.suptitle(_title(study, f"{study.parts.phi_rad.size} parts of equal area"))
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.2])
    _section(left, study)
    parts = study.parts
    number = np.arange(1, parts.phi_rad.size + 1)
    right.plot(number, np.degrees(parts.width_rad), color=BLUE, marker="o", ms=3)
    right.set_ylabel("width, degrees", color=BLUE)
    right.set_xlabel("number of the part from the long axis")
    right.grid(alpha=0.3)
    other = right.twinx()
    other.plot(number, parts.change_mm * _UM_PER_MM, color=ORANGE, marker="s", ms=3)
    other.set_ylabel("change of depth, µm", color=ORANGE)
    return figure


def _section(axes: Axes, study: Analysis) -> None:
    """Draw blank and section, the chip enlarged to a third of the radius, with the borders."""
    phi = np.linspace(0, study.cut.pattern_rad, 721)
    depth = study.cut.depth_mm(phi)
    factor = 0.35 / float(depth.max())
    inner = 1 - factor * depth
    for radius, colour in ((np.ones_like(phi), GREY), (inner, BLUE)):
        axes.plot(radius * np.cos(phi), radius * np.sin(phi), color=colour)
    chip = np.concatenate([np.ones_like(phi), inner[::-1]])
    around = np.concatenate([phi, phi[::-1]])
    axes.fill(chip * np.cos(around), chip * np.sin(around), color=PALE)
    borders = np.append(0.0, study.parts.phi_rad)
    low = 1 - factor * study.cut.depth_mm(borders)
    for angle, foot in zip(borders, low, strict=True):
        axes.plot(
            [foot * np.cos(angle), np.cos(angle)],
            [foot * np.sin(angle), np.sin(angle)],
            color=BLUE,
            lw=0.7,
        )
    axes.set_aspect("equal")
    axes.axis("off")
    times = factor * study.cut.blank_mm
    axes.set_title(f"chip between blank and part, enlarged {times:.0f} times", fontsize=9.5)


def draw_speed(study: Analysis) -> Figure:
    """Return speed, acceleration and removal rate over a turn, uniform and equal-volume."""
    title = f"spindle at constant removal rate, mean {study.rpm:g} r/min"
    names = ("spindle speed, r/min", "acceleration, rad/s²", "removal rate, mm³/s")
    figure, panels = _panels(study, title, *names)
    phi, omega = np.radians(_TURN_DEG), TURN_RAD * study.rpm / 60
    ratio, product, _, _ = motion_at(study.cut, phi)
    rate = study.feed_mm * study.cut.area_rate_mm2(phi) * omega
    _both(panels[0], np.full(phi.size, study.rpm), ratio * study.rpm)
    _both(panels[1], np.zeros(phi.size), product * omega**2)
    _both(panels[2], rate, rate * ratio)
    legend_below(figure, panels[0], 2)
    angle_axis(panels[-1])
    return figure


def _both(axes: Axes, uniform: Floats, even: Floats) -> None:
    axes.plot(_TURN_DEG, uniform, color=GREY, ls="--", label="uniform")
    axes.plot(_TURN_DEG, even, color=BLUE, label="equal volume")


def draw_motion(study: Analysis) -> Figure:
    """Return U, its speed and acceleration over time, uniform and equal-volume."""
    title = f"U over one turn in time, mean {study.rpm:g} r/min"
    names = ("U, µm", "speed of U, mm/s", "acceleration of U, m/s²")
    figure, panels = _panels(study, title, *names)
    phi, omega = np.radians(_TURN_DEG), TURN_RAD * study.rpm / 60
    u = study.cut.delta(phi)
    ratio, _, speed, motion = motion_at(study.cut, phi)
    steps = np.diff(phi) * (1 / ratio[1:] + 1 / ratio[:-1]) / 2
    even_ms = 1000 * np.concatenate([[0.0], np.cumsum(steps)]) / omega
    uniform_ms = 1000 * phi / omega
    curves = (
        (u.delta * _UM_PER_MM, u.delta * _UM_PER_MM),
        (u.d1 * omega, speed * omega),
        (u.d2 * omega**2 / _MM_PER_M, motion * omega**2 / _MM_PER_M),
    )
    for axes, (uniform, even) in zip(panels, curves, strict=True):
        axes.plot(uniform_ms, uniform, color=GREY, ls="--", label="uniform")
        axes.plot(even_ms, even, color=BLUE, label="equal volume")
    legend_below(figure, panels[0], 2)
    panels[-1].set_xlabel("time from the long axis, ms")
    return figure


def draw_forces(study: Analysis) -> Figure:
    """Return the force over a turn in both models, and the power."""
    title = f"forces, kc = {study.kc_n_mm2:g} N/mm²"
    figure, panels = _panels(study, title, "force, N", "force, N", "power, W")
    phi, omega = np.radians(_TURN_DEG), TURN_RAD * study.rpm / 60
    ratio = study.cut.speed_ratio(phi)
    area = study.cut.area_rate_mm2(phi)
    slice_rad = study.cut.pattern_rad / study.parts.phi_rad.size
    _both(panels[0], study.kc_n_mm2 * area * slice_rad, study.kc_n_mm2 * area * ratio * slice_rad)
    depth_mm = study.cut.depth_mm(phi)
    panels[1].plot(
        _TURN_DEG, study.chip_n(depth_mm), color=RED, label="uniform and equal volume alike"
    )
    specific = study.force.specific_n_mm2(depth_mm, study.feed_mm)
    power = specific * study.feed_mm * area * omega / 1000
    _both(panels[2], power, power * ratio)
    panels[0].set_title("the papers' model: proportional to the area cut in one slice of time")
    panels[1].set_title("physical model: section of the chip, whatever the speed")
    panels[1].legend(frameon=False, loc="lower right")
    legend_below(figure, panels[0], 2)
    for axes in panels:
        axes.set_ylim(bottom=0)
    angle_axis(panels[-1])
    return figure


def draw_harmonics(study: Analysis) -> Figure:
    """Return the waves of U per turn, uniform and equal-volume."""
    figure = new_figure(9, 4)
    axes = figure.add_subplot()
    n = np.arange(1, study.waves_mm.size)
    uniform, even = (np.abs(one[1:]) for one in (study.uniform_waves_mm, study.waves_mm))
    axes.bar(n - 0.2, uniform * _UM_PER_MM, width=0.38, color=GREY, label="uniform")
    axes.bar(n + 0.2, even * _UM_PER_MM, width=0.38, color=BLUE, label="equal volume")
    axes.set_yscale("log")
    axes.set_ylim(bottom=1e-3)
    axes.set_xticks(n)
    axes.set_xlabel("waves per turn of the spindle")
    axes.set_ylabel("amplitude of U, µm")
    axes.set_title(_title(study, "waves of U in time"))
    axes.legend(frameon=False)
    return figure


def draw_all(study: Analysis) -> dict[str, bytes]:
    """Return all pictures as PNG by topic."""
    drawers = {
        "area": draw_area,
        "parts": draw_parts,
        "speed": draw_speed,
        "motion": draw_motion,
        "forces": draw_forces,
        "harmonics": draw_harmonics,
    }
    return pictures({topic: partial(draw, study) for topic, draw in drawers.items()})
