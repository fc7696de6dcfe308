"""The reach of a U that takes forces: the firmware's loop as tools/tune designs it, in whole cuts.

The limits are those of the plant: a step F of the force moves it by about F / (m w^2) at the
crossover w, whatever controls it. They were found by an independent simulation of the loop.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from camtools.tune.parameters import Drive, parameters_of
from tests.tools.cases.camsim_cases import cut, refusal
from tests.tools.cases.drive_plant import designed

MASS_KG = 1.5
LONG = ("--tolerance-um", "99", "--turns-limit", "150")
MACHINE = """\
[machine]
name = "force"
[spindle]
ripple = 0
[encoder]
counts_per_turn = 1000000
[u]
kind = "force"
delay_us = {delay_us}
quantum_nm = {scale_nm}
mass_kg = 1.5
friction_m_per_s2 = 3.333
amplifier_hz = {amplifier_hz}
stroke_mm = 3
mode_hz = 1200
mode_share = {share}
mode_on_scale = 1
[believed.u]
mass_kg = {believed_kg}
[controller]
"""


@cache
def loop_of(amplifier_hz: float, delay_us: float, share: float) -> str:
    """Return the lines of a proposed loop."""
    drive = Drive(
        mass_kg=MASS_KG, amplifier_hz=amplifier_hz, delay_us=delay_us, tick_hz=20000.0,
        mode_hz=1200.0, mode_share=share,
    )  # fmt: skip
    values = parameters_of(designed(drive.plant), drive)
    loop = [
        name for name in values if any(k in name for k in ("cross", "lead", "pole", "int", "notch"))
    ]
    return "".join(f"{name} = {values[name]}\n" for name in loop)


def machine(
    amplifier_hz: float, delay_us: float, share: float, scale_nm: float = 10.0,
    believed_kg: float = MASS_KG,
) -> str:  # fmt: skip
    """Return a machine with the loop for it."""
    text = MACHINE.format(
        delay_us=delay_us, scale_nm=scale_nm, amplifier_hz=amplifier_hz, share=share,
        believed_kg=believed_kg,
    )  # fmt: skip
    return text + loop_of(amplifier_hz, delay_us, share)


@pytest.mark.long
@pytest.mark.parametrize(("scale_nm", "most_um"), [(10, 0.05), (100, 0.15), (1000, 1.0)])
def test_wrong_mass_after_a_rehearsal(oval30: Path, scale_nm: float, most_um: float) -> None:
    """1 mm at 3000 r/min, mass believed 20 % wrong."""
    for believed_kg in (1.2, 1.8):
        lathe = machine(1500, 25, -0.2, scale_nm, believed_kg)
        found = cut(oval30, "--rpm", 3000, *LONG, machine=lathe)
        assert np.abs(found.surface["error_nm"]).max() / 1e3 <= most_um


@pytest.mark.long
def test_slow_loop_learns_only_below_half_its_crossover(oval30: Path) -> None:
    """A mode on the scale leaves 66 Hz; learned at 3000 r/min the part had 98 um."""
    lathe = (
        '[u]\nkind = "force"\nstroke_mm = 3\nmass_kg = 0.21\nmode_hz = 2207\nmode_on_scale = 1\n'
    )
    for rpm, reason, most_um in ((3000, "slow_loop", 1.0), (600, "all", 0.5)):
        found = cut(oval30, "--rpm", rpm, *LONG, machine=lathe).summary
        assert found["learning"]["reason"] == reason
        assert found["form_error_um"]["max"] <= most_um


def test_continuous_force_below_the_rms_of_a_cut_is_refused(oval30: Path) -> None:
    """1 mm at 100 Hz takes 0.5 mm (2 pi 100 Hz)^2 of 1.5 kg, and 5 N of friction."""
    lathe, words = machine(1500, 25, -0.2), ("--rpm", 3000, *LONG, "--turns-limit", 3, "--set")
    rms_n = np.hypot(MASS_KG * 0.5e-3 * (200 * np.pi) ** 2 / np.sqrt(2), 5.0)
    cut(oval30, *words, f"servo_continuous_mn={1002 * rms_n:.0f}", machine=lathe)
    line = refusal(oval30, *words, f"servo_continuous_mn={998 * rms_n:.0f}", machine=lathe)
    needed = float(line.split("needs ")[1].split(" N rms")[0])
    assert needed == pytest.approx(rms_n, rel=1e-3)
    assert "give at most --rpm 29" in line
