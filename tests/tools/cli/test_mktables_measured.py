"""mktables --measured: what it writes and says, and every surface that it refuses."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from camtools.cli.mktables import main
from camtools.cli.run import main as run_part
from tests.tools.cases.command_cases import job_of
from tests.tools.cases.gauged_cases import ENDS, Floats, error_um, traces
from tests.tools.cases.part_cases import PERKINS, Capture

Refusal = Callable[..., str]
HEADER = "angle_deg,height_mm,deviation_um"


def write_surface(path: Path, turn: Floats, z_mm: Floats, error: NDArray[np.float64]) -> Path:
    """Write traces as an instrument does."""
    rows = np.column_stack([360 * turn, z_mm, error])
    np.savetxt(path, rows, fmt="%.9g", delimiter=",", header=HEADER, comments="")
    return path


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make the plain table and a surface beside it; return their folder."""
    folder = tmp_path_factory.mktemp("first")
    assert main([str(PERKINS), "-o", str(folder)]) == 0
    turn, z_mm = traces(np.linspace(*ENDS, 9), 120)
    write_surface(folder / "surface.csv", turn, z_mm, error_um(turn, z_mm))
    return folder


def correct(*words: str | Path) -> int:
    """Run the command."""
    return main([str(PERKINS), *map(str, words)])


@pytest.fixture
def refusal(capsys: Capture) -> Refusal:
    """Return what runs a correction that is refused, and gives its one line."""

    def run(*words: str | Path) -> str:
        capsys.readouterr()
        assert correct(*words) == 2
        (line,) = capsys.readouterr().err.splitlines()
        return line

    return run


def test_round_is_reported(first: Path, tmp_path: Path, capsys: Capture) -> None:
    """The drawing stays, the target moves, and text and NAME.json say what was done."""
    assert correct("-o", tmp_path, "--measured", first / "surface.csv") == 0
    text = capsys.readouterr().out
    assert "round 1 of correcting, gain 0.7: 1080 points at 9 heights, deviation max" in text
    assert "harmonic  2: 3 um at most" in text
    before = json.loads((first / "perkins240.json").read_text())
    after = json.loads((tmp_path / "perkins240.json").read_text())
    assert before["design"] == after["design"]
    assert "target" not in before
    assert [one["order"] for one in after["target"]["correction"]] == [1, 2, 5]
    about = after["correction"]["rounds"][0]
    assert about["table_crc32"] == before["table_crc32"]
    assert about["expected_um"]["max"] == pytest.approx(0.3 * about["gauged_um"]["max"], rel=0.1)


def test_same_surface_is_not_taken_twice(first: Path, tmp_path: Path, refusal: Refusal) -> None:
    """Neither into the folder of the table that cut it, nor by the report of the next one."""
    surface = first / "surface.csv"
    line = refusal("-o", first, "--measured", surface)
    assert "has the perkins240.json of the table that cut the measured part" in line
    assert correct("-o", tmp_path, "--measured", surface) == 0
    words: list[str | Path] = ["--measured", surface, "--previous", tmp_path / "perkins240.json"]
    line = refusal("-o", tmp_path / "next", *words)
    assert "was already used in round 1 of" in line
    assert not (tmp_path / "next").exists()


def test_corrections_add_up(first: Path, tmp_path: Path) -> None:
    """What a second surface shows of what was left on purpose is taken whole, the rest by gain."""
    assert correct("-o", tmp_path / "1", "--measured", first / "surface.csv", "--gain", "0.5") == 0
    turn, z_mm = traces(np.linspace(*ENDS, 9), 120)
    surface = write_surface(tmp_path / "1" / "b.csv", turn, z_mm, 0.8 * error_um(turn, z_mm))
    assert correct("-o", tmp_path / "2", "--measured", surface, "--gain", "0.6") == 0
    waves = [
        json.loads((tmp_path / one / "perkins240.json").read_text())["correction"]["waves"][2]
        for one in "12"
    ]
    once, twice = (np.array(one["cos_um"]) for one in waves)
    assert np.abs(twice - once * (0.5 + 0.5 + 0.6 * 0.3) / 0.5).max() < 2e-3


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--gain", "0.01"], "--gain 0.01: must be 0.05 .. 1; leave it out for 0.7"),
        (["--gain", "1.5"], "--gain 1.5: must be 0.05 .. 1"),
        (["--keep-harmonics", "0"], "--keep-harmonics 0: must be 1 .. 64"),
        (["--keep-harmonics", "60"], "harmonics up to 60 need 182 points"),
        (["--previous", "none.json"], "--previous none.json: cannot be read: No such file"),
        (["--previous", str(PERKINS)], "not a NAME.json of mktables"),
    ],
)
def test_options_out_of_range(
    first: Path, tmp_path: Path, refusal: Refusal, words: list[str], message: str
) -> None:
    """Each option is named with its range or what it needs."""
    surface = first / "surface.csv"
    assert message in refusal("-o", tmp_path / "x", "--measured", surface, *words)
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("words", [["--gain", "0.5"], ["--keep-harmonics", "4"], ["--centred"]])
def test_options_without_a_surface(tmp_path: Path, refusal: Refusal, words: list[str]) -> None:
    """An option that says how to correct wants a surface."""
    assert "has no effect without --measured; add --measured" in refusal("-o", tmp_path, *words)


def test_surface_of_another_part(first: Path, tmp_path: Path, refusal: Refusal) -> None:
    """Heights, radii, name, drawing or table show that a surface is not of this part."""
    turn, z_mm = traces(np.linspace(*ENDS, 9), 120)
    alone = write_surface(tmp_path / "alone.csv", turn, z_mm, error_um(turn, z_mm))
    out: list[str | Path] = ["-o", tmp_path / "x", "--measured", alone]
    assert "no perkins240.json next to it, so the table that cut the part is unknown" in refusal(
        *out
    )
    report = first / "perkins240.json"
    high = write_surface(tmp_path / "high.csv", turn, z_mm + 20, error_um(turn, z_mm))
    words: list[str | Path] = ["-o", tmp_path / "x", "--previous", report, "--measured"]
    assert "height 82 mm is beyond the part's 0 .. 62 mm" in refusal(*words, high)
    rows = np.column_stack([turn, z_mm, np.full(turn.size, 45.0), 1000 * error_um(turn, z_mm)])
    thin, header = tmp_path / "thin.csv", "turn,z_mm,radius_mm,error_nm"
    np.savetxt(thin, rows, delimiter=",", header=header, comments="")
    assert "radii and deviations contradict each other by -913 um" in refusal(*words, thin)
    other = json.loads(report.read_text())
    other["part"]["name"] = "other"
    wrong = tmp_path / "wrong.json"
    wrong.write_text(json.dumps(other))
    line = refusal("-o", tmp_path / "x", "--measured", alone, "--previous", wrong)
    assert "is of the part 'other', not of 'perkins240'" in line
    other["part"]["name"] = "perkins240"
    other["design"]["ovality_mm"]["coefficients"][0][3] += 0.001
    wrong.write_text(json.dumps(other))
    line = refusal("-o", tmp_path / "x", "--measured", alone, "--previous", wrong)
    assert "not the drawing of the part file" in line
    (tmp_path / "summary.json").write_text('{"table_crc32": 1}')
    assert "another table cut the part" in refusal(*words, alone)
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (lambda turn: 0 * turn + 150.0, "the mean of a height is 150 um off, the limit is 100 um"),
        (
            lambda turn: 40 * np.cos(4 * np.pi * turn),
            "an oval reach 40 um, the limit is 15 um",
        ),
    ],
)
def test_too_large_an_error(
    first: Path, tmp_path: Path, refusal: Refusal, error: object, message: str
) -> None:
    """What no machine does that cuts this part is refused with the limit."""
    assert callable(error)
    turn, z_mm = traces(np.linspace(*ENDS, 9), 120)
    surface = write_surface(tmp_path / "large.csv", turn, z_mm, error(turn))
    words: list[str | Path] = ["--previous", first / "perkins240.json", "--measured", surface]
    assert message in refusal("-o", tmp_path / "x", *words)


def test_changed_speed_is_cautioned(first: Path, tmp_path: Path, capsys: Capture) -> None:
    """A correction is for the speed at which the part was cut; another one is said."""
    slow = tmp_path / "slow.toml"
    slow.write_text(PERKINS.read_text().replace("spindle_rpm = 2500", "spindle_rpm = 2000"))
    words = ["--measured", str(first / "surface.csv")]
    assert main([str(slow), "-o", str(tmp_path / "slow"), *words]) == 0
    assert capsys.readouterr().err == (
        "caution: the measured part was cut with other settings: process.spindle_rpm: "
        "2500 r/min then, 2000 now\n"
    )


def test_drive_that_cannot_follow(first: Path, tmp_path: Path, refusal: Refusal) -> None:
    """A high wave that takes more acceleration than U has is refused as in any table."""
    turn, z_mm = traces(np.linspace(*ENDS, 9), 360)
    error = 12 * np.cos(60 * np.pi * turn)
    surface = write_surface(tmp_path / "high.csv", turn, z_mm, error)
    words: list[str | Path] = ["--previous", first / "perkins240.json", "--measured", surface]
    line = refusal("-o", tmp_path / "x", *words, "--keep-harmonics", "40")
    assert "u_acceleration" in line
    assert line.endswith("or leave the high waves of the correction out by --keep-harmonics")


def test_run_takes_the_same_options(first: Path, capsys: Capture) -> None:
    """A round of tools/run has a folder of its own, and may not take that of the one before."""
    words = [str(PERKINS), "--measured", str(first / "surface.csv")]
    job = job_of(*words)
    assert job.folder("a", 2).name == "a-round2"
    assert job.folder("a").name == "a"
    assert run_part([*words, "-o", str(first)]) == 2
    assert "give another folder for each round" in capsys.readouterr().err
    assert run_part([str(PERKINS), "--gain", "0.5"]) == 2
    assert "has no effect without --measured; add --measured" in capsys.readouterr().err
