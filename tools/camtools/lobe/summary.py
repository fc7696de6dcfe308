"""What is known about the table and the cut of a camshaft, for programs and for people.

>>> from camtools.lobe.generate import generate_lobes
>>> from camtools.lobe.motion import example_lobe
>>> emit_lobe_text(make_lobe_summary(generate_lobes(example_lobe()))).splitlines()[0]
'example: table of 55648 bytes, for turning'
"""

from dataclasses import dataclass

from camtools.base.quantities import NM_PER_MM, Floats, length_text
from camtools.base.text import Json
from camtools.cut.feasibility import feasibility_of, tenth_below
from camtools.lobe.generate import GeneratedLobes
from camtools.lobe.lift import Disc, LiftLaw, Listed, Poly345, Risen, curve_of
from camtools.lobe.motion import (
    ShaftLobe,
    extent_of,
    extent_texts,
    smoothing_of,
    smoothing_takes_um,
    smoothing_texts,
)
from camtools.lobe.plunge import left_by_wear_um
from camtools.part.smoothing import share_text
from camtools.report.learning_text import learned
from camtools.report.text import (
    COMPUTING_TIME,
    FOLLOWING_ERROR,
    MACHINE_TIME,
    ReportRow,
    form_text,
    quantity,
    table_quantity,
    turns_text,
)
from camtools.sim.results import Cut
from camtools.table.summary import about_image, describe_channel

_NAMES = {1: "u", 2: "x", 3: "speed", 4: "swing", 5: "contact", 7: "way"}


def _lobe(lobe: ShaftLobe) -> Json:
    shape = lobe.shape
    is_hollow = shape.hollow_radius_mm < float("inf")
    return {
        "z_mm": list(lobe.z_mm),
        "least_radius_mm": shape.least_radius_mm,
        "hollow_radius_mm": shape.hollow_radius_mm if is_hollow else None,
        "largest_pressure_angle_deg": shape.largest_swing_deg,
        **extent_of(lobe.law),
        **smoothing_of(lobe.law),
    }


def make_lobe_summary(made: GeneratedLobes) -> Json:
    """Return everything that is known about the table of a camshaft; no dates, no paths."""
    table, process = made.table, made.part.process
    return about_image(table, made.tolerance_nm) | {
        "part": {"name": table.part_name, "kind": "cam", "source": made.part.part.source},
        "process": {
            "operation": process.operation,
            "speed": process.speed,
            "spindle_rpm": float(process.spindle_rpm),
            "mean_spindle_rpm": made.mean_rpm,
            "feed_mm": table.feed_nm / NM_PER_MM,
            "depth_mm": table.depth_nm / NM_PER_MM,
            "direction": process.direction,
            "form_error_um": process.form_error_um,
            "smoothing_takes_um": smoothing_takes_um(made.laws),
        },
        **_tool(made),
        **_plunge(made),
        "channels": {_NAMES[channel.kind]: describe_channel(channel) for channel in table.channels},
        "error": {
            "u_nm": made.lift.error,
            "angle_deg": made.angle.error,
            "speed_ratio": made.speed.error if made.speed else 0.0,
        },
        "feasibility": feasibility_of(
            made.peaks, made.part.machine.limits, made.mean_rpm, made.highest_speed
        ),
        "lobes": [_lobe(lobe) for lobe in made.lobes],
        "design": design_of_lobes(made),
    }


def _tool(result: GeneratedLobes) -> Json:
    heel = result.heel
    if heel is None:
        return {}
    found = {"needed_clearance_deg": heel.needed_deg, "lobe": heel.lobe, "at_deg": heel.angle_deg}
    return {"tool": result.part.tool.model_dump() | found}


def _plunge(result: GeneratedLobes) -> Json:
    plan, process = result.plunge, result.part.process
    if plan is None:
        return {}
    turns = plan.turns(len(result.lobes))
    found = {
        "infeed_um": process.infeed_um,
        "stock_um": process.stock_um,
        "wheel_width_mm": result.part.cam.wheel_width_mm,
        "wheel_wear_um_per_lobe": process.wheel_wear_um_per_lobe,
        "left_by_wear_um": left_by_wear_um(result.part, result.lobes),
        "infeed_turns": plan.infeed_turns,
        "spark_out_turns": plan.spark_turns,
        "clearing_turns": plan.off_turns,
        "move_turns": plan.move_turns,
        "turns_per_lobe": plan.stay_turns,
        "turns": turns,
        "grinding_s": turns * 60 / result.mean_rpm,
    }
    return {"plunge": found}


def _law(law: LiftLaw) -> Json:
    """Return a law of lift as numbers; a list as the pieces of its spline."""
    if isinstance(law, Poly345):
        return {"law": "poly345", "lift_mm": law.lift_mm, "half_angle_rad": law.half_angle_rad}
    if isinstance(law, Risen):
        angles = ("lift_mm", "rise_rad", "dwell_rad", "fall_rad")
        soft = {
            f"{name}_deflection": flank.deflection
            for name, flank in (("rise", law.rise), ("fall", law.fall))
            if flank.name == "polydyne"
        }
        numbers = {name: getattr(law, name) for name in angles}
        return {"law": "flanks", "shape": law.rise.name} | numbers | soft
    if isinstance(law, Disc):
        return {"law": "disc", "reach_mm": law.reach_mm, "offset_mm": law.offset_mm}
    assert isinstance(law, Listed)
    curve = curve_of(law)
    return {
        "law": "pieces",
        "breaks_rad": curve.x.tolist(),
        "coefficients": curve.c.T.ravel().tolist(),
    }


def design_of_lobes(result: GeneratedLobes) -> Json:
    """Return the shape for programs that measure: laws in radians and millimetres, no table.

    Pieces of a list are quintics, highest power first, of the angle above each break.
    """
    process, cam = result.part.process, result.part.cam
    return {
        "shape": "cam",
        "follower": cam.follower,
        "operation": "turning" if process.operation == "turning" else "grinding",
        **({"path": "plunge"} if process.is_plunge else {}),
        "speed": process.speed,
        "base_mm": float(cam.base_radius_mm),
        "roller_mm": float(cam.roller_radius_mm),
        "follower_mm": float(result.part.follower_radius_mm),
        "base_speed": float(process.spindle_rpm) / result.mean_rpm,
        "lobes": [
            {"z_mm": list(lobe.z_mm), "phase_rad": lobe.phase_rad} | _law(lobe.law)
            for lobe in result.lobes
        ],
    }


def emit_lobe_text(summary: Json) -> str:
    """Return a summary as a few lines for people."""
    process, feasible, error = summary["process"], summary["feasibility"], summary["error"]
    needed = feasible["needed"]
    lines = [
        f"{summary['part']['name']}: table of {summary['table_bytes']} bytes, for "
        f"{process['operation']}",
        f"  error u {error['u_nm']:.3f} nm (tolerance {summary['tolerance_nm']:g} nm), angle of "
        f"the contact {error['angle_deg']:.1e} degrees, speed ratio {error['speed_ratio']:.1e}",
        f"  U: stroke {needed['u_stroke_mm']:.4f} mm, {needed['u_speed_mm_s']:.3f} mm/s, "
        f"{needed['u_acceleration_mm_s2']:.1f} mm/s2",
    ]
    if needed["swing_deg"] > 0:
        lines.append(
            f"  swing {needed['swing_deg']:.4f} degrees, {needed['swing_speed_deg_s']:.2f} "
            f"degrees/s, {needed['swing_acceleration_deg_s2']:.0f} degrees/s2"
        )
    lines.append(
        f"  spindle {process['spindle_rpm']:g} r/min, mean {process['mean_spindle_rpm']:.4f}, "
        f"peak {needed['spindle_rpm']:.3f}, {needed['spindle_acceleration_rad_s2']:.2f} rad/s2"
    )
    if "tool" in summary:
        tool = summary["tool"]
        lines.append(
            f"  tool: clearance angle {tool['clearance_deg']:g} degrees over {tool['heel_mm']:g} "
            f"mm, required {tool['needed_clearance_deg']:.2f}"
        )
    if "plunge" in summary:
        lines += _plunge_lines(summary["plunge"])
    allowed_um, taken_um = process["form_error_um"], process["smoothing_takes_um"]
    for i, lobe in enumerate(summary["lobes"]):
        texts = [*extent_texts(lobe), *smoothing_texts(lobe, allowed_um)]
        lines += [_lobe_text(i, lobe), *(f"    {text}" for text in texts)]
    lines += [f"  {share_text(taken_um, allowed_um)}"] if taken_um else []
    lines.append(
        f"  highest speed {tenth_below(feasible['highest_spindle_rpm'])} r/min, "
        f"limited by {feasible['decided_by']}"
    )
    return "\n".join(lines) + "\n"


def _plunge_lines(found: Json) -> list[str]:
    return [
        f"  plunge: {found['infeed_um']:g} um per turn over {found['infeed_turns']} turns and one "
        f"at reduced infeed, spark-out {found['spark_out_turns']} turns; {found['turns_per_lobe']} "
        f"turns per lobe, {found['move_turns']} turns to move Z to the next",
        f"  the shaft takes {found['turns']} turns, {found['grinding_s']:.1f} s; wheel "
        f"{found['wheel_width_mm']:g} mm wide, wear {found['wheel_wear_um_per_lobe']:g} um per "
        f"lobe leaves up to {found['left_by_wear_um']:.2g} um",
    ]


def _lobe_text(i: int, lobe: Json) -> str:
    hollow = lobe["hollow_radius_mm"]
    flank = "convex" if hollow is None else f"hollow flank of radius {hollow:.2f} mm"
    return (
        f"  lobe {i}, {lobe['z_mm'][0]:g} .. {lobe['z_mm'][1]:g} mm: pressure angle up to "
        f"{lobe['largest_pressure_angle_deg']:.3f} degrees, sharpest radius "
        f"{lobe['least_radius_mm']:.3f} mm, {flank}"
    )


@dataclass(frozen=True, eq=False)
class LobeOutcome(Cut[GeneratedLobes]):
    """All that is known about the cut of lobes."""

    swing_deg: Floats | None = None  # true swing in every tick of the trace; None for a wheel

    @property
    def is_turned(self) -> bool:
        """Return whether a swung tool turned it; a wheel ground it otherwise."""
        return self.generated.part.process.operation == "turning"


def _lobe_rows(outcome: LobeOutcome) -> list[ReportRow]:
    found = outcome.summary["cam"]
    if len(found["lobes"]) < 2:
        return []
    rows = []
    for i, lobe in enumerate(found["lobes"]):
        text = "not cut"
        if "max_um" in lobe:
            text = f"max {length_text(lobe['max_um'])}, rms {length_text(lobe['rms_um'])}"
        place = f"{lobe['z_first_mm']:g} .. {lobe['z_last_mm']:g} mm"
        rows.append(ReportRow(f"lobe {i}", f"{place}: {text}"))
    return rows


def _speed_rows(outcome: LobeOutcome) -> list[ReportRow]:
    found = outcome.summary["cam"]
    if "surface_speed_mm_s" not in found:
        return []
    speed = found["surface_speed_mm_s"]
    share = [100 * (speed[key] / speed["base_circle"] - 1) for key in ("min", "mean", "max")]
    text = (
        f"{speed['min']:.1f} .. {speed['max']:.1f} mm/s along the profile, base circle "
        f"{speed['base_circle']:.1f} mm/s: {share[0]:+.1f} % .. {share[2]:+.1f} %, mean "
        f"{share[1]:+.1f} %"
    )
    plan = f"within {speed['off_plan_percent']:.2f} % everywhere"
    return [ReportRow("surface speed", text), ReportRow("deviation from the table", plan)]


def _rake_rows(outcome: LobeOutcome) -> list[ReportRow]:
    found = outcome.summary["cam"]
    if "rake_deg" not in found:
        return []
    rake = found["rake_deg"]
    largest = max(abs(rake["min"]), abs(rake["max"]))
    bare = f"{rake['without_swing_min']:.2f} .. {rake['without_swing_max']:.2f}°"
    within = f"{largest:.1g}" if largest < 1 else f"{largest:.2f}"
    return [ReportRow("effective rake", f"constant within {within}°; without the swing {bare}")]


def _plunge_rows(outcome: LobeOutcome) -> list[ReportRow]:
    made = outcome.generated
    plan, process = made.plunge, made.part.process
    if plan is None:
        return []
    text = (
        f"{process.infeed_um:g} um per turn until {process.stock_um:g} um are removed, spark-out "
        f"{plan.spark_turns} turns, {plan.stay_turns} turns per lobe, {plan.move_turns} to the next"
    )
    wear = f"{process.wheel_wear_um_per_lobe:g} um per lobe, compensated by X"
    left = length_text(left_by_wear_um(made.part, made.lobes))
    return [
        ReportRow("plunge", text),
        ReportRow("wear of the wheel", f"{wear}; error up to {left}"),
    ]


def _list_rows(outcome: LobeOutcome) -> list[ReportRow]:
    made = outcome.generated
    allowed_um = made.part.process.form_error_um
    return [
        ReportRow(f"lift of lobe {i}", text)
        for i, law in enumerate(made.laws)
        for text in smoothing_texts(smoothing_of(law), allowed_um)
    ]


def _what_was_cut(outcome: LobeOutcome) -> str:
    found = outcome.summary["cam"]
    how = (
        f"turned, tip of radius {found['tip_mm']:g} mm"
        if outcome.is_turned
        else f"ground, wheel of radius {found['wheel_mm']:g} mm"
    )
    return f"cam {how}, {turns_text(outcome)}"


ROWS = (
    quantity("cut", _what_was_cut),
    _list_rows,
    _plunge_rows,
    quantity(
        "form error",
        lambda cut: form_text(cut.summary["form_error_um"], smoothing_takes_um(cut.generated.laws)),
    ),
    _lobe_rows,
    _speed_rows,
    _rake_rows,
    FOLLOWING_ERROR,
    learned,
    table_quantity(lambda cut: cut.generated.lift.error),
    MACHINE_TIME,
    COMPUTING_TIME,
)
