"""camsim identify: what U plays is the file, and nothing is written of what was cut short.

A pulse of force moves U as Newton's law says.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from tests.tools.cases.camsim_cases import ROOT, camsim, only_error

N, PERIODS, FADE, PLACE_NM = 2000, 3, 1000, -200_000
Rows = dict[str, npt.NDArray[np.float64]]


def tones(*lines: tuple[int, float]) -> npt.NDArray[np.int64]:
    """Return a period of some lines, each with its amplitude [nm]."""
    turn = 2 * np.pi * np.arange(N) / N
    return np.rint(sum(a * np.sin(k * turn + k) for k, a in lines)).astype(np.int64)


def wave_file(folder: Path, samples: npt.NDArray[np.int64], head: str = "u_nm") -> Path:
    """Write a wave."""
    path = folder / "wave.csv"
    path.write_text(f"{head}\n" + "".join(f"{value}\n" for value in samples))
    return path


def words(table: Path, wave: Path, record: Path, *more: str | Path) -> list[str | Path]:
    """Return the command line of an excitation."""
    shape = ("--periods", str(PERIODS), "--fade-ticks", str(FADE), "--place-nm", str(PLACE_NM))
    return ["identify", table, "--wave", wave, "--record", record, *shape, *more]


def record_of(table: Path, folder: Path, samples: npt.NDArray[np.int64], *more: str) -> Rows:
    """Excite; return the columns of the record."""
    done = camsim(*words(table, wave_file(folder, samples), folder / "record.csv", *more))
    assert done.returncode == 0, done.stderr
    assert "at 20000 Hz" in done.stdout
    names = (folder / "record.csv").read_text().splitlines()[0].split(",")
    rows = np.loadtxt(folder / "record.csv", delimiter=",", skiprows=1, unpack=True)
    return dict(zip(names, rows, strict=True))


def test_u_plays_the_wave_to_the_bit(table: Path, tmp_path: Path) -> None:
    """The last periods before the fall are the file's samples about the place, as commanded."""
    samples = tones((4, 50_000.0), (61, 800.0))
    rows = record_of(table, tmp_path, samples)
    assert list(rows) == ["tick", "t_s", "u_set_q6", "u_command_nm", "u_actual_nm"]
    assert np.all(np.diff(rows["tick"]) == 1)
    assert np.allclose(rows["t_s"] * 20_000, rows["tick"] - rows["tick"][0])
    for name, factor in (("u_set_q6", 64), ("u_command_nm", 1)):
        played = rows[name][-PERIODS * N :].reshape(PERIODS, N)
        assert np.all(played == (PLACE_NM + samples) * factor)


def test_the_drive_answers_as_its_machine_file_says(table: Path, tmp_path: Path) -> None:
    """A line of 500 Hz comes back as a drive of 300 Hz, 0.7, 75 us and half a tick tells it."""
    k = 50
    rows = record_of(table, tmp_path, tones((4, 40_000.0), (k, 5_000.0)))
    last = slice(-N, None)
    u, y = (np.fft.rfft(rows[name][last])[k] for name in ("u_command_nm", "u_actual_nm"))
    omega, natural = 2 * np.pi * 500.0, 2 * np.pi * 300.0
    ratio = omega / natural
    drive = 1 / (1 - ratio**2 + 2j * 0.7 * ratio)
    delay_s = 75e-6 + 0.5 / 20_000
    hold = np.sinc(500.0 / 20_000)
    assert y / u == pytest.approx(drive * hold * np.exp(-1j * omega * delay_s), abs=2e-3)


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (["--alive-s", "0.01"], "no sign of life"),
        (["--inject", "estop@t0.3"], "a fault"),
        (["--inject", "u-block@t0.1"], "a fault"),  # 0.3 mm from where the wave is played
    ],
)
def test_what_is_cut_short_is_lost(table: Path, tmp_path: Path, more: list[str], why: str) -> None:
    """Status 1, the reason, no file."""
    samples = np.tile(tones((4, 50_000.0)), 5)
    record = tmp_path / "record.csv"
    done = camsim(*words(table, wave_file(tmp_path, samples), record, *more))
    assert done.returncode == 1
    assert why in done.stderr
    assert not record.exists()


def test_what_exceeds_u_is_refused_with_numbers(table: Path, tmp_path: Path) -> None:
    """Stroke, speed, acceleration, the wrap's too, length, and a full memory."""
    step = np.linspace(0, 10_000, N).astype(np.int64)
    cases = [
        (tones((4, 500_000.0)), "U would be at"),
        (tones((90, 160_000.0)), "u_speed_um_per_s is 400000"),
        (tones((90, 40_000.0)), "u_acceleration_mm_per_s2 is 250000"),
        (step, "u_acceleration_mm_per_s2 is 250000"),
        (tones((4, 50_000.0))[:15], "too short or too long"),
    ]
    record = tmp_path / "record.csv"
    for samples, why in cases:
        error = only_error(camsim(*words(table, wave_file(tmp_path, samples), record)))
        assert why in error, error
    full = camsim(
        *words(table, wave_file(tmp_path, tones((4, 9.0))), record, "--periods", "300"),
        *("--signals", "u_set_q6,u_actual_nm,state,tick,counts,clock"),
    )
    assert full.returncode == 1
    assert "memory is full" in full.stderr
    assert not record.exists()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "line 1: no u_nm"),
        ("u_nm\n", "no samples"),
        ("u_nm\n1\n2.5\n", "line 3: 2.5: give a whole number"),
        ("u_nm\n1\nnan\n", "line 3: nan"),
        ("u_nm\n3000000000\n", "line 2: 3000000000"),
        ("u_um\n1\n", "line 1: no u_nm or force_mn"),
        ("force_mn\n1.5\n", "line 2: 1.5: give a whole number of mN"),
    ],
)
def test_bad_wave_is_named(table: Path, tmp_path: Path, text: str, why: str) -> None:
    """File, line, value and remedy; no record."""
    wave, record = tmp_path / "wave.csv", tmp_path / "record.csv"
    wave.write_text(text)
    error = only_error(camsim(*words(table, wave, record)))
    assert why in error
    assert "wave.csv" in error
    assert not record.exists()


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (["--periods", "0"], "--periods 0: out of range; give a whole number"),
        (["--fade-ticks", "15"], "--fade-ticks 15: out of range; give a whole number, 16 .. 65535"),
        (["--place-nm", "1.5"], "--place-nm 1.5"),
        (["--signals", "state,nonsense"], "--signals nonsense: no such signal"),
        (["--signals", ""], "empty"),
        (["--alive-s", "0"], "--alive-s 0"),
        (["--trace", "t.csv"], "t.csv: an output of camsim run"),
        (["--nonsense"], "unknown option"),
        (["--wave"], "value missing"),
    ],
)
def test_bad_option_is_named(table: Path, tmp_path: Path, more: list[str], why: str) -> None:
    """One line, status 2, no file."""
    wave = wave_file(tmp_path, tones((4, 30_000.0)))
    record = tmp_path / "record.csv"
    assert why in only_error(camsim(*words(table, wave, record, *more)))
    assert not record.exists()


def test_without_wave_or_record_the_help_is_named(table: Path) -> None:
    """Both are needed."""
    assert "--wave and --record are needed" in only_error(camsim("identify", table))
    assert "--record F.csv" in camsim("identify", "--help").stdout


FORCE = ROOT / "tests" / "scenarios" / "cases" / "machines" / "force.toml"
PULSE_TICKS, PULSE_S, REST_TICKS = 160, 8e-3, 20
FORCE_N, MASS_KG = 10.0, 1.5
WEAK = ("--set", "servo_integral_mHz=1000", "--set", "servo_crossover_hz=1")


def pushed(table: Path, folder: Path, force_n: npt.ArrayLike, *more: str | Path) -> tuple[int, str]:
    """Push U once with forces, on the machine of the scenarios; return status and words."""
    wave = wave_file(folder, np.rint(1000 * np.asarray(force_n)).astype(np.int64), "force_mn")
    shape = ("--periods", "1", "--fade-ticks", "16", "--signals", "u_set_q6,u_actual_nm,u_force_q6")
    record = ("--wave", wave, "--record", folder / "record.csv")
    done = camsim("identify", table, *record, *shape, *more)
    return done.returncode, done.stderr


def lathe(folder: Path, friction_m_per_s2: float) -> Path:
    """Write the force machine with another friction."""
    old, path = "friction_m_per_s2 = 3\n", folder / "force.toml"
    text = FORCE.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, f"friction_m_per_s2 = {friction_m_per_s2}\n"), "utf-8")
    return path


def pulse(force_n: float) -> npt.NDArray[np.float64]:
    """Return +, -, -, + of 8 ms each, between 1 ms without force."""
    senses = np.repeat(
        [0.0, 1.0, -1.0, -1.0, 1.0, 0.0], [REST_TICKS, *[PULSE_TICKS] * 4, REST_TICKS]
    )
    return np.asarray(force_n * senses)


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("friction_m_per_s2", "accuracy"), [(0, 0.005), (3, 0.02)])
def test_pulse_moves_u_by_its_force_alone(
    table: Path, tmp_path: Path, sense: int, friction_m_per_s2: float, accuracy: float
) -> None:
    """With a loop of 1 Hz; without friction U gets as far as F t^2 / m, and back; it was ready."""
    force_n = pulse(sense * FORCE_N)
    machine = ("--machine", lathe(tmp_path, friction_m_per_s2))
    assert pushed(table, tmp_path, force_n, *machine, *WEAK) == (0, "")
    rows = np.genfromtxt(tmp_path / "record.csv", delimiter=",", names=True)[-force_n.size :]
    assert not rows["u_set_q6"].any()
    u_um = sense * (rows["u_actual_nm"] - rows["u_actual_nm"][0]) * 1e-3
    faster, slower = (FORCE_N / MASS_KG + way * friction_m_per_s2 for way in (-1, 1))
    peak_um = 0.5e6 * faster * PULSE_S**2 * (1 + faster / slower)  # until it stands
    assert u_um.max() == pytest.approx(peak_um, rel=accuracy)
    if friction_m_per_s2 == 0:
        assert abs(u_um[-1]) < 0.02 * u_um.max()
    assert rows["u_force_q6"][1:] / 64e3 == pytest.approx(force_n[:-1], abs=0.1)


@pytest.mark.parametrize(
    ("force_n", "more", "status", "why"),
    [
        ([0] * 20 + [600.001] * 20, (), 2, "servo_force_limit_mn is 600000"),
        ([0] * 10, (), 2, "--wave: refused"),
        (pulse(120), WEAK, 1, "a fault"),  # 5 mm out of a stroke of 2 mm
    ],
)
def test_force_that_u_cannot_take_leaves_no_record(
    table: Path,
    tmp_path: Path,
    force_n: npt.ArrayLike,
    more: tuple[str, ...],
    status: int,
    why: str,
) -> None:
    """One line each; nor does a U that takes positions."""
    assert "U takes positions" in pushed(table, tmp_path, [0] * 40)[1]
    found, said = pushed(table, tmp_path, force_n, "--machine", lathe(tmp_path, 0), *more)
    assert found == status and why in said and len(said.splitlines()) == 1
    assert not (tmp_path / "record.csv").exists()
