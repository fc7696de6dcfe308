"""What is known about a table, as a few lines for people.

>>> from camtools.skirt.table.generate import generate
>>> from camtools.skirt.part.part_file import example_part
>>> from camtools.skirt.report.summary import make_summary
>>> emit_text(make_summary(generate(example_part()))).splitlines()[0]
'example: table of 3456 bytes'
"""

from __future__ import annotations

from camtools.base.text import Json
from camtools.cut.feasibility import tenth_below
from camtools.measured.correction_step import round_text
from camtools.part.smoothing import share_text
from camtools.skirt.geometry.profile import smoothing_texts
from camtools.skirt.tool.heel import Heel


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
        + tool_text(summary["tool"])
        + _segments_text(summary.get("segments", {}))
        + _smoothing_text(summary)
        + _profile_text(summary)
        + "".join(f"  {text} (overshoot_um)\n" for text in summary.get("overshoots", []))
        + _scan_text(summary)
        + _sides_text(summary)
        + _refit_text(summary)
        + _speed_text(summary)
        + (round_text(summary["correction"]) if "correction" in summary else "")
    )


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
    """Return the segments as lines for the terminal, nothing without any."""
    return "".join(
        f"  {name}: {'; '.join(_words(one) for one in segments)}\n"
        for name, segments in found.items()
    )


def tool_text(tool: Json) -> str:
    """Return the tool of a skirt's table and the clearance that its heel has left."""
    nose = f"nose radius {tool['nose_radius_mm']:g} mm" if tool["nose_radius_mm"] else "pointed"
    worn = f", worn by {tool['wear_um']:g} um" if tool["wear_um"] else ""
    heel = Heel(tool["needed_clearance_deg"], tool["heel_at_deg"], tool["heel_at_mm"])
    return f"  tool: {nose}{worn}, {clearance_text(tool['clearance_deg'], heel)}\n"


def _smoothing_text(summary: Json) -> str:
    """Return what smoothing did or would do, and what it takes of the tolerance."""
    process = summary["process"]
    # Of polygons, whose summary is this one, too, nothing is smoothed.
    allowed_um, taken_um = process.get("form_error_um", 0.0), process.get("smoothing_takes_um", 0.0)
    found, noise = summary.get("smoothing", {}), summary.get("noise", {})
    lines = smoothing_texts(found, noise, allowed_um)
    lines += [share_text(taken_um, allowed_um)] if taken_um else []
    return "".join(f"  {line}\n" for line in lines)


def _room_text(summary: Json) -> str:
    """Return where U swings, where the tool runs in and out, and the passes; nothing by default."""
    process, text = summary["process"], ""
    if process["u_zero"] == "mean":
        below = f"{process['u_zero_mm']:.6g} mm below the long axis"
        text += f"  U = 0 is the middle of its stroke, {below}\n"
    if process["run_in_mm"] or process["run_out_mm"]:
        text += f"  run-in {process['run_in_mm']:g} mm, run-out {process['run_out_mm']:g} mm\n"
    for number, one in enumerate(process.get("passes", []), start=1):
        text += (
            f"  pass {number} of {len(process['passes'])}: {one['spindle_rpm']:g} r/min, feed "
            f"{one['feed_mm']:.6g} mm, leaves {one['allowance_um']:g} um\n"
        )
    if process.get("feed_law") is not None:
        low, high = min(process["feed_law"]["feed_mm"]), max(process["feed_law"]["feed_mm"])
        text += f"  feed {low:g} .. {high:g} mm over the height, mean {process['feed_mm']:.6g} mm\n"
    return text


def _speed_text(summary: Json) -> str:
    """Return what the modulation of the spindle brings, nothing for uniform turning."""
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
    """Return what corners over the height cost, nothing for curves without."""
    text = ""
    for axis, curve in (("x", "profile"), ("u", "ovality")):
        error_nm = summary["error"][axis]["value_nm"]
        if error_nm > summary["tolerance_nm"]:
            steps = f"the {curve} has corners or steps of curvature"
            text += f"  {steps}; {axis} follows them within {error_nm:.3g} nm\n"
    return text


def _scan_text(summary: Json) -> str:
    """Return how far a measured part's table is from its points, nothing for other parts."""
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
    return text


def _covered_text(scan: Json) -> str:
    """Return what was measured, and what is bridged."""
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
    """Return by how much two sides differ where they meet, nothing for other parts."""
    if "sides" not in summary:
        return ""
    sides = summary["sides"]
    place = sides["meet"].replace("-", " ")
    most = f"at most {sides['step_um']:.3f} um"
    return f"  the two sides differ by {most} where they meet, at the {place}\n"


def _refit_text(summary: Json) -> str:
    """Return the corner's refit and all candidates, nothing for other sections."""
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
    lines += [_candidate_text(one, (one["s1"], one["s2"]) == chosen) for one in refit["candidates"]]
    return "\n".join(lines) + "\n"


def _candidate_text(one: Json, is_chosen: bool) -> str:
    mark = "*" if is_chosen else " "
    return (
        f"  {mark}{one['s1']:2d} {one['s2']:2d}  {one['acceleration_mm_s2']:18.1f}  "
        f"{one['peak_deg']:7.2f}  {one['jerk_mm_s3']:10.3e}  {one['tail_jerk_mm_s3']:13.3e}  "
        f"{one['deviation_um']:12.2f}"
    )
