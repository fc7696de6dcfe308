"""Pictures of a camshaft: the tool around a lobe, the axes over a turn, and the cut.

>>> from camtools.lobe.generate import generate_lobes
>>> from camtools.lobe.motion import example_lobe
>>> draw_lobes(generate_lobes(example_lobe()))["cam"][1:4]
b'PNG'

>>> from camtools.lobe.motion import example_lobe, make_lobes
>>> [lobe] = make_lobes(example_lobe())
>>> speed_of_contact(lobe, np.zeros(1), np.ones(1)).tolist()
[28.0]
"""

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.quantities import MM_PER_M, NM_PER_MM, Floats, Ints
from camtools.lobe.channels import patterns_of
from camtools.lobe.contact import Contact, Follower
from camtools.lobe.generate import GeneratedLobes
from camtools.lobe.lift import Listed, Smoothing
from camtools.lobe.motion import ShaftLobe, profiles_of
from camtools.lobe.summary import LobeOutcome
from camtools.plots.style import (
    BLUE,
    GREY,
    ORANGE,
    RED,
    angle_axis,
    log_axis,
    new_figure,
    nice_floor,
    nice_limit,
    pictures,
    stacked,
    stroke_of,
    titled_figure,
)
from camtools.report.charts import ChartPanel, TurnOfU, slope_of
from camtools.report.surface import over_turn
from camtools.sim.results import CUTTING, CutTrace
from camtools.table.channel import RATIO_ONE
from camtools.table.evaluate import evaluate_at

_N_ANGLES = 3601
_SHOWN = 8  # lobes of a profile that are named one by one
_TOOLS_DEG = (-60, -40, -20, 0, 20, 40, 60, 120, 180, 240)
_WHEELS_DEG = (-70, -55, -35, -15, 0, 15, 35, 55, 70, 180)
_CAM, _LINE, _NORMAL, _PATH = "#dfe6ee", "#2a4d77", "#c0392b", "#7f8c8d"


def _turned(radius: Floats, angle_rad: Floats) -> tuple[Floats, Floats]:
    return radius * np.cos(angle_rad), radius * np.sin(angle_rad)


def name_of(result: GeneratedLobes, profile: int) -> str:
    """Return the lobes of a profile and their law, as pictures name them."""
    numbers = [i for i, lobe in enumerate(result.lobes) if lobe.profile == profile]
    law = result.part.cam.lobe[numbers[0]].law
    shown = ", ".join(map(str, numbers[:_SHOWN])) + (", ..." if len(numbers) > _SHOWN else "")
    return f"lobe{'s' if len(numbers) > 1 else ''} {shown}: {law}"


def _outline(
    axes: Axes, lobe: ShaftLobe, *, turned_rad: float = 0.0, number: int | None = None
) -> None:
    phi = np.linspace(0, 2 * np.pi, _N_ANGLES) + lobe.phase_rad
    touch, path = lobe.contacts(phi)
    up = np.pi / 2 + turned_rad
    if number is not None:
        axes.plot(*_turned(touch.radius, touch.alpha + up), **stroke_of(number), lw=1.3)
        return
    axes.fill(*_turned(touch.radius, touch.alpha + up), fc=_CAM, ec=_LINE, lw=1.5, zorder=2)
    axes.plot(*_turned(path.centre, path.phi + up), color=_PATH, lw=0.8, ls="--")
    axes.plot([0], [0], marker="+", color=_LINE, zorder=4)


def _at(touch: Contact, path: Follower, i: int) -> tuple[complex, complex]:
    """Return contact and centre of the follower in the plane, nose upwards."""
    contact = touch.radius[i] * np.exp(1j * (touch.alpha[i] + np.pi / 2))
    return complex(contact), complex(path.centre[i] * np.exp(1j * (path.phi[i] + np.pi / 2)))


def _segment(axes: Axes, start: complex, end: complex, colour: str, width: float) -> None:
    axes.plot([start.real, end.real], [start.imag, end.imag], color=colour, lw=width, zorder=3)


def _followers(axes: Axes, lobe: ShaftLobe, *, is_turned: bool) -> None:
    degrees = np.array(_TOOLS_DEG if is_turned else _WHEELS_DEG, dtype=float)
    touch, path = lobe.contacts(np.radians(degrees) + lobe.phase_rad)
    around = np.exp(1j * np.linspace(0, 2 * np.pi, _N_ANGLES))
    for i in range(degrees.size):
        contact, centre = _at(touch, path, i)
        circle = centre + lobe.follower_mm * around
        axes.plot(circle.real, circle.imag, color=_LINE, lw=0.5, alpha=0.5)
        _segment(axes, contact, centre, _NORMAL, 1.6 if is_turned else 0.7)
        if is_turned:
            _segment(axes, 0j, centre, _PATH, 0.5)
            out = centre + 3.6 * centre / abs(centre)
            label = f"{round(float(np.degrees(path.angle[i])), 1) + 0.0:.1f}°"
            paper = {"facecolor": "white", "lw": 0, "pad": 0.6}
            look: dict[str, Any] = {"ha": "center", "va": "center", "bbox": paper, "zorder": 6}
            axes.text(out.real, out.imag, label, fontsize=8, **look)
        axes.plot([contact.real], [contact.imag], "o", color=_NORMAL, ms=3.5, zorder=5)


def _reach(lobes: list[ShaftLobe]) -> float:
    phi = np.linspace(-np.pi, np.pi, 361)
    return max(float(lobe.contacts(phi)[0].radius.max()) for lobe in lobes)


def _square(axes: Axes, reach_mm: float, title: str) -> None:
    limits = (-reach_mm, reach_mm)
    axes.set(xlim=limits, ylim=limits, aspect="equal", xlabel="mm", ylabel="mm", title=title)


def _shaft(axes: Axes, result: GeneratedLobes) -> None:
    reach = 1.35 * _reach(profiles_of(result.lobes))
    for i, lobe in enumerate(result.lobes):
        _outline(axes, lobe, turned_rad=lobe.phase_rad, number=i)
        nose = np.exp(1j * (lobe.phase_rad + np.pi / 2)) * reach * (0.86 + 0.09 * (i % 2))
        axes.text(
            nose.real, nose.imag, str(i), color=stroke_of(i)["color"], ha="center", va="center"
        )
    axes.plot([0], [0], marker="+", color=_LINE)
    _square(axes, reach, "all lobes, seen from the headstock, 0° upwards")


def draw_positions(result: GeneratedLobes) -> Figure:
    """Return every profile with tool or wheel around it, and all lobes at their angles."""
    profiles, is_turned = profiles_of(result.lobes), result.part.process.operation == "turning"
    what = "tool (red) about the roller's centre, with its swing"
    if not is_turned:
        what = f"wheel of radius {profiles[0].follower_mm:g} mm (grey); contacts and normals red"
    n = len(profiles) + (len(result.lobes) > 1)
    columns = 2 if n == 4 else min(n, 3)
    rows = -(-n // columns)
    title = f"{result.table.part_name}: {what}"
    figure = titled_figure(7.5 if n == 1 else 5.6 * columns, 7.5 if n == 1 else 5.9 * rows, title)
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    for axes, lobe in zip(panels, profiles, strict=False):
        _outline(axes, lobe)
        _followers(axes, lobe, is_turned=is_turned)
        reach = 1.35 * _reach([lobe]) + (2 * lobe.roller_mm if is_turned else 0)
        _square(axes, reach, name_of(result, lobe.profile))
    if len(result.lobes) > 1:
        _shaft(panels[len(profiles)], result)
    for axes in panels[n:]:
        axes.set_axis_off()
    return figure


def _omega(result: GeneratedLobes, phi: Floats, pattern: int) -> Floats:
    """Return the spindle's speed [r/min] as the table has it."""
    if result.speed is None:
        return np.full(phi.size, result.mean_rpm)
    channel = result.speed.channel
    height = float(pattern) if channel.has_patterns else float(channel.z_first_nm)
    ratio = evaluate_at(channel, phi / (2 * np.pi), np.full(phi.size, height)).value
    return np.asarray(ratio / RATIO_ONE * result.mean_rpm, dtype=np.float64)


def _ends(axes: Axes) -> tuple[float, float]:
    """Return round ends of a logarithmic axis for the lines that are drawn."""
    values = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in axes.lines])
    return nice_floor(float(np.nanmin(values))), nice_limit(float(np.nanmax(values)))


def draw_motion(result: GeneratedLobes) -> Figure:
    """Return lift, pressure angle, radius of curvature, spindle and surface speed over a turn."""
    what = "turned" if result.part.process.operation == "turning" else "ground"
    figure = titled_figure(
        8.5, 10, f"{result.table.part_name}, {what}: over one turn of the spindle"
    )
    angle = "pressure" if what == "turned" else "contact"
    names = ["lift, mm", f"{angle} angle, °", "radius of\ncurvature, mm"]
    panels = stacked(figure, [*names, "spindle, r/min", "surface speed,\nmm/s"])
    name, ticks = "spindle angle, degrees", range(-180, 181, 30)
    panels[-1].set(xlabel=name, xticks=ticks, xlim=(-180, 180))
    degrees = np.linspace(-180, 180, _N_ANGLES)
    for pattern, lobe in enumerate(patterns_of(result.lobes)):
        phi = np.radians(degrees)
        touch, path = lobe.contacts(phi)
        rpm = _omega(result, phi, pattern)
        radius = np.where(touch.curvature > 1e-3, 1 / touch.curvature, np.nan)
        surface = path.ds_dphi * rpm * 2 * np.pi / 60
        curves = (path.lift, np.degrees(path.angle), radius, rpm, surface)
        for axes, values in zip(panels, curves, strict=True):
            name = name_of(result, lobe.profile)
            axes.plot(degrees, values, **stroke_of(pattern), label=name, lw=1.4)
    if len(result.lobes) > 1:
        panels[0].legend(frameon=False)
        panels[-1].set_xlabel("angle from the zero of the law, degrees")
    log_axis(panels[2], "y", *_ends(panels[2]))
    panels[3].set_ylim(bottom=0)
    return figure


def draw_smoothing(result: GeneratedLobes) -> Figure:
    """Return the residuals of smoothed lists, and acceleration and jerk before and after."""
    figure = titled_figure(8.5, 8, f"{result.table.part_name}: smoothed lists of lift")
    names = ["residual, µm", "acceleration,\nmm/rad²", "jerk, mm/rad³"]
    panels = stacked(figure, names)
    for i, (name, smoothing) in enumerate(smoothed_lists(result)):
        panels[0].plot(
            smoothing.angle_deg, smoothing.off_um, ".", ms=3, color=stroke_of(i)["color"]
        )
        for edge_um in (-smoothing.band_um, smoothing.band_um):
            panels[0].axhline(edge_um, lw=0.8, ls="--", color=_PATH)
        degrees = np.linspace(smoothing.angle_deg[0], smoothing.angle_deg[0] + 360, _N_ANGLES)
        for axes, n in zip(panels[1:], (2, 3), strict=True):
            axes.plot(degrees, smoothing.before(np.radians(degrees), nu=n), lw=0.5, color=_PATH)
            after = smoothing.after(np.radians(degrees), nu=n)
            axes.plot(degrees, after, **stroke_of(i), lw=1.4, label=name)
    panels[1].legend(frameon=False)
    panels[-1].set_xlabel("angle of the list in degrees of the cam")
    return figure


def smoothed_lists(result: GeneratedLobes) -> list[tuple[str, Smoothing]]:
    """Return the smoothing of each profile that has it, by the name of the profile."""
    return [
        (name_of(result, lobe.profile), lobe.law.smoothing)
        for lobe in profiles_of(result.lobes)
        if isinstance(lobe.law, Listed) and lobe.law.smoothing is not None
    ]


def draw_lobes(result: GeneratedLobes) -> dict[str, bytes]:
    """Return all pictures of a camshaft as PNG, by topic."""
    drawers = {"cam": draw_positions, "motion": draw_motion}
    drawers |= {"smoothing": draw_smoothing} if smoothed_lists(result) else {}
    return pictures({topic: partial(draw, result) for topic, draw in drawers.items()})


ANGLE = "polar angle on the shaft"
_N_BINS = 720
_SPEED_TICKS = 10
_SLOPE_TICKS = 8  # over which a slope is taken: set-points are whole nanometres
_MARKS = 180


def _heights(lobe: ShaftLobe, z_mm: Floats) -> Floats:
    return np.asarray((z_mm >= lobe.z_mm[0]) & (z_mm <= lobe.z_mm[1]))


def speed_of_contact(lobe: ShaftLobe, phi_rad: Floats, omega_rad_s: Floats) -> Floats:
    """Return the speed of the contact along the profile [mm/s] at spindle angles."""
    return np.asarray(lobe.at(phi_rad).ds_dphi * omega_rad_s)


def _over_the_angle(lowest: Axes, named: Axes, height: float) -> None:
    """Make x the spindle's angle, and put the names of the curves above the panels."""
    named.legend(frameon=False, loc="upper left", bbox_to_anchor=(0, height), ncols=4)
    angle_axis(lowest, "spindle angle")


def draw_speed(outcome: LobeOutcome) -> Figure:
    """Return the speed of the contact against the spindle's angle, all turns of cutting."""
    figure = new_figure(10, 3.8)
    axes, trace = figure.add_subplot(), outcome.trace
    omega = 2 * np.pi * np.abs(slope_of(trace.turn, trace.t_s, _SPEED_TICKS))  # rad/s
    for i, lobe in enumerate(outcome.generated.lobes):
        rows = (trace.state == CUTTING) & _heights(lobe, trace.z_mm) & np.isfinite(omega)
        if not rows.any():
            continue
        phi = 2 * np.pi * np.mod(trace.turn[rows], 1)
        speed_mm_s = speed_of_contact(lobe, phi, omega[rows])
        degrees, least, most, _ = over_turn(trace.turn[rows], speed_mm_s, _N_BINS)
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
    degrees, least, most, _ = over_turn(turn, -pressure_deg, _N_BINS)
    above.plot(degrees, (least + most) / 2, color=ORANGE, lw=1.4, label="without the swing")
    degrees, least, most, _ = over_turn(turn, -off_deg, _N_BINS)
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
        ("acceleration, m/s²", slope_of(velocity, turn.t_s, _SLOPE_TICKS) / MM_PER_M, None),
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
