"""What the cut of a polygon came to, in words and numbers.

>>> from camtools.polygon.part import example_polygon
>>> name_of(example_polygon().polygon)
'P3G 25, e 0.8 mm (DIN 32711)'
"""

from __future__ import annotations

from camtools.base.quantities import length_text
from camtools.polygon.generate import GeneratedPolygon
from camtools.polygon.part import PolygonSection
from camtools.polygon.summary import blend_text, make_polygon_summary, section_text
from camtools.report.learning_text import learning_rows
from camtools.report.text import ReportRow, error_pair
from camtools.sim.results import Cut
from camtools.skirt.report.text import pass_rows
from camtools.skirt.report.tool_text import tool_row, track_row

PolygonCut = Cut[GeneratedPolygon]


def name_of(section: PolygonSection) -> str:
    """Return what a section is called on drawings."""
    if section.form == "p3g":
        return f"P3G {section.mean_diameter_mm:g}, e {section.eccentricity_mm:g} mm (DIN 32711)"
    if section.form == "p4c":
        return (
            f"P4C {section.outer_diameter_mm:g}/{section.inner_diameter_mm:g}, "
            f"e {section.eccentricity_mm:g} mm (DIN 32712)"
        )
    if section.form == "regular":
        return f"polygon of {section.sides} sides, {section.across_flats_mm:g} mm across flats"
    return f"polygon of {len(section.corners_mm or [])} corners"


def polygon_rows(outcome: PolygonCut) -> list[ReportRow]:
    """Return the summary, machine limits apart."""
    summary, made = outcome.summary, outcome.generated
    form, cut, section = summary["form_error_um"], summary["cut"], made.part.polygon
    about = make_polygon_summary(made)["polygon"]
    worst_nm = max(made.accuracy_u.value_nm, made.accuracy_x.value_nm)
    taper = f", taper {section.taper:g}" if section.taper else ""
    what = (
        f"{section.length_mm:g} mm{taper} at {cut['spindle_rpm']:g} r/min, feed "
        f"{cut['feed_mm']:g} mm, {cut['turns']:.0f} of {cut['planned_turns']:.0f} turns"
    )
    control = summary.get("control_error_um")
    against = [] if control is None else [ReportRow("controller's own error", error_pair(control))]
    wall_s = summary["wall_time_s"]
    return [
        ReportRow("section", f"{name_of(section)}: {section_text(about)}"),
        ReportRow("cut", what),
        ReportRow("form error", f"{error_pair(form)} (tolerance {length_text(form['tolerance'])})"),
        *against,
        *pass_rows(summary),
        ReportRow("blends", blend_text(about)),
        ReportRow("following error of U", error_pair(summary["following_error_um"])),
        *learning_rows(summary),
        tool_row(summary, made.part.tool, made.heel),
        track_row(summary, made.part.tool),
        ReportRow("table", f"{summary['table_bytes']} bytes, accurate to {worst_nm:.2g} nm"),
        ReportRow("machine time", f"{summary['machine_time_s']:.1f} s"),
        ReportRow("computing time", f"{wall_s:.2f} s for the cut with its trace"),
    ]
