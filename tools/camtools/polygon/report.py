"""The report of a polygon, and pictures of its section, the motion of U and the blend of a joint.

>>> REPORT.views[0].key, REPORT.views[-1].key
('fault', 'compare')
"""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from camtools.base.quantities import MM_PER_M, NM_PER_MM, UM_PER_MM, Floats, omega_rad_s
from camtools.part.areas import ZonedTolerances
from camtools.plots.style import (
    BLUE,
    GREY,
    ORANGE,
    PALE,
    RED,
    angle_axis,
    around,
    new_figure,
    pictures,
    stacked,
    titled_figure,
)
from camtools.polygon.generate import Blend, GeneratedPolygon
from camtools.polygon.outline import measures_of, shifted
from camtools.polygon.summary import ROWS, PolygonCut, angles_of, name_of
from camtools.report import views
from camtools.report.charts import ChartPanel, TurnOfU
from camtools.report.kind_report import KindReport
from camtools.report.sheet import Subject
from camtools.sim.results import CUTTING, CutTrace

_WINDOW = 2.2  # half width of the picture of a blend over that of the blend
_N_WINDOW = 801
BLEND_NAMES = ("off the drawing, µm\n(above 0: metal left)", "acceleration of U, m/s²")


def draw_section(made: GeneratedPolygon) -> Figure:
    """Return the first section to scale between its circles, joints marked."""
    figure = titled_figure(7.5, 7.9, f"{made.part.part.name}: {name_of(made.part.polygon)}")
    axes = figure.add_subplot()
    measures, phi = measures_of(made.drawing), angles_of(made)
    turn = np.linspace(0, 2 * np.pi, 361)
    circles = (("inner", measures.inner_circle_mm, ":"), ("outer", measures.outer_circle_mm, "--"))
    for name, diameter, style in circles:
        label = f"{name} circle, diameter {diameter:.6g} mm"
        circle = around(np.full(turn.size, diameter / 2), turn)
        axes.plot(*circle, color=GREY, lw=0.9, ls=style, label=label)
    x, y = (np.append(column, column[0]) for column in around(made.drawing.polar(phi).r, phi))
    # As axes.fill, which looks for the limits of so many corners by itself: they are set below.
    axes.add_artist(Polygon(np.column_stack((x, y)), color=PALE, alpha=0.5, lw=0))
    axes.plot(x, y, color=BLUE, lw=1.8, label="drawing")
    joints = np.array([blend.joint_rad for blend in made.blended.blends])
    if joints.size:
        r = made.drawing.polar(joints).r
        axes.plot(r * np.cos(joints), r * np.sin(joints), "s", color="black", ms=4, label="joints")
    room = 1.3 * measures.outer_circle_mm / 2
    axes.set(xlim=(-room, room), ylim=(-room, room))
    for degrees in (0, 90, 180, 270):
        where = 1.08 * measures.outer_circle_mm / 2
        x, y = where * np.cos(np.radians(degrees)), where * np.sin(np.radians(degrees))
        side = {0: "left", 180: "right"}.get(degrees, "center")
        axes.text(x, y, f"{degrees}°", ha=side, va="center", color=GREY, fontsize=9)
    axes.set(aspect="equal", xlabel="mm, seen along Z from the headstock", ylabel="mm")
    axes.grid(alpha=0.2)
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    return figure


def draw_motion(made: GeneratedPolygon) -> Figure:
    """Return U, its velocity and acceleration over a turn at the part's speed."""
    rpm, z_mm = made.part.process.spindle_rpm, made.geometry.z_first_mm
    title = f"{made.part.part.name}: motion of U at {rpm:g} r/min"
    figure = titled_figure(8.5, 8.0, title)
    panels = stacked(figure, ("U towards the axis, mm", "velocity, mm/s", "acceleration, m/s²"))
    phi, omega = angles_of(made), omega_rad_s(rpm)
    u = made.geometry.delta(phi, z_mm)
    from_zero_mm = u.delta - made.middle_nm / NM_PER_MM
    curves = (from_zero_mm, u.d1 * omega, u.d2 * omega**2 / MM_PER_M)
    for axes, curve in zip(panels, curves, strict=True):
        axes.plot(np.degrees(phi), curve, color=BLUE, lw=1.4)
    limit = made.part.machine.limits.u_acceleration_mm_s2 / MM_PER_M
    for sign in (1, -1):
        panels[2].axhline(sign * limit, color=RED, lw=1, ls="--")
    panels[2].set_title("dashed: limit of the machine")
    angle_axis(panels[-1], "angle of the drawing")
    return figure


def hardest_blend(made: GeneratedPolygon) -> Blend:
    """Return the blend with the highest acceleration."""
    return max(made.blended.blends, key=lambda blend: blend.acceleration_mm())


def paint_blend(panels: list[Axes], made: GeneratedPolygon, blend: Blend) -> None:
    """Draw what a blend does to radius and acceleration around its joint."""
    half = _WINDOW * blend.half_rad
    phi = blend.joint_rad + half * np.linspace(-1, 1, _N_WINDOW)
    drawn, cut = made.drawing.polar(phi), made.blended.outline.polar(phi)
    degrees, omega = np.degrees(phi), omega_rad_s(made.part.process.spindle_rpm)
    panels[0].plot(degrees, drawn.r * 0, color=BLUE, lw=1.6, label="drawing")
    off_um = (cut.r - drawn.r) * UM_PER_MM
    panels[0].plot(degrees, off_um, color=ORANGE, lw=1.6, label="blend")
    behind, before = phi > blend.joint_rad, phi < blend.joint_rad
    unit = -(omega**2) / MM_PER_M
    for side in (before, behind):
        panels[1].plot(degrees[side], drawn.d2[side] * unit, color=BLUE, lw=1.6)
    panels[1].plot(degrees, cut.d2 * unit, color=ORANGE, lw=1.6)
    for axes in panels:
        axes.axvline(float(np.degrees(blend.joint_rad)), color=GREY, lw=0.8, ls=":")
        axes.ticklabel_format(useOffset=False)
    name = "angle of the drawing, degrees; dotted: the joint"
    panels[1].set(xlabel=name, xlim=(float(degrees[0]), float(degrees[-1])))


def draw_blend(made: GeneratedPolygon) -> Figure:
    """Return the hardest joint: deviation from the drawing and acceleration."""
    figure = titled_figure(8.5, 6.4, f"{made.part.part.name}: blend of a joint")
    panels = stacked(figure, BLEND_NAMES)
    paint_blend(panels, made, hardest_blend(made))
    panels[0].legend(frameon=False)
    return figure


def draw_polygon(made: GeneratedPolygon) -> dict[str, bytes]:
    """Return all pictures by topic."""
    drawers = {"section": draw_section, "motion": draw_motion}
    drawers |= {"blend": draw_blend} if made.blended.blends else {}
    return pictures({topic: partial(draw, made) for topic, draw in drawers.items()})


ANGLE = "spindle angle from the corner"
_MOST_TICKS = 180  # of the measured motion
_MARKS = {"color": RED, "ls": "", "marker": "o", "ms": 3.0, "mfc": "none"}
_MOST_MARKS = 240
_LEFT_OUT = (
    "long and short axis, ovality, phase and the roundness of the section itself, since a polygon "
    "is no oval; each section is described by its deviation from the drawing"
)


def draw_cut_blend(outcome: PolygonCut) -> Figure:
    """Return the hardest joint with the points cut there."""
    made, surface = outcome.generated, outcome.surface
    blend = hardest_blend(made)
    figure = new_figure(10, 6.0)
    panels = stacked(figure, BLEND_NAMES)
    paint_blend(panels, made, blend)
    off = shifted(2 * np.pi * surface.turn, blend.joint_rad)
    near = np.flatnonzero(np.abs(off) < 2.2 * blend.half_rad)
    near = near[:: max(1, near.size // _MOST_MARKS)]
    degrees = np.degrees(blend.joint_rad + off[near])
    panels[0].plot(degrees, surface.error_um[near], label="cut", **_MARKS)  # type: ignore[arg-type]
    panels[0].legend(frameon=False)
    return figure


def _measured(turn: CutTrace) -> tuple[Floats, Floats, Floats]:
    """Return angle [degrees], place of U [mm] and its velocity [mm/s] at some ticks of a turn."""
    u_mm, step = turn.u_act_nm / NM_PER_MM, max(1, turn.t_s.size // _MOST_TICKS)
    columns = 360 * (turn.turn % 1), u_mm, np.gradient(u_mm, turn.t_s)
    degrees, moved_mm, slope = (column[::step] for column in columns)
    return degrees, moved_mm, slope


def motion_of(outcome: PolygonCut) -> TurnOfU:
    """Return U, its velocity and acceleration over a turn in the middle of the cut."""
    made, trace = outcome.generated, outcome.trace
    omega = omega_rad_s(outcome.summary["cut"]["spindle_rpm"])
    cutting = np.flatnonzero(trace.state == CUTTING)
    whole = np.floor(trace.turn[cutting])
    rows = cutting[whole == np.median(whole)] if cutting.size else cutting
    z_mm = float(trace.z_mm[rows].mean()) if rows.size else made.geometry.z_first_mm
    phi = angles_of(made)
    u = made.geometry.delta(phi, z_mm)
    degrees, moved_mm, slope = _measured(trace.pick(rows)) if rows.size > 2 else (None,) * 3
    return TurnOfU(
        f"height {z_mm:.1f} mm",
        np.degrees(phi),
        (
            ChartPanel("U towards the axis, mm", u.delta - made.middle_nm / NM_PER_MM, moved_mm),
            ChartPanel("velocity, mm/s", trace.sense * u.d1 * omega, slope),
            ChartPanel("acceleration, m/s²", u.d2 * omega**2 / MM_PER_M),
        ),
        "table",
        degrees,
        "angle of the drawing",
    )


def _subject(cut: PolygonCut) -> Subject:
    stated = ZonedTolerances(**cut.generated.part.tolerances.model_dump())
    return Subject(False, True, _LEFT_OUT, tolerances=stated)


_VIEWS: tuple[views.View[PolygonCut], ...] = (
    views.fault_view(
        "U must leave the work first, within a few milliseconds, and the tool tip must not move "
        "towards the axis (below 0) after the dashed line."
    ),
    views.View(
        "blend",
        "The hardest joint",
        "Where two curves of the outline meet, U would need an acceleration that jumps or is "
        "infinite. The blend keeps it finite at the cost of the deviation at the top; the cut "
        "points must lie on the blend and within the tolerance.",
        draw_cut_blend,
        lambda cut: views.has_surface(cut) and bool(cut.generated.blended.blends),
    ),
    views.motion_view(
        "The measured points must lie on the curve of the table in position and velocity; the "
        "peaks are the required values in the table of machine limits above.",
        motion_of,
    ),
    views.LEARNING,
    views.following_view(
        "Difference between the actual and the demanded position of U; the band covers every turn "
        "of the cut."
    ),
    views.SEQUENCE,
    views.COMPARE,
)

REPORT = KindReport(
    what="shaft",
    angle=ANGLE,
    heights_mm=lambda cut: cut.generated.geometry.ends_mm,
    rows=ROWS,
    views=_VIEWS,
    subject=_subject,
    hint="Stripes at the joints are the blends, which count as error; anything else comes from the "
    "machine.",
    pictures=draw_polygon,
)
