"""The report of a polygon: its pictures, in order, and its page.

>>> list(_TEXTS)[:3]
['fault', 'section', 'blend']
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from camtools.base.beside import beside
from camtools.part.tolerances import Tolerances
from camtools.plots.panels import stacked
from camtools.plots.style import RED, drawing, new_figure, nice_limit, png_of
from camtools.polygon.plots import BLEND_NAMES, hardest_blend, paint_blend, paint_section
from camtools.polygon.report_interactive import ANGLE, live_of, motion_of
from camtools.polygon.report_text import PolygonCut, name_of, polygon_rows
from camtools.report.common_pictures import COMPARE_TEXT, SEQUENCE_TEXT, common_drawers, in_order
from camtools.report.learning import CONVERGENCE_TEXT
from camtools.report.map_cells import map_rows
from camtools.report.motion import draw_motion
from camtools.report.page import EDGE_IS_A_POINT, Page, Picture, render_page
from camtools.report.sheet import Subject
from camtools.report.sheet_page import sheet_pages
from camtools.sim.results import GaugedSurface
from camtools.skirt.report import surface_plots

_MARKS = {"color": RED, "ls": "", "marker": "o", "ms": 3.0, "mfc": "none"}
_MOST_MARKS = 240
_TEXTS = {
    "fault": (
        "The fault",
        "U must leave the work first, within a few milliseconds, and the tool tip must not move "
        "towards the axis (below 0) after the dashed line.",
    ),
    "section": (
        "The section",
        "Left: the drawing to scale between its two circles, with cut points of the middle height. "
        "Right: their error alone, enlarged as on a roundness instrument. Away from the joints the "
        "line should stay on the middle circle; at the joints it shows the blends.",
    ),
    "blend": (
        "The hardest joint",
        "Where two curves of the outline meet, U would need an acceleration that jumps or is "
        "infinite. The blend keeps it finite at the cost of the deviation at the top; the cut "
        "points must lie on the blend and within the tolerance.",
    ),
    "map": (
        "Error map",
        "The shaft unrolled: red is metal left standing, blue is cut too deep. Stripes at the "
        "joints are the blends, which count as error; anything else comes from the machine.",
    ),
    "height": (
        "Error over height",
        "The band should be narrow and even from end to end: all sections are alike.",
    ),
    "motion": (
        "Motion of U over one turn",
        "The measured points must lie on the curve of the table in position and velocity; the "
        "peaks are the required values in the table of machine limits above.",
    ),
    "learning": CONVERGENCE_TEXT,
    "following": (
        "Following error of U",
        "Difference between the actual and the demanded position of U; the band covers every turn "
        "of the cut.",
    ),
    "sequence": SEQUENCE_TEXT,
    "compare": COMPARE_TEXT,
}


def _band(outcome: PolygonCut) -> tuple[GaugedSurface, float]:
    """Return the gauged points near the middle height, and that height."""
    geometry, feed_mm = outcome.generated.geometry, outcome.summary["cut"]["feed_mm"]
    low, high = geometry.z_first_mm, geometry.z_last_mm
    middle = (low + high) / 2
    rows = map_rows(high - low, feed_mm)
    return surface_plots.section_at(outcome.surface, middle, 1.5 * (high - low) / rows), middle


def draw_cut_section(outcome: PolygonCut) -> Figure:
    """Return the section with cut points, and their error enlarged."""
    made = outcome.generated
    near, z_mm = _band(outcome)
    figure = new_figure(11, 6.2)
    figure.set_layout_engine("constrained", h_pad=0.12)  # between the axis and what is named below
    left, right = figure.subplots(1, 2)
    paint_section(left, made)
    left.set_title(name_of(made.part.polygon), fontsize=9.5)
    factor = float(
        made.geometry.radius_mm(z_mm) / made.geometry.radius_mm(made.geometry.z_first_mm)
    )
    step, phi = max(1, near.turn.size // 90), 2 * np.pi * near.turn
    r = near.radius_mm / factor
    left.plot((r * np.cos(phi))[::step], (r * np.sin(phi))[::step], label="cut", **_MARKS)
    limit_um = nice_limit(float(np.abs(near.error_um).max(initial=0.0)))
    surface_plots.draw_roundness(right, near, float(made.geometry.radius_mm(z_mm)), limit_um)
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    return figure


def draw_cut_blend(outcome: PolygonCut) -> Figure:
    """Return the hardest joint with the points cut there."""
    made, surface = outcome.generated, outcome.surface
    blend = hardest_blend(made)
    figure = new_figure(10, 6.0)
    panels = stacked(figure, BLEND_NAMES)
    paint_blend(panels, made, blend)
    off = 2 * np.pi * surface.turn - blend.joint_rad
    off = np.mod(off + np.pi, 2 * np.pi) - np.pi
    near = np.flatnonzero(np.abs(off) < 2.2 * blend.half_rad)
    near = near[:: max(1, near.size // _MOST_MARKS)]
    degrees = np.degrees(blend.joint_rad + off[near])
    panels[0].plot(degrees, surface.error_um[near], label="cut", **_MARKS)  # type: ignore[arg-type]
    panels[0].legend(frameon=False)
    return figure


def _named(figure: Figure) -> Figure:
    """Return a picture of a surface with the words of a shaft."""
    for axes in figure.axes:
        axes.set_xlabel(axes.get_xlabel().replace("skirt ", "").replace("long axis", "corner"))
        axes.set_ylabel(axes.get_ylabel().replace("skirt ", ""))
    return figure


def pictures_of(outcome: PolygonCut) -> list[Picture]:
    """Return the pictures of a cut, not drawn yet."""
    geometry, surface = outcome.generated.geometry, outcome.surface
    feed_mm = outcome.summary["cut"]["feed_mm"]
    drawers = common_drawers(outcome, ANGLE)
    drawers["motion"] = lambda: draw_motion(motion_of(outcome))
    if surface.turn.size:
        drawers["section"] = lambda: draw_cut_section(outcome)
        if outcome.generated.blended.blends:
            drawers["blend"] = lambda: draw_cut_blend(outcome)
        drawers["map"] = lambda: _named(surface_plots.draw_map(surface, geometry, feed_mm))
        drawers["height"] = lambda: _named(surface_plots.draw_height(surface, geometry))
    return in_order(_TEXTS, drawers)


_LEFT_OUT = (
    "long and short axis, ovality, phase and the roundness of the section itself, since a polygon "
    "is no oval; each section is described by its deviation from the drawing"
)


def make_polygon_report(outcome: PolygonCut) -> dict[str, bytes]:
    """Return the page and its pictures by file name."""
    stated = Tolerances(**outcome.generated.part.tolerances.model_dump())
    subject = Subject(False, True, _LEFT_OUT, tolerances=stated)
    with drawing(), beside(lambda: sheet_pages(outcome, subject)) as drawn_sheets:
        shown = [(picture, png_of(picture.draw())) for picture in pictures_of(outcome)]
        sheets = drawn_sheets()
    page = Page(
        outcome.generated.part.part.source,
        polygon_rows(outcome),
        shown,
        EDGE_IS_A_POINT,
        "the tool's true path",
        "shaft",
        live_of(outcome),
        sheets,
    )
    files = {f"cut_{picture.key}.png": png for picture, png in shown}
    files |= sheets.files if sheets is not None else {}
    return files | {"report.html": render_page(outcome, page).encode("utf-8")}
