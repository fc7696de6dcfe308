# SPDX-License-Identifier: Apache-2.0
"""camsim identify: what U plays is the file, and nothing is written of what was cut short."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from tests.tools.cases.camsim_cases import camsim, only_error

N, PERIODS, FADE, PLACE_NM = 2000, 3, 1000, -200_000
Rows = dict[str, npt.NDArray[np.float64]]


def tones(*lines: tuple[int, float]) -> npt.NDArray[np.int64]:
    """Return a period of some lines, each with its amplitude [nm]."""
    turn = 2 * np.pi * np.arange(N) / N
    return np.rint(sum(a * np.sin(k * turn + k) for k, a in lines)).astype(np.int64)


def wave_file(folder: Path, samples: npt.NDArray[np.int64]) -> Path:
    """Write a wave."""
    path = folder / "wave.csv"
    path.write_text("u_nm\n" + "".join(f"{value}\n" for value in samples))
    return path


def words(table: Path, wave: Path, record: Path, *more: str) -> list[str | Path]:
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
        (["--inject", "u-block@t0.2", "--set", "following_limit_nm=1000"], "a fault"),
    ],
)
def test_what_is_cut_short_is_not_written(
    table: Path, tmp_path: Path, more: list[str], why: str
) -> None:
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
