"""What commands refuse: one line with the option and the remedy, status 2, nothing written."""

from importlib import import_module
from pathlib import Path

import pytest

from tests.tools.cases.command_cases import command, complaint
from tests.tools.cases.part_cases import PERKINS, listing

# A command and its first words; then the words that it refuses, and what its line contains.
REFUSALS = {
    "analyse {parts}/perkins240.toml -o out": [
        ("--height 63", "--height 63.0: lies outside the part; give 0 .. 62 mm"),
        ("--height nan", "--height nan"),
        ("--step-deg 7", "--step-deg 7.0: does not divide 90 degrees"),
        ("--parts 1", "--parts 1: out of range; give 2 .. 1000"),
        ("--rpm 0", "--rpm 0.0: out of range"),
        ("--kc-n-mm2 inf", "--kc-n-mm2 inf: out of range"),
        ("--cycle-us x", "argument --cycle-us"),
        ("--turns 0", "--turns 0"),
        ("--slice-volume-mm3 -1", "--slice-volume-mm3 -1.0"),
        ("--nose-mm 0", "--nose-mm 0.0: out of range; give 0.01 .. 100"),
    ],
    "analyse {parts}/cam-345.toml -o out": [
        ("--height 3", "--height 3.0: has no meaning for a cam; leave it out"),
        ("--parts 30", "--parts 30: has no meaning for a cam"),
        ("--nose-mm 2", "--nose-mm 2.0: has no meaning for a cam"),
        ("--step-deg 7", "--step-deg 7.0: does not divide 90 degrees"),
        ("--step-deg nan", "--step-deg nan: out of range"),
        ("--rpm 0", "--rpm 0.0: out of range; give 1 .. 60000"),
    ],
    "forecast {parts}/perkins240.toml -o out": [
        ("--runs 0", "forecast: --runs 0: out of range; give 1 .. 1000000"),
        ("--seed -1", "forecast: --seed -1: out of range"),
        ("--turns nan", "forecast: --turns nan: must be a finite number above 0"),
        ("--tolerance-um 0", "forecast: --tolerance-um 0.0: must be a finite number"),
        ("--machine nowhere", "forecast: --machine nowhere: no such machine"),
        ("--vary /nowhere.toml", "forecast: /nowhere.toml: cannot be read: No such file"),
        ("--set k1_ns", "forecast: --set k1_ns: give PARAM=VALUE"),
        ("--rpm 9000", "forecast: --rpm 9000: infeasible"),
        ("--sections --runs 58", "--runs 58: too few for a bound of a section; give at least 59"),
    ],
    "mkgcode {parts}/perkins240.toml -o out": [
        ("--from-mm -1", "--from-mm -1: must be a height of the part; give 0 .. 62 mm"),
        ("--to-mm 62.5", "--to-mm 62.5: must be a height"),
        ("--to-mm nan", "--to-mm nan: must be a height"),
        ("--from-mm 9 --to-mm 9", "--to-mm 9: must be at least 0.01 mm above"),
        ("--chord-um 0", "--chord-um 0: must be 0.002 .. 1000; give micrometres"),
        ("--chord-um inf", "--chord-um inf: must be"),
        ("--axes xy", "argument --axes: invalid choice: 'xy'"),
        ("--axes cxz", "--axes cxz: not for a piston; give xz or cxzu"),
        ("--chords 1", "unrecognized arguments: --chords"),
        ("-o /", "/: is a folder; give the name of a file"),
    ],
    "mkgcode {parts}/cam-345.toml -o out": [
        ("--axes xz", "--axes xz: not for a cam; give cxz"),
        ("--from-mm 2", "--from-mm 2: has no meaning for a cam"),
        ("--chord-um 0", "--chord-um 0: must be 0.002 .. 1000"),
    ],
    "mktables": [
        ("", "required"),
        ("x.toml", "-o"),
        ("x.toml -o d --tolerance-nm much", "--tolerance-nm"),
        ("x.toml -o d --tolerance-nm 0", "tolerance_nm = 0"),
        ("x.toml -o d --tolerance-nm nan", "tolerance_nm = nan"),
        ("x.toml -o d --colour", "--colour"),
        ("missing.toml -o d", "missing.toml: cannot be read: No such file"),
        ("{parts} -o d", "cannot be read: Is a directory"),
        ("{parts}/perkins240.toml -o d --tolerance-nm 1e-9", "tolerance_nm = 1e-09: unreach"),
        ("{parts}/perkins240.toml -o {parts}/perkins240.toml", "perkins240.toml: cannot write"),
        ("{parts}/perkins240.toml -o /proc/none", "/proc/none: cannot write"),
    ],
    "identify": [
        ("--machine default --form-error-um 1", "--form-error-um: needs a part: add PART"),
        ("", "identify: one of the arguments --machine --bus --record is required"),
        ("--machine nowhere", "--machine nowhere: no such machine; give one of analog_position, c"),
        ("--machine default --apply", "identify: --apply: needs a folder for the machine file"),
        ("--machine default --rpm 900", "identify: --rpm: needs a part: add PART.toml"),
        ("--record a.csv --apply", "identify: --apply: has no effect with --record; leave it out"),
        ("--machine default --channel can0", "--channel: needs a bus: use --bus instead of"),
        ("--machine default --rms-um 0", "argument --rms-um: 0: give a number above 0"),
        ("--machine default --periods 2", "argument --periods: 2: give 3 .. 100"),
        ("--machine default --highest-hz 20", "--highest-hz 20: give at least 50"),
        ("--machine default nopart.toml", "nopart.toml: cannot be read"),
        (
            "--machine default --rms-um 70",
            "--rms-um 70: too large: acceleration of U 3.664e+05 mm/s2, 0.8 of 2.5e+05 are allowed",
        ),
        ("--bus --interface nobus", "identify: interface nobus: unknown to python-can"),
    ],
}


@pytest.mark.parametrize(
    ("command", "words", "message"),
    [(command, *row) for command, rows in REFUSALS.items() for row in rows],
)
def test_what_is_wrong_is_one_line(
    command: str,
    words: str,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """It names the command and the option, with the remedy; no folder is made."""
    monkeypatch.chdir(tmp_path)
    name, *given = (word.format(parts=PERKINS.parent) for word in f"{command} {words}".split())
    line = complaint(import_module(f"camtools.cli.{name}").main, given, capsys)
    assert line.startswith(f"{name}: ") and message in line
    assert listing(tmp_path) == []


SECRETS = {
    "token": "hunter2",
    "line": "hunter2\n",
    "settings": 'user = "hunter2"\nhunters = ["hunter2"]\n',
    "section": '[user]\nname = "hunter2"\n',
    "json": '{"token":"hunter2","a":1}',
    "columns": "name;word\na;hunter2\n",
}
NAMED = [
    "mktables FILE -o out",
    "mktables {parts}/perkins240.toml --measured FILE -o out",
    "run {parts}/perkins240.toml --machine FILE -o out",
    "identify --record FILE",
    "tune FILE",
    "tune --record FILE",
    "forecast {parts}/perkins240.toml --vary FILE -o out",
    "camctl -i virtual -c named params load FILE",
    "camctl -i virtual -c named learned load FILE",
    "camctl -i virtual -c named table download FILE",
    "camctl -i virtual -c named excite FILE out.csv",
]


@pytest.mark.parametrize("secret", list(SECRETS))
@pytest.mark.parametrize("words", NAMED)
def test_nothing_of_a_wrong_file_is_shown(
    words: str, secret: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody names a file of another kind; the terminal's log may be public."""
    monkeypatch.chdir(tmp_path)
    Path("FILE").write_text(SECRETS[secret])
    name, *rest = words.format(parts=PERKINS.parent).split()
    done = command(f"camtools.cli.{name}", *rest)
    assert done.returncode == 2 and done.stderr
    assert "hunter2" not in done.stdout + done.stderr


TOOLS = "analyse camctl flash forecast identify live mkgcode mktables panel papers run tune"


@pytest.mark.parametrize("name", TOOLS.split())
def test_help_is_shown(name: str) -> None:
    """A sign of percent in a text is not taken for a format."""
    done = command(f"camtools.cli.{name}", "--help")
    assert done.returncode == 0
    assert done.stdout.startswith("usage: ")
