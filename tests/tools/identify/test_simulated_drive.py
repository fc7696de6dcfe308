# SPDX-License-Identifier: Apache-2.0
"""U of the simulator, with the constants of its machine file."""

from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.identify.excitation_plan import Wishes, plan
from camtools.identify.excited import excited
from camtools.identify.fit import K1, K2, LEAD
from camtools.identify.identified import Identified, Limits, identify
from camtools.identify.simulated_drive import CutShortError, SimulatedU
from camtools.skirt.table.generate import GeneratedSkirt
from camtools.table.image import pack

MACHINE = """\
[machine]
tick_hz = {tick_hz}
[u]
bandwidth_hz = {hz}
damping = {damping}
delay_us = {delay_us}
friction_m_per_s2 = {friction}
quantum_nm = {quantum_nm}
{more}
[believed.u]
bandwidth_hz = 270
damping = 0.8
delay_us = 60
"""
DRIVE: dict[str, float | str] = {
    "tick_hz": 20_000,
    "hz": 300.0,
    "damping": 0.7,
    "delay_us": 75.0,
    "friction": 5,
    "quantum_nm": 10,
    "more": "",
}


def simulated(folder: Path, generated: GeneratedSkirt, text: str) -> SimulatedU:
    """Return U of a machine."""
    return SimulatedU(folder, text.encode(), "m.toml", pack(generated.table))


def found_on(u: SimulatedU) -> Identified:
    """Excite and identify."""
    believed = u.believed()
    return identify(excited(u, plan(believed, Wishes()), believed))


@pytest.mark.parametrize(
    "other",
    [
        {},
        {"friction": 20},
        {"friction": 20, "quantum_nm": 1000},
        {"hz": 220.0, "damping": 0.55, "delay_us": 130.0, "friction": 10, "quantum_nm": 100},
        {"hz": 600.0, "damping": 0.8, "delay_us": 40.0, "friction": 2, "tick_hz": 40_000},
        {"more": "scale_latency_us = 6\nscale_error_nm = 20\nscale_period_um = 4"},
    ],
)
def test_constants_are_found(
    tmp_path: Path, generated: GeneratedSkirt, other: dict[str, float | str]
) -> None:
    """1 % of k1 and k2, 2 us of lead; the lead holds the latency of the scale."""
    drive: dict[str, float | str] = DRIVE | other
    text = MACHINE.format(**drive)
    found = found_on(simulated(tmp_path, generated, text))
    w, damping = 2 * np.pi * float(drive["hz"]), float(drive["damping"])
    latency_us = 6.0 if drive["more"] else 0.0
    lead_us = float(drive["delay_us"]) + 0.5e6 / float(drive["tick_hz"]) + latency_us
    plain = found.plain
    assert plain.k1_s == pytest.approx(2 * damping / w, rel=0.01)
    assert plain.k2_s2 == pytest.approx(1 / w**2, rel=0.01)
    assert plain.lead_s * 1e6 == pytest.approx(lead_us, abs=2.0)
    if drive["quantum_nm"] == 10:
        assert plain.k1_s == pytest.approx(2 * damping / w, rel=1e-3)
        assert plain.k2_s2 == pytest.approx(1 / w**2, rel=1e-3)
    assert plain.friction_m_s2 == pytest.approx(float(drive["friction"]), rel=0.05, abs=0.2)
    assert found.problems(Limits()) == []


def test_mode_is_reported(tmp_path: Path, generated: GeneratedSkirt) -> None:
    """A mode that the scale sees: its frequency, and the true bias of the fit."""
    more = "mode_hz = 800\nmode_damping = 0.03\nmode_share = 0.1\nmode_on_scale = 1"
    found = found_on(simulated(tmp_path, generated, MACHINE.format(**(DRIVE | {"more": more}))))
    w = 2 * np.pi * 300
    assert found.has_mode
    assert found.with_mode is not None
    assert found.with_mode.mode.hz == pytest.approx(800, rel=0.02)
    assert found.bias[K1] == pytest.approx(found.plain.k1_s / (1.4 / w) - 1, abs=3e-3)
    assert found.bias[K2] == pytest.approx(found.plain.k2_s2 * w**2 - 1, abs=6e-3)
    assert found.bias[LEAD] == pytest.approx(found.plain.lead_s - 100e-6, abs=4e-6)
    assert found.problems(Limits()) == []


def test_believed_is_what_the_controller_has(tmp_path: Path, generated: GeneratedSkirt) -> None:
    """Not what is true."""
    believed = simulated(tmp_path, generated, MACHINE.format(**DRIVE)).believed()
    w = 2 * np.pi * 270
    assert believed.k1_ns == pytest.approx(1.6 / w * 1e9, abs=1)
    assert believed.k2_us2 == pytest.approx(1e12 / w**2, abs=1)
    assert believed.lead_ns == 85_000
    assert believed.tick_hz == 20_000


def test_bad_machine_is_named(tmp_path: Path, generated: GeneratedSkirt) -> None:
    """By the name that the user gave it."""
    with pytest.raises(CamtoolsError) as error:
        simulated(tmp_path, generated, "[u]\nbandwidth_hz = 0\n").believed()
    assert error.value.lines[0].startswith("m.toml: ")
    assert len(error.value.lines) == 1


def test_excitation_that_ends_early_gives_no_record(
    tmp_path: Path, generated: GeneratedSkirt
) -> None:
    """The emergency stop is pressed meanwhile."""
    text = MACHINE.format(**DRIVE).encode()
    u = SimulatedU(tmp_path, text, "m.toml", pack(generated.table), ["--inject=estop@t0.5"])
    believed = u.believed()
    with pytest.raises(CutShortError, match="cut short"):
        excited(u, plan(believed, Wishes()), believed)
