"""What the cut of a camshaft came to, in words and numbers.

>>> _degrees(0.00012)
'0.0001°'
"""

from __future__ import annotations

from dataclasses import dataclass

from camtools.base.quantities import Floats, length_text
from camtools.lobe.generate import GeneratedLobes
from camtools.lobe.list_report import smoothing_of, smoothing_takes_um, smoothing_texts
from camtools.lobe.plunge import left_by_wear_um
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


def _lobe_rows(outcome: LobeOutcome) -> list[ReportRow]:
    """Return the error of each lobe, where there are several."""
    found = outcome.summary["cam"]
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


def _list_rows(outcome: LobeOutcome) -> list[ReportRow]:
    """Return what smoothing did to lists, or would do."""
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
