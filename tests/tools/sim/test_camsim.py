"""The commands of camsim: results, determinism, and everything that must be refused."""

import json
import os
import resource
import subprocess
from pathlib import Path

import numpy as np
import pytest

from camtools.link.messages import NUMBERS
from camtools.skirt.geometry.skirt_geometry import Geometry
from tests.tools.cases.camsim_cases import (
    CAMSIM,
    ROOT,
    camsim,
    cut,
    form_um,
    only_error,
)
from tests.tools.cases.cut_cases import file_evaluated
from tests.tools.cases.part_cases import TableOf

CUT = ("--rpm", "2500", "--feed", "1")
HEADER = "turn,z_mm"
COLUMNS = "turn,z_mm,u_nm,u1_nm_per_rad,u2_nm_per_rad2,x_nm,speed_ratio,clamped"
NM_PER_MM = 1e6


def test_run_without_feed_forward_shows_what_the_drive_costs(table: Path) -> None:
    """Expect what a 300 Hz drive misses of a 150 um sweep at 83 Hz: |1 - H| with its dead time."""
    omega, natural, damping = 2 * 2500 / 60 * 6.283185307, 300 * 6.283185307, 0.7
    s = 1j * omega
    drive = natural**2 / (s * s + 2 * damping * natural * s + natural**2)
    swing_um = 75.0  # amplitude of U at G = 0.3 mm
    bare = abs(1 - drive) * swing_um
    late = swing_um * omega * 100e-6
    for word, error_um in (("--no-feed-forward", bare), ("--no-lead", late)):
        found = cut(table, *CUT, "--no-learning", word, status=None)
        assert form_um(found) == pytest.approx(error_um, rel=0.05)


def test_cut_that_nothing_gauged_is_not_good(table: Path, tmp_path: Path) -> None:
    """An operator's stop before the cut leaves no sample: status 1, and the line says why."""
    words = ("--rpm", "600", "--inject", "stop@t1", "--summary", tmp_path / "s.json")
    done = camsim("run", table, *words)
    summary = json.loads((tmp_path / "s.json").read_text())
    assert (summary["cut"]["samples"], summary["end"]) == (0, "stopped")
    assert (done.returncode, summary["is_good"]) == (1, False)
    assert "form error      not gauged: nothing was cut to full depth\n" in done.stdout
    told = "not gauged: nothing was cut to full depth before the cut was stopped; leave the stop"
    assert done.stderr == f"camsim: {table}: {told} out, or stop later\n"


REFUSED = [
    ("run", "--rpm 0", "--rpm"),
    ("run", "--rpm -2500", "--rpm"),
    ("run", "--rpm nan", "--rpm"),
    ("run", "--rpm fast", "--rpm"),
    ("run", "--rpm", "--rpm: value missing"),
    ("run", "--summary=", "--summary: empty; give F.json"),
    ("run", "-xy", "-xy: unknown option"),
    ("run", "--progress=3", "--progress=3: unknown option"),
    ("run", "--feed 0", "--feed"),
    ("run", "--feed -0.1", "--feed"),
    ("run", "--feed inf", "--feed"),
    ("run", "--rpm 5000", "3000"),
    ("run", "--feed 70", "feed"),
    ("run", "--seed x", "--seed"),
    ("run", "--slice-us 0", "--slice-us"),
    ("run", "--slice-us x", "--slice-us"),
    ("run", "--kc-n-mm2 -1", "--kc-n-mm2"),
    ("run", "--machine none.toml", "none.toml"),
    ("run", "--inject earthquake@1", "earthquake"),
    ("run", "--inject acknowledge@1:0.5", "acknowledge@1:0.5: cannot happen here"),
    ("run", "--inject key@1:1", "key@1:1: cannot happen here"),
    ("run", "--inject node-dead@0:2", "cannot happen here; camsim run --help"),
    ("run", "--set no_such=1", "no_such"),
    ("run", "--set lead_ns=-1", "lead_ns"),
    ("run", "--frobnicate", "--frobnicate: unknown option; see camsim run --help"),
    ("run", "surplus", "one TABLE"),
    ("run", "--nose-mm 0", "--nose-mm 0: out of range; give mm, 0.01 .. 100"),
    ("run", "--scallop {out}/x.csv", "no tool for it; give --nose-mm, too"),
    ("run", "--nose-mm 1 --scallop-mm 5:4", "--scallop-mm 5:4: no two rising heights"),
    ("run", "--nose-mm 1 --scallop-mm 5", "--scallop-mm 5: no two rising heights"),
    ("run", "--nose-mm 1 --scallop-mm a:b", "--scallop-mm a:b: no two rising heights"),
    ("run", "--nose-mm 1 --scallop-mm 61:63", "beyond the part; give heights 0 .. 62"),
    ("run", "--nose-mm 1 --scallop {out}/x.csv --trace {out}/x.csv", "named for two purposes"),
    ("bus", "", "no --can"),
    ("bus", "--can", "--can: value missing"),
    ("bus", "--can nocan7", "nocan7: no such interface"),
    ("bus", "--can lo --rpm 300", "set it in the controller"),
    ("bus", "--can lo --set k1_ns=1", "set it in the controller"),
    ("bus", "--can lo --sections s.csv", "an option of camsim run only"),
    ("bus", "--can lo --tick-hz 20", "100 .. 4000"),
    ("bus", "--can lo --encoder-modulus 100.5", "not whole"),
    ("bus", "--can lo --without w", "encoder, u, x, z or spindle"),
    ("bus", "--can lo --inject late-tick@0:100", "cannot happen here"),
    ("bus", "--can lo --inject node-fault@0:1", "a drive, 2 .. 5"),
    ("bus", "--can lo --inject fire@0", "camsim bus --help"),
    ("bus", "--can lo --nonsense", "bus: --nonsense: unknown option"),
    ("bus", "--can vcan0 --machine {real}", "the drives on the bus take positions"),
    ("params", "", "params: s.json: an output of camsim run; leave it out"),
]


@pytest.mark.parametrize(("command", "words", "told"), REFUSED)
def test_bad_words_refused(
    command: str, words: str, told: str, table: Path, tmp_path: Path
) -> None:
    """One line names the option or the numbers; nothing is written."""
    real = ROOT / "host_sim" / "machines" / "real.toml"
    given = [word.format(real=real, out=tmp_path) for word in words.split()]
    out = "s.json" if command == "params" else tmp_path / "s.json"
    done = camsim(command, table, "--summary", out, *given)
    assert told in only_error(done)
    assert list(tmp_path.iterdir()) == []


def test_table_and_help() -> None:
    """Each command names the table that is missing; help goes to standard output."""
    assert "bus: give one TABLE" in only_error(camsim("bus", "--can", "vcan0"))
    assert "table" in only_error(camsim("run")).lower()
    assert "none.camtab" in only_error(camsim("run", "none.camtab"))
    done = camsim("bus", "--help")
    assert done.returncode == 0 and "--gpiochip" in done.stdout


@pytest.mark.parametrize(
    ("words", "field"),
    [
        (("--feed", "0.000003"), "--feed 3e-06"),
        (("--set", "feed_nm=1"), "feed_nm = 1"),
        (("--feed", "0.0000034"), "--feed 3.4e-06"),
    ],
)
def test_run_refuses_rings_nearer_than_the_firmware_cuts(
    table_of: TableOf, words: tuple[str, ...], field: str
) -> None:
    """Below 4 nm it would cut other turns than planned; a Z that others lead has no rings."""
    rings = table_of("perkins240_ring_helix")
    told = f"{field}: rings of a ring-helix are at least 0.000004 mm apart; give at least "
    line = only_error(camsim("run", rings, "--rpm", "900", *words))
    assert line == f'camsim: {told}--feed 0.000004, or a table with path = "helix"'
    short = ("--rpm", "900", "--turns-limit", "1")
    for many in (("--feed", "0.000004"), (*words, "--set", "z_is_measured=1")):
        assert "the part has too many turns: " in only_error(camsim("run", rings, *short, *many))


@pytest.mark.parametrize("more", [(), ("--set", "z_is_measured=1")])
def test_run_cuts_rings_that_are_far_enough(table_of: TableOf, more: tuple[str, ...]) -> None:
    """At 70 nm the part has as many turns as the firmware counts."""
    words = ("--rpm", "900", "--turns-limit", "1", "--feed", "0.00007", *more)
    assert camsim("run", table_of("perkins240_ring_helix"), *words).returncode == 0


def corrupted(image: bytes) -> dict[str, bytes]:
    """Return images with something wrong, by what it is."""
    flipped = bytearray(image)
    flipped[len(image) // 2] ^= 0x10
    return {
        "empty": b"",
        "short": image[:100],
        "cut": image[:-32],
        "longer": image + bytes(32),
        "flipped": bytes(flipped),
        "text": b"this is not a table\n" * 50,
        "order": image[:8] + image[11:7:-1] + image[12:],
        "version": image[:12] + b"\x02" + image[13:],
    }


@pytest.mark.parametrize("what", list(corrupted(bytes(200))))
def test_run_refuses_a_damaged_table(table: Path, tmp_path: Path, what: str) -> None:
    """Refuse each kind of damage, naming the file."""
    bad = tmp_path / "bad.camtab"
    bad.write_bytes(corrupted(table.read_bytes())[what])
    for command in ("run", "eval"):
        assert "bad.camtab" in only_error(camsim(command, bad, stdin="turn,z_mm\n0,0\n"))


@pytest.mark.parametrize("what", ["pipe", "folder"])
def test_what_is_no_regular_file_is_refused(table: Path, tmp_path: Path, what: str) -> None:
    """A pipe without a writer is not waited for, whatever it is given as."""
    path = tmp_path / what
    if what == "pipe":
        os.mkfifo(path)
    else:
        path.mkdir()
    told = {"pipe": "is not a regular file", "folder": "is a folder"}[what]
    calls: list[tuple[str | Path, ...]] = [
        ("run", path),
        ("eval", path),
        ("bus", path, "--can", "none0", "--gpiochip", "none0"),
        ("run", table, "--machine", path),
        ("run", table, "--design", path),
    ]
    for words in calls:
        assert only_error(camsim(*words)) == f"camsim: {path}: {told}; give a file"


def test_run_refuses_a_report_of_another_table(table: Path, tmp_path: Path) -> None:
    """Do not gauge against the design of another table."""
    report = json.loads(table.with_suffix(".json").read_text())
    report["table_crc32"] ^= 1
    other = tmp_path / "other.json"
    other.write_text(json.dumps(report))
    assert "other.json" in only_error(camsim("run", table, "--design", other))


def test_run_without_a_report_says_what_it_gauges_against(table: Path, tmp_path: Path) -> None:
    """Fall back to the table itself, with a warning and a word in the summary."""
    lonely = tmp_path / "lonely.camtab"
    lonely.write_bytes(table.read_bytes())
    done = camsim("run", lonely, *CUT, "--summary", tmp_path / "s.json")
    assert done.returncode == 0
    assert "lonely.json" in done.stderr
    assert json.loads((tmp_path / "s.json").read_text())["gauge"]["reference"] == "table"


def test_run_measures_what_is_removed(table: Path) -> None:
    """Slices hold volume, rate, power and both forces; the summary their spread and ripple."""
    words = ("--rpm", 600, "--feed", 1, "--no-learning", "--kc-n-mm2", 800)
    found = cut(table, *words, status=None, tables=["removal"])
    rows, told = found.removal, found.summary["removal"]
    assert len(rows) == pytest.approx(120 * found.summary["cut"]["turns"], rel=0.01)
    assert rows["volume_mm3"].sum() == pytest.approx(told["volume_mm3"], rel=1e-3)
    assert told["slice_s"] == pytest.approx(0.1 / 120)
    some = rows[1000:1010]
    np.testing.assert_allclose(some["power_w"], 0.8 * some["rate_mm3_s"], atol=1e-5)
    np.testing.assert_allclose(some["rate_force_n"], 800 * some["volume_mm3"], atol=1e-3)
    ripple = told["rate_ripple"]
    assert 0.4 < ripple["min"] <= ripple["mean"] <= ripple["max"] < 0.75
    assert told["turns"] == pytest.approx(58, abs=3)


def test_run_takes_other_slices(table: Path) -> None:
    """Longer slices are fewer."""
    found = cut(table, *CUT, "--slice-us", 2000, status=None, tables=["removal"])
    assert np.diff(found.removal["t_s"])[0] == pytest.approx(0.002, abs=1e-9)


@pytest.mark.parametrize("option", ["--trace", "--surface", "--summary", "--removal"])
def test_run_refuses_an_unwritable_output(table: Path, tmp_path: Path, option: str) -> None:
    """Refuse a folder that does not exist, and a folder in place of a file."""
    assert option in only_error(camsim("run", table, *CUT, option, tmp_path / "no" / "file"))
    assert option in only_error(camsim("run", table, *CUT, option, tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_run_leaves_nothing_when_the_disk_is_full(table: Path, tmp_path: Path) -> None:
    """Stop at a size limit, as at a full disk: one line, status 2, no file under any name."""
    done = subprocess.run(
        [CAMSIM, "run", table, *CUT, "--trace", tmp_path / "t.csv"],
        capture_output=True, text=True, check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)),
    )  # fmt: skip
    assert "t.csv" in only_error(done)
    assert list(tmp_path.iterdir()) == []


def test_every_parameter_is_there(table: Path, tmp_path: Path) -> None:
    """After the tick rate, in the order of the list, with the values that were set."""
    machine = tmp_path / "m.toml"
    machine.write_text("[machine]\ntick_hz = 25000\n[controller]\nk1_ns = 700000\n", "ascii")
    done = camsim("params", table, "--machine", machine, "--set", "lead_ns=5000")
    assert done.returncode == 0, done.stderr
    header, *rows = done.stdout.splitlines()
    found = dict(row.split(",") for row in rows)
    assert header == "name,value"
    assert list(found) == ["tick_hz", "planned_turns", "planned_s", *NUMBERS["parameter"]]
    # 62 mm at 0.1 mm, and half of the feed's ramp of 30 turns at each end.
    assert found["planned_turns"] == "680"
    assert (found["tick_hz"], found["k1_ns"], found["lead_ns"]) == ("25000", "700000", "5000")
    assert "k1_ns = -1: out of range" in only_error(camsim("params", table, "--set", "k1_ns=-1"))


def test_retired_parameters_are_ignored_with_one_line(table: Path, tmp_path: Path) -> None:
    """A machine file of an older version still gives its other parameters."""
    machine = tmp_path / "old.toml"
    machine.write_text("[controller]\nswitch_1_per_turn = 2\nk1_ns = 700000\n", "ascii")
    done = camsim("params", table, "--machine", machine, "--set", "switch_8_sense=1")
    assert done.returncode == 0, done.stderr
    assert "k1_ns,700000\n" in done.stdout
    assert [line for line in done.stderr.splitlines() if "retired" in line] == [
        "camsim: --set: switch_8_sense: retired and ignored"
    ]


@pytest.mark.parametrize("mass_kg", [0.2, 10, 40])
def test_loop_of_any_slide_fits_the_controller(table: Path, tmp_path: Path, mass_kg: float) -> None:
    """The loop that follows from a force drive, however heavy, is accepted."""
    machine = tmp_path / "m.toml"
    drive = f'[u]\nkind = "force"\nmass_kg = {mass_kg}\ndelay_us = 5\namplifier_hz = 3000\n'
    limits = "acceleration_mm_per_s2 = 50000\nforce_limit_n = 3000\n"
    machine.write_text(drive + limits, "ascii")
    done = camsim("run", table, "--machine", machine, "--feed", "1", "--turns-limit", "1")
    assert "refused" not in done.stderr
    assert done.returncode == 0, done.stderr


def test_eval_is_within_1_nm_of_exact_geometry(table: Path, geometry: Geometry) -> None:
    """Judge the firmware's u and x on random points of the whole skirt, many turns out."""
    rng = np.random.default_rng(240)
    turn, z_mm = rng.uniform(-50, 50, 20_000), rng.uniform(0, 62, 20_000)
    got = file_evaluated(table, turn, z_mm)
    assert list(got) == COLUMNS.split(",")
    exact = geometry.delta(2 * np.pi * (turn - np.floor(turn)), z_mm)
    assert np.abs(got["u_nm"] - exact.delta * NM_PER_MM).max() <= 1.0
    assert np.abs(got["x_nm"] - geometry.radius_mm(z_mm) * NM_PER_MM).max() <= 1.0
    for column, derivative in (("u1_nm_per_rad", exact.d1), ("u2_nm_per_rad2", exact.d2)):
        off = np.abs(got[column] - derivative * NM_PER_MM).max()
        assert off <= 1e-3 * np.abs(derivative * NM_PER_MM).max()


def test_eval_wraps_and_flags_heights_outside(table: Path) -> None:
    """See the same value every turn, and clamped heights marked."""
    turn = np.array([0.1, 1.1, -0.9, 0.1, 0.1, 0.1, 0.1])
    got = file_evaluated(table, turn, np.array([30, 30, 30, -0.001, 0, 62, 62.001]))
    u_nm = got["u_nm"]
    assert u_nm[1:3] == pytest.approx(u_nm[0], abs=1e-2)
    assert got["clamped"].tolist() == [0, 0, 0, 1, 0, 0, 1]
    assert (u_nm[3], u_nm[6]) == (u_nm[4], u_nm[5])
    assert np.all(got["speed_ratio"] == 1), "no speed channel"


@pytest.mark.parametrize(
    ("points", "place"),
    [
        ("", "empty"),
        ("z_mm,turn\n0,1\n", "line 1"),
        (f"{HEADER}\n0,20\n0.1\n", "line 3"),
        (f"{HEADER}\n0,20,7\n", "line 2"),
        (f"{HEADER}\nabc,20\n", "line 2"),
        (f"{HEADER}\n0,nan\n", "line 2"),
        (f"{HEADER}\ninf,20\n", "line 2"),
    ],
)
def test_eval_refuses_malformed_points(table: Path, points: str, place: str) -> None:
    """Name the line of a malformed point and leave with status 2."""
    assert place in only_error(camsim("eval", table, stdin=points))
