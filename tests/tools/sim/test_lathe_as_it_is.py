"""Effects of a real lathe in whole cuts: what the gauge sees against what a formula says."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.tools.cases.camsim_cases import cut as camsim_cut

SWING_UM, OMEGA = 500.0, 2 * np.pi * 100.0  # 1 mm of tool motion twice per turn of 3000 r/min
Keys = dict[str, float | str]
BASE: dict[str, Keys] = {
    "spindle": {"limit_rpm": 3500, "ripple": 0},
    "encoder": {"counts_per_turn": 65536},
    "u": {"speed_mm_per_s": 800, "acceleration_mm_per_s2": 500000, "stroke_mm": 3},
    "controller": {"following_limit_nm": 300000, "learn_harmonics": 0, "engage_turns": 40},
}


def cut(oval30: Path, **sections: Keys) -> dict[str, Any]:
    """Return the summary of the first turns of a cut on the base machine with some keys."""
    lines = []
    for name in {**BASE, **sections}:
        keys = {**BASE.get(name, {}), **sections.get(name, {})}
        lines += [f"[{name.replace('_', '.')}]", *(f"{key} = {keys[key]}" for key in keys)]
    words = ("--tolerance-um", "999", "--turns-limit", "65")
    return camsim_cut(oval30, *words, machine="\n".join(lines)).summary


def form_um(summary: dict[str, Any]) -> float:
    """Return the largest form error."""
    return float(summary["form_error_um"]["max"])


def test_belief_sets_the_parameters_and_truth_the_motion(oval30: Path) -> None:
    """The error is that of feed-forward by the wrong inverse: 500 um times |1 - G / G^|."""
    believed: Keys = {"bandwidth_hz": 270, "damping": 0.77, "delay_us": 67.5}
    summary = cut(oval30, believed_u=believed)
    w = 2 * np.pi * 270.0
    parameters = summary["parameters"]
    assert parameters["k1_ns"] == pytest.approx(2 * 0.77 / w * 1e9, abs=1)
    assert parameters["k2_us2"] == pytest.approx(1e12 / w**2, abs=1)
    assert parameters["lead_ns"] == 92500
    s, truth = 1j * OMEGA, 2 * np.pi * 300.0
    made = 1 + 2 * 0.77 * s / w + s**2 / w**2
    needed = 1 + 2 * 0.7 * s / truth + s**2 / truth**2
    wanted_um = SWING_UM * abs(1 - made / needed * np.exp(-s * 7.5e-6))
    assert form_um(summary) == pytest.approx(wanted_um, rel=0.03)


W = 2 * np.pi * 300.0
CHIP: Keys = {"kc_n_per_mm2": 700, "radial_share": 0.3}
# The mean force of 12.6 N on 1.5 kg moves a loop of 300 Hz by 2.4 um, the swing of it more.
PUSHED_UM = (12.6 / W**2 + 10.5 / abs(W**2 - OMEGA**2 + 1.4j * W * OMEGA)) / 1.5 * 1e6
# The tip moves by r^2 / (1 - r^2) of the swing besides, which the scale does not see.
SWUNG_UM = SWING_UM / ((1500 / 100) ** 2 - 1)
EFFECTS: dict[str, tuple[dict[str, Keys], float, float]] = {
    "what the other tests see comes from the effects": ({}, 0.05, 0.05),
    "both run-outs add up": ({"spindle": {"runout_um": 3, "runout_2_um": 2}}, 5, 0.1),
    "a mode beyond the scale": (
        {"u": {"mode_hz": 1500, "mode_damping": 0.01}},
        SWUNG_UM,
        0.05 * SWUNG_UM,
    ),
    # 1.1 mm deep, 0.1 mm per turn: 23.1 N bend it; U is held.
    "the chip bends the tool": (
        {"u": {"mass_kg": 1000}, "cut": CHIP | {"tool_stiffness_n_per_um": 20}},
        1.155,
        0.1,
    ),
    "the chip pushes U": ({"cut": CHIP}, PUSHED_UM, 0.05 * PUSHED_UM),
}


@pytest.mark.parametrize(("sections", "wanted_um", "within_um"), EFFECTS.values(), ids=EFFECTS)
def test_effect_is_gauged(
    oval30: Path, sections: dict[str, Keys], wanted_um: float, within_um: float
) -> None:
    """The largest form error is that of a formula; the scale sees only what the chip does."""
    summary = cut(oval30, **sections)
    assert form_um(summary) == pytest.approx(wanted_um, abs=within_um)
    if "cut" not in sections:
        assert summary["following_error_um"]["max"] < 0.1


def test_mode_on_the_scale_is_measured(oval30: Path) -> None:
    """Then the controller knows of it."""
    summary = cut(oval30, u={"mode_hz": 1500, "mode_damping": 0.01, "mode_on_scale": 1})
    assert summary["following_error_um"]["max"] == pytest.approx(form_um(summary), rel=0.05)


def test_latency_of_the_scale_is_seen_and_its_parameter_takes_it_away(oval30: Path) -> None:
    """10 us at 314 mm/s are 3.1 um of following error, none of form."""
    blind: Keys = {"scale_latency_us": 10}
    told = cut(oval30, u=blind)
    assert told["parameters"]["u_scale_latency_ns"] == 10000
    assert form_um(told) < 0.1
    assert told["following_error_um"]["max"] < 0.1
    untold = cut(oval30, u=blind, believed_u={"scale_latency_us": 0})
    assert form_um(untold) < 0.1
    assert untold["following_error_um"]["max"] == pytest.approx(3.14, rel=0.05)


def test_force_drive_is_worth_what_the_controller_is_told(oval30: Path) -> None:
    """The force of the right mass leaves a thousandth; that of a wrong one far more."""
    force: Keys = {"kind": '"force"', "force_limit_n": 1000}
    assert form_um(cut(oval30, u=force)) < 0.001 * SWING_UM
    assert form_um(cut(oval30, u=force, believed_u={"mass_kg": 1.8})) > 0.005 * SWING_UM
