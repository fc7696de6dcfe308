"""The command line tools/run: results complete or not at all, exit status, one line per error."""

import json
import os
import re
import shutil
import signal
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from camtools.cli.run import main
from camtools.part.common import MachineLimits
from camtools.pipeline.job import without_faults
from camtools.pipeline.load import load
from camtools.pipeline.run import traced_turns, variant_of
from camtools.sim.machine_file import machine_bytes, machine_text
from camtools.sim.results import read_surface, read_trace
from camtools.sim.table_file import Numbers, ParquetFile
from tests.tools.cases.camsim_cases import BUILD
from tests.tools.cases.command_cases import command, job_of
from tests.tools.cases.page_cases import PageReader, map_of
from tests.tools.cases.part_cases import PERKINS, ROOT, Capture, Command, listing, refused, sure

DRAWN = (
    *("compare", "learning", "profiles", "sequence"),
    *(f"sheet{number}" for number in range(1, 6)),
)
RESULTS = [
    *(f"cut_{key}.png" for key in DRAWN),
    *(f"perkins240{end}" for end in (".camtab", ".json", "_machine.toml", "_table.c", "_table.h")),
    *("report.html", "sections.csv", "sheets.json", "summary.json", "surface.csv", "trace.parquet"),
]


def complaints(stderr: str) -> list[str]:
    """Return stderr without the lines that tell what is going on."""
    steps = re.compile(
        r"run: (making the table of|cutting (about )?[\d.e+]+ turns|drawing the report|\S+ holds)"
    )
    return [line for line in stderr.splitlines() if not steps.match(line)]


class Cut(NamedTuple):
    """A part whose drawing states a roundness, cut at 2 mm per turn."""

    folder: Path
    said: subprocess.CompletedProcess[str]


@pytest.fixture(scope="module")
def cut(tmp_path_factory: pytest.TempPathFactory) -> Cut:
    """Cut in this process, without pictures, and keep the traces as CSV, too."""
    folder = tmp_path_factory.mktemp("run")
    text = f"{PERKINS.read_text()}\n[tolerances]\nroundness_um = 1.0\n"
    (folder / "my part.toml").write_text(text)
    words = ("my part.toml", "--feed", "2", "--csv", "-o", "ein Ordner für Kolben")
    done = command("camtools.cli.run", *words, cwd=folder, draws=False)
    assert done.returncode == 0, done.stderr
    return Cut(folder / "ein Ordner für Kolben", done)


def test_cut_is_within_a_micrometre(cut: Cut) -> None:
    """The Perkins skirt at 2500 r/min gives all results, a table on stdout, and status 0."""
    folder, done = cut
    assert complaints(done.stderr) == []
    assert listing(folder) == sorted([*RESULTS, "trace.csv"])
    assert done.stdout.startswith("perkins240: within tolerance\n")
    for words in ("accurate to 0.", "if U were 5 % slower", "on, "):
        assert words in done.stdout
    assert "cutting 62 turns, " in done.stderr, "with the ramp of the feed"
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["is_good"] and not summary["sheets_out_of_tolerance"]
    assert summary["form_error_um"]["max"] < 1
    assert summary["table_error_nm"]["u"] <= 1
    assert summary["cut"]["spindle_rpm"] == 2500
    assert summary["feasibility"]["u_speed_mm_s"]["limit"] == 400
    complete, *worse = summary["comparison"]
    assert complete["max_um"] == pytest.approx(summary["form_error_um"]["max"], rel=0.1)
    assert worse[-1]["max_um"] > 25
    trace, surface = (read_trace(folder / "trace.parquet"), read_surface(folder / "surface.csv"))
    assert len((folder / "trace.csv").read_text().splitlines()) == trace.t_s.size + 1
    assert summary["trace"] == {
        "file": "trace.parquet",
        "ticks": trace.t_s.size,
        "is_complete": True,
    }
    largest_um = float(np.abs(surface.error_um).max())
    assert largest_um < 1
    page = PageReader((folder / "report.html").read_text("utf-8"))
    held = map_of(page.data("part-data"))
    assert np.nanmax(np.abs(held.error_um)) == pytest.approx(largest_um, rel=1e-12)
    assert largest_um == pytest.approx(summary["form_error_um"]["max"], rel=1e-3)


def test_script_runs_from_anywhere(tmp_path: Path) -> None:
    """Through a symbolic link, both with spaces, up to the simulator, which refuses a speed."""
    if BUILD != ROOT / "build" / "host":
        pytest.skip("the script builds build/host")
    (tmp_path / "my run").symlink_to(ROOT / "tools" / "run")
    shutil.copy(PERKINS, tmp_path / "my part.toml")
    words = ["./my run", "my part.toml", "-o", "my out", "--rpm", "4000"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("run: --rpm 4000: ")
    assert "give at most --rpm 3000" in done.stderr
    assert listing(tmp_path) == ["my part.toml", "my run"]


def test_fault_gives_a_report_and_status_1(run: Command, tmp_path: Path) -> None:
    """An emergency stop in the cut is told by camsim's line, by the table and by the report."""
    done = run("--feed", "2", "-o", "out", "--", "--inject", "estop@0.3", draws=False)
    assert done.returncode == 1
    assert [line for line in complaints(done.stderr) if "fault estop" in line]
    assert done.stdout.startswith("perkins240: fault: estop\n")
    assert "FAULT: ESTOP" in (tmp_path / "out" / "report.html").read_text()
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["faults"] == ["estop"]


def test_incomplete_part_is_status_1(run: Command, tmp_path: Path) -> None:
    """What was cut is within tolerance, but a part is good only when all of it was cut."""
    done = run("--feed", "2", "-o", "out", "--", "--turns-limit", "10", draws=False)
    assert done.returncode == 1
    assert done.stdout.startswith("perkins240: incomplete: stopped\n")
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["is_good"] is False
    report = (tmp_path / "out" / "report.html").read_text()
    assert re.search(r"1\d of \d\d turns were cut\. So far the largest form error", report)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--rpm", "0"], "--rpm 0: must be a finite number above 0; give r/min"),
        (["--rpm=-5"], "--rpm -5: must be"),
        (["--rpm", "nan"], "--rpm nan: must be"),
        (["--rpm", "inf"], "--rpm inf: must be"),
        (["--rpm", "fast"], "--rpm fast: must be"),
        (["--rpm", ""], "--rpm : must be"),
        (["--rpm", "1e9"], "--rpm 1000000000.0: out of range"),
        (["--rpm", "4000"], "give at most --rpm 3000"),
        (["--feed", "0"], "--feed 0: must be a finite number above 0; give mm per turn"),
        (["--feed", "500"], "--feed 500: must be at most 10 mm, the limit of the firmware; give"),
        (["-o", ""], "-o: an empty path"),
        (["-o", "older"], "older: cannot write: File exists"),
        (["-o", "older/below"], "older/below: cannot write: Not a directory"),
        (["-o", "/proc/none"], "/proc/none: cannot write"),
        (["-o", "x" * 300], "cannot write: File name too long"),
        (["missing.toml"], "missing.toml: cannot be read: No such file"),
        (["older"], "older: not TOML"),
        (["--colour"], "--colour"),
        (["a.toml", "b.toml"], "unrecognized arguments: b.toml"),
        (["--", "--trace", "t.csv"], "-- --trace: is set by tools/run itself"),
        (["--", "--inject", "flood@1"], "--inject flood@1: no such kind"),
        (["--", "--machine", "missing.toml"], "missing.toml: cannot be opened"),
        (["--keep", "2"], "run: --keep: applies only to build/run; leave out -o or --keep\n"),
    ],
)
def test_wrong_usage_is_told(run: Command, tmp_path: Path, words: list[str], named: str) -> None:
    """Bad input gives exit status 2, one line that names it, and no file."""
    (tmp_path / "older").write_text("older, not a folder\n")
    output = [] if "-o" in words else ["-o", "out"]
    done = run(*output, *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert len(complaints(done.stderr)) == 1
    assert named in done.stderr
    assert listing(tmp_path) == ["older"]


@pytest.mark.parametrize("kind", ["piston", "cam"])
def test_feed_beyond_the_part_is_refused_first(kind: str, tmp_path: Path, capfd: Capture) -> None:
    """One line tells the largest feed that would do; no table is made before."""
    name, heights, shorter = {
        "piston": ("perkins240", "[0, 10, 20, 30, 40, 50, 62]", "[0, 1, 2, 3, 4, 6, 8]"),
        "cam": ("cam-345", "[0, 12]", "[4, 12]"),
    }[kind]
    path = tmp_path / "low.toml"
    text = PERKINS.with_name(f"{name}.toml").read_text()
    path.write_text(text.replace(heights, shorter))
    part = load(path).part
    job_of("--feed", "8").check_feed(part)
    job_of().check_feed(part)
    for feed in ("8.000001", "20"):
        told = f"--feed {feed}: must be at most 8 mm, the height of the part; give at most --feed 8"
        job = job_of("--feed", feed)
        assert refused(lambda: job.check_feed(part)) == told  # noqa: B023
    assert main([str(path), "--feed", "20", "-o", str(tmp_path / "out")]) == 2
    assert capfd.readouterr().err == f"run: {told}\n"  # nothing of a table that is made
    assert listing(tmp_path) == ["low.toml"]


def test_limits_of_the_part_become_the_machine() -> None:
    """The machine file carries the part's limits, within the simulator's ranges."""
    text = machine_text(
        MachineLimits(u_stroke_mm=0.9, u_speed_mm_s=350.5, u_acceleration_mm_s2=1e9)
    )
    assert "stroke_mm = 0.9\n" in text
    assert "speed_mm_per_s = 350.5\n" in text
    assert "acceleration_mm_per_s2 = 10000000.0\n" in text
    assert "limit_rpm = 3000.0\n" in text


def test_long_cuts_are_traced_in_part() -> None:
    """Up to 500 000 ticks all are traced; slow spindles get fewer turns."""
    assert traced_turns(620, 2500) is None
    assert traced_turns(62_000, 2500) == 200
    assert traced_turns(620, 6) == pytest.approx(1.25)


def test_job_takes_options_apart() -> None:
    """What follows -- goes to camsim; files keep their place, faults can be left out."""
    job = job_of("x.toml", "--rpm", "600", "--", "--inject", "estop@1", "--seed", "3")
    assert (job.part, job.rpm, job.feed) == (Path("x.toml"), 600.0, None)
    assert job.extra == ("--inject", "estop@1", "--seed", "3")
    assert without_faults(job.extra) == ["--seed", "3"]
    assert without_faults(["--inject=estop@1", "--seed", "3"]) == ["--seed", "3"]
    assert job_of("--", "--machine", os.path.relpath(PERKINS)).extra[1] == str(PERKINS)


def test_comparison_tells_a_cut_that_ended_early() -> None:
    """A variant that faulted is named so, one that cut nothing is left out."""
    form = {"max": 3.0, "rms": 1.0}
    early = variant_of("x", {"end": "fault", "form_error_um": form})
    assert sure(early).name == "x (ended early: fault)"
    nothing = {"max": None, "rms": None}
    assert variant_of("x", {"end": "fault", "form_error_um": nothing}) is None


@pytest.mark.long
def test_report_shows_what_a_machine_learns(run: Command, tmp_path: Path) -> None:
    """The report of the machine `real` says what was learned, draws it, and what it is worth."""
    done = run("--machine", "real", "--feed", "1", "-o", "out", draws=False)
    assert done.returncode in (0, 1), done.stderr
    assert "\n  learning  " in done.stdout and " on, " in done.stdout
    assert (tmp_path / "out" / "cut_learning.png").exists()
    assert "Error of each turn" in (tmp_path / "out" / "report.html").read_text("utf-8")
    kept = (tmp_path / "out" / "perkins240_machine.toml").read_bytes()
    assert kept == machine_bytes("real")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    um, states = summary["error_per_turn_um"], summary["error_per_turn"]["state"]
    assert states.count("rehearsing") > 20 and states[-1] == "cutting"
    assert min(um[: states.count("rehearsing")]) < max(um[: states.count("rehearsing")]) / 10
    names = [one["name"] for one in summary["comparison"]]
    assert names[:2] == ["complete controller", "without learning"]
    assert summary["comparison"][1]["max_um"] > summary["comparison"][0]["max_um"]


def test_failed_run_leaves_earlier_results(run: Command, tmp_path: Path) -> None:
    """What an earlier run wrote stays as it was, byte for byte and nothing beside it."""
    for name in ("report.html", "summary.json", "notes.txt"):
        (tmp_path / name).write_text("older")
    assert run("--rpm", "4000", "-o", tmp_path).returncode == 2
    assert listing(tmp_path) == ["notes.txt", "report.html", "summary.json"]
    assert {path.read_text() for path in tmp_path.iterdir()} == {"older"}


def test_full_disk_leaves_nothing(run: Command, tmp_path: Path) -> None:
    """When the trace does not fit, nothing appears and the status is 2."""
    done = run("--feed", "2", "-o", "out", largest_file=200_000)
    assert (done.returncode, done.stdout) == (2, "")
    assert "File too large" in done.stderr
    assert listing(tmp_path) == []


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_run_leaves_nothing(
    number: signal.Signals, run: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A signal in the cut, when a part of the trace is written, removes stage and new folder."""
    written: list[int] = []

    def interrupt(file: ParquetFile, numbers: Numbers) -> None:
        write(file, numbers)
        written.append(len(numbers))
        os.kill(os.getpid(), number)

    write = ParquetFile.write
    monkeypatch.setattr(ParquetFile, "write", interrupt)
    done = run("--feed", "2", "-o", "out")
    assert written and written[0] > 0
    assert done.returncode == 128 + number
    assert done.stderr.endswith("run: interrupted; nothing was written\n")
    assert listing(tmp_path) == []


def test_stated_roundness_decides(run: Command, tmp_path: Path) -> None:
    """Beyond it the part is not good, in every place that tells, though its form error is."""
    part = tmp_path / "part.toml"
    part.write_text(f"{PERKINS.read_text()}\n[tolerances]\nroundness_um = 0.001\n")
    done = run(part, "--feed", "2", "-o", "out", draws=False)
    assert done.returncode == 1
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["form_error_um"]["max"] < 1
    assert not summary["is_good"] and summary["sheets_out_of_tolerance"]
    assert done.stdout.startswith("perkins240: out of tolerance")
    assert ": out of tolerance</title>" in (tmp_path / "out" / "report.html").read_text().lower()
