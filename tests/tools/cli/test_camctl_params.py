"""All parameters as a file and in the controller's memory, and refusals with their numbers."""

import tomllib
from pathlib import Path

from camtools.link.kept_values import INFOS
from camtools.link.messages import NAMES
from tests.tools.cases.camctl_bench import Bench, Refusal
from tests.tools.cases.part_cases import Capture


def test_parameters_are_those_of_the_dbc() -> None:
    """The header that names, ranges and meanings come from has all of them, in order."""
    assert list(INFOS) == [NAMES["parameter"][i] for i in range(len(NAMES["parameter"]))]
    assert all(info.low <= info.default <= info.high and info.what for info in INFOS.values())


def test_a_file_is_saved_and_loaded(bench: Bench, refusal: Refusal, tmp_path: Path) -> None:
    """A saved file is equal; after a change it differs by one line, and load brings it back."""
    file = tmp_path / "machine.toml"
    assert f"{len(INFOS)} parameters, version 1" in bench.do("params", "save", file)
    told = tomllib.loads(file.read_text())
    assert told["axis_u"]["lead_ns"] == 50_000
    assert sum(map(len, told.values())) == len(INFOS)
    assert "# dead time of the U drive" in file.read_text()
    assert "equal, checksum" in bench.do("params", "diff", file)
    bench.do("set", "lead_ns", "60000")
    status, text = bench.run("params", "diff", file)
    assert status == 1
    assert [line.split() for line in text.splitlines()] == [
        ["parameter", "file", "controller"],
        ["lead_ns", "50000", "60000"],
    ]
    assert "1 of" in refusal(bench, 1, f"params diff {file}")
    assert bench.do("params", "load", file).splitlines()[1].split() == ["lead_ns", "60000", "50000"]
    assert f"0 of {len(INFOS)} parameters changed" in bench.do("params", "load", file)


def test_a_file_of_an_older_version_names_what_is_retired(bench: Bench, tmp_path: Path) -> None:
    """One line for all retired parameters; the others are loaded."""
    file = tmp_path / "old.toml"
    file.write_text("[switches]\nswitch_1_per_turn = 2\nswitch_8_sense = 1\n[u]\nk1_ns = 30\n")
    retired, *_, last = bench.do("params", "load", file).splitlines()
    assert retired == f"{file}: retired and ignored: 2 parameters, first switch_1_per_turn"
    assert last == f"{file}: 1 of 1 parameters changed"


def test_a_file_with_errors_changes_nothing(bench: Bench, capsys: Capture, tmp_path: Path) -> None:
    """Every wrong line is told before the controller is asked."""
    file = tmp_path / "bad.toml"
    file.write_text(
        "lead_ns = 1\n[u]\nk1_ns = -1\nlaed_ns = 2\nk2_us2 = 1.5\nencoder_sign = 0\n"
        "[v]\nlead_ns = 3\n"
    )
    assert bench.run("params", "load", file)[0] == 2
    lines = [line.removeprefix(f"camctl: {file}: ") for line in capsys.readouterr().err.split("\n")]
    assert lines[0] == "k1_ns = -1: out of range; give 0 .. 100000000"
    assert lines[1] == "laed_ns: no such parameter; tools/camctl list prints all"
    assert lines[2] == "k2_us2 = 1.5: give a whole number"
    assert lines[3] == "encoder_sign = 0: out of range; give -1 .. 1"
    assert lines[4] == "lead_ns: appears twice; give it once"
    assert bench.do("get", "lead_ns") == "lead_ns = 50000\n"
    for text in ("", "lead_ns = ", "\xff"):
        file.write_text(text, "latin-1")
        assert bench.run("params", "diff", file)[0] == 2
    assert bench.run("params", "load", tmp_path / "none.toml")[0] == 2


def test_a_refused_load_changes_nothing(bench: Bench, refusal: Refusal, tmp_path: Path) -> None:
    """One parameter of the encoder in ready: the trims in front of it do not change either."""
    file = tmp_path / "mixed.toml"
    file.write_text("x_trim_nm = 2000\nk1_ns = 30\ncounts_per_turn = 20000\n")
    bench.do("home")
    line = refusal(bench, 1, f"params load {file}")
    assert "nothing is changed" in line
    assert "counts_per_turn cannot change in this state" in line
    assert bench.do("get", "x_trim_nm", "k1_ns") == "x_trim_nm = 0\nk1_ns = 0\n"
    file.write_text("x_trim_nm = 2000\nk1_ns = 30\n")
    assert "2 of 2 parameters changed" in bench.do("params", "load", file)
    assert bench.do("get", "x_trim_nm", "k1_ns") == "x_trim_nm = 2000\nk1_ns = 30\n"
    assert "parameters are not in the file" in bench.do("params", "diff", file)


def test_what_is_kept_is_brought_back(bench: Bench, refusal: Refusal, tmp_path: Path) -> None:
    """Keep, change, revert, defaults; in ready nothing is kept."""
    assert "not kept: a restart uses the defaults" in bench.do("status")
    assert "no" in refusal(bench, 1, "params revert")
    file = tmp_path / "trim.toml"
    file.write_text("x_trim_nm = 3000\n")
    assert "keep: done" in bench.do("params", "load", file, "--keep")
    assert ", kept\n" in bench.do("status")
    bench.do("set", "x_trim_nm", "4000")
    assert "a restart uses other values" in bench.do("status")
    bench.do("params", "revert")
    assert bench.do("get", "x_trim_nm") == "x_trim_nm = 3000\n"
    assert ", kept\n" in bench.do("status")
    bench.do("params", "defaults")
    assert bench.do("get", "x_trim_nm", "lead_ns") == "x_trim_nm = 0\nlead_ns = 100000\n"
    bench.do("home")
    assert "save parameters: refused: state" in refusal(bench, 1, "params keep")


def test_a_refusal_names_demand_limit_and_what_is_feasible(bench: Bench, refusal: Refusal) -> None:
    """In ready a limit below the demand; the table's limit; a lead beyond the history."""
    bench.do("home")
    line = refusal(bench, 1, "set u_acceleration_mm_per_s2 15000")
    assert "refused: U would have to accelerate more than it can: needs " in line
    assert ", limit 15000 mm/s2 (u_acceleration_mm_per_s2); the highest feasible speed is " in line
    line = refusal(bench, 1, "speed 3200")
    assert "needs 3200 r/min, limit 3000 r/min (spindle_limit_mrpm)" in line
    assert "exceeds the height of the part: needs 9.9 mm, " in refusal(bench, 1, "feed 9.9")
    line = refusal(bench, 1, "set observer_bandwidth_mHz 1700000")
    assert "observer_bandwidth_mHz cannot change in this state" in line
    bench.do("disable")
    line = refusal(bench, 1, "set observer_bandwidth_mHz 1700000")
    assert "observer_bandwidth_mHz = 1700000: " in line and "; give at most 1600000" in line
