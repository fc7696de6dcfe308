# SPDX-License-Identifier: Apache-2.0
"""A pulse of force moves U as Newton's law says, and what the machine cannot do is refused."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.tools.cases.camsim_cases import camsim, only_error

MACHINES = Path(__file__).parent / "cases" / "machines"
TICK_HZ, PULSE_MS, FORCE_N, MASS_KG = 20_000, 8, 10.0, 1.5
WEAK = ("--set", "servo_integral_mHz=1000", "--set", "servo_crossover_hz=1")


def lathe(folder: Path, friction_m_per_s2: float) -> Path:
    """Write the force machine with another friction."""
    text = (MACHINES / "force.toml").read_text("utf-8")
    old = "friction_m_per_s2 = 3\n"
    assert old in text
    path = folder / "force.toml"
    path.write_text(text.replace(old, f"friction_m_per_s2 = {friction_m_per_s2}\n"), "utf-8")
    return path


def pulse_mn(force_mn: int) -> list[int]:
    """Return +, -, -, + of 8 ms each, between 1 ms without force."""
    part, rest = [force_mn] * (PULSE_MS * TICK_HZ // 1000), [0] * (TICK_HZ // 1000)
    back = [-force_mn] * len(part)
    return [*rest, *part, *back, *back, *part, *rest]


def excite(table: Path, folder: Path, samples: list[int], *words: str | Path) -> list[str | Path]:
    """Write the wave; return the command that plays it once."""
    wave = folder / "wave.csv"
    wave.write_text("force_mn\n" + "".join(f"{one}\n" for one in samples), "utf-8")
    return [
        "identify", table, "--wave", wave, "--record", folder / "record.csv", "--periods", "1",
        "--fade-ticks", "16", "--signals", "u_set_q6,u_actual_nm,u_force_q6", *words,
    ]  # fmt: skip


def peak_um(friction_m_per_s2: float) -> float:
    """Return how far U gets until it stands: F t^2 / m without friction."""
    t_s, push = PULSE_MS * 1e-3, FORCE_N / MASS_KG
    faster, slower = push - friction_m_per_s2, push + friction_m_per_s2
    return 0.5e6 * faster * t_s**2 * (1 + faster / slower)


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("friction_m_per_s2", "accuracy"), [(0, 0.005), (3, 0.02)])
def test_pulse_moves_u_by_its_force_alone(
    table_of: Callable[[str], Path], tmp_path: Path,
    sense: int, friction_m_per_s2: float, accuracy: float,
) -> None:  # fmt: skip
    """With a loop of 1 Hz; the set-point rests, and the state is ready again without a fault."""
    samples = pulse_mn(round(sense * FORCE_N * 1000))
    machine = lathe(tmp_path, friction_m_per_s2)
    done = camsim(*excite(table_of("perkins240"), tmp_path, samples, "--machine", machine, *WEAK))
    assert done.returncode == 0, done.stderr
    rows = np.genfromtxt(tmp_path / "record.csv", delimiter=",", names=True)[-len(samples) :]
    assert not rows["u_set_q6"].any()
    u_um = sense * (rows["u_actual_nm"] - rows["u_actual_nm"][0]) * 1e-3
    assert u_um.max() == pytest.approx(peak_um(friction_m_per_s2), rel=accuracy)
    if friction_m_per_s2 == 0:
        assert u_um.max() == pytest.approx(FORCE_N * 0.008**2 / MASS_KG * 1e6, rel=accuracy)
        assert abs(u_um[-1]) < 0.02 * u_um.max()  # back at its start
    force_n = rows["u_force_q6"] / 64e3
    assert force_n[1:] == pytest.approx(np.array(samples[:-1]) * 1e-3, abs=0.1)


@pytest.mark.parametrize(
    ("samples", "words", "why"),
    [
        ([0] * 20 + [600_001] * 20, ("--machine", "force"), "servo_force_limit_mn is 600000"),
        ([0] * 40, (), "U takes positions"),
        ([0] * 10, ("--machine", "force"), "--wave: refused"),
    ],
)
def test_what_u_cannot_do_is_refused(
    table_of: Callable[[str], Path], tmp_path: Path,
    samples: list[int], words: tuple[str, ...], why: str,
) -> None:  # fmt: skip
    """One line, and no record."""
    named = [MACHINES / "force.toml" if word == "force" else word for word in words]
    done = camsim(*excite(table_of("perkins240"), tmp_path, samples, *named))
    assert why in only_error(done)
    assert not (tmp_path / "record.csv").exists()


def test_pulse_beyond_the_travel_ends_in_a_fault(
    table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """120 N would take U 5 mm out of a stroke of 2 mm."""
    words = ("--machine", lathe(tmp_path, 0), *WEAK)
    done = camsim(*excite(table_of("perkins240"), tmp_path, pulse_mn(120_000), *words))
    assert done.returncode == 1
    assert "cut short" in done.stderr and "a fault" in done.stderr
    assert not (tmp_path / "record.csv").exists()
