"""Recordings of other instruments: constants within their deviations, and when no model holds."""

import numpy as np
import pytest
from scipy.signal import lfilter

from camtools.base.errors import CamtoolsError, InputError
from camtools.base.quantities import Floats
from camtools.identify.foreign_record import ForeignRecord, parse_record
from camtools.identify.linear_model import (
    LinearModel,
    constants_of,
    identify_record,
    record_lines,
    record_numbers,
)
from tests.tools.cases.drive_plant import Plant, limited_m, oscillator_m, played

RATE_HZ, SLOW_HZ = 10_000.0, 1000.0
N = 120_000
MASS_KG, VISCOUS, STIFFNESS, CUBIC = 1.5, 120.0, 4e5, 6e12


TRUE = {"mass kg": MASS_KG, "viscous N s/m": VISCOUS, "stiffness N/m": STIFFNESS}


def smooth_noise(seed: int, rms: float, width: int = 21) -> Floats:
    """Return random values without much above two rates over the width."""
    noise = np.random.default_rng(seed).normal(0, 1, N + width)
    wave = np.convolve(noise, np.hanning(width), "valid")
    return np.asarray(rms * wave[:N] / wave.std())


def white_noise(seed: int, n: int) -> Floats:
    """Return random values of 20 um rms."""
    return np.random.default_rng(seed).normal(0, 20_000.0, n)


def oscillator(force_n: Floats, cubic: float = 0.0) -> Floats:
    """Return the position [m] of mass, damper and spring."""
    return oscillator_m(force_n, 1 / RATE_HZ, MASS_KG, VISCOUS, STIFFNESS, cubic)


def force_record(force_n: Floats, y: Floats, noise: float, seed: int) -> ForeignRecord:
    """Return every tenth value, the position with a share of noise."""
    u, y = force_n[::10], y[::10]
    noisy = y + np.random.default_rng(seed).normal(0, noise * y.std(), y.size)
    return ForeignRecord(SLOW_HZ, u, noisy, "force_n")


def named(found: LinearModel, record: ForeignRecord) -> dict[str, tuple[float, float]]:
    """Return value and deviation of each constant."""
    rows = record_numbers(found, record)["constants"]
    return {name: (one["found"], one["deviation"]) for name, one in rows.items()}


@pytest.mark.long
def test_deviations_are_honest() -> None:
    """Errors of mass, damping and stiffness are as large as is said: chi squared over records."""
    force_n = smooth_noise(3, 20.0, 101)
    clean = oscillator(force_n)
    squares = []
    for seed in range(12):
        record = force_record(force_n, clean, 0.5, seed)
        values = named(identify_record(record), record)
        off = [(values[name][0] - one) / values[name][1] for name, one in TRUE.items()]
        squares.append(np.square(off))
    chi = np.mean(squares, axis=0)
    assert np.all(chi > 0.2) and np.all(chi < 4), chi


@pytest.mark.long
def test_spring_that_hardens_is_not_linear() -> None:
    """A cubic spring under a growing force; the same one without the cubic term is linear."""
    force_n = smooth_noise(5, 60.0, 101)
    force_n *= np.linspace(0.1, 1, force_n.size)
    for cubic, is_linear in ((0.0, True), (CUBIC, False)):
        record = force_record(force_n, oscillator(force_n, cubic), 1e-3, 6)
        found = identify_record(record)
        assert (found.problems == []) is is_linear, found.problems
    assert any("the static term is +" in one for one in found.problems)


def test_other_responses_are_not_of_this_model() -> None:
    """A second resonance, noise, a resonance that is smeared by a recording that is too short."""
    force_n = smooth_noise(7, 20.0, 101)
    second = np.convolve(force_n, np.sin(np.arange(4000) * 0.08) * 1e-8, "full")[: force_n.size]
    found = identify_record(force_record(force_n, oscillator(force_n) + second, 1e-3, 8))
    assert any("times its deviations" in one for one in found.problems)
    unrelated = np.random.default_rng(8).normal(0, 1e-6, force_n.size)
    with pytest.raises(CamtoolsError, match="lines have a coherence above"):
        identify_record(force_record(force_n, unrelated, 0.0, 0))
    force_n = smooth_noise(9, 20.0, 101)[:20_000]
    found = identify_record(force_record(force_n, oscillator(force_n), 1e-3, 9))
    assert any("Hz wide, but lines are" in one for one in found.problems)


def drive_record(plant: Plant, u_nm: Floats, seed: int) -> ForeignRecord:
    """Return the recording of a drive whose command is held for each step, with noise of 20 nm."""
    y_nm = played([plant], u_nm, RATE_HZ)[0]
    noisy = y_nm + np.random.default_rng(seed).normal(0, 20, u_nm.size)
    return ForeignRecord(RATE_HZ, u_nm * 1e-9, noisy * 1e-9, "command_nm")


@pytest.mark.long
@pytest.mark.parametrize(
    ("plant", "u_nm", "near", "late_ns"),
    [
        (Plant(gain=0.9, delay_us=100), smooth_noise(1, 50_000.0)[:30_000], 0.01, 3000),
        (Plant(hz=1200.0, damping=0.3, delay_us=37.5), white_noise(11, 30_000), 0.003, 200),
    ],
    ids=["smooth", "held in a wide band"],
)
def test_position_drive(plant: Plant, u_nm: Floats, near: float, late_ns: float) -> None:
    """A drive moved by another model: neither gain, hold nor what that folds back is off."""
    record = drive_record(plant, u_nm, 12)
    found = identify_record(record)
    assert found.problems == []
    values = named(found, record)
    true = {
        "gain": plant.gain,
        "k1 ns": plant.k1_s * 1e9,
        "k2 us2": plant.k2_s2 * 1e12,
        "natural frequency Hz": plant.hz,
        "damping": plant.damping,
    }
    for name, wanted in true.items():
        assert values[name][0] == pytest.approx(wanted, rel=near), name
        assert values[name][1] < 0.01 * wanted, name
    assert values["delay ns"][0] == pytest.approx(plant.lead_s(RATE_HZ) * 1e9, abs=late_ns)
    assert plant.gain < 1 or "held" in "\n".join(record_lines(found, record))


@pytest.mark.parametrize("friction_m_s2", [0.0, 3.0, pytest.param(15.0, marks=pytest.mark.long)])
def test_friction_is_not_linear(friction_m_s2: float) -> None:
    """Coulomb friction of 2 and 8 % of a command of constant amplitude; none is linear."""
    u_nm = smooth_noise(13, 50_000.0)[:20_000]
    found = identify_record(drive_record(Plant(friction_m_s2=friction_m_s2), u_nm, 14))
    assert len(found.problems) == (friction_m_s2 > 0), found.problems
    assert all(one.startswith("friction") for one in found.problems)


@pytest.mark.long
@pytest.mark.parametrize("share", [0.0, 0.03])
def test_asymmetrical_drive_is_not_linear(share: float) -> None:
    """A motor that pulls more than it pushes answers at twice the frequency."""
    u_nm = smooth_noise(13, 50_000.0)[:20_000]
    bent_nm = u_nm + share * u_nm**2 / 50_000.0
    record = drive_record(Plant(), bent_nm, 14)._replace(u=u_nm * 1e-9)
    problems = identify_record(record).problems
    assert len(problems) == (share > 0), problems
    assert all(one.startswith("a square term of the command") for one in problems)


@pytest.mark.parametrize("n", [4000, 30_000])
@pytest.mark.parametrize("last", [0.5, 1.0])
def test_single_step_is_refused(n: int, last: float) -> None:
    """A step, or a step and back, with one sentence that names what to record instead."""
    part = np.arange(n) / n
    record = drive_record(Plant(), np.where((part > 0.33) & (part < last), 50_000.0, 0.0), 14)
    with pytest.raises(CamtoolsError, match="a single step is not enough; record noise, a sweep"):
        identify_record(record)


def saturated(force_n: Floats, most_n: float) -> Floats:
    """Return the position [m] of the oscillator whose actuator gives at most a force."""
    return oscillator(np.clip(force_n, -most_n, most_n))


@pytest.mark.long
def test_actuator_that_saturates_is_not_linear() -> None:
    """A force clipped at 1.8 times its rms, and an acceleration clipped inside of a loop."""
    force_n = smooth_noise(15, 20.0, 101)
    u_m = smooth_noise(16, 5e-5)[:40_000]
    found = []
    for share in (10.0, 1.8):
        record = force_record(force_n, saturated(force_n, share * 20.0), 1e-3, 17)
        found.append(identify_record(record).problems)
        y_m = limited_m(u_m, RATE_HZ, 60.0 * share)
        found.append(identify_record(ForeignRecord(RATE_HZ, u_m, y_m, "command_m")).problems)
    assert found[:2] == [[], []]
    assert any("of the command, acts like" in one for one in found[2]), found[2]
    assert any("of the acceleration, acts like" in one for one in found[3]), found[3]


def test_units_are_those_of_the_header() -> None:
    """Decimal commas, capitals and other units; a drive of 10 mm per 10 V."""
    found = parse_record("\n".join(GOOD), "scope.csv")
    assert found.rate_hz == pytest.approx(10_000)
    assert found.u[1] == pytest.approx(1.5e-3)
    assert found.y[1] == pytest.approx(1e-6)
    assert constants_of(np.array([1e3, 0.7, 3e-4, 0.0]), "command_v")["gain um/V"] == 1000


def test_record_without_a_natural_frequency_reports_none() -> None:
    """A lag of first order, 1 ms: its second-order term has either sign."""
    u = white_noise(18, 8192) * 1e-9
    y = lfilter([1 - np.exp(-0.1)], [1, -np.exp(-0.1)], u) + white_noise(19, 8192) * 1e-12
    record = ForeignRecord(RATE_HZ, u, y, "command_m")
    found = named(identify_record(record), record)
    assert found.keys() == {"gain", "k1 ns", "k2 us2", "delay ns"}
    assert found["k1 ns"][0] == pytest.approx(1e6, rel=0.01)


GOOD = ["time_ms;Command_mm;position_um"] + [f"{i / 10};{i % 7},5;{i % 5}" for i in range(2000)]


def text_with(line: int, content: str) -> str:
    """Return a good file with one line replaced."""
    return "\n".join([*GOOD[: line - 1], content, *GOOD[line:]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (text_with(1, "time_s;x;position_um"), "line 1: needs one column of the command or force"),
        (text_with(1, "time_s;force_n;command_um"),
         "one column of the command or force: .*; has force_n, command_um; rename all but one"),
        ("\n".join(GOOD[:500]), "has 499 rows, 1024 .. 2000000 are needed; record for longer"),
        (text_with(77, "7,5;nan;1"), r"line 77: cell 2 \(command_mm\) is no finite number"),
        (text_with(77, "7,9;1;1"), "line 77: the step to this time is not the mean"),
        ("\n".join(line.rsplit(";", 1)[0] + ";3" if i else line for i, line in enumerate(GOOD)),
         "the position does not change; excite the drive"),
        ("\n".join(f"{line.rsplit(';', 1)[0]};{7 - (i - 1) % 7 if i else 'position_nm'}"
                   for i, line in enumerate(["time_ms;force_n;x", *GOOD[1:]])),
         "scope.csv: the position is the command or force times a constant: one signal is in both"),
    ],
)  # fmt: skip
def test_bad_files_name_line_and_remedy(text: str, message: str) -> None:
    """One line each."""
    with pytest.raises(InputError, match=message) as caught:
        parse_record(text, "scope.csv")
    assert len(caught.value.lines) == 1
    assert caught.value.lines[0].startswith("scope.csv: ")
