"""Lets CTest run the steps of tools/steps: run_steps.py LABEL [STEP...].

CTest reports which step begins or has ended, and what a failed one printed. Then this program
prints the slowest steps, the processor time of all, and how many tests passed: those that a step
counted in a JUnit file, and one for each other step. build/reports/LABEL.txt has that too, with the
last line that each step printed. When this program is stopped, it ends the processes of all steps.

No step has a limit of time. A step that neither computes nor prints for minutes hangs: then its
processes without children are ended, so that only the test fails that one of them runs.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from xml.etree import ElementTree

import psutil

from checks.patience import SLOWNESS, slowness
from checks.progress import Watch, tree, waits_for

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build"
REPORTS = BUILD / "reports"
N_CORES = min(len(os.sched_getaffinity(0)), 8)
STEPS_PER_CORE = 2  # of tools/verify, whose campaigns are the load of the step "busy"
N_SLOWEST = 12
UNKNOWN = 2  # exit status; CTest itself has 8 for failed steps
KILL_AFTER_S = 10.0  # between SIGTERM and SIGKILL
STALL_S = 300.0  # a pytest that works ends its hanging test before that
LOOK_S = 5.0
NO_LIMIT = "10000000"  # CTest's own limit of a test [s] cannot be switched off
PR_SET_CHILD_SUBREAPER = 36  # linux/prctl.h: orphans become children of this process
END_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def end_descendants() -> None:
    """End all processes below this one, and those that they begin meanwhile."""
    here, patience_s = psutil.Process(), KILL_AFTER_S
    while below := here.children(recursive=True):
        for process in below:
            with_signal = process.terminate if patience_s else process.kill
            try:
                with_signal()
            except psutil.NoSuchProcess:
                continue
        psutil.wait_procs(below, timeout=patience_s or 1.0)
        patience_s = 0.0


def end_hanging(ctest: int, watches: dict[int, Watch]) -> None:
    """End what hangs below CTest: of each step without progress the processes without children.

    Steps and watches are known by the numbers of their processes; watches are kept between calls.
    """
    steps = [process.pid for process in tree(ctest)[1:] if process.ppid() == ctest]
    for ended in watches.keys() - steps:
        del watches[ended]
    for pid in steps:
        watch = watches.setdefault(pid, Watch(pid, STALL_S))
        if watch.is_stalled():
            watch.restart()
            leaves = [process for process in tree(pid) if not process.children()]
            for leaf in leaves:
                print(f"hang: {waits_for(leaf)}; ended", flush=True)
                leaf.kill()


@contextlib.contextmanager
def without_hangs(ctest: int) -> Iterator[None]:
    """Look for hangs below CTest now and then."""
    is_over = threading.Event()

    def look() -> None:
        watches: dict[int, Watch] = {}
        while not is_over.wait(LOOK_S):
            with contextlib.suppress(psutil.NoSuchProcess):
                end_hanging(ctest, watches)

    thread = threading.Thread(target=look)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


def counts(report: Path) -> Counter[str]:
    """Return how many tests of a JUnit file passed, failed and were skipped."""
    suites = list(ElementTree.parse(report).getroot().iter("testsuite"))

    def total(*names: str) -> int:
        return sum(int(suite.get(name, "0")) for suite in suites for name in names)

    failed, skipped = total("failures", "errors"), total("skipped", "disabled")
    passed = total("tests") - failed - skipped
    return Counter(passed=passed, failed=failed, skipped=skipped)


def summary(steps: Path, reports: Path) -> tuple[list[str], int]:
    """Return the closing lines, and how many tests failed, from CTest's file of the steps.

    In the folder of reports the step "pytest linux kernel" has pytest-linux-kernel.xml.
    """
    cases = list(ElementTree.parse(steps).getroot().iter("testcase"))
    total, lines = Counter[str](), []
    for case in cases:
        name, status = case.get("name", ""), case.get("status")
        report = reports / (name.replace(" ", "-") + ".xml")
        if status not in ("run", "fail"):
            lines.append(f"not run: {name}")
            total["skipped"] += 1
            continue
        ran = counts(report) if report.exists() else Counter(passed=int(status == "run"))
        if status == "fail":
            ran["failed"] = max(ran["failed"], 1)
        if ran["failed"]:
            lines.append(f"failed: {name}")
        total += ran
    slowest = sorted(cases, key=lambda case: -float(case.get("time", "0")))[:N_SLOWEST]
    rows = [f"{case.get('name'):<32}{float(case.get('time', '0')):>10.1f}" for case in slowest]
    last = f"{total['passed']} passed, {total['failed']} failed"
    last += f", {total['skipped']} skipped" if total["skipped"] else ""
    return [f"{'slowest steps':<32}{'time [s]':>10}", *rows, *lines, last], total["failed"]


def results(steps: Path) -> list[str]:
    """Return a line for each step: its result, its time, and the last line that it printed."""
    lines = []
    for case in ElementTree.parse(steps).getroot().iter("testcase"):
        last = (case.findtext("system-out") or "").strip().rpartition("\n")[2]
        took_s = float(case.get("time", "0"))
        lines.append(f"{case.get('name'):<24}{case.get('status'):<8}{took_s:>8.1f} s  {last}")
    return lines


def steps_of(ctest: tuple[str | Path, ...], label: str) -> list[str]:
    """Return the names of the steps that have a label."""
    words = (*ctest, "-L", f"^{label}$", "--show-only=json-v1")
    listed = subprocess.check_output(words, text=True)
    return [step["name"] for step in json.loads(listed)["tests"]]


def run_ctest(label: str, names: list[str]) -> tuple[int, list[str]]:
    """Run the steps of a label, or some of them with what they need.

    Returns CTest's status, 2 when a step is unknown and nothing is run, and the names of the steps
    that only tools/verify runs.
    """
    folder = BUILD / "steps" / label
    folder.mkdir(parents=True, exist_ok=True)
    configure = ("cmake", "-S", ROOT / "tools" / "steps", "-B", folder, "--fresh")
    reports = REPORTS / label
    env = os.environ | {
        "CAMTURN_CORES": str(N_CORES),
        "CAMTURN_REPORTS": str(reports),
        SLOWNESS: f"{slowness():.2f}",
    }
    with (folder / "configure.log").open("w") as log:
        subprocess.run(configure, env=env, stdout=log, stderr=log, check=True)
    ctest: tuple[str | Path, ...] = ("ctest", "--test-dir", folder)
    known, tested = steps_of(ctest, label), steps_of(ctest, "test")
    only_verified = [name for name in steps_of(ctest, "verify") if name not in tested]
    if missing := [name for name in names if name not in known]:
        command = "verify" if label == "verify" else "test"
        print(
            f"tools/{command}: no step {missing[0]!r}; there are: {', '.join(known)}",
            file=sys.stderr,
        )
        return UNKNOWN, []
    shutil.rmtree(reports, ignore_errors=True)
    reports.mkdir(parents=True)
    chosen = ("-R", f"^({'|'.join(map(re.escape, names))})$") if names else ()
    whole = ("--output-on-failure", "--test-output-size-passed", "1000000", "--timeout", NO_LIMIT)
    n_steps = N_CORES * (STEPS_PER_CORE if label == "verify" else 1)
    outputs = ("-j", str(n_steps), "--output-junit", reports / "steps.xml")
    words = (*ctest, "-L", f"^{label}$", *chosen, *whole, *outputs)
    with subprocess.Popen(words, env=env) as process, without_hangs(process.pid):
        return process.wait(), only_verified


def main(label: str, *names: str) -> int:
    """Run steps; return the exit status: 0, 1 after a failure, 128 + n after signal n."""

    def stop(number: int, _frame: FrameType | None) -> None:
        for end_signal in END_SIGNALS:
            signal.signal(end_signal, signal.SIG_IGN)
        print(f"{signal.Signals(number).name}: stopping all steps", flush=True)
        end_descendants()
        os._exit(128 + number)

    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    for number in END_SIGNALS:
        signal.signal(number, stop)
    REPORTS.mkdir(exist_ok=True)
    lock = (REPORTS / f"{label}.lock").open("w")
    fcntl.flock(lock, fcntl.LOCK_EX)  # a second run in this clone waits for the first
    status, only_verified = run_ctest(label, list(names))
    end_descendants()
    steps = REPORTS / label / "steps.xml"
    if status == UNKNOWN or not steps.exists():
        return status or 1
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    lines, n_failed = summary(steps, REPORTS / label)
    lines.insert(0, f"processor time {used.ru_utime + used.ru_stime:.0f} s")
    if label != "verify" and not names:
        lines.insert(-1, f"only tools/verify checks: {', '.join(only_verified)}")
    (REPORTS / f"{label}.txt").write_text("\n".join([*results(steps), "", *lines, ""]))
    print("\n".join(["", *lines]))
    return 1 if status or n_failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
