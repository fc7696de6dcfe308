"""What is known about a table, as JSON for programs and as a few lines for people.

The gauge compares a cut skirt with the drawing, and with its refit or filter, not with the table.

>>> from camtools.skirt.part.part_file import example_part
>>> segment_facts(example_part().piston)
{}
"""

from collections.abc import Callable, Sequence
from math import isinf

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.quantities import NM_PER_MM, NM_PER_UM, Floats, omega_rad_s
from camtools.base.text import Json
from camtools.cut.feasibility import feasibility_of, tenth_below
from camtools.measured.correction_step import round_text
from camtools.part.areas import Zone
from camtools.part.common import Tool
from camtools.part.smoothing import share_text
from camtools.skirt.geometry.corner import Corner
from camtools.skirt.geometry.corrected import CorrectedSurface
from camtools.skirt.geometry.outliers import Outlier
from camtools.skirt.geometry.poly_surface import TURN_RAD, PolySurface, piecewise
from camtools.skirt.geometry.profile import (
    noise_facts,
    notable_overshoots,
    pieces_of,
    smoothing_facts,
    smoothing_takes_um,
    smoothing_texts,
    tolerances_left,
)
from camtools.skirt.geometry.run_in import HeldSurface
from camtools.skirt.geometry.scan import coverage
from camtools.skirt.geometry.sections import ALL_AROUND_RAD, SkirtSurface
from camtools.skirt.geometry.sides import SidesSurface, TurnedSurface
from camtools.skirt.geometry.skirt_geometry import Geometry, dense_heights_mm
from camtools.skirt.part.curves import Piece
from camtools.skirt.part.keys import GIVEN_BY_POINTS, Ovality, Profile
from camtools.skirt.part.part_file import Piston, SkirtPart
from camtools.skirt.report.fit import fit_facts, fit_text
from camtools.skirt.table.accuracy import Accuracy
from camtools.skirt.table.generate import GeneratedSkirt, peaks_of_table
from camtools.skirt.table.speed import summary_of
from camtools.skirt.tool.program import bands_document
from camtools.skirt.tool.turning import Heel
from camtools.table.channel import KIND_U, KIND_X
from camtools.table.evaluate import jumps
from camtools.table.image import Table
from camtools.table.summary import about_image, describe_channel


def _document(part: SkirtPart, geometry: Geometry, radius_mm: PPoly, surface: SkirtSurface) -> Json:
    if isinstance(surface, HeldSurface):  # beyond the ends nothing is gauged
        surface = surface.inner
    if isinstance(surface, CorrectedSurface):
        more = {"correction": surface.correction.for_gauge()}
        return _document(part, geometry, radius_mm, surface.inner) | more
    section = part.piston.section
    radius: Json = {"radius_mm": piecewise(radius_mm)}
    if isinstance(surface, TurnedSurface):
        radius["phase_rad"] = piecewise(surface.phase)
        surface = surface.surface
    if isinstance(surface, PolySurface):
        return {"shape": "surface"} | radius | {"surface": surface.document()}
    if isinstance(surface, SidesSurface):
        return {"shape": "sides"} | radius | surface.document()
    oval = radius | {"ovality_mm": piecewise(geometry.ovality)}
    found: Json = {"shape": section.shape, "beta": float(np.asarray(section.beta))} | oval
    if isinstance(surface, Corner):
        # What it has beyond an oval; layout: host_sim/part/sim_design.h.
        joint = PPoly(np.radians(surface.joint_deg.c) / TURN_RAD, surface.joint_deg.x)
        corner = {"trim_mm": piecewise(surface.trim), "joint_turn": piecewise(joint)}
        found |= {"base": section.base} | corner
    return found


def drawing_of(part: SkirtPart, geometry: Geometry) -> Json:
    """Return the drawing of a geometry that may play something else."""
    radius = geometry.drawn_radius or geometry.radius
    return _document(part, geometry, radius, geometry.drawing)


def _zone(zone: Zone) -> Json:
    found: Json = zone.area.document() | {"name": zone.name}
    if zone.form_error_um is not None:
        found["tolerance_um"] = zone.form_error_um
    for key, um in (("lower_um", zone.lower_um), ("upper_um", zone.upper_um)):
        if zone.height_mm is not None and um is not None:
            slopes = np.diff(um) / np.diff(zone.height_mm)
            pieces = np.stack([0 * slopes, 0 * slopes, slopes, np.array(um[:-1])])
            found[key] = piecewise(PPoly(pieces, zone.height_mm))
    return found


def _areas_of(part: SkirtPart) -> Json:
    """Return windows, zones and bands, where a part has any; layout: sim_area.h, sim_band.h."""
    lists = {
        "windows": [area.document() for area in part.piston.window_areas],
        "zones": [_zone(zone) for zone in tolerances_left(part).zones],
        "bands": bands_document(part.bands),
    }
    return {name: found for name, found in lists.items() if found}


def design_of(result: GeneratedSkirt) -> Json:
    """Return the drawing, by which a part is judged: corners and all measured points included."""
    return drawing_of(result.part, result.geometry) | _areas_of(result.part)


def target_of(result: GeneratedSkirt) -> Json:
    """Return {"target": ...} where the table plays a refit, a filter or a correction, else {}."""
    geometry = result.geometry
    if geometry.drawn is None:
        return {}
    target = _document(result.part, geometry, geometry.radius, geometry.surface)
    return {"target": target}


_PEAK_ANGLES = 1440
_PEAK_HEIGHTS_PER_PIECE = 16


def motion_at(
    geometry: Geometry,
    grid: tuple[Floats, Floats],
    spindle_rpm: float,
    feed_mm: float,
    grooves: Sequence[tuple[float, float]] = (),
) -> Json:
    """Return the peaks of U on a grid of angles [rad] and heights [mm] at a spindle speed.

    Nothing is fed through grooves, between two heights each.
    """
    phi_rad, z_mm = grid
    u, omega = geometry.delta(phi_rad, z_mm[:, None]), omega_rad_s(spindle_rpm)
    rise = np.diff(u.delta, axis=0) / np.diff(z_mm)[:, None]
    for low, high in grooves:
        rise = np.where(((z_mm[:-1] < high) & (z_mm[1:] > low))[:, None], 0.0, rise)
    return {
        "stroke_mm": float(np.ptp(u.delta)),
        "velocity_mm_s": float(np.abs(u.d1).max()) * omega,
        "acceleration_mm_s2": float(np.abs(u.d2).max()) * omega**2,
        "jerk_mm_s3": float(np.abs(u.d3).max()) * omega**3,
        "velocity_from_feed_mm_s": float(np.abs(rise).max()) * feed_mm * spindle_rpm / 60,
    }


def _error(accuracy: Accuracy, per: str) -> Json:
    return {
        "value_nm": accuracy.value_nm,
        f"first_nm_per_{per}": accuracy.first,
        f"second_nm_per_{per}2": accuracy.second,
        "first_share_of_peak": accuracy.first_share,
        "second_share_of_peak": accuracy.second_share,
    }


def about_channels(table: Table, accuracy_u: Accuracy, accuracy_x: Accuracy) -> Json:
    """Return sizes, errors and jumps of the channels of U and X."""
    channels = {"u": table.channel(KIND_U), "x": table.channel(KIND_X)}
    places = {name: jumps(channel) for name, channel in channels.items()}
    return {
        "channels": {name: describe_channel(channel) for name, channel in channels.items()},
        "error": {"u": _error(accuracy_u, "rad"), "x": _error(accuracy_x, "mm")},
        "continuity": {
            name: {"at_knots": knots._asdict(), "at_wrap": wrap._asdict()}
            for name, (knots, wrap) in places.items()
        },
    }


def passes_of(table: Table) -> list[Json]:
    """Return the passes as the table has them, none of a part that is cut in one."""
    return [
        {
            "allowance_um": record.allowance_nm / NM_PER_UM,
            "feed_mm": record.feed_nm / NM_PER_MM,
            "spindle_rpm": record.spindle_mrpm / 1000,
        }
        for record in table.passes
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
        "candidates": [candidate._asdict() for candidate in corner.candidates],
    }


def where_sides_meet(geometry: Geometry) -> Json | None:
    """Return where two sides meet and by how much they differ there, nothing of other sections."""
    sides = geometry.surface
    sides = sides.inner if isinstance(sides, HeldSurface | CorrectedSurface) else sides
    sides = sides.surface if isinstance(sides, TurnedSurface) else sides
    if not isinstance(sides, SidesSurface) or sides.antithrust is None:
        return None
    z_mm = dense_heights_mm(geometry, _PEAK_HEIGHTS_PER_PIECE)
    inside = (z_mm >= geometry.skirt_mm[0]) & (z_mm <= geometry.skirt_mm[1])
    return {"meet": sides.meet, "step_um": sides.step_mm(z_mm[inside]) * 1000}


_MOST_BEYOND_MM = 1e-3  # of the diameter, which noise may have


def beyond_profile(geometry: Geometry) -> Json | None:
    """Return where the drawn surface exceeds the profile's diameter most, and by how much [mm]."""
    z_mm = geometry.breaks_mm()
    z_mm = z_mm[(z_mm >= geometry.skirt_mm[0]) & (z_mm <= geometry.skirt_mm[1])]
    less = np.stack([geometry.drawing.delta(ALL_AROUND_RAD, float(z)).delta for z in z_mm])
    more_mm = -(less + np.roll(less, less.shape[1] // 2, axis=1))
    i, j = np.unravel_index(int(more_mm.argmax()), more_mm.shape)
    if more_mm[i, j] <= _MOST_BEYOND_MM:
        return None
    return {
        "diameter_mm": float(more_mm[i, j]),
        "z_mm": float(z_mm[i]),
        "angle_deg": float(np.degrees(ALL_AROUND_RAD[j % (ALL_AROUND_RAD.size // 2)])),
        "is_inverted": bool(more_mm[i, j] > -more_mm.min()),  # it is hardly less anywhere
    }


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
        name: [_piece(piece, scale) for piece in pieces_of(curve)]
        for name, (curve, scale) in drawn.items()
        if isinstance(curve, Profile | Ovality) and curve.segment
    }


def import_facts(piston: Piston) -> Json:
    """Return how the files were understood that give profile and ovality, nothing of lists."""
    drawn = {"profile": piston.profile, "ovality": piston.ovality}
    return {
        name: curve.understood
        for name, curve in drawn.items()
        if isinstance(curve, Profile | Ovality) and curve.understood
    }


def _extras(result: GeneratedSkirt) -> Json:
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
        "imported": import_facts,
    }
    known: Json = {name: facts_of(result.part.piston) for name, facts_of in facts.items()}
    known["fit"] = fit_facts(result.part.piston, result.geometry)
    known["sides"] = where_sides_meet(result.geometry)
    if result.part.piston.section.shape in GIVEN_BY_POINTS:
        known["beyond_profile"] = beyond_profile(result.geometry)
    extras |= {name: fact for name, fact in known.items() if fact}
    if result.geometry.correction is not None:
        extras["correction"] = result.geometry.correction.document()
    if result.speed is not None:
        extras["equal_volume"] = summary_of(result.speed, result.part)
    return extras


def make_summary(made: GeneratedSkirt) -> Json:
    """Return everything that is known about a table, ready for JSON; no dates, no paths."""
    table = made.table
    process = made.part.process
    phi_rad = 2 * np.pi * np.arange(_PEAK_ANGLES) / _PEAK_ANGLES
    grid = phi_rad, dense_heights_mm(made.geometry, _PEAK_HEIGHTS_PER_PIECE)
    return (
        _extras(made)
        | about_image(table, made.tolerance_nm)
        | {
            "part": {"name": table.part_name, "source": made.part.part.source},
            "process": _process(made),
            "tool": tool_of(made.part.tool, made.heel),
            **about_channels(table, made.accuracy_u, made.accuracy_x),
            "motion": motion_at(
                *(made.geometry, grid, process.spindle_rpm, process.feed_mm),
                made.part.piston.grooves_mm,
            ),
            "feasibility": feasibility_of(
                peaks_of_table(table, made.speed),
                *(made.part.machine.limits, process.spindle_rpm, made.highest_speed),
            ),
            "design": design_of(made) | {"gauge_mm": list(made.geometry.skirt_mm)},
        }
        | target_of(made)
    )


def emit_text(summary: Json) -> str:
    """Return a summary as a few lines for people."""
    u, x, error = summary["channels"]["u"], summary["channels"]["x"], summary["error"]
    motion, feasible = summary["motion"], summary["feasibility"]
    knots = u["knots_per_pattern"] * u["patterns_per_turn"]
    error_u, error_x = error["u"], error["x"]
    return (
        f"{summary['part']['name']}: table of {summary['table_bytes']} bytes\n"
        f"  u {u['n_slices']} slices, {knots} knots per turn ({u['knots_per_pattern']} stored), "
        f"{u['frac_bits']} fraction bits; x {x['n_slices']} knots\n"
        f"  error u {error_u['value_nm']:.3f} nm, x {error_x['value_nm']:.3f} nm "
        f"(tolerance {summary['tolerance_nm']:g} nm), "
        f"u' {error_u['first_share_of_peak']:.1e}, u'' {error_u['second_share_of_peak']:.1e}"
        " of their peaks\n"
        f"  U at {summary['process']['spindle_rpm']:g} r/min: stroke {motion['stroke_mm']:.4f} mm, "
        f"{motion['velocity_mm_s']:.3f} mm/s, {motion['acceleration_mm_s2']:.1f} mm/s2, "
        f"{motion['jerk_mm_s3']:.4g} mm/s3\n"
        f"  highest speed {tenth_below(feasible['highest_spindle_rpm'])} r/min, "
        f"limited by {feasible['decided_by']}\n"
        + _room_text(summary)
        + "".join(map(_band_text, summary["design"].get("bands", [])))
        + tool_text(summary["tool"])
        + "".join(f"  {name} from {how}\n" for name, how in summary.get("imported", {}).items())
        + _segments_text(summary.get("segments", {}))
        + _smoothing_text(summary)
        + _profile_text(summary)
        + "".join(f"  {text} (overshoot_um)\n" for text in summary.get("overshoots", []))
        + _scan_text(summary)
        + _beyond_text(summary)
        + fit_text(summary.get("fit", {}))
        + _sides_text(summary)
        + _refit_text(summary)
        + _speed_text(summary)
        + (round_text(summary["correction"]) if "correction" in summary else "")
    )


def _band_text(band: Json) -> str:
    passes = zip(band["feed_mm"], band["allowance_mm"], strict=True)
    words = (f"feed {feed:.4g} mm leaves {1000 * mm:g} um" for feed, mm in passes)
    return f"  {band['name']} {band['low_mm']:g} .. {band['high_mm']:g} mm: {', '.join(words)}\n"


def clearance_text(clearance_deg: float, heel: Heel) -> str:
    """Return the clearance angle of a tool, and what the part requires where.

    >>> clearance_text(7.0, Heel(0.188, 45.0, 62.0))
    'clearance angle 7 degrees, required 0.19 (at 45 degrees, height 62 mm)'
    """
    place = f"{heel.angle_deg:g} degrees, height {heel.z_mm:g} mm"
    return f"clearance angle {clearance_deg:g} degrees, required {heel.needed_deg:.2f} (at {place})"


def _words(segment: Json) -> str:
    radius = segment["radius_mm"]
    kind = "line" if radius is None else f"arc of {radius:.6g} mm"
    return f"{kind} to {segment['to_mm']:g} mm, {segment['value_mm']:.6g} mm"


def _segments_text(found: Json) -> str:
    return "".join(
        f"  {name}: {'; '.join(_words(segment) for segment in segments)}\n"
        for name, segments in found.items()
    )


def tool_text(tool: Json) -> str:
    """Return the tool of a skirt's table and the clearance that its heel has left."""
    nose = f"nose radius {tool['nose_radius_mm']:g} mm" if tool["nose_radius_mm"] else "pointed"
    worn = f", worn by {tool['wear_um']:g} um" if tool["wear_um"] else ""
    heel = Heel(tool["needed_clearance_deg"], tool["heel_at_deg"], tool["heel_at_mm"])
    return f"  tool: {nose}{worn}, {clearance_text(tool['clearance_deg'], heel)}\n"


def _smoothing_text(summary: Json) -> str:
    process = summary["process"]
    # Of polygons, whose summary is this one, too, nothing is smoothed.
    allowed_um, taken_um = process.get("form_error_um", 0.0), process.get("smoothing_takes_um", 0.0)
    found, noise = summary.get("smoothing", {}), summary.get("noise", {})
    lines = smoothing_texts(found, noise, allowed_um)
    lines += [share_text(taken_um, allowed_um)] if taken_um else []
    return "".join(f"  {line}\n" for line in lines)


def _room_text(summary: Json) -> str:
    process, text = summary["process"], ""
    if process["u_zero"] == "mean":
        below = f"{process['u_zero_mm']:.6g} mm below the long axis"
        text += f"  U = 0 is the middle of its stroke, {below}\n"
    if process["run_in_mm"] or process["run_out_mm"]:
        text += f"  run-in {process['run_in_mm']:g} mm, run-out {process['run_out_mm']:g} mm\n"
    for number, record in enumerate(process.get("passes", []), start=1):
        text += (
            f"  pass {number} of {len(process['passes'])}: {record['spindle_rpm']:g} r/min, feed "
            f"{record['feed_mm']:.6g} mm, leaves {record['allowance_um']:g} um\n"
        )
    if process.get("feed_law") is not None:
        low, high = min(process["feed_law"]["feed_mm"]), max(process["feed_law"]["feed_mm"])
        text += f"  feed {low:g} .. {high:g} mm over the height, mean {process['feed_mm']:.6g} mm\n"
    return text


def _speed_text(summary: Json) -> str:
    speed = summary.get("equal_volume")
    if speed is None:
        return ""
    return (
        f"  equal volume: ripple of the removal rate {100 * speed['ripple']:.2f} % of its mean "
        f"(uniform {100 * speed['ripple_uniform']:.2f} %, partial modulation "
        f"{100 * speed['ripple_partial']:.2f} %, law alone "
        f"{100 * speed['ripple_of_the_law']:.2f} %), worst at height {speed['height_mm']:g} mm\n"
        f"  spindle up to {speed['ratio_max']:.4f} of its mean speed, "
        f"{speed['spindle_acceleration_rad_s2']:.1f} rad/s2; a constant rate is possible up to "
        f"{speed['full_modulation_up_to_rpm']:.1f} r/min\n"
        f"  {speed['time_per_part_s']:.1f} s for the part; uniform turning at its highest speed, "
        f"{speed['uniform_highest_rpm']:.0f} r/min, "
        f"{speed['time_uniform_at_highest_speed_s']:.1f} s\n"
    )


def _profile_text(summary: Json) -> str:
    text = ""
    for axis, curve in (("x", "profile"), ("u", "ovality")):
        error_nm = summary["error"][axis]["value_nm"]
        if error_nm > summary["tolerance_nm"]:
            steps = f"the {curve} has corners or steps of curvature"
            text += f"  {steps}; {axis} follows them within {error_nm:.3g} nm\n"
    return text


def _scan_text(summary: Json) -> str:
    if "scan" not in summary:
        return ""
    scan = summary["scan"]
    text = f"  the scan has {_covered_text(scan)}\n"
    text += f"  the surface is within {scan['off_points_um']:.3f} um of all points\n"
    if scan["joined_um"] > 0:
        text += (
            f"  the heights have different angles; splines join them within "
            f"{scan['joined_um']:.2g} um\n"
        )
    if scan["outliers"]:
        text += f"  caution: {Outlier(**scan['outliers'][0]).words}\n"
    return text


def _beyond_text(summary: Json) -> str:
    if "beyond_profile" not in summary:
        return ""
    found = summary["beyond_profile"]
    text = (
        f"the surface exceeds the profile's diameter by up to {found['diameter_mm']:.4g} mm, at "
        f"{found['angle_deg']:g} degrees, height {found['z_mm']:g} mm"
    )
    if found["is_inverted"]:
        text = f"caution: {text}; reductions are positive towards the axis"
    return f"  {text}\n"


def _covered_text(scan: Json) -> str:
    heights, gaps = scan["heights_mm"], scan["gaps"]
    if len(heights) == 1:
        text = f"{scan['points']} points at {heights[0]:g} mm, which serve all heights"
    else:
        text = f"{scan['points']} points at {len(heights)} heights, {heights[0]:g} .. "
        text += f"{heights[-1]:g} mm"
    if not gaps:
        return text + ", without a gap in the angle"
    widest = max(gaps, key=lambda gap: (gap["to_deg"] - gap["from_deg"]) % 360)
    most_um = max(gap["beyond_um"] for gap in gaps)
    return (
        f"{text}; bridged gaps in the angle: {len(gaps)}, at most {most_um:.3g} um beyond their "
        f"ends, the widest from {widest['from_deg']:g} to {widest['to_deg']:g} degrees at "
        f"{widest['z_mm']:g} mm"
    )


def _sides_text(summary: Json) -> str:
    if "sides" not in summary:
        return ""
    sides = summary["sides"]
    place = sides["meet"].replace("-", " ")
    most = f"at most {sides['step_um']:.3f} um"
    return f"  the two sides differ by {most} where they meet, at the {place}\n"


def _refit_text(summary: Json) -> str:
    refit = summary.get("refit")
    if refit is None:
        return ""
    recipe = refit["recipe"]
    lines = [
        f"  corner at {refit['joint_deg']:g} degrees, height {refit['height_mm']:g} mm: slope "
        f"jumps by {refit['corner_mm_per_rad']:.4f} mm/rad, eccentricity "
        f"{refit['eccentricity_mm']:.6f} mm",
        f"  the refit deviates from the drawing by at most {refit['deviation_um']:.2f} um "
        f"({refit['deviation_limit_um']:g} um allowed)",
        f"  {recipe['spline']} refit, {recipe['ends']} ends; effect of deleting s1 and s2 points, "
        "* marks this table:",
        "   s1 s2  acceleration mm/s2   at deg  jerk mm/s3   after corner  deviation um",
    ]
    chosen = recipe["s1"], recipe["s2"]
    lines += [_candidate_text(candidate, chosen) for candidate in refit["candidates"]]
    return "\n".join(lines) + "\n"


def _candidate_text(found: Json, chosen: tuple[int, int]) -> str:
    mark = "*" if (found["s1"], found["s2"]) == chosen else " "
    return (
        f"  {mark}{found['s1']:2d} {found['s2']:2d}  {found['acceleration_mm_s2']:18.1f}  "
        f"{found['peak_deg']:7.2f}  {found['jerk_mm_s3']:10.3e}  {found['tail_jerk_mm_s3']:13.3e}  "
        f"{found['deviation_um']:12.2f}"
    )
