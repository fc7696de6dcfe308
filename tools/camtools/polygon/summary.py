"""What is known about the table of a polygon, as JSON for programs and in lines for people.

>>> from camtools.polygon.generate import generate_polygon
>>> from camtools.polygon.part import example_polygon
>>> emit_polygon_text(make_polygon_summary(generate_polygon(example_polygon()))).splitlines()[0]
'p3g-25: table of 4928 bytes'
"""

from __future__ import annotations

import numpy as np

from camtools.base.json_text import Json
from camtools.base.quantities import NM_PER_MM, omega_rad_s
from camtools.cut.feasibility import given_of, needed_of
from camtools.polygon.blend import widest_rad
from camtools.polygon.generate import GeneratedPolygon
from camtools.polygon.outline import Outline, OutlineJoint, all_around, is_smooth, measures_of
from camtools.skirt.geometry.poly_surface import PolySurface
from camtools.skirt.report.summary import error_of, jumps_of, motion_at, passes_of, tool_of
from camtools.skirt.report.summary_text import emit_text
from camtools.table.channel import KIND_U, KIND_X
from camtools.table.summary import about_image, describe_channel


def surface_of(prism: PolySurface, made: GeneratedPolygon) -> Json:
    """Return a surface as the gauge reads it."""
    radius = made.geometry.radius
    axis = {"breaks_mm": radius.x.tolist(), "coefficients": radius.c.T.tolist()}
    return {
        "shape": "surface",
        "radius_mm": axis,
        "surface": prism.document(),
        "gauge_mm": list(made.geometry.skirt_mm),
    }


def angles_of(made: GeneratedPolygon) -> np.ndarray:
    """Return angles all around, dense in the blends [rad]."""
    dense = [blend.looked_at() for blend in made.blended.blends]
    around = np.concatenate([all_around(made.drawing), *dense])
    return np.unique(np.mod(around, 2 * np.pi))


def _motion(made: GeneratedPolygon) -> Json:
    """Return the peaks of U at the part's speed; the first section is not always the largest."""
    process, geometry = made.part.process, made.geometry
    phi, ends = angles_of(made), np.array([geometry.z_first_mm, geometry.z_last_mm])
    return motion_at(geometry, (phi, ends), process.spindle_rpm, process.feed_mm)


def _feasibility(made: GeneratedPolygon) -> Json:
    limits, rpm = made.part.machine.limits, made.part.process.spindle_rpm
    given, needed = given_of(limits), needed_of(made.peaks, limits, omega_rad_s(rpm))
    return {
        "limits": given,
        "needed": {name: needed[name] for name in given},
        "highest_spindle_rpm": made.highest_speed.rpm,
        "decided_by": made.highest_speed.decides,
    }


def joints_of(outline: Outline) -> list[OutlineJoint]:
    """Return the joints of the first of the repeated stretches."""
    joints = [one for one in outline.joints() if not is_smooth(one)]
    return joints[: len(joints) // outline.repeat]


def _about(made: GeneratedPolygon) -> Json:
    """Return section, joints and blends."""
    section = made.part.polygon
    blends = {blend.joint_rad: blend for blend in made.blended.blends}
    joints = [
        {
            "angle_deg": float(np.degrees(one.angle_rad)),
            "slope_jump_mm_per_rad": one.slope_mm,
            "bend_jump_mm_per_rad2": one.bend_mm,
            "blend_half_deg": float(np.degrees(blends[one.angle_rad].half_rad)),
            "room_half_deg": float(np.degrees(widest_rad(one))),
            "deviation_um": 1000 * blends[one.angle_rad].deviation_mm(),
        }
        for one in joints_of(made.drawing)
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
    u, x = table.channel(KIND_U), table.channel(KIND_X)
    own = {
        "part": {"name": table.part_name, "kind": "polygon", "source": made.part.part.source},
        "process": process.model_dump()
        | {"u_zero_mm": made.middle_nm / NM_PER_MM, "passes": passes_of(table), "feed_law": None},
        "tool": tool_of(made.part.tool, made.heel),
        "polygon": _about(made),
        "channels": {"u": describe_channel(u), "x": describe_channel(x)},
        "error": {"u": error_of(made.accuracy_u, "rad"), "x": error_of(made.accuracy_x, "mm")},
        "continuity": {"u": jumps_of(u), "x": jumps_of(x)},
        "motion": _motion(made),
        "feasibility": _feasibility(made),
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
    widest = max(2 * one["blend_half_deg"] for one in about["joints"])
    return (
        f"{about['deviation_um']:.3g} um off the drawing at most (allowed {about['blend_um']:g} um)"
        f", over {widest:.3g} degrees"
    )


def emit_polygon_text(summary: Json) -> str:
    """Return a summary as a few lines for people."""
    about = summary["polygon"]
    own = f"  {section_text(about)}\n  blends: {blend_text(about)}\n"
    return emit_text(summary) + own
