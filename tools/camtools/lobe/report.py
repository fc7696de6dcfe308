"""The report of a camshaft.

>>> REPORT.views[0].key, REPORT.views[-1].key
('fault', 'compare')
"""

from camtools.lobe.motion import smoothing_takes_um
from camtools.lobe.plots import (
    ANGLE,
    draw_lobes,
    draw_motion,
    draw_positions,
    draw_rake,
    draw_smoothing,
    draw_speed,
    motion_of,
    smoothed_lists,
)
from camtools.lobe.summary import ROWS, LobeOutcome
from camtools.part.smoothing import sheet_note
from camtools.report import views
from camtools.report.kind_report import KindReport
from camtools.report.sheet import Subject


def _modelled(outcome: LobeOutcome) -> str:
    tool = (
        "The tip of the tool is a circle" if outcome.is_turned else "The wheel is a whole cylinder"
    )
    return f"{tool} that takes off what it sweeps; forces, wear and bending are not modelled."


def _subject(outcome: LobeOutcome) -> Subject:
    return Subject(
        is_oval=False,
        has_radius=False,
        left_out="long and short axis, ovality, phase, roundness of the section as it is: a lobe "
        "is no oval, so each is described by the deviation along the normals of its profile, over "
        "the direction of the roller; profiles along the axis: a lobe is gauged as one section",
        names=tuple(
            f"lobe {i}, {lobe['z_first_mm']:g} .. {lobe['z_last_mm']:g} mm"
            for i, lobe in enumerate(outcome.summary["cam"]["lobes"])
        ),
        note=sheet_note(
            outcome.summary["form_error_um"], smoothing_takes_um(outcome.generated.laws)
        ),
    )


_VIEWS: tuple[views.View[LobeOutcome], ...] = (
    views.fault_view(
        "U must leave the work first, beyond the nose of the cam, and no axis may move towards the "
        "axis after the dashed line. X follows more slowly; the spindle runs down by itself."
    ),
    views.View(
        "cam",
        "Cam and tool",
        "The profile with the tool or the wheel at some angles. The red lines are the normals at "
        "the contacts; the number at a tool is its swing, which equals the pressure angle.",
        lambda cut: draw_positions(cut.generated),
    ),
    views.View(
        "motion",
        "Lift, pressure angle, curvature and speeds",
        "One turn of the spindle as the table demands it. Where the flank is flat, the contact "
        "moves far within a degree; there a constant surface speed needs a slow spindle.",
        lambda cut: draw_motion(cut.generated),
    ),
    views.View(
        "smoothing",
        "Smoothing of a list",
        "Top: by how much smoothing moved each listed point; the dashed lines are the band of "
        "smooth_um. Residuals that follow one another on the same side mean a curve that the band "
        "bent, not noise. Below: acceleration and jerk of the lift, as listed (thin) and smoothed.",
        lambda cut: draw_smoothing(cut.generated),
        lambda cut: bool(smoothed_lists(cut.generated)),
    ),
    views.motion_view(
        "U as the table demands it and as measured, in position and velocity; the peaks of "
        "velocity and acceleration are the required values in the table of machine limits above.",
        motion_of,
        "stroke",
    ),
    views.View(
        "speed",
        "Surface speed",
        "Speed of the contact along the profile, from the measured spindle speed. With a constant "
        "surface speed it stays near that of the base circle (dashed) and is lower where the "
        "spindle cannot accelerate or decelerate fast enough.",
        draw_speed,
        views.has_turns,
    ),
    views.View(
        "rake",
        "Effective rake",
        "The angle between the tool and the normal of the profile, by which the ground rake "
        "changes. With the swing it stays at 0; without, it would be the pressure angle. Bottom: "
        "the remaining error of the swing drive and its set-points, enlarged.",
        draw_rake,
        lambda cut: views.has_turns(cut) and cut.swing_deg is not None,
    ),
    views.LEARNING,
    views.following_view(
        "Difference between the actual and the demanded position of U; the band covers every turn. "
        "The shape of the lift's slope points to a wrong dead time or k1, that of its curvature "
        "to a wrong k2."
    ),
    views.SEQUENCE._replace(
        text="X approaches from clear of the lobes while the lift grows from zero, so that the "
        "nose is never cut; disengaging is the reverse. Only the green stretch counts for the "
        "verdict."
    ),
    views.COMPARE,
)

REPORT = KindReport(
    what="cam",
    angle=ANGLE,
    heights_mm=lambda cut: (cut.generated.lobes[0].z_mm[0], cut.generated.lobes[-1].z_mm[1]),
    rows=ROWS,
    views=_VIEWS,
    subject=_subject,
    hint="An error that follows the slope of the lift comes from the angle or dead time, one that "
    "follows its curvature from U's feed-forward.",
    modelled=_modelled,
    compared="what it leaves, along the normals of the profile,",
    pictures=draw_lobes,
)
