"""What is known about a table, as JSON for programs.

>>> from camtools.skirt.part.part_file import example_part
>>> segment_facts(example_part().piston)
{}
"""

from __future__ import annotations

from collections.abc import Callable
from math import isinf

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats, omega_rad_s
from camtools.base.text import Json
from camtools.cut.feasibility import feasibility_of
from camtools.part.common import Tool
from camtools.skirt.geometry.corner import Corner
from camtools.skirt.geometry.profile import (
    noise_facts,
    notable_overshoots,
    pieces_of,
    smoothing_facts,
    smoothing_takes_um,
)
from camtools.skirt.geometry.run_in import HeldSurface
from camtools.skirt.geometry.scan import coverage
from camtools.skirt.geometry.sides import SidesSurface, TurnedSurface
from camtools.skirt.geometry.skirt_geometry import Geometry, dense_heights_mm
from camtools.skirt.part.part_file import Piston
from camtools.skirt.part.profile_keys import Ovality, Profile
from camtools.skirt.part.segments import Piece
from camtools.skirt.table.accuracy import Accuracy
from camtools.skirt.table.gauge_design import design_of, target_of
from camtools.skirt.table.generate import NM_PER_UM, GeneratedSkirt, peaks_of_table
from camtools.skirt.table.speed import summary_of
from camtools.skirt.tool.heel import Heel
from camtools.table.channel import KIND_U, KIND_X, Channel
from camtools.table.evaluate import jumps
from camtools.table.image import Table
from camtools.table.summary import about_image, describe_channel

_PEAK_ANGLES = 1440
_PEAK_HEIGHTS_PER_PIECE = 16


def motion_at(
    geometry: Geometry, grid: tuple[Floats, Floats], spindle_rpm: float, feed_mm: float
) -> Json:
    """Return the peaks of U on a grid of angles [rad] and heights [mm] at a spindle speed."""
    phi_rad, z_mm = grid
    u, omega = geometry.delta(phi_rad, z_mm[:, None]), omega_rad_s(spindle_rpm)
    rise = np.diff(u.delta, axis=0) / np.diff(z_mm)[:, None]
    return {
        "stroke_mm": float(np.ptp(u.delta)),
        "velocity_mm_s": float(np.abs(u.d1).max()) * omega,
        "acceleration_mm_s2": float(np.abs(u.d2).max()) * omega**2,
        "jerk_mm_s3": float(np.abs(u.d3).max()) * omega**3,
        "velocity_from_feed_mm_s": float(np.abs(rise).max()) * feed_mm * spindle_rpm / 60,
    }


def error_of(accuracy: Accuracy, per: str) -> Json:
    """Return the errors of a channel for the summary; derivatives by `per`."""
    return {
        "value_nm": accuracy.value_nm,
        f"first_nm_per_{per}": accuracy.first,
        f"second_nm_per_{per}2": accuracy.second,
        "first_share_of_peak": accuracy.first_share,
        "second_share_of_peak": accuracy.second_share,
    }


def jumps_of(channel: Channel) -> Json:
    """Return the jumps of a channel at its knots and at the wrap."""
    knots, wrap = jumps(channel)
    return {"at_knots": knots._asdict(), "at_wrap": wrap._asdict()}


def passes_of(table: Table) -> list[Json]:
    """Return the passes as the table has them, none of a part that is cut in one."""
    return [
        {
            "allowance_um": one.allowance_nm / NM_PER_UM,
            "feed_mm": one.feed_nm / NM_PER_MM,
            "spindle_rpm": one.spindle_mrpm / 1000,
        }
        for one in table.passes
    ]


def _process(result: GeneratedSkirt) -> Json:
    process, magnify = result.part.process, result.part.magnify
    return {
        "spindle_rpm": float(process.spindle_rpm),
        "feed_mm": float(process.feed_mm),
        "depth_mm": float(process.depth_mm),
        "direction": process.direction,
        "form_error_um": float(process.form_error_um),
        "smoothing_takes_um": smoothing_takes_um(result.part),
        "u_zero": process.u_zero,
        "u_zero_mm": result.middle_nm / NM_PER_MM,
        "run_in_mm": float(process.run_in_mm),
        "run_out_mm": float(process.run_out_mm),
        "passes": passes_of(result.table),
        "feed_law": process.feed_law.model_dump() if process.feed_law else None,
        "magnify": float(magnify.factor) if magnify else 1.0,
        "magnify_profile": magnify.profile_factor if magnify else 1.0,
    }


def tool_of(tool: Tool, heel: Heel) -> Json:
    """Return the tool for which a table is made, and how near its heel comes to the work."""
    return tool.model_dump() | {
        "needed_clearance_deg": heel.needed_deg,
        "heel_at_deg": heel.angle_deg,
        "heel_at_mm": heel.z_mm,
    }


def _refit(corner: Corner) -> Json:
    """Return what a refit came to, and what all deletions would come to at the part's speed."""
    recipe, at = corner.recipe, corner.joint(corner.worst_mm)
    assert recipe is not None
    arc = at.arc()
    return {
        "recipe": recipe._asdict(),
        "height_mm": corner.worst_mm,
        "joint_deg": float(np.degrees(at.joint_rad)),
        "eccentricity_mm": float(arc.eccentricity_mm),
        "radius_mm": float(arc.radius_mm),
        "corner_mm_per_rad": float(at.corner_mm_rad()),
        "deviation_um": corner.off.um if corner.off else 0.0,
        "deviation_limit_um": corner.off_limit_um,
        "candidates": [one._asdict() for one in corner.candidates],
    }


def where_sides_meet(geometry: Geometry) -> Json | None:
    """Return where two sides meet and by how much they differ there, nothing of other sections."""
    sides = geometry.surface
    sides = sides.inner if isinstance(sides, HeldSurface) else sides
    sides = sides.surface if isinstance(sides, TurnedSurface) else sides
    if not isinstance(sides, SidesSurface) or sides.antithrust is None:
        return None
    z_mm = dense_heights_mm(geometry, _PEAK_HEIGHTS_PER_PIECE)
    inside = (z_mm >= geometry.skirt_mm[0]) & (z_mm <= geometry.skirt_mm[1])
    return {"meet": sides.meet, "step_um": sides.step_mm(z_mm[inside]) * 1000}


def _piece(piece: Piece, scale: int) -> Json:
    return {
        "to_mm": piece.to_mm,
        "value_mm": scale * piece.value_mm,
        "radius_mm": None if isinf(piece.radius_mm) else piece.radius_mm,
        "kink_deg": piece.kink_deg,
    }


def segment_facts(piston: Piston) -> Json:
    """Return lines and arcs of profile and ovality, nothing of other curves.

    Values are diameters and ovalities at the ends; a line has no radius; kink_deg is the turn
    against the segment before.
    """
    drawn = {"profile": (piston.profile, 2), "ovality": (piston.ovality, 1)}
    return {
        name: [_piece(piece, scale) for piece in pieces_of(one)]
        for name, (one, scale) in drawn.items()
        if isinstance(one, Profile | Ovality) and one.segment
    }


def _extras(result: GeneratedSkirt) -> Json:
    """Return what only some parts have: a corner, measured points, a modulated spindle."""
    extras: Json = {}
    if result.geometry.corner is not None:
        extras["refit"] = _refit(result.geometry.corner)
    if result.geometry.measured is not None:
        extras["scan"] = {
            "off_points_um": result.geometry.off_points_um,
            "joined_um": result.geometry.joined_um,
            **coverage(result.geometry.measured[0]),
        }
    facts: dict[str, Callable[[Piston], Json | list[str]]] = {
        "overshoots": notable_overshoots,
        "smoothing": smoothing_facts,
        "noise": noise_facts,
        "segments": segment_facts,
    }
    known: Json = {name: facts_of(result.part.piston) for name, facts_of in facts.items()}
    known["sides"] = where_sides_meet(result.geometry)
    extras |= {name: fact for name, fact in known.items() if fact}
    if result.geometry.correction is not None:
        extras["correction"] = result.geometry.correction.document()
    if result.speed is not None:
        extras["equal_volume"] = summary_of(result.speed, result.part)
    return extras


def make_summary(result: GeneratedSkirt) -> Json:
    """Return everything that is known about a table, ready for JSON; no dates, no paths."""
    table = result.table
    u, x = table.channel(KIND_U), table.channel(KIND_X)
    process = result.part.process
    phi_rad = 2 * np.pi * np.arange(_PEAK_ANGLES) / _PEAK_ANGLES
    grid = phi_rad, dense_heights_mm(result.geometry, _PEAK_HEIGHTS_PER_PIECE)
    return (
        _extras(result)
        | about_image(table, result.tolerance_nm)
        | {
            "part": {"name": table.part_name, "source": result.part.part.source},
            "process": _process(result),
            "tool": tool_of(result.part.tool, result.heel),
            "channels": {"u": describe_channel(u), "x": describe_channel(x)},
            "error": {
                "u": error_of(result.accuracy_u, "rad"),
                "x": error_of(result.accuracy_x, "mm"),
            },
            "continuity": {"u": jumps_of(u), "x": jumps_of(x)},
            "motion": motion_at(result.geometry, grid, process.spindle_rpm, process.feed_mm),
            "feasibility": feasibility_of(
                peaks_of_table(table, result.speed),
                *(result.part.machine.limits, process.spindle_rpm, result.highest_speed),
            ),
            "design": design_of(result) | {"gauge_mm": list(result.geometry.skirt_mm)},
        }
        | target_of(result)
    )
