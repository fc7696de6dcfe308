# SPDX-License-Identifier: Apache-2.0
"""The runner of all tests: what it counts, says and stops, and in which order steps run."""

from __future__ import annotations

import re
import shlex
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import step_runner
import test_steps
from step_runner import Runner, Step, Timing

PASSED_AND_SKIPPED = '<testsuite tests="5" failures="0" errors="0" skipped="2"/>'
ONE_FAILED = '<testsuite tests="5" failures="1" errors="0" skipped="0"/>'


def is_running(pid: int) -> bool:
    """Return whether a process is there and no zombie."""
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False


def is_gone_soon(pid: int) -> bool:
    """Return whether a process that was sent a signal ends."""
    end_s = time.monotonic() + 10.0
    while is_running(pid) and time.monotonic() < end_s:
        time.sleep(0.02)
    return not is_running(pid)


def shell(name: str, script: str, *needs: str, **more: object) -> Step:
    """Return a step that is a script."""
    return Step(name, ["bash", "-c", script], needs, **more)  # type: ignore[arg-type]


class Said:
    """What a runner said, and the runner."""

    def __init__(self, folder: Path, steps: list[Step], n_cores: int = 2) -> None:
        self.lines: list[str] = []
        self.runner = Runner(steps, folder, folder / "logs", n_cores, self._take)

    def _take(self, text: str) -> None:
        self.lines += text.split("\n")

    def text(self) -> str:
        """Return all of it."""
        return "\n".join(self.lines)


Run = Callable[..., Said]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Return a function that runs steps in a folder of the test and expects an exit status."""

    def all_of(*steps: Step, status: int, n_cores: int = 2) -> Said:
        said = Said(tmp_path, list(steps), n_cores)
        assert said.runner.run() == status
        return said

    return all_of


def test_status_of_a_step_is_told(run: Run) -> None:
    """The command's own, and 127 where there is no command; each gate is one test."""
    said = run(
        shell("good", "true"), shell("bad", "exit 3"), Step("none", ["/no/such/command"]), status=1
    )
    text = said.text()
    assert "good: ok" in text and "bad: FAILED (exit status 3)" in text
    assert "none: FAILED (exit status 127)" in text and "/no/such/command" in text
    assert {"failed: bad", "failed: none"} == set(said.lines[-3:-1])
    assert said.lines[-1] == "1 passed, 2 failed"


def test_progress_tells_step_time_and_verdict(run: Run) -> None:
    """Step n of m when it begins, its time and closing line when it ends."""
    said = run(
        shell("first", "echo begun; echo 12 tests passed; echo"),
        shell("second", "echo lines: 99.1%; echo branches: 95.0%; echo done", closing="%"),
        status=0,
        n_cores=1,
    )
    assert said.lines[0] == "[0:00] step 1 of 2: first"
    assert re.fullmatch(r"\[0:00\] first: ok, 0\.\d s: 12 tests passed", said.lines[1])
    assert said.lines[2] == "[0:00] step 2 of 2: second"
    assert re.fullmatch(r".* second: ok, 0\.\d s: lines: 99\.1%; branches: 95\.0%", said.lines[3])
    assert said.lines[-1] == "2 passed, 0 failed"


def test_outputs_of_steps_side_by_side_are_not_mixed(run: Run) -> None:
    """All of a failed step's output stands together; of one that passed only the closing line."""
    write = "for i in 1 2 3 4; do echo {0} $i; sleep 0.05; done; {1}"
    said = run(
        shell("a", write.format("a", "false")),
        shell("b", write.format("b", "false")),
        shell("c", write.format("c", "true")),
        status=1,
        n_cores=3,
    )
    for name in "ab":
        at = said.lines.index(f"--- output of {name}")
        assert said.lines[at + 1 : at + 5] == [f"{name} {i}" for i in range(1, 5)]
        assert said.lines[at + 5] == f"--- end of output of {name}"
    assert "c 1" not in said.lines
    assert sum(line.endswith(": c 4") for line in said.lines) == 1


def test_step_that_needs_a_failed_one_is_not_run(run: Run, tmp_path: Path) -> None:
    """Nor what needs that; they count as skipped, and others go on."""
    said = run(
        shell("build", "false"),
        shell("tests", "touch tests", "build"),
        shell("report", "touch report", "tests"),
        shell("other", "touch other"),
        status=1,
    )
    assert [p.name for p in sorted(tmp_path.iterdir()) if p.is_file()] == ["other"]
    assert "tests: not run, it needs build" in said.text()
    assert {"not run: tests", "not run: report"} <= set(said.lines)
    assert said.lines[-1] == "1 passed, 1 failed, 2 skipped"


def test_step_that_needs_another_waits_for_it(run: Run, tmp_path: Path) -> None:
    """Although there is a core for it."""
    run(shell("one", "sleep 0.2; touch one"), shell("two", "test -e one", "one"), status=0)
    assert (tmp_path / "one").exists()


def beside(said: Said, name: str) -> set[str]:
    """Return the steps that ran while one ran, by what the runner said."""
    runs: set[str] = set()
    met: set[str] = set()
    for line in said.lines:
        begun = re.fullmatch(r"\[.*\] step \d+ of \d+: (\w+)", line)
        ended = re.match(r"\[.*\] (\w+): ok", line)
        if begun:
            runs.add(begun[1])
        elif ended:
            runs.remove(ended[1])
        if name in runs:
            met |= runs - {name}
    return met


def test_as_many_steps_run_as_there_are_cores(run: Run) -> None:
    """Of steps of one core; one core runs them one after the other."""
    steps = [shell(name, "sleep 0.2") for name in "abc"]
    said = run(*steps, status=0, n_cores=2)
    assert [line.split("] ")[1] for line in said.lines[:2]] == ["step 1 of 3: a", "step 2 of 3: b"]
    assert beside(said, "a") >= {"b"} and ": ok" in said.lines[2]
    said = run(*steps, status=0, n_cores=1)
    assert all(beside(said, name) == set() for name in "abc")


def test_only_one_wide_step_runs_at_a_time(run: Run) -> None:
    """Two that use all cores by themselves do not; one and a small one do."""
    wide = [shell(name, "sleep 0.2", is_wide=True) for name in "ab"]
    said = run(*wide, shell("c", "sleep 0.2"), status=0)
    assert "c" in beside(said, "a") and "b" not in beside(said, "a")


def test_step_that_judges_the_clock_runs_alone(run: Run) -> None:
    """Whatever else could run waits."""
    steps = [shell(name, "sleep 0.1", is_alone=name == "b") for name in "abcd"]
    said = run(*steps, status=0, n_cores=3)
    assert beside(said, "a") == {"c", "d"} and beside(said, "b") == set()


def test_reports_are_counted(run: Run, tmp_path: Path) -> None:
    """Tests of a JUnit file; one that cannot be read, or an old one, is one failure."""
    stale = tmp_path / "stale.xml"
    stale.write_text(PASSED_AND_SKIPPED)
    said = run(
        shell("few", f"echo '{PASSED_AND_SKIPPED}' >few.xml", report=tmp_path / "few.xml"),
        shell("one", f"echo '{ONE_FAILED}' >one.xml; exit 1", report=tmp_path / "one.xml"),
        shell("crash", f"echo '{PASSED_AND_SKIPPED}' >c.xml; exit 9", report=tmp_path / "c.xml"),
        shell("stale", "true", report=stale),
        shell("hides", f"echo '{ONE_FAILED}' >hides.xml", report=tmp_path / "hides.xml"),
        status=1,
        n_cores=1,
    )
    assert said.lines[-1] == "14 passed, 4 failed, 4 skipped"
    assert said.runner.tally.failed_steps == ["one", "crash", "stale", "hides"]


def test_old_files_are_cleared_and_the_environment_is_the_steps(run: Run, tmp_path: Path) -> None:
    """Counters of an earlier run do not count."""
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "old.gcda").touch()
    script = "! ls a/*.gcda && test $WHICH = this"
    run(
        shell("counts", script, clears="a/**/*.gcda", environment={"WHICH": "this"}),
        status=0,
    )


def test_step_that_hangs_is_stopped_with_its_children(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A failure, told; children are gone, of a session of their own too, and others go on."""
    script = (
        "trap '' TERM; sleep 600 & echo $! >pid; setsid sleep 600 & echo $! >far; "
        "echo begun; wait; sleep 600"
    )
    monkeypatch.setattr(step_runner, "KILL_AFTER_S", 0.5)
    said = run(
        shell("hangs", script, limit_s=1.0), shell("other", "sleep 0.1; echo fine"), status=1
    )
    assert "begun\nnot done after 1 s: stopped\n" in said.text()
    assert "hangs: FAILED (exit status 124)" in said.text()
    assert "other: ok" in said.text()
    assert said.lines[-1] == "1 passed, 1 failed"
    for name in ("pid", "far"):
        assert is_gone_soon(int((tmp_path / name).read_text())), name


def test_child_that_a_step_leaves_behind_is_stopped(run: Run, tmp_path: Path) -> None:
    """The step's verdict is its own."""
    run(shell("leaves", "sleep 600 >/dev/null & echo $! >pid"), status=0)
    assert is_gone_soon(int((tmp_path / "pid").read_text()))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signal_stops_all_steps(number: signal.Signals, tmp_path: Path) -> None:
    """Within a process of its own: exit status 128 + n, no counts, and no process is left."""
    program = f"""
import sys
from pathlib import Path
from step_runner import Runner, Step
folder = Path({str(tmp_path)!r})
steps = [Step(n, ["bash", "-c", f"sleep 600 & echo $! >{{n}}.new; mv {{n}}.new {{n}}.pid; wait"])
         for n in "abc"]
sys.exit(Runner(steps, folder, folder / "logs", 2).run())
"""
    process = subprocess.Popen(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=Path(test_steps.__file__).parent,
    )
    files = [tmp_path / "a.pid", tmp_path / "b.pid"]
    until_s = time.monotonic() + 20.0
    while not all(file.exists() for file in files) and time.monotonic() < until_s:
        time.sleep(0.02)
    process.send_signal(number)
    said, _ = process.communicate(timeout=20)
    assert process.returncode == 128 + number
    last = said.splitlines()[-1]
    assert re.fullmatch(rf"\[0:\d\d\] {number.name}: stopping a \(.*\), b \(.*\)", last), said
    for file in files:
        assert is_gone_soon(int(file.read_text()))
    assert not (tmp_path / "c.pid").exists()


def test_long_silence_is_broken(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """What still runs is said again."""
    monkeypatch.setattr(step_runner, "STILL_RUNNING_S", 0.1)
    said = run(shell("a", "sleep 0.5"), shell("b", "sleep 0.5"), status=0)
    assert "still running: a (0:00), b (0:00)" in said.text()


def test_slowest_steps_stand_in_a_table(run: Run) -> None:
    """In order of time, with the processor's time of all their processes."""
    burn = f"{shlex.quote(sys.executable)} -c 'import time\nwhile time.process_time() < 0.3: pass'"
    said = run(shell("quick", "true"), shell("burns", burn), shell("waits", "sleep 0.5"), status=0)
    used = {timing.name: timing for timing in said.runner.timings}
    assert used["burns"].cpu_s >= 0.3 > used["waits"].cpu_s
    assert used["waits"].wall_s >= 0.5
    rows = said.text().split("\n\n")[-1].splitlines()
    assert rows[0].split() == ["slowest", "steps", "time", "[s]", "CPU", "[s]"]
    assert {row.split()[0] for row in rows[1:4]} == {"waits", "burns", "quick"}
    assert rows[4].startswith("all 3 steps")
    many = [Timing(f"step {n}", float(n), 0.0) for n in range(40)]
    short = step_runner.table(many, 50.0).splitlines()
    assert len(short) == step_runner.N_SLOWEST + 2
    assert short[1].startswith("step 39")


def test_runner_gives_back_the_signal_handlers(run: Run) -> None:
    """A caller's Ctrl-C works as before."""
    before = signal.getsignal(signal.SIGINT)
    run(shell("good", "true"), status=0)
    assert signal.getsignal(signal.SIGINT) is before
    assert threading.current_thread() is threading.main_thread()


def test_list_of_steps_is_right(tmp_path: Path) -> None:
    """Needs stand before, names are single, the fast steps are among all, reports are apart."""
    fast, steps = test_steps.fast_steps(), test_steps.all_steps()
    for some in (fast, steps):
        Runner(some, tmp_path, tmp_path / "logs", 2)
    assert {step.name for step in fast} <= {step.name for step in steps}
    reports = [step.report for step in steps if step.report is not None]
    assert len(set(reports)) == len(reports)
    with pytest.raises(AssertionError, match="later"):
        Runner([shell("a", "true", "later"), shell("later", "true")], tmp_path, tmp_path, 2)
    with pytest.raises(AssertionError, match="twice"):
        Runner([shell("a", "true"), shell("a", "true")], tmp_path, tmp_path, 2)
