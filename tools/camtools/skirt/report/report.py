"""The report of a skirt: views, and pictures of corner, controller and equal volumes.

>>> REPORT.views[0].key, REPORT.views[-1].key
('fault', 'compare')
"""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.quantities import (
    MM_PER_M,
    NM_PER_MM,
    UM_PER_MM,
    Floats,
    Ints,
    length_unit,
    omega_rad_s,
)
from camtools.part.datum import Datum
from camtools.part.smoothing import sheet_note
from camtools.plots.style import (
    BLUE,
    GREY,
    ORANGE,
    PALE,
    RED,
    angle_axis,
    new_figure,
    nice_limit,
    stacked,
)
from camtools.report import views
from camtools.report.charts import ChartPanel, TurnOfU, slope_of
from camtools.report.kind_report import KindReport
from camtools.report.sheet import Subject
from camtools.report.surface import cells_of, map_rows
from camtools.sim.results import CUTTING, CutTrace, GaugedSurface, Removal
from camtools.skirt.geometry.corner import Corner
from camtools.skirt.geometry.profile import smoothed_curves, smoothing_takes_um, tolerances_left
from camtools.skirt.geometry.sections import fold
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.report.outcome import ROWS, Even, SkirtOutcome
from camtools.skirt.report.plots import draw_all, draw_clearance, draw_smoothing
from camtools.skirt.table.speed import SpeedTable, motion_played, worst_of

_PERCENT = 100.0
_N_ANGLES = 721
_ENLARGED = 30.0  # the part in space
_BETWEEN_PASSES = 1000  # ticks: engaging and disengaging take more
_SLOPE_TICKS = 4  # the measured position is quantised, so the slope is taken over 2 x 4 ticks
_ROOM_DEG = 14.0  # of the corner, to both sides
_CORNER_ANGLES, _CORNER_POINTS, _CORNER_TICKS = 1401, 120, 2
_RISING = 4  # turns at either end in which the feed rises or falls, or the chips of such a turn
_DOTS: dict[str, Any] = {"ls": "", "marker": "o", "ms": 3.2, "mfc": "none", "color": RED}


def draw_own(outcome: SkirtOutcome) -> Figure:
    """Return the error of the cut against what the table plays, over angle and height."""
    geometry, played = outcome.generated.geometry, outcome.control
    assert played is not None
    heights_mm = geometry.ends_mm
    n_rows = map_rows(heights_mm[1] - heights_mm[0], outcome.summary["cut"]["feed_mm"])
    limit_um = nice_limit(float(np.abs(played.error_um).max(initial=0.0)))
    factor, unit = length_unit(limit_um)
    figure = new_figure(10, 5.2)
    axes = figure.add_subplot()
    axes.set_facecolor(PALE)
    picture = axes.imshow(
        cells_of(played, heights_mm, n_rows).error_um * factor,
        extent=(0, 360, *heights_mm),
        origin="lower",
        aspect="auto",
        interpolation="nearest",
        cmap="RdBu_r",  # red: metal left, blue: cut too deep; safe for red-green blindness
        vmin=-limit_um * factor,
        vmax=limit_um * factor,
    )
    bar = figure.colorbar(picture, ax=axes, pad=0.02)
    bar.set_label(f"error against the {geometry.played_name}, {unit}  (above 0: metal left)")
    angle_axis(axes)
    axes.set_ylabel("skirt height, mm")
    return figure


def hardest_turn(trace: CutTrace, geometry: Geometry, ends_mm: tuple[float, float]) -> Ints:
    """Return the ticks of the whole turn of the last pass on the skirt in which U moves most."""
    low, high = ends_mm
    on_skirt = (trace.z_mm >= low) & (trace.z_mm <= high)
    cutting = np.flatnonzero((trace.state == CUTTING) & on_skirt)
    if not cutting.size:
        return cutting
    cutting = cutting[np.append(0, np.flatnonzero(np.diff(cutting) > _BETWEEN_PASSES) + 1)[-1] :]
    turned = trace.sense * trace.turn[cutting]
    whole = np.floor(turned).astype(np.int64)
    turns = np.arange(whole[0] + 1, whole[-1])
    if not turns.size:
        return cutting[:0]
    first = np.searchsorted(turned, turns)
    moves_mm = geometry.ovality_mm(trace.z_mm[cutting[first]])
    best = turns[int(np.argmax(moves_mm))]
    return np.asarray(cutting[whole == best], dtype=np.int64)


def _measured(turn: CutTrace) -> tuple[Floats, Floats, Floats]:
    """Return angle [degrees], place of U [um] and its velocity [mm/s] at some ticks of a turn."""
    u_mm = turn.u_act_nm / NM_PER_MM
    step = max(1, u_mm.size // 60)
    columns = 360 * (turn.turn % 1), u_mm * UM_PER_MM, slope_of(u_mm, turn.t_s, _SLOPE_TICKS)
    degrees, moved_um, slope = (column[::step] for column in columns)
    return degrees, moved_um, slope


def motion_of(outcome: SkirtOutcome) -> TurnOfU:
    """Return U, its velocity and acceleration over the turn in which U moves most."""
    generated, trace, geometry = outcome.generated, outcome.trace, outcome.generated.geometry
    law = generated.speed.channel if generated.speed is not None else None
    speed_rpm = outcome.summary["cut"]["spindle_rpm"]
    rows = hardest_turn(trace, geometry, generated.part.piston.skirt_mm)
    z_mm = float(trace.z_mm[rows].mean()) if rows.size else geometry.z_last_mm
    turns = np.linspace(0, 1, _N_ANGLES)
    u_mm, velocity, acceleration = motion_played(geometry, speed_rpm, z_mm, turns, law)
    u_mm = u_mm - generated.middle_nm / NM_PER_MM
    degrees, moved_um, slope = _measured(trace.pick(rows)) if rows.size else (None,) * 3
    mean = "mean " if law is not None else ""
    return TurnOfU(
        f"height {z_mm:.1f} mm, {mean}{speed_rpm:g} r/min",
        360 * turns,
        (
            ChartPanel("U towards the axis, µm", u_mm * UM_PER_MM, moved_um),
            ChartPanel("velocity, mm/s", trace.sense * velocity, slope),
            ChartPanel("acceleration, m/s²", acceleration / MM_PER_M),
        ),
        geometry.played_name,
        degrees,
    )


class Lines(NamedTuple):
    """Curves around the joint, each over `deg`."""

    deg: Floats  # angle from the long axis
    drawn_um: Floats  # radius reduction
    refit_um: Floats
    velocity_mm_s: Floats  # of U along the refit
    acceleration_m_s2: Floats


def around_joint(turn: Floats, joint_deg: float) -> Floats:
    """Return the distance from the joint [deg] of angles of all four quadrants."""
    folded, _ = fold(2 * np.pi * turn)
    return np.degrees(folded) - joint_deg


def lines_at(geometry: Geometry, corner: Corner, z_mm: float, spindle_rpm: float) -> Lines:
    """Return drawing, refit and the motion of U around the joint at a height."""
    joint_deg, omega = float(corner.joint_deg(z_mm)), omega_rad_s(spindle_rpm)
    deg = joint_deg + np.linspace(-_ROOM_DEG, _ROOM_DEG, _CORNER_ANGLES)
    u = geometry.delta(np.radians(deg), z_mm)
    drawn = geometry.drawing.delta(np.radians(deg), z_mm).delta
    return Lines(
        deg, drawn * UM_PER_MM, u.delta * UM_PER_MM, u.d1 * omega, u.d2 * omega**2 / MM_PER_M
    )


def _cut_points(
    geometry: Geometry, corner: Corner, cut: GaugedSurface, z_mm: float
) -> tuple[Floats, Floats]:
    """Return angle [deg] and distance from the drawing [um] of gauged points near a height."""
    joint_deg = float(corner.joint_deg(z_mm))
    off_deg = around_joint(cut.turn, joint_deg)
    half_band_mm = (geometry.z_last_mm - geometry.z_first_mm) / 100
    near = (np.abs(off_deg) < _ROOM_DEG) & (np.abs(cut.z_mm - z_mm) < half_band_mm)
    rows = np.flatnonzero(near)
    rows = rows[np.argsort(off_deg[rows], kind="stable")]
    rows = rows[:: max(1, rows.size // _CORNER_POINTS)]
    return joint_deg + off_deg[rows], -cut.error_um[rows]


def _corner_speed(trace: CutTrace, corner: Corner, z_mm: float) -> tuple[Floats, Floats]:
    """Return angle [deg] and velocity of U [mm/s] in the first quadrant's corner near a height."""
    cutting = np.flatnonzero(trace.state == CUTTING)
    if cutting.size < 2 * _CORNER_TICKS + 1:
        return np.empty(0), np.empty(0)
    nearest = cutting[int(np.argmin(np.abs(trace.z_mm[cutting] - z_mm)))]
    before = trace.sense if z_mm >= trace.z_mm[cutting[-1]] else 0
    whole = np.floor(trace.turn[nearest]) - before
    deg = 360 * (trace.turn - whole)
    joint_deg, k = float(corner.joint_deg(z_mm)), _CORNER_TICKS
    rows = np.flatnonzero((np.abs(deg - joint_deg) < _ROOM_DEG) & (trace.state == CUTTING))
    rows = rows[(rows >= k) & (rows < trace.t_s.size - k)]
    return deg[rows], slope_of(trace.u_act_nm / NM_PER_MM, trace.t_s, k)[rows]


def draw_corner(
    cut: GaugedSurface, trace: CutTrace, geometry: Geometry, spindle_rpm: float
) -> Figure:
    """Return contour, deviation, velocity and acceleration around the joint of a refit."""
    corner = geometry.corner
    assert corner is not None
    z_mm = corner.worst_mm
    lines = lines_at(geometry, corner, z_mm, spindle_rpm)
    names = ("reduction of\nthe radius, µm", "error, µm\n(above 0: metal left)")
    figure = new_figure(10, 8.6)
    panels = stacked(figure, (*names, "U velocity,\nmm/s", "U acceleration,\nm/s²"))
    deg, off_um = _cut_points(geometry, corner, cut, z_mm)
    drawn_um = np.interp(deg, lines.deg, lines.drawn_um)
    _contour(panels, lines, deg, drawn_um + off_um)
    panels[2].plot(lines.deg, trace.sense * lines.velocity_mm_s, color=ORANGE, lw=1.6, ls="--")
    panels[2].plot(*_corner_speed(trace, corner, z_mm), **_DOTS, label="measured on U")
    panels[3].plot(lines.deg, lines.acceleration_m_s2, color=ORANGE, lw=1.6, ls="--")
    for axes in panels:
        axes.axvline(float(corner.joint_deg(z_mm)), color=GREY, lw=1, ls=":")
    panels[0].set_title(f"height {z_mm:.1f} mm, {spindle_rpm:g} r/min; dotted: the joint")
    panels[0].legend(frameon=False, loc="lower left", ncols=3)
    panels[-1].set_xlabel("spindle angle from the long axis, degrees (all quadrants folded)")
    panels[-1].set_xlim(lines.deg[0], lines.deg[-1])
    return figure


def _contour(panels: list[Axes], lines: Lines, deg: Floats, cut_um: Floats) -> None:
    panels[0].plot(lines.deg, lines.drawn_um, color=BLUE, lw=1.4, label="drawing")
    panels[0].plot(lines.deg, lines.refit_um, color=ORANGE, lw=1.6, ls="--", label="refit")
    panels[0].plot(deg, cut_um, **_DOTS, label="cut")
    panels[0].invert_yaxis()
    panels[1].axhline(0, color=BLUE, lw=1.4)
    panels[1].plot(lines.deg, lines.drawn_um - lines.refit_um, color=ORANGE, lw=1.6, ls="--")
    panels[1].plot(deg, np.interp(deg, lines.deg, lines.drawn_um) - cut_um, **_DOTS)


def ripple_by_turn(removal: Removal) -> tuple[Floats, Floats]:
    """Return mean height [mm] and (largest - least) / mean of the rate of every turn."""
    whole = np.floor(removal.turn).astype(np.int64)
    starts = np.flatnonzero(np.diff(whole, prepend=whole[0] - 1))
    count = np.diff(np.append(starts, whole.size))
    least = np.minimum.reduceat(removal.rate_mm3_s, starts)
    most = np.maximum.reduceat(removal.rate_mm3_s, starts)
    mean = np.add.reduceat(removal.rate_mm3_s, starts) / count
    z_mm = np.add.reduceat(removal.z_mm, starts) / count
    return z_mm, (most - least) / mean


def turn_near(removal: Removal, z_mm: float) -> Removal:
    """Return the slices of the whole turn nearest to a height."""
    whole = np.floor(removal.turn)
    turns = np.unique(whole)[1:-1]
    if not turns.size:
        return removal
    middle = np.array([removal.z_mm[whole == turn].mean() for turn in turns])
    best = turns[int(np.argmin(np.abs(middle - z_mm)))]
    return Removal(*(column[whole == best] for column in removal))


def draw_even(even: Even, speed: SpeedTable, spindle_rpm: float) -> Figure:
    """Return speed, rate, power and both forces over one turn where the ripple is largest."""
    worst = worst_of(speed)
    z_mm, law = float(speed.z_mm[worst]), speed.laws[worst]
    forces = ("force, papers'\nmodel, N", "force of the\nchip, N")
    figure = new_figure(10, 10)
    panels = stacked(figure, ("spindle, r/min", "removal rate,\nmm³/s", "power, W", *forces))
    ours, theirs = turn_near(even.removal, z_mm), turn_near(even.uniform_removal, z_mm)
    deg = np.linspace(0, 360, 721)
    panels[0].plot(deg, spindle_rpm * law.ratio(np.radians(deg)), color=BLUE, label="equal volume")
    # between the middles of the slices; with M4 the drawing's angle falls
    measured_rpm = 60 * np.abs(np.gradient(ours.turn, ours.t_s))
    panels[0].plot(360 * (ours.turn % 1), measured_rpm, label="spindle, measured", **_DOTS)
    panels[0].axhline(spindle_rpm, color=GREY, ls="--", label="uniform turning")
    names = ("rate_mm3_s", "power_w", "rate_force_n", "chip_force_n")
    for axes, name in zip(panels[1:], names, strict=True):
        for removal, colour, style in ((theirs, GREY, "--"), (ours, BLUE, "-")):
            order = np.argsort(removal.turn % 1, kind="stable")
            place = 360 * (removal.turn % 1)[order]
            axes.plot(place, getattr(removal, name)[order], color=colour, ls=style)
        axes.set_ylim(bottom=0)
    panels[0].set_title(f"height {z_mm:.1f} mm, mean {spindle_rpm:g} r/min", loc="left")
    panels[0].legend(frameon=False, loc="lower right", bbox_to_anchor=(1, 0.97), ncols=3)
    angle_axis(panels[-1])
    return figure


def draw_ripple(even: Even, speed: SpeedTable) -> Figure:
    """Return the ripple of the removal rate over height: measured, planned, uniform."""
    figure = new_figure(10, 4)
    axes = figure.add_subplot()
    for removal, colour, name in (
        (even.uniform_removal, GREY, "uniform turning, measured"),
        (even.removal, RED, "equal volume, measured"),
    ):
        z_mm, ripple = ripple_by_turn(removal)
        full = slice(_RISING, -_RISING)
        axes.plot(z_mm[full], _PERCENT * ripple[full], color=colour, lw=1.4, label=name)
    laws = _PERCENT * speed.played
    blended = [_PERCENT * law.ripple for law in speed.partial]
    axes.plot(speed.z_mm, laws, color=BLUE, ls="", marker="o", ms=4, label="promised by the table")
    axes.plot(
        speed.z_mm, blended, color=ORANGE, ls="", marker="x", ms=5, label="partial modulation"
    )
    axes.set_ylim(bottom=0)
    axes.set_xlabel("skirt height, mm")
    axes.set_ylabel("ripple of the removal rate,\n% of its mean in the turn")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, ncols=2)
    return figure


def _space(cut: SkirtOutcome) -> int:
    """Return by how much to enlarge the part in space; its drawing may be enlarged already."""
    magnify = cut.generated.part.magnify
    return max(1, round(_ENLARGED / (magnify.factor if magnify else 1.0)))


def _draw_even(cut: SkirtOutcome) -> Figure:
    assert cut.even is not None and cut.generated.speed is not None
    return draw_even(cut.even, cut.generated.speed, cut.summary["cut"]["spindle_rpm"])


def _draw_ripple(cut: SkirtOutcome) -> Figure:
    assert cut.even is not None and cut.generated.speed is not None
    return draw_ripple(cut.even, cut.generated.speed)


def _is_even(cut: SkirtOutcome) -> bool:
    """Return whether removal rates beside those of uniform turning are known."""
    has_law = cut.generated.speed is not None
    return cut.even is not None and has_law and bool(cut.even.removal.turn.size)


def _subject(cut: SkirtOutcome) -> Subject:
    part = cut.generated.part
    note = sheet_note(cut.summary["form_error_um"], smoothing_takes_um(part))
    return Subject(
        True,
        True,
        tolerances=tolerances_left(part),
        note=note,
        windows=part.piston.window_areas,
        datum=part.piston.datum or Datum(),
        drawn_mm=cut.generated.geometry.drawn_mm,
    )


_VIEWS: tuple[views.View[SkirtOutcome], ...] = (
    views.fault_view(
        "U must leave the work first, within a few milliseconds, and the tool tip must not move "
        "towards the axis (below 0) after the dashed line. X follows more slowly, and the spindle "
        "runs down by itself."
    ),
    views.View(
        "own",
        "Error map of the controller alone",
        "The table plays a refit or a filtered form of the drawing; this map compares the cut with "
        "that, so it shows what machine and controller add. The verdict uses the map above.",
        draw_own,
        lambda cut: views.has_surface(cut) and cut.control is not None,
    ),
    views.View(
        "corner",
        "The corner",
        "Where ellipse and circle of the drawing meet, there is a corner that no axis can follow. "
        "A spline replaces it: it keeps U's acceleration (bottom) finite and deviates from the "
        "drawing as the second picture shows. The cut must lie on this refit; its deviation "
        "counts in the form error.",
        lambda cut: draw_corner(
            *(cut.surface, cut.trace, cut.generated.geometry, cut.summary["cut"]["spindle_rpm"])
        ),
        lambda cut: views.has_surface(cut) and cut.generated.geometry.corner is not None,
    ),
    views.View(
        "smoothing",
        "Smoothing of listed points",
        "By how much smoothing moved the points of the drawing, in diameter or ovality; the dashed "
        "lines are the band of smooth_um. Residuals that stay on one side over many points mean "
        "that the band is too wide for the shape.",
        lambda cut: draw_smoothing(cut.generated),
        lambda cut: bool(smoothed_curves(cut.generated.part.piston)),
    ),
    views.View(
        "clearance",
        "Cold, coated and hot",
        "The part is turned cold and bare; the map shows the radial clearance to the bore in the "
        "last state, by the growth law and the coating of the part file, of a perfect cut.",
        lambda cut: draw_clearance(cut.generated),
        lambda cut: cut.generated.part.piston.has_fit,
    ),
    views.LEARNING,
    views.motion_view(
        "U swings in and out twice per turn; the measured points must lie on the drawn curve in "
        "position and in velocity. The peaks of velocity and acceleration are what the machine "
        "limits above are compared with.",
        motion_of,
    ),
    views.View(
        "even",
        "Equal-volume turning",
        "The spindle slows down where the chip is deep, so that removal rate and power stay even; "
        "dashed: the same part at constant speed. The chip force does not change, since neither "
        "depth nor feed depend on the speed: the papers' claim of a constant force holds only for "
        "their model, in which force is proportional to the removal rate.",
        _draw_even,
        _is_even,
    ),
    views.View(
        "ripple",
        "Ripple of the removal rate",
        "Largest minus smallest rate of every turn, over the height, measured on the workpiece. If "
        "the spindle's acceleration allows it, the rate is constant; otherwise the table holds "
        "the law of least ripple, which must lie below the papers' partial modulation.",
        _draw_ripple,
        _is_even,
    ),
    views.following_view(
        "Difference between the actual and the demanded position of U; the band covers every turn "
        "of the cut. The shape of the velocity curve points to a wrong dead time or k1, that of "
        "the acceleration curve to a wrong k2; a thin band means that all turns are alike."
    ),
    views.SEQUENCE,
    views.COMPARE,
)
REPORT = KindReport(
    what="skirt",
    angle="spindle angle from the long axis",
    heights_mm=lambda cut: cut.generated.geometry.ends_mm,
    rows=ROWS,
    views=_VIEWS,
    subject=_subject,
    hint="Stripes at fixed angles point to U, its timing or the spindle speed; bands at fixed "
    "heights to X or to engaging; an even colour to the tool setting.",
    space=_space,
    pictures=draw_all,
)
