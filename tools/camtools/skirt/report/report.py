"""The report of a skirt.

>>> REPORT.views[0].key, REPORT.views[-1].key
('fault', 'compare')
"""

from __future__ import annotations

from matplotlib.figure import Figure

from camtools.part.smoothing import sheet_note
from camtools.report.kind_report import KindReport
from camtools.report.sheet import Subject
from camtools.report.views import (
    COMPARE,
    LEARNING,
    SEQUENCE,
    View,
    fault_view,
    following_view,
    has_surface,
    motion_view,
)
from camtools.skirt.geometry.profile import smoothed_curves, smoothing_takes_um, tolerances_left
from camtools.skirt.report.cut_plots import draw_corner, draw_even, draw_own, draw_ripple, motion_of
from camtools.skirt.report.outcome import ROWS, SkirtOutcome
from camtools.skirt.report.plots import draw_smoothing

_ENLARGED = 30.0  # the part in space


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
    return Subject(True, True, tolerances=tolerances_left(part), note=note)


_VIEWS: tuple[View[SkirtOutcome], ...] = (
    fault_view(
        "U must leave the work first, within a few milliseconds, and the tool tip must not move "
        "towards the axis (below 0) after the dashed line. X follows more slowly, and the spindle "
        "runs down by itself."
    ),
    View(
        "own",
        "Error map of the controller alone",
        "The table plays a refit or a filtered form of the drawing; this map compares the cut with "
        "that, so it shows what machine and controller add. The verdict uses the map above.",
        draw_own,
        lambda cut: has_surface(cut) and cut.control is not None,
    ),
    View(
        "corner",
        "The corner",
        "Where ellipse and circle of the drawing meet, there is a corner that no axis can follow. "
        "A spline replaces it: it keeps U's acceleration (bottom) finite and deviates from the "
        "drawing as the second picture shows. The cut must lie on this refit; its deviation "
        "counts in the form error.",
        lambda cut: draw_corner(
            *(cut.surface, cut.trace, cut.generated.geometry, cut.summary["cut"]["spindle_rpm"])
        ),
        lambda cut: has_surface(cut) and cut.generated.geometry.corner is not None,
    ),
    View(
        "smoothing",
        "Smoothing of listed points",
        "By how much smoothing moved the points of the drawing, in diameter or ovality; the dashed "
        "lines are the band of smooth_um. Residuals that stay on one side over many points mean "
        "that the band is too wide for the shape.",
        lambda cut: draw_smoothing(cut.generated),
        lambda cut: bool(smoothed_curves(cut.generated.part.piston)),
    ),
    LEARNING,
    motion_view(
        "U swings in and out twice per turn; the measured points must lie on the drawn curve in "
        "position and in velocity. The peaks of velocity and acceleration are what the machine "
        "limits above are compared with.",
        motion_of,
    ),
    View(
        "even",
        "Equal-volume turning",
        "The spindle slows down where the chip is deep, so that removal rate and power stay even; "
        "dashed: the same part at constant speed. The chip force does not change, since neither "
        "depth nor feed depend on the speed: the papers' claim of a constant force holds only for "
        "their model, in which force is proportional to the removal rate.",
        _draw_even,
        _is_even,
    ),
    View(
        "ripple",
        "Ripple of the removal rate",
        "Largest minus smallest rate of every turn, over the height, measured on the workpiece. If "
        "the spindle's acceleration allows it, the rate is constant; otherwise the table holds "
        "the law of least ripple, which must lie below the papers' partial modulation.",
        _draw_ripple,
        _is_even,
    ),
    following_view(
        "Difference between the actual and the demanded position of U; the band covers every turn "
        "of the cut. The shape of the velocity curve points to a wrong dead time or k1, that of "
        "the acceleration curve to a wrong k2; a thin band means that all turns are alike."
    ),
    SEQUENCE,
    COMPARE,
)

REPORT = KindReport(
    what="skirt",
    angle="spindle angle from the long axis",
    heights_mm=lambda cut: (
        cut.generated.geometry.z_first_mm,
        cut.generated.geometry.z_last_mm,
    ),
    rows=ROWS,
    views=_VIEWS,
    subject=_subject,
    hint="Stripes at fixed angles point to U, its timing or the spindle speed; bands at fixed "
    "heights to X or to engaging; an even colour to the tool setting.",
    space=_space,
)
