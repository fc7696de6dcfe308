"""What is known about table and cut of a polygon, as JSON for programs and for people.

>>> from camtools.polygon.generate import generate_polygon
>>> from camtools.polygon.part import example_polygon
>>> emit_polygon_text(make_polygon_summary(generate_polygon(example_polygon()))).splitlines()[0]
'p3g-25: table of 4928 bytes'
>>> name_of(example_polygon().polygon)
'P3G 25, e 0.8 mm (DIN 32711)'
"""

import numpy as np

from camtools.base.quantities import NM_PER_MM, length_text
from camtools.base.text import Json
from camtools.cut.feasibility import feasibility_of
from camtools.polygon.generate import GeneratedPolygon, widest_rad
from camtools.polygon.outline import all_around, is_smooth, measures_of
from camtools.polygon.part import PolygonSection
from camtools.report.learning_text import learned
from camtools.report.text import (
    COMPUTING_TIME,
    FOLLOWING_ERROR,
    MACHINE_TIME,
    error_pair,
    quantity,
    table_quantity,
    turns_text,
)
from camtools.sim.results import Cut
from camtools.skirt.geometry.poly_surface import PolySurface, piecewise
from camtools.skirt.report.outcome import pass_rows, table_error_nm, tool_rows
from camtools.skirt.report.summary import (
    about_channels,
    emit_text,
    motion_at,
    passes_of,
    tool_of,
)
from camtools.table.summary import about_image


def surface_of(prism: PolySurface, made: GeneratedPolygon) -> Json:
    """Return a surface as the gauge reads it."""
    return {
        "shape": "surface",
        "radius_mm": piecewise(made.geometry.radius),
        "surface": prism.document(),
        "gauge_mm": list(made.geometry.skirt_mm),
    }


def angles_of(made: GeneratedPolygon) -> np.ndarray:
    """Return angles all around, dense in the blends [rad]."""
    dense = [blend.looked_at() for blend in made.blended.blends]
    around = np.concatenate([all_around(made.drawing), *dense])
    return np.unique(np.mod(around, 2 * np.pi))


def _about(made: GeneratedPolygon) -> Json:
    section = made.part.polygon
    blends = {blend.joint_rad: blend for blend in made.blended.blends}
    drawn = [joint for joint in made.drawing.joints() if not is_smooth(joint)]  # of all repeats
    joints = [
        {
            "angle_deg": float(np.degrees(joint.angle_rad)),
            "slope_jump_mm_per_rad": joint.slope_mm,
            "bend_jump_mm_per_rad2": joint.bend_mm,
            "blend_half_deg": float(np.degrees(blends[joint.angle_rad].half_rad)),
            "room_half_deg": float(np.degrees(widest_rad(joint))),
            "deviation_um": 1000 * blends[joint.angle_rad].deviation_mm(),
        }
        for joint in drawn[: len(drawn) // made.drawing.repeat]
    ]
    return {
        "form": section.form,
        "repeats_per_turn": made.drawing.repeat,
        **measures_of(made.drawing)._asdict(),
        "taper": section.taper,
        "blend_um": section.blend_um,
        "deviation_um": made.deviation_um,
        "joints": joints,
    }


def make_polygon_summary(made: GeneratedPolygon) -> Json:
    """Return everything that is known about a table, ready for JSON; no dates, no paths."""
    table, process = made.table, made.part.process
    own = {
        "part": {"name": table.part_name, "kind": "polygon", "source": made.part.part.source},
        "process": process.model_dump()
        | {"u_zero_mm": made.middle_nm / NM_PER_MM, "passes": passes_of(table), "feed_law": None},
        "tool": tool_of(made.part.tool, made.heel),
        "polygon": _about(made),
        **about_channels(table, made.accuracy_u, made.accuracy_x),
        # the first section is not always the largest
        "motion": motion_at(
            *(made.geometry, (angles_of(made), np.array(made.part.heights_mm))),
            *(process.spindle_rpm, process.feed_mm),
        ),
        "feasibility": feasibility_of(
            made.peaks, made.part.machine.limits, process.spindle_rpm, made.highest_speed
        ),
        "design": surface_of(made.design, made),
    }
    if made.geometry.surface is not made.design:
        assert isinstance(made.geometry.surface, PolySurface)
        own["target"] = surface_of(made.geometry.surface, made)
    return about_image(table, made.tolerance_nm) | own


def section_text(about: Json) -> str:
    """Return the measures of a section in one phrase."""
    width = f"{about['least_width_mm']:.4g} .. {about['largest_width_mm']:.4g}"
    if about["largest_width_mm"] - about["least_width_mm"] < 1e-5:
        width = f"{about['largest_width_mm']:.6g} in every direction"
    return (
        f"inner circle {about['inner_circle_mm']:.6g} mm, "
        f"outer circle {about['outer_circle_mm']:.6g} mm, width {width}"
    )


def blend_text(about: Json) -> str:
    """Return what the blends are and cost in one phrase."""
    if not about["joints"]:
        return "none needed: the outline is smooth"
    widest = max(2 * joint["blend_half_deg"] for joint in about["joints"])
    return (
        f"{about['deviation_um']:.3g} um off the drawing at most (allowed {about['blend_um']:g} um)"
        f", over {widest:.3g} degrees"
    )


def emit_polygon_text(summary: Json) -> str:
    """Return a summary as a few lines for people."""
    about = summary["polygon"]
    own = f"  {section_text(about)}\n  blends: {blend_text(about)}\n"
    return emit_text(summary) + own


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


PolygonCut = Cut[GeneratedPolygon]


def _what_was_cut(cut: PolygonCut) -> str:
    section = cut.generated.part.polygon
    taper = f", taper {section.taper:g}" if section.taper else ""
    return f"{section.length_mm:g} mm{taper} {turns_text(cut)}"


def _form_text(cut: PolygonCut) -> str:
    form = cut.summary["form_error_um"]
    return f"{error_pair(form)} (tolerance {length_text(form['tolerance'])})"


ROWS = (
    quantity(
        "section",
        lambda cut: f"{name_of(cut.generated.part.polygon)}: {section_text(_about(cut.generated))}",
    ),
    quantity("cut", _what_was_cut),
    quantity("form error", _form_text),
    quantity(
        "controller's own error",
        lambda cut: error_pair(own) if (own := cut.summary.get("control_error_um")) else "",
    ),
    pass_rows,
    quantity("blends", lambda cut: blend_text(_about(cut.generated))),
    FOLLOWING_ERROR,
    learned,
    tool_rows,
    table_quantity(table_error_nm),
    MACHINE_TIME,
    COMPUTING_TIME,
)
