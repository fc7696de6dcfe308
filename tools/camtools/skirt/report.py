"""The report of a skirt: its pictures, in order, and its page.

>>> list(_TEXTS)[:3]
['fault', 'map', 'own']
"""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure

from camtools.base.beside import beside
from camtools.plots.style import drawing, png_of
from camtools.report import compare as report_compare
from camtools.report import motion as report_motion
from camtools.report.learning import CONVERGENCE_TEXT, convergence
from camtools.report.page import EDGE_IS_A_POINT, Page, Picture, render_page
from camtools.report.sheet import Subject
from camtools.report.sheet_page import SheetPages, sheet_pages
from camtools.report.switches import SWITCHES_TEXT, switches
from camtools.sim.results import CUTTING, FAULT
from camtools.skirt import report_surface
from camtools.skirt.outcome import SkirtOutcome
from camtools.skirt.report_alive import live_of, motion_of
from camtools.skirt.report_corner import draw_corner
from camtools.skirt.report_even import draw_even, draw_ripple
from camtools.skirt.report_shape import draw_skirt
from camtools.skirt.report_text import rows_of

_TEXTS = {
    "fault": (
        "The fault",
        "U must leave the work first, within a few milliseconds, and the tool tip must never move "
        "towards the axis (below 0) after the dashed line. X follows more slowly, and the spindle "
        "runs down by itself.",
    ),
    "map": (
        "Error map of the skirt",
        "The skirt unrolled: red is metal left standing, blue is cut too deep, each cell shows its "
        "worst point, grey was not cut. Stripes at fixed angles point to U, its timing or the "
        "spindle's speed; bands at fixed heights to X or to the engage; an even colour to tool "
        "setting.",
    ),
    "own": (
        "Error map of the controller alone",
        "Where the table plays a refit or a filter of the drawing, this is how far the cut is from "
        "that: what machine and controller add. The verdict is by the map above.",
    ),
    "sections": (
        "Sections",
        "Above, the cut points must lie on the drawn oval everywhere. Below, the error alone is "
        "enlarged far more, as on a roundness instrument: the line should stay near the middle "
        "circle, and a line turned against the axes tells of a wrong dead time.",
    ),
    "corner": (
        "The corner",
        "Where ellipse and circle of the drawing meet there is a corner that no axis can follow; "
        "the spline in its place costs the deviation of the second picture and keeps U's "
        "acceleration, below, finite. The cut must lie on the refit; how far that is off the "
        "drawing counts in the form error.",
    ),
    "skirt": (
        "The skirt in space",
        "The gauged surface with its deviations from a cylinder enlarged: oval, barrel shape and, "
        "where there is one, the corner can be seen; steps or waves would stand out.",
    ),
    "even": (
        "Equal-volume turning",
        "The spindle slows down where the chip is deep, so that removal rate and power stay even; "
        "dashed is the same part at constant speed. The force of the chip stays as it is, since "
        "neither depth nor feed depend on the speed: the papers' claim of a constant force holds "
        "only for their model, in which force is proportional to the removal rate.",
    ),
    "ripple": (
        "Ripple of the removal rate",
        "Largest minus least rate of every turn, over the height, measured on the workpiece. Where "
        "the spindle's acceleration allows it the rate is constant; where it does not, the table "
        "holds the law of least ripple, which must lie below the papers' partial modulation.",
    ),
    "height": (
        "Error over height",
        "The band should be narrow and without steps from bottom to top. A rise with height is "
        "normal when the ovality rises; a spike at an end comes from the engage or disengage.",
    ),
    "learning": CONVERGENCE_TEXT,
    "switches": SWITCHES_TEXT,
    "motion": (
        "Motion of U over one turn",
        "U swings in and out twice per turn; the measured points must lie on the drawn curve in "
        "position and in velocity. The peaks of velocity and acceleration are what the machine "
        "limits above are compared with.",
    ),
    "following": (
        "Following error of U",
        "How far U was from where it should have been at that moment; the band holds every turn of "
        "the cut. The shape of the velocity curve means a wrong dead time or k1, that of the "
        "acceleration curve a wrong k2; a thin band means that all turns are alike.",
    ),
    "sequence": (
        "How the cut begins, goes on and ends",
        "Homing finds the index with U out of the work; engaging brings X to depth and lets the "
        "swing of U grow smoothly from nothing; disengaging is the reverse. There must be no jump "
        "in any line, and only the green stretch is the part that is judged.",
    ),
    "compare": (
        "What each part of the controller is worth",
        "The same cut with parts of the controller switched off; mind the scale, which grows "
        "tenfold from number to number. Dead-time lead plays the table ahead by the time the drive "
        "needs to react, feed-forward adds the table's own velocity and acceleration so that U "
        "need not lag.",
    ),
}


def _drawers(outcome: SkirtOutcome) -> dict[str, Callable[[], Figure]]:
    """Return what can be drawn of a cut, in the order of the report."""
    geometry, cut = outcome.generated.geometry, outcome.summary["cut"]
    surface, trace = outcome.surface, outcome.trace
    magnify = outcome.generated.part.magnify
    factor = magnify.factor if magnify else 1.0
    feed_mm, speed_rpm = cut["feed_mm"], cut["spindle_rpm"]
    drawers: dict[str, Callable[[], Figure]] = {}
    if (trace.state == FAULT).any():
        retract_s = outcome.summary.get("fault", {}).get("retract_s", 0.0)
        drawers["fault"] = lambda: report_motion.draw_fault(trace, retract_s)
    if surface.turn.size:
        drawers["map"] = lambda: report_surface.draw_map(surface, geometry, feed_mm)
        own = outcome.control
        if own is not None:
            played = geometry.played_name
            drawers["own"] = lambda: report_surface.draw_map(own, geometry, feed_mm, played)
        drawers["sections"] = lambda: report_surface.draw_sections(surface, geometry, feed_mm)
        if geometry.corner is not None:
            drawers["corner"] = lambda: draw_corner(surface, trace, geometry, speed_rpm)
        drawers["height"] = lambda: report_surface.draw_height(surface, geometry)
        drawers["skirt"] = lambda: draw_skirt(surface, geometry, factor)
    drawers |= convergence(outcome.summary)
    drawers |= switches(outcome.summary)
    even, speed = outcome.even, outcome.generated.speed
    drawers["motion"] = lambda: report_motion.draw_motion(motion_of(outcome))
    if even is not None and speed is not None and even.removal.turn.size:
        drawers["even"] = lambda: draw_even(even, speed, speed_rpm)
        drawers["ripple"] = lambda: draw_ripple(even, speed)
    if (trace.state == CUTTING).any():
        drawers["following"] = lambda: report_motion.draw_following(trace)
    if trace.t_s.size > 1:
        drawers["sequence"] = lambda: report_motion.draw_sequence(trace, outcome.overview)
    if len(outcome.variants) > 1:
        tolerance_um = outcome.summary["form_error_um"]["tolerance"]
        variants = outcome.variants
        drawers["compare"] = lambda: report_compare.draw_variants(variants, tolerance_um)
    return drawers


def pictures_of(outcome: SkirtOutcome) -> list[Picture]:
    """Return the pictures of a cut, not drawn yet."""
    return [Picture(key, *_TEXTS[key], draw) for key, draw in _drawers(outcome).items()]


def render(outcome: SkirtOutcome, pngs: dict[str, bytes], sheets: SheetPages | None = None) -> str:
    """Return the HTML page.

    Parameters
    ----------
    pngs : dict
        Pictures by key, drawn.
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
    subject = Subject(True, True, tolerances=outcome.generated.part.tolerances)
    with drawing(), beside(lambda: sheet_pages(outcome, subject)) as drawn_sheets:
        pngs = {picture.key: png_of(picture.draw()) for picture in pictures_of(outcome)}
        files = {f"cut_{key}.png": png for key, png in pngs.items()}
        if outcome.surface.turn.size:
            cut, geometry = outcome.summary["cut"], outcome.generated.geometry
            title = f"{outcome.name} at {cut['spindle_rpm']:g} r/min on the simulator"
            overview = report_surface.draw_overview(
                outcome.surface, geometry, cut["feed_mm"], title
            )
            files["cut_overview.png"] = png_of(overview)
        sheets = drawn_sheets()
    files |= sheets.files if sheets is not None else {}
    return files | {"report.html": render(outcome, pngs, sheets).encode("utf-8")}
