# SPDX-License-Identifier: Apache-2.0
"""Runs steps side by side, as far as their needs and the computer's cores allow.

A step is a command. Its output goes to a file and is shown when the step ends: the closing line
of a step that passed, all of it when the step failed. Steps wait for those that they need, a step
that uses all cores by itself for the others, and a step that judges the clock has the computer for
itself. Whatever ends a run, no process of a step goes on.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from xml.etree import ElementTree

STEP_LIMIT_S = 2400.0  # several times what the longest takes; a step that hangs is a failure
KILL_AFTER_S = 10.0  # between SIGTERM and SIGKILL
LOOK_S = 0.05  # between two looks at what runs
STILL_RUNNING_S = 30.0  # without news: what runs is said again
NO_COMMAND, OUT_OF_TIME = 127, 124
N_SLOWEST = 12
END_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@dataclass(frozen=True)
class Step:
    """A command that passes or fails.

    Attributes
    ----------
    needs : names of the steps that must have passed
    is_wide : uses all cores by itself, so that no other of that kind runs meanwhile
    is_alone : nothing else may run meanwhile
    report : JUnit file that the command writes and whose tests count; without one the step is
        one test
    closing : expression; the lines of the output that hold it are shown of a step that passed;
        without an expression the last line
    clears : files to be removed before, as a pattern in the folder of the run
    """

    name: str
    command: Sequence[str | Path]
    needs: tuple[str, ...] = ()
    is_wide: bool = False
    is_alone: bool = False
    report: Path | None = None
    closing: str | None = None
    clears: str = ""
    environment: Mapping[str, str] = field(default_factory=dict)
    limit_s: float = STEP_LIMIT_S


@dataclass
class Tally:
    """Counts over all steps, and the names of those that failed or could not be run."""

    passed: int = 0
    failed: int = 0
    skipped: int = 0
    failed_steps: list[str] = field(default_factory=list)
    not_run: list[str] = field(default_factory=list)

    def summary(self) -> str:
        """Return the last line that tools/test prints."""
        line = f"{self.passed} passed, {self.failed} failed"
        return line + f", {self.skipped} skipped" if self.skipped else line

    def add(self, step: Step, status: int) -> bool:
        """Count the end of a step; return whether it passed."""
        failed_before = self.failed
        if step.report is not None:
            self._add_junit(step.report, status)
        elif status == 0:
            self.passed += 1
        else:
            self.failed += 1
        if self.failed > failed_before:
            self.failed_steps.append(step.name)
        return self.failed == failed_before

    def _add_junit(self, report: Path, status: int) -> None:
        """Add the counts of a JUnit file; a runner that broke down counts as one failure."""
        try:
            suites = list(ElementTree.parse(report).getroot().iter("testsuite"))
        except (OSError, ElementTree.ParseError):
            self.failed += 1
            return

        def total(*names: str) -> int:
            return sum(int(suite.get(name, "0")) for suite in suites for name in names)

        failed, skipped = total("failures", "errors"), total("skipped", "disabled")
        self.passed += total("tests") - failed - skipped
        self.skipped += skipped
        self.failed += max(failed, 1) if status else failed


@dataclass
class Running:
    """A step's process, the first of a session of its own."""

    step: Step
    process: subprocess.Popen[bytes]
    log: Path
    start_s: float
    status: int | None = None
    cpu_s: float = 0.0
    is_late: bool = False

    def look(self) -> bool:
        """Return whether it has ended; take its status and the time that it used."""
        if self.status is None:
            pid, status, used = os.wait4(self.process.pid, os.WNOHANG)
            if pid:
                self.status = self.process.returncode = os.waitstatus_to_exitcode(status)
                self.cpu_s = used.ru_utime + used.ru_stime
        return self.status is not None


@dataclass
class Timing:
    """What a step took."""

    name: str
    wall_s: float
    cpu_s: float


def family(session: int) -> set[int]:
    """Return the processes of a session, and those that they started in sessions of their own."""
    children: dict[int, list[int]] = {}
    found: list[int] = []
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            state, parent, _, its_session = (
                (folder / "stat").read_text().rpartition(")")[2].split()[:4]
            )
            children.setdefault(int(parent), []).append(int(folder.name))
            if int(its_session) == session and state != "Z":
                found.append(int(folder.name))
    for pid in found:  # grows meanwhile
        found += [child for child in children.get(pid, []) if child not in found]
    return set(found)


def send(number: int, processes: Iterable[int]) -> None:
    """Send a signal to processes, some of which may have ended."""
    for pid in processes:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)


def have_ended(running: Sequence[Running]) -> bool:
    """Look at each; return whether none is left."""
    return sum(one.look() for one in running) == len(running)


def stop(running: Sequence[Running]) -> None:
    """End steps: SIGTERM, and what still runs after a while SIGKILL."""
    families = set().union(*(family(one.process.pid) for one in running))
    for one in running:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(one.process.pid, signal.SIGTERM)
    until_s = time.monotonic() + KILL_AFTER_S
    while not have_ended(running) and time.monotonic() < until_s:
        time.sleep(LOOK_S)
    # The first processes first, so that they say nothing of the others' end.
    send(signal.SIGKILL, [one.process.pid for one in running if not one.look()])
    send(signal.SIGKILL, families.union(*(family(one.process.pid) for one in running)))
    while not have_ended(running):
        time.sleep(LOOK_S)


def clock(s: float) -> str:
    """Return a time as minutes and seconds.

    >>> clock(133.4)
    '2:13'
    """
    return f"{int(s) // 60}:{int(s) % 60:02}"


def table(timings: Sequence[Timing], all_s: float) -> str:
    """Return the slowest steps, and the sum of all."""
    slowest = sorted(timings, key=lambda one: -one.wall_s)[:N_SLOWEST]
    total = Timing(f"all {len(timings)} steps", all_s, sum(one.cpu_s for one in timings))
    rows = [f"{one.name:<32}{one.wall_s:>10.1f}{one.cpu_s:>10.1f}" for one in (*slowest, total)]
    return "\n".join([f"{'slowest steps':<32}{'time [s]':>10}{'CPU [s]':>10}", *rows])


class Runner:
    """Runs steps in the order in which they stand, several at a time.

    Parameters
    ----------
    steps : what each needs stands before it
    root : where the commands run
    logs : folder for the output of each
    n_cores : how many steps of one core run side by side
    say : gets the progress, a line or more at a time
    """

    def __init__(
        self,
        steps: Sequence[Step],
        root: Path,
        logs: Path,
        n_cores: int,
        say: Callable[[str], None] = lambda text: print(text, flush=True),
    ) -> None:
        self._steps, self._root, self._logs, self._n_cores = steps, root, logs, n_cores
        self._say = say
        self._waiting = list(steps)
        self._running: list[Running] = []
        self._passed: set[str] = set()
        self._start_s = self._news_s = time.monotonic()
        self._signal = 0
        self.tally = Tally()
        self.timings: list[Timing] = []
        known: set[str] = set()
        for step in steps:
            missing = set(step.needs) - known
            assert not missing and step.name not in known, f"{step.name}: {missing or 'twice'}"
            known.add(step.name)
        logs.mkdir(parents=True, exist_ok=True)

    def run(self) -> int:
        """Run all; return the exit status: 0, 1 after a failure, 128 + n after signal n."""
        before = {number: signal.signal(number, self._take_signal) for number in END_SIGNALS}
        try:
            while (self._waiting or self._running) and not self._signal:
                self._begin()
                time.sleep(LOOK_S)
                self._look()
            self._say_result()
        finally:
            stop(self._running)
            for number, handler in before.items():
                signal.signal(number, handler)
        if self._signal:
            return 128 + self._signal
        return 1 if self.tally.failed else 0

    def _take_signal(self, number: int, _frame: FrameType | None) -> None:
        self._signal = number

    def _say_now(self, text: str) -> None:
        self._news_s = time.monotonic()
        self._say(f"[{clock(self._news_s - self._start_s)}] {text}")

    def _fits(self, step: Step) -> bool:
        """Return whether there is room for a step.

        As many steps run as there are cores, at most one of them wide: what it leaves of the cores
        when it links or waits is used by the others.
        """
        others = [one.step for one in self._running]
        if step.is_alone or any(other.is_alone for other in others):
            return not others
        if step.is_wide and any(other.is_wide for other in others):
            return False
        return len(others) < self._n_cores

    def _begin(self) -> None:
        """Begin whatever can begin."""
        for step in list(self._waiting):
            lacking = set(step.needs) - self._passed
            if not lacking and self._fits(step):
                self._waiting.remove(step)
                self._start(step)
            elif lacking & {*self.tally.failed_steps, *self.tally.not_run}:
                self._waiting.remove(step)
                self.tally.not_run.append(step.name)
                self.tally.skipped += 1
                self._say_now(f"{step.name}: not run, it needs {', '.join(sorted(lacking))}")

    def _start(self, step: Step) -> None:
        n = len(self._steps) - len(self._waiting)
        self._say_now(f"step {n} of {len(self._steps)}: {step.name}")
        for file in [*self._root.glob(step.clears)] if step.clears else []:
            file.unlink()
        if step.report is not None:
            step.report.parent.mkdir(parents=True, exist_ok=True)
            step.report.unlink(missing_ok=True)
        log = self._logs / (re.sub(r"\W+", "-", step.name) + ".log")
        words = [str(word) for word in step.command]
        with log.open("wb") as output:
            try:
                # One stream, so that messages stand where they belong; a session of its own, so
                # that all of it can be stopped.
                process = subprocess.Popen(
                    words,
                    cwd=self._root,
                    env=os.environ | step.environment,
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
            except OSError as err:
                output.write(f"{err}\n".encode())
                output.flush()
                self._end(step, NO_COMMAND, log, Timing(step.name, 0.0, 0.0))
                return
        self._running.append(Running(step, process, log, time.monotonic()))

    def _look(self) -> None:
        """Take the ends of steps, stop those that take too long."""
        for one in list(self._running):
            wall_s = time.monotonic() - one.start_s
            if not one.look() and wall_s > one.step.limit_s:
                one.is_late = True
                stop([one])
            if one.status is None:
                continue
            send(signal.SIGKILL, family(one.process.pid))
            self._running.remove(one)
            status = one.status
            if one.is_late:
                status = OUT_OF_TIME
                with one.log.open("a") as log:
                    log.write(f"not done after {one.step.limit_s:g} s: stopped\n")
            self._end(one.step, status, one.log, Timing(one.step.name, wall_s, one.cpu_s))
        if time.monotonic() - self._news_s > STILL_RUNNING_S:
            self._say_now("still running: " + self._names_running())

    def _names_running(self) -> str:
        now_s = time.monotonic()
        return ", ".join(f"{one.step.name} ({clock(now_s - one.start_s)})" for one in self._running)

    def _end(self, step: Step, status: int, log: Path, timing: Timing) -> None:
        self.timings.append(timing)
        output = log.read_text(errors="replace").rstrip()
        took = f"{timing.wall_s:.1f} s"
        if self.tally.add(step, status):
            self._passed.add(step.name)
            lines = [line.strip() for line in output.splitlines() if line.strip()]
            if step.closing is None:
                lines = lines[-1:]
            else:
                lines = [line for line in lines if re.search(step.closing, line)]
            said = "; ".join(lines)
            self._say_now(f"{step.name}: ok, {took}" + (f": {said}" if said else ""))
        else:
            self._say(f"--- output of {step.name}\n{output}\n--- end of output of {step.name}")
            self._say_now(f"{step.name}: FAILED (exit status {status}), {took}")

    def _say_result(self) -> None:
        """Tell what failed, what was slow, and the counts; or that the run was broken off."""
        if self._signal:
            name = signal.Signals(self._signal).name
            self._say_now(f"{name}: stopping {self._names_running() or 'nothing'}")
            return
        all_s = time.monotonic() - self._start_s
        lines = [f"failed: {name}" for name in self.tally.failed_steps]
        lines += [f"not run: {name}" for name in self.tally.not_run]
        self._say("\n".join(["", table(self.timings, all_s), *lines, self.tally.summary()]))
