# SPDX-License-Identifier: Apache-2.0
"""Pictures of the cut of a camshaft: error of the profile, surface speed, rake, U over a turn.

>>> from camtools.lobe.motion import example_lobe, make_lobes
>>> [lobe] = make_lobes(example_lobe())
>>> speed_of_contact(lobe, np.zeros(1), np.ones(1)).tolist()
[28.0]
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.quantities import NM_PER_MM, Floats, Ints, length_unit
from camtools.lobe.motion import ShaftLobe
from camtools.lobe.report_text import LobeOutcome
from camtools.plots.panels import stacked
from camtools.plots.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    angle_axis,
    new_figure,
    stroke_of,
)
from camtools.report.charts import ChartPanel, TurnOfU, slope_of
from camtools.sim.results import CUTTING, CutTrace

ANGLE = "polar angle on the shaft"
_N_BINS = 720
_SPEED_TICKS = 10
_SLOPE_TICKS = 8  # over which a slope is taken: set-points are whole nanometres
_MARKS = 180
_MM_PER_M = 1000.0


def band(turn: Floats, values: Floats) -> tuple[Floats, Floats, Floats]:
    """Return angle [degrees], smallest and largest value of every bin of a turn that has any."""
    place = (np.mod(turn, 1) * _N_BINS).astype(np.int64).clip(0, _N_BINS - 1)
    least, most = np.full(_N_BINS, np.inf), np.full(_N_BINS, -np.inf)
    np.minimum.at(least, place, values)
    np.maximum.at(most, place, values)
    some = least <= most
    degrees: Floats = (np.arange(_N_BINS, dtype=np.float64) + 0.5) * (360 / _N_BINS)
    return degrees[some], least[some], most[some]


def _heights(lobe: ShaftLobe, z_mm: Floats) -> Floats:
    return np.asarray((z_mm >= lobe.z_mm[0]) & (z_mm <= lobe.z_mm[1]))


def draw_profile(outcome: LobeOutcome) -> Figure:
    """Return the error of every lobe's profile against the polar angle."""
    lobes, surface = outcome.generated.lobes, outcome.surface
    figure = new_figure(10, 1.2 + 2.4 * len(lobes))
    panels = figure.subplots(len(lobes), 1, sharex=True, squeeze=False)[:, 0]
    for i, (axes, lobe) in enumerate(zip(panels, lobes, strict=True)):
        rows = _heights(lobe, surface.z_mm)
        degrees, least, most = band(surface.turn[rows], surface.error_um[rows])
        largest_um = float(np.abs(np.concatenate([least, most])).max(initial=0.0))
        factor, unit = length_unit(largest_um)
        axes.fill_between(degrees, least * factor, most * factor, color=ORANGE, alpha=0.4, lw=0)
        axes.plot(degrees, most * factor, color=ORANGE, lw=1, label="largest of all turns")
        axes.plot(degrees, least * factor, color=BLUE, lw=1, label="smallest of all turns")
        axes.axhline(0, color=GREY, lw=0.8)
        axes.axvline(np.degrees(lobe.phase_rad) % 360, color=GREEN, lw=1, ls="--")
        name = f"lobe {i}, {lobe.z_mm[0]:g} .. {lobe.z_mm[1]:g} mm; dashed: zero of its law"
        axes.set_title(name, loc="left")
        axes.set_ylabel(f"error, {unit}\n(above 0: metal left)")
        axes.grid(alpha=0.3)
    panels[0].legend(frameon=False, loc="lower right", bbox_to_anchor=(1, 0.97), ncols=2)
    angle_axis(panels[-1], ANGLE)
    return figure


def speed_of_contact(lobe: ShaftLobe, phi_rad: Floats, omega_rad_s: Floats) -> Floats:
    """Return the speed of the contact along the profile [mm/s] at spindle angles."""
    return np.asarray(lobe.at(phi_rad).ds_dphi * omega_rad_s)


def _speed_of(trace: CutTrace) -> Floats:
    """Return the spindle's speed from its angle over some ticks to both sides [rad/s]."""
    k, speed = _SPEED_TICKS, np.full(trace.t_s.size, np.nan)
    if trace.t_s.size > 2 * k:
        turned = trace.turn[2 * k :] - trace.turn[: -2 * k]
        speed[k:-k] = 2 * np.pi * np.abs(turned) / (trace.t_s[2 * k :] - trace.t_s[: -2 * k])
    return speed


def _over_the_angle(lowest: Axes, named: Axes, height: float) -> None:
    """Make x the spindle's angle, and put the names of the curves above the panels."""
    named.legend(frameon=False, loc="upper left", bbox_to_anchor=(0, height), ncols=4)
    angle_axis(lowest, "spindle angle")


def draw_speed(outcome: LobeOutcome) -> Figure:
    """Return the speed of the contact against the spindle's angle, all turns of cutting."""
    figure = new_figure(10, 3.8)
    axes, trace = figure.add_subplot(), outcome.trace
    omega = _speed_of(trace)
    for i, lobe in enumerate(outcome.generated.lobes):
        rows = (trace.state == CUTTING) & _heights(lobe, trace.z_mm) & np.isfinite(omega)
        if not rows.any():
            continue
        phi = 2 * np.pi * np.mod(trace.turn[rows], 1)
        degrees, least, most = band(phi / (2 * np.pi), speed_of_contact(lobe, phi, omega[rows]))
        axes.fill_between(degrees, least, most, color=stroke_of(i)["color"], alpha=0.4, lw=0)
        axes.plot(degrees, most, **stroke_of(i), lw=1.2, label=f"lobe {i}")
    speed = outcome.summary["cam"].get("surface_speed_mm_s")
    if speed is not None:
        axes.axhline(speed["base_circle"], color=RED, lw=1.2, ls="--", label="base circle")
    axes.set_ylim(bottom=0)
    axes.set_ylabel("surface speed, mm/s")
    axes.grid(alpha=0.3)
    _over_the_angle(axes, axes, 1.16)
    return figure


def draw_rake(outcome: LobeOutcome) -> Figure:
    """Return the tool's line from the normal over the angle, with and without the swing."""
    swing_deg = outcome.swing_deg
    assert swing_deg is not None
    figure, trace = new_figure(10, 5.4), outcome.trace
    names = "off the ground rake,\ndegrees", "the same with the\nswing, degrees"
    above, below = stacked(figure, names)
    rows = trace.state == CUTTING
    lobe = outcome.generated.lobes[0]  # one is enough to see it
    rows &= _heights(lobe, trace.z_mm)
    pressure_deg = np.degrees(lobe.at(2 * np.pi * np.mod(trace.turn[rows], 1)).angle)
    turn, off_deg = trace.turn[rows], swing_deg[rows] - pressure_deg
    degrees, least, most = band(turn, -pressure_deg)
    above.plot(degrees, (least + most) / 2, color=ORANGE, lw=1.4, label="without the swing")
    degrees, least, most = band(turn, -off_deg)
    above.plot(degrees, (least + most) / 2, color=BLUE, lw=1.6, label="with the swing")
    below.fill_between(degrees, least, most, color=BLUE, alpha=0.5, lw=0.8)
    for axes in (above, below):
        axes.axhline(0, color=GREY, lw=0.8)
    _over_the_angle(below, above, 1.22)
    return figure


def whole_turn(trace: CutTrace) -> Ints:
    """Return the ticks of the turn in the middle of the cut; none where there is no whole one."""
    cutting = np.flatnonzero(trace.state == CUTTING)
    turns = np.floor(trace.turn[cutting]).astype(np.int64)
    inner = np.unique(turns)[1:-1]
    if not inner.size:
        return cutting[:0]
    return np.asarray(cutting[turns == inner[inner.size // 2]], dtype=np.int64)


def motion_of(outcome: LobeOutcome) -> TurnOfU | None:
    """Return U over a turn in the middle of the cut; nothing where no whole turn was cut."""
    rows = whole_turn(outcome.trace)
    if rows.size <= 4 * _SLOPE_TICKS:
        return None
    turn = outcome.trace.pick(rows)
    degrees: Floats = 360 * (turn.turn % 1)
    due_mm, is_mm = turn.u_due_nm / NM_PER_MM, turn.u_act_nm / NM_PER_MM
    velocity = slope_of(due_mm, turn.t_s, _SLOPE_TICKS)
    curves = (
        ("U towards the axis, mm", due_mm, is_mm),
        ("velocity, mm/s", velocity, slope_of(is_mm, turn.t_s, _SLOPE_TICKS)),
        ("acceleration, m/s²", slope_of(velocity, turn.t_s, _SLOPE_TICKS) / _MM_PER_M, None),
    )
    fine, coarse = (slice(None, None, max(1, rows.size // n)) for n in (1440, _MARKS))
    return TurnOfU(
        f"height {turn.z_mm.mean():.1f} mm",
        degrees[fine],
        [
            ChartPanel(name, wanted[fine], None if found is None else found[coarse])
            for name, wanted, found in curves
        ],
        "table",
        degrees[coarse],
        "spindle angle",
    )
