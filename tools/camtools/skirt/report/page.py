"""The report of a skirt: its pictures, in order, and its page.

>>> list(_TEXTS)[:3]
['fault', 'map', 'own']
"""

from __future__ import annotations

from camtools.base.beside import beside
from camtools.part.smoothing_text import sheet_note
from camtools.plots.style import drawing, png_of
from camtools.report.common_pictures import COMPARE_TEXT, SEQUENCE_TEXT, common_drawers, in_order
from camtools.report.learning import CONVERGENCE_TEXT
from camtools.report.motion import draw_motion
from camtools.report.page import EDGE_IS_A_POINT, Page, Picture, render_page
from camtools.report.sheet import Subject
from camtools.report.sheet_page import SheetPages, sheet_pages
from camtools.skirt.geometry.smooth_points import (
    smoothed_curves,
    smoothing_takes_um,
    tolerances_left,
)
from camtools.skirt.report import surface_plots
from camtools.skirt.report.corner_plot import draw_corner
from camtools.skirt.report.equal_volume_plots import draw_even, draw_ripple
from camtools.skirt.report.interactive import ANGLE, live_of, motion_of
from camtools.skirt.report.outcome import SkirtOutcome
from camtools.skirt.report.part_plots import draw_smoothing
from camtools.skirt.report.shape_plot import draw_skirt
from camtools.skirt.report.text import rows_of

_TEXTS = {
    "fault": (
        "The fault",
        "U must leave the work first, within a few milliseconds, and the tool tip must not move "
        "towards the axis (below 0) after the dashed line. X follows more slowly, and the spindle "
        "runs down by itself.",
    ),
    "map": (
        "Error map of the skirt",
        "The skirt unrolled: red is metal left standing, blue is cut too deep, each cell shows its "
        "worst point, grey areas were not cut. Stripes at fixed angles point to U, its timing or "
        "the spindle speed; bands at fixed heights to X or to engaging; an even colour to the tool "
        "setting.",
    ),
    "own": (
        "Error map of the controller alone",
        "The table plays a refit or a filtered form of the drawing; this map compares the cut with "
        "that, so it shows what machine and controller add. The verdict uses the map above.",
    ),
    "sections": (
        "Sections",
        "Top: the cut points must lie on the drawn oval everywhere. Bottom: the error alone, "
        "enlarged far more, as on a roundness instrument. The line should stay near the middle "
        "circle; a pattern rotated against the axes points to a wrong dead time.",
    ),
    "corner": (
        "The corner",
        "Where ellipse and circle of the drawing meet, there is a corner that no axis can follow. "
        "A spline replaces it: it keeps U's acceleration (bottom) finite and deviates from the "
        "drawing as the second picture shows. The cut must lie on this refit; its deviation "
        "counts in the form error.",
    ),
    "height": (
        "Error over height",
        "The band should be narrow and without steps from bottom to top. A rise with height is "
        "normal when the ovality rises; a spike at an end comes from the engage or disengage.",
    ),
    "skirt": (
        "The skirt in space",
        "The gauged surface with its deviations from a cylinder enlarged. It shows the oval, the "
        "barrel shape and, if there is one, the corner; steps or waves would stand out.",
    ),
    "smoothing": (
        "Smoothing of listed points",
        "By how much smoothing moved the points of the drawing, in diameter or ovality; the dashed "
        "lines are the band of smooth_um. Residuals that stay on one side over many points mean "
        "that the band is too wide for the shape.",
    ),
    "learning": CONVERGENCE_TEXT,
    "motion": (
        "Motion of U over one turn",
        "U swings in and out twice per turn; the measured points must lie on the drawn curve in "
        "position and in velocity. The peaks of velocity and acceleration are what the machine "
        "limits above are compared with.",
    ),
    "even": (
        "Equal-volume turning",
        "The spindle slows down where the chip is deep, so that removal rate and power stay even; "
        "dashed: the same part at constant speed. The chip force does not change, since neither "
        "depth nor feed depend on the speed: the papers' claim of a constant force holds only for "
        "their model, in which force is proportional to the removal rate.",
    ),
    "ripple": (
        "Ripple of the removal rate",
        "Largest minus smallest rate of every turn, over the height, measured on the workpiece. If "
        "the spindle's acceleration allows it, the rate is constant; otherwise the table holds "
        "the law of least ripple, which must lie below the papers' partial modulation.",
    ),
    "following": (
        "Following error of U",
        "Difference between the actual and the demanded position of U; the band covers every turn "
        "of the cut. The shape of the velocity curve points to a wrong dead time or k1, that of "
        "the acceleration curve to a wrong k2; a thin band means that all turns are alike.",
    ),
    "sequence": SEQUENCE_TEXT,
    "compare": COMPARE_TEXT,
}


def pictures_of(outcome: SkirtOutcome) -> list[Picture]:
    """Return the pictures of a cut, not drawn yet."""
    geometry, cut = outcome.generated.geometry, outcome.summary["cut"]
    surface, magnify = outcome.surface, outcome.generated.part.magnify
    factor = magnify.factor if magnify else 1.0
    feed_mm, speed_rpm = cut["feed_mm"], cut["spindle_rpm"]
    drawers = common_drawers(outcome, ANGLE)
    drawers["motion"] = lambda: draw_motion(motion_of(outcome))
    if smoothed_curves(outcome.generated.part.piston):
        drawers["smoothing"] = lambda: draw_smoothing(outcome.generated)
    if surface.turn.size:
        drawers["map"] = lambda: surface_plots.draw_map(surface, geometry, feed_mm)
        own = outcome.control
        if own is not None:
            played = geometry.played_name
            drawers["own"] = lambda: surface_plots.draw_map(own, geometry, feed_mm, played)
        drawers["sections"] = lambda: surface_plots.draw_sections(surface, geometry, feed_mm)
        if geometry.corner is not None:
            drawers["corner"] = lambda: draw_corner(surface, outcome.trace, geometry, speed_rpm)
        drawers["height"] = lambda: surface_plots.draw_height(surface, geometry)
        drawers["skirt"] = lambda: draw_skirt(surface, geometry, factor)
    even, speed = outcome.even, outcome.generated.speed
    if even is not None and speed is not None and even.removal.turn.size:
        drawers["even"] = lambda: draw_even(even, speed, speed_rpm)
        drawers["ripple"] = lambda: draw_ripple(even, speed)
    return in_order(_TEXTS, drawers)


def render(outcome: SkirtOutcome, pngs: dict[str, bytes], sheets: SheetPages | None = None) -> str:
    """Return the HTML page.

    Parameters
    ----------
    sheets : SheetPages or None
        Sheets of the gauged sections, drawn.
    """
    page = Page(
        outcome.generated.part.part.source,
        rows_of(outcome),
        [(one, pngs[one.key]) for one in pictures_of(outcome) if one.key in pngs],
        EDGE_IS_A_POINT,
        "the tool's true path",
        "skirt",
        live_of(outcome),
        sheets,
    )
    return render_page(outcome, page)


def make_report(outcome: SkirtOutcome) -> dict[str, bytes]:
    """Return the page, its pictures and an overview picture, by file name."""
    part = outcome.generated.part
    note = sheet_note(outcome.summary["form_error_um"], smoothing_takes_um(part))
    subject = Subject(True, True, tolerances=tolerances_left(part), note=note)
    with drawing(), beside(lambda: sheet_pages(outcome, subject)) as drawn_sheets:
        pngs = {picture.key: png_of(picture.draw()) for picture in pictures_of(outcome)}
        files = {f"cut_{key}.png": png for key, png in pngs.items()}
        if outcome.surface.turn.size:
            cut, geometry = outcome.summary["cut"], outcome.generated.geometry
            title = f"{outcome.name} at {cut['spindle_rpm']:g} r/min on the simulator"
            overview = surface_plots.draw_overview(outcome.surface, geometry, cut["feed_mm"], title)
            files["cut_overview.png"] = png_of(overview)
        sheets = drawn_sheets()
    files |= sheets.files if sheets is not None else {}
    return files | {"report.html": render(outcome, pngs, sheets).encode("utf-8")}
