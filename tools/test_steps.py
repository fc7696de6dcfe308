# SPDX-License-Identifier: Apache-2.0
"""The steps of tools/test: run each, go on after a failure, add everything up.

A gate (a build, a formatter, a linter) counts as one test; ctest and pytest tell their own
numbers in JUnit files.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build"
PYTHON = sys.executable
PYPROJECT = "tools/pyproject.toml"
C_FOLDERS = ("firmware", "hal", "host_sim", "tests")
PYTEST_PATHS = ("tests/tools", "tests/scenarios")
PIL_PATHS = ("tests/pil",)
# What drives the simulator, once more under the sanitizers.
SIMULATOR_PATHS = (
    "tests/scenarios",
    "tests/tools/test_camsim_run.py",
    "tests/tools/test_camsim_eval.py",
)
# The flashable image in an emulator, compared with a program of the host build.
IMAGE_PATHS = ("tests/stm32",)
# The port for Linux on a real kernel.
LINUX_PATHS = (
    "tests/linux/test_uml.py",
    "tests/linux/test_linux_start.py",
    "tests/linux/test_linux.py",
)
N_JOBS = "2"
# A process per core; all tests of a file in one process, since they share what is costly to make.
# A crash is told and ends that process for good. What judges the clock is marked and comes
# afterwards by itself.
PARALLEL = ("-n", N_JOBS, "--dist", "loadfile", "--max-worker-restart=0")
NOT_ALONE, ALONE = ("-m", "not alone"), ("-m", "alone")
STEP_LIMIT_S = 900  # ten times what the longest takes; a step that hangs is a failure
KILL_AFTER_S = 10
MIN_LINE_PERCENT = "95"
MIN_BRANCH_PERCENT = "90"


@dataclass
class Tally:
    """Counts over all runners, and the names of the steps that failed."""

    passed: int = 0
    failed: int = 0
    skipped: int = 0
    failed_steps: list[str] = field(default_factory=list)

    def summary(self) -> str:
        """Return the last line that tools/test prints."""
        line = f"{self.passed} passed, {self.failed} failed"
        return line + f", {self.skipped} skipped" if self.skipped else line

    def fail(self, step: str, count: int = 1) -> None:
        """Count failures of one step."""
        self.failed += count
        self.failed_steps.append(step)

    def add_junit(self, step: str, report: Path, status: int) -> None:
        """Add the counts of a JUnit file; a runner that broke down counts as one failure."""
        try:
            suites = list(ElementTree.parse(report).getroot().iter("testsuite"))
        except (OSError, ElementTree.ParseError):
            self.fail(step)
            return

        def total(*names: str) -> int:
            return sum(int(suite.get(name, "0")) for suite in suites for name in names)

        failed, skipped = total("failures", "errors"), total("skipped", "disabled")
        self.passed += total("tests") - failed - skipped
        self.skipped += skipped
        if failed or status:
            self.fail(step, max(failed, 1))


def wait(process: subprocess.Popen[bytes], limit_s: float) -> int:
    """Return a step's exit status, 124 when it took too long; nothing that it started goes on."""
    try:
        return process.wait(limit_s)
    except subprocess.TimeoutExpired:
        print(f"not done after {limit_s:g} s: stopped", flush=True)
        return 124
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGTERM)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(KILL_AFTER_S)
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def run(step: str, command: Iterable[str | Path], limit_s: float = STEP_LIMIT_S) -> int:
    """Run one step from the root of the repository; its output passes through."""
    print(f"--- {step}", flush=True)
    start_s = time.monotonic()
    try:
        # One stream, so that messages stand where they belong; a group, so that all can be stopped.
        process = subprocess.Popen(
            [str(word) for word in command],
            cwd=ROOT,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        status = wait(process, limit_s)
    except OSError as err:
        print(err)
        status = 127
    verdict = "ok" if status == 0 else f"FAILED (exit status {status})"
    print(f"--- {step}: {verdict}, {time.monotonic() - start_s:.1f} s\n", flush=True)
    return status


def gate(tally: Tally, step: str, *command: str | Path) -> bool:
    """Run a step that counts as one test; tell whether it passed."""
    if run(step, command) == 0:
        tally.passed += 1
        return True
    tally.fail(step)
    return False


def build(tally: Tally, preset: str) -> bool:
    """Build a preset by the function that tools/run uses too."""
    script = 'set -euo pipefail; source "$1/tools/setup.sh"; camturn_build "$2"'
    return gate(tally, f"build {preset}", "bash", "-c", script, "bash", ROOT, preset)


def build_and_ctest(tally: Tally, preset: str) -> bool:
    """Build a preset and run its C tests; tell whether the build passed."""
    if not build(tally, preset):
        return False
    report = BUILD / preset / "ctest.xml"
    report.unlink(missing_ok=True)
    step = f"ctest {preset}"
    status = run(step, ["ctest", "--preset", preset, "-j", N_JOBS, "--output-junit", report])
    tally.add_junit(step, report, status)
    return True


def pytest(tally: Tally, preset: str, paths: Iterable[str], *options: str) -> None:
    """Run tests in Python against the simulator of a preset."""
    step = f"pytest {preset}"
    report = BUILD / preset / "pytest.xml"
    report.unlink(missing_ok=True)
    os.environ["CAMTURN_BUILD"] = str(BUILD / preset)
    command = [PYTHON, "-m", "pytest", "-c", PYPROJECT, f"--rootdir={ROOT}", "-q", *options]
    tally.add_junit(step, report, run(step, [*command, f"--junitxml={report}", *paths]))


def source_checks(tally: Tally) -> None:
    """Check formatting, lint and types: what needs no build."""
    sources = sorted(p for f in C_FOLDERS for p in (ROOT / f).rglob("*.[ch]"))
    gate(tally, "clang-format", "clang-format-14", "--dry-run", "--Werror", *sources)
    ruff = (PYTHON, "-m", "ruff")
    gate(tally, "ruff format", *ruff, "format", "--check", "--config", PYPROJECT, "tools", "tests")
    gate(tally, "ruff check", *ruff, "check", "--config", PYPROJECT, "tools", "tests")
    gate(tally, "mypy", PYTHON, "-m", "mypy", "--config-file", PYPROJECT, "tools", "tests")
    gate(tally, "misra", ROOT / "tools" / "misra")


def coverage(tally: Tally) -> None:
    """Run the C tests with counters, and hold the firmware to its coverage."""
    for counters in (BUILD / "host-cov").rglob("*.gcda"):
        counters.unlink()  # of earlier runs
    if build_and_ctest(tally, "host-cov"):
        # main() never returns and runs on machines only.
        files = ("--filter", "firmware/", "--exclude", r"firmware/main\.c")
        gcovr = (PYTHON, "-m", "gcovr", "--root", ROOT, *files)
        limits = ("--fail-under-line", MIN_LINE_PERCENT, "--fail-under-branch", MIN_BRANCH_PERCENT)
        gate(tally, "coverage of firmware", *gcovr, *limits, "--print-summary", BUILD / "host-cov")


def clang_tidy(tally: Tally) -> None:
    """Analyse firmware, ports and simulator, with the compile commands of the clang build."""
    tidy = ("run-clang-tidy-14", "-quiet", "-j", N_JOBS, "-p", BUILD / "host-clang")
    gate(tally, "clang-tidy", *tidy, r"/(firmware|hal|host_sim)/.*\.c$")


def linux_port(tally: Tally) -> None:
    """Build the Linux port with the system's libgpiod and with version 2, analyse both, run it."""
    for preset in ("linux", "linux-gpiod2"):
        if build(tally, preset):
            # The compile commands are gcc's: clang does not know all of its optimisations.
            tidy = ("run-clang-tidy-14", "-quiet", "-j", N_JOBS, "-p", BUILD / preset)
            more = "-extra-arg=-Wno-ignored-optimization-argument"
            gate(tally, f"clang-tidy {preset}", *tidy, more, r"/hal/linux/.*\.c$")
    pytest(tally, "host", LINUX_PATHS)


def main() -> int:
    """Run all steps, or with --fast the quick ones; return the exit status."""
    tally = Tally()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # stops the step, too
    start_s = time.monotonic()
    os.environ.setdefault("CTEST_OUTPUT_ON_FAILURE", "1")
    fast = "--fast" in sys.argv[1:]

    if not fast:
        source_checks(tally)
    build_and_ctest(tally, "host")
    pytest(tally, "host", PYTEST_PATHS, *PARALLEL, *NOT_ALONE)
    pytest(tally, "host", PYTEST_PATHS, *ALONE)
    if not fast:
        if build_and_ctest(tally, "host-clang"):
            clang_tidy(tally)
        if build_and_ctest(tally, "host-asan"):
            pytest(tally, "host-asan", SIMULATOR_PATHS, *PARALLEL)
        linux_port(tally)
        coverage(tally)
        for board in ("mcu-qemu", "mcu-qemu-m4"):
            if build_and_ctest(tally, board):
                same = (PYTHON, "-m", "camtools.same_bytes", board, "test_budget")
                gate(tally, f"same bytes {board}", *same)
        gate(tally, "cycles", PYTHON, "-m", "camtools.cycles", BUILD)
        if build(tally, "mcu-stm32h743"):
            pytest(tally, "host", IMAGE_PATHS, *PARALLEL)
        pytest(tally, "host", PIL_PATHS)  # the simulator of the host, the images of both boards

    for step in tally.failed_steps:
        print(f"failed: {step}")
    print(f"{time.monotonic() - start_s:.0f} s")
    print(tally.summary(), flush=True)
    return 1 if tally.failed else 0


if __name__ == "__main__":
    sys.exit(main())
