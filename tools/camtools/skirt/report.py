"""The report of a cut: pictures and one self-contained HTML page.

>>> data_uri(b"abc")
'data:image/png;base64,YWJj'
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.figure import Figure

from camtools.plots.style import drawing, png_of
from camtools.report import compare as report_compare
from camtools.report import motion as report_motion
from camtools.sim.results import CUTTING, FAULT, Cut, Json, Outcome
from camtools.skirt import report_surface
from camtools.skirt.report_corner import draw_corner
from camtools.skirt.report_even import draw_even, draw_ripple
from camtools.skirt.report_shape import draw_skirt
from camtools.skirt.report_text import Margin, Row, fault_story, margins_of, rows_of, verdict_of

_TEMPLATE = "page.html.j2"


class Picture(NamedTuple):
    """A picture with its title and what to look for."""

    key: str  # names the file: cut_KEY.png
    title: str
    text: str
    draw: Callable[[], Figure]


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
        "acceleration, below, finite. The cut must lie on the refit, not on the drawing.",
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


def _drawers(outcome: Outcome) -> dict[str, Callable[[], Figure]]:
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
        drawers["sections"] = lambda: report_surface.draw_sections(surface, geometry, feed_mm)
        if geometry.corner is not None:
            drawers["corner"] = lambda: draw_corner(surface, trace, geometry, speed_rpm)
        drawers["height"] = lambda: report_surface.draw_height(surface, geometry)
        drawers["skirt"] = lambda: draw_skirt(surface, geometry, factor)
    drawers["motion"] = lambda: report_motion.draw_motion(trace, geometry, speed_rpm)
    even, speed = outcome.even, outcome.generated.speed
    if even is not None and speed is not None and even.removal.turn.size:
        drawers["even"] = lambda: draw_even(even, speed, speed_rpm)
        drawers["ripple"] = lambda: draw_ripple(even, speed)
    if (trace.state == CUTTING).any():
        drawers["following"] = lambda: report_motion.draw_following(trace)
    if trace.t_s.size > 1:
        drawers["sequence"] = lambda: report_motion.draw_sequence(trace)
    return drawers | _comparison(outcome)


def _comparison(outcome: Outcome) -> dict[str, Callable[[], Figure]]:
    tolerance_um = outcome.summary["form_error_um"]["tolerance"]
    if len(outcome.variants) < 2:
        return {}
    return {"compare": lambda: report_compare.draw_variants(outcome.variants, tolerance_um)}


def pictures_of(outcome: Outcome) -> list[Picture]:
    """Return the pictures of a cut, not drawn yet."""
    return [Picture(key, *_TEXTS[key], draw) for key, draw in _drawers(outcome).items()]


def data_uri(png: bytes) -> str:
    """Return an image as text that a page can hold."""
    return "data:image/png;base64," + b64encode(png).decode("ascii")


def trace_text(outcome: Cut) -> str:
    """Return what the trace holds, in one sentence."""
    ticks = f"{outcome.trace.t_s.size:,}".replace(",", "\u2009")
    if outcome.is_trace_complete:
        return f"trace.csv holds every tick of the run, {ticks} of them."
    last_s = float(outcome.trace.t_s[-1]) if outcome.trace.t_s.size else 0.0
    return (
        "This cut is long, so trace.csv, the pictures of U, following error and sequence, and the "
        f"comparison hold the first {last_s:.1f} s only: {ticks} ticks of a run ended there."
    )


class Caption(NamedTuple):
    """Title of a picture and what to look for."""

    title: str
    text: str


class Page(NamedTuple):
    """What a report says of a part of one kind."""

    source: str
    rows: list[Row]
    margins: list[Margin]
    shown: Sequence[tuple[Picture | Caption, bytes]]  # pictures and their PNGs, in order
    modelled: str  # what the simulator leaves out of the tool, a sentence
    compared: str  # what the gauge compares
    what: str  # what was cut


def render(outcome: Outcome, pngs: dict[str, bytes]) -> str:
    """Return the HTML page.

    Parameters
    ----------
    pngs : dict
        Pictures by key, drawn.
    """
    page = Page(
        outcome.generated.part.part.source,
        rows_of(outcome),
        margins_of(outcome),
        [(one, pngs[one.key]) for one in pictures_of(outcome) if one.key in pngs],
        "The tool is a point; feed marks, tool nose and bending are not modelled.",
        "the tool's true path",
        "skirt",
    )
    return render_page(outcome, page)


def render_page(outcome: Cut, page: Page) -> str:
    """Return the HTML page of a part of any kind."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).resolve().parents[1] / "report"),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(_TEMPLATE).render(
        name=outcome.name,
        source=page.source,
        summary=outcome.summary,
        verdict=verdict_of(outcome),
        rows=page.rows,
        margins=page.margins,
        story=fault_story(outcome) if outcome.has_fault else [],
        shown=[(picture, data_uri(png)) for picture, png in page.shown],
        modelled=page.modelled,
        compared=page.compared,
        what=page.what,
        trace=trace_text(outcome),
        is_trace_complete=outcome.is_trace_complete,
    )


def make_report(outcome: Outcome) -> dict[str, bytes]:
    """Return the page, its pictures and an overview picture, by file name."""
    with drawing():
        pngs = {picture.key: png_of(picture.draw()) for picture in pictures_of(outcome)}
        files = {f"cut_{key}.png": png for key, png in pngs.items()}
        if outcome.surface.turn.size:
            files["cut_overview.png"] = png_of(_overview(outcome))
    return files | {"report.html": render(outcome, pngs).encode("utf-8")}


def _overview(outcome: Outcome) -> Figure:
    cut: Json = outcome.summary["cut"]
    title = f"{outcome.name} at {cut['spindle_rpm']:g} r/min on the simulator"
    geometry = outcome.generated.geometry
    return report_surface.draw_overview(outcome.surface, geometry, cut["feed_mm"], title)
