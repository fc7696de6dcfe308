"""What the cut of a camshaft came to, in words and numbers.

>>> _degrees(0.00012)
'0.0001°'
"""

from __future__ import annotations

from dataclasses import dataclass

from camtools.base.json_text import Json
from camtools.base.quantities import Floats, length_text
from camtools.lobe.generate import GeneratedLobes
from camtools.lobe.list_report import smoothing_of, smoothing_takes_um, smoothing_texts
from camtools.lobe.plunge import left_by_wear_um
from camtools.report.learning_text import learning_rows
from camtools.report.text import ReportRow, error_pair, form_text
from camtools.sim.results import Cut


@dataclass(frozen=True, eq=False)
class LobeOutcome(Cut[GeneratedLobes]):
    """All that is known about the cut of lobes.

    Attributes
    ----------
    swing_deg : ndarray or None
        True swing of the tool in every tick of the trace; None for a wheel.
    """

    swing_deg: Floats | None = None

    @property
    def is_turned(self) -> bool:
        """Return whether a swung tool turned it; a wheel ground it otherwise."""
        return self.generated.part.process.operation == "turning"


def _degrees(value: float) -> str:
    return f"{value:.1g}°" if abs(value) < 1 else f"{value:.2f}°"


def _lobe_rows(found: Json) -> list[ReportRow]:
    """Return the error of each lobe, where there are several."""
    if len(found["lobes"]) < 2:
        return []
    return [
        ReportRow(
            f"lobe {i}",
            f"{lobe['z_first_mm']:g} .. {lobe['z_last_mm']:g} mm: "
            + ("not cut" if "max_um" not in lobe else f"max {length_text(lobe['max_um'])}, ")
            + ("" if "max_um" not in lobe else f"rms {length_text(lobe['rms_um'])}"),
        )
        for i, lobe in enumerate(found["lobes"])
    ]


def _speed_rows(found: Json) -> list[ReportRow]:
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


def _rake_rows(found: Json) -> list[ReportRow]:
    if "rake_deg" not in found:
        return []
    rake = found["rake_deg"]
    largest = max(abs(rake["min"]), abs(rake["max"]))
    bare = f"{rake['without_swing_min']:.2f} .. {rake['without_swing_max']:.2f}°"
    return [
        ReportRow(
            "effective rake", f"constant within {_degrees(largest)}; without the swing {bare}"
        )
    ]


def _plunge_rows(outcome: LobeOutcome) -> list[ReportRow]:
    """Return the turns of a plunge cut."""
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


def _list_rows(made: GeneratedLobes) -> list[ReportRow]:
    """Return what smoothing did to lists, or would do."""
    allowed_um = made.part.process.form_error_um
    return [
        ReportRow(f"lift of lobe {i}", text)
        for i, law in enumerate(made.laws)
        for text in smoothing_texts(smoothing_of(law), allowed_um)
    ]


def lobe_rows(outcome: LobeOutcome) -> list[ReportRow]:
    """Return the summary of a camshaft, machine limits apart."""
    summary, made, found = outcome.summary, outcome.generated, outcome.summary["cam"]
    cut = summary["cut"]
    how = (
        f"tip of radius {found['tip_mm']:g} mm"
        if outcome.is_turned
        else f"wheel of radius {found['wheel_mm']:g} mm"
    )
    mean = "mean " if outcome.is_modulated else ""
    what = (
        f"cam {'turned' if outcome.is_turned else 'ground'}, {how}, at {mean}"
        f"{cut['spindle_rpm']:g} r/min, feed {cut['feed_mm']:g} mm, "
        f"{cut['turns']:.0f} of {cut['planned_turns']:.0f} turns"
    )
    return [
        ReportRow("cut", what),
        *_list_rows(made),
        *_plunge_rows(outcome),
        ReportRow("form error", form_text(summary["form_error_um"], smoothing_takes_um(made.laws))),
        *_lobe_rows(found),
        *_speed_rows(found),
        *_rake_rows(found),
        ReportRow("following error of U", error_pair(summary["following_error_um"])),
        *learning_rows(summary),
        ReportRow("table", f"{summary['table_bytes']} bytes, accurate to {made.lift.error:.2g} nm"),
        ReportRow("machine time", f"{summary['machine_time_s']:.1f} s"),
        ReportRow("computing time", f"{summary['wall_time_s']:.2f} s for the cut with its trace"),
    ]
