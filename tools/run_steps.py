# SPDX-License-Identifier: Apache-2.0
"""Lets CTest run the steps of tools/steps: run_steps.py LABEL [STEP...].

CTest reports which step begins or has ended, and what a failed one printed. Then this program
prints the slowest steps, the processor time of all, and how many tests passed: those that a step
counted in a JUnit file, and one for each other step. build/reports/LABEL.txt has that too, with the
last line that each step printed. When this program is stopped, it ends the processes of all steps.
"""

from __future__ import annotations

import ctypes
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path
from types import FrameType
from xml.etree import ElementTree

import psutil

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build"
REPORTS = BUILD / "reports"
N_CORES = min(len(os.sched_getaffinity(0)), 8)
N_SLOWEST = 12
UNKNOWN = 2  # exit status; CTest itself has 8 for failed steps
KILL_AFTER_S = 10.0  # between SIGTERM and SIGKILL
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


def counts(report: Path) -> Counter[str]:
    """Return how many tests of a JUnit file passed, failed and were skipped."""
    suites = list(ElementTree.parse(report).getroot().iter("testsuite"))

    def total(*names: str) -> int:
        return sum(int(suite.get(name, "0")) for suite in suites for name in names)

    failed, skipped = total("failures", "errors"), total("skipped", "disabled")
    passed = total("tests") - failed - skipped
    return Counter(passed=passed, failed=failed, skipped=skipped)


def summary(steps: Path, reports: Path) -> tuple[list[str], int]:
    """Return the closing lines, and how many tests failed.

    Parameters
    ----------
    steps : what CTest wrote of the steps
    reports : folder in which the step "pytest linux kernel" has pytest-linux-kernel.xml
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
        said = (case.findtext("system-out") or "").strip().rpartition("\n")[2]
        took_s = float(case.get("time", "0"))
        lines.append(f"{case.get('name'):<24}{case.get('status'):<8}{took_s:>8.1f} s  {said}")
    return lines


def unknown_step(ctest: tuple[str | Path, ...], names: list[str]) -> str:
    """Return an error that names a step which there is not, or nothing."""
    listed = subprocess.check_output((*ctest, "--show-only=json-v1"), text=True)
    known = [one["name"] for one in json.loads(listed)["tests"]]
    missing = [name for name in names if name not in known]
    return f"no step {missing[0]!r}; there are: {', '.join(known)}" if missing else ""


def clear_reports(label: str) -> None:
    """Delete what former runs reported; the report and the pictures of the other command stay."""
    REPORTS.mkdir(exist_ok=True)
    kept = ("test.txt", "browser") if label == "verify" else ("verify.txt",)
    for path in REPORTS.iterdir():
        if path.name in kept:
            continue
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()


def run_ctest(label: str, names: list[str]) -> int:
    """Run the steps of a label, or some of them with what they need.

    Returns
    -------
    int
        CTest's status; 2 when a step is unknown, and then nothing is run
    """
    place, log = BUILD / "steps", BUILD / "steps.log"
    with log.open("w") as said:
        configure = ("cmake", "-S", ROOT / "tools" / "steps", "-B", place, "--fresh")
        env = os.environ | {"CAMTURN_CORES": str(N_CORES)}
        subprocess.run(configure, env=env, stdout=said, stderr=said, check=True)
    ctest: tuple[str | Path, ...] = ("ctest", "--test-dir", place, "-L", f"^{label}$")
    if error := unknown_step(ctest, names):
        print(f"tools/{'verify' if label == 'verify' else 'test'}: {error}", file=sys.stderr)
        return UNKNOWN
    clear_reports(label)
    chosen = ("-R", f"^({'|'.join(map(re.escape, names))})$") if names else ()
    whole = ("--output-on-failure", "--test-output-size-passed", "1000000")
    outputs = ("-j", str(N_CORES), "--output-junit", REPORTS / "steps.xml")
    return subprocess.run((*ctest, *chosen, *whole, *outputs), check=False).returncode


def main(label: str, *names: str) -> int:
    """Run steps; return the exit status: 0, 1 after a failure, 128 + n after signal n."""

    def stop(number: int, _frame: FrameType | None) -> None:
        for one in END_SIGNALS:
            signal.signal(one, signal.SIG_IGN)
        print(f"{signal.Signals(number).name}: stopping all steps", flush=True)
        end_descendants()
        os._exit(128 + number)

    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    for number in END_SIGNALS:
        signal.signal(number, stop)
    status = run_ctest(label, list(names))
    end_descendants()
    steps = REPORTS / "steps.xml"
    if status == UNKNOWN or not steps.exists():
        return status or 1
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    lines, n_failed = summary(steps, REPORTS)
    lines.insert(0, f"processor time {used.ru_utime + used.ru_stime:.0f} s")
    (REPORTS / f"{label}.txt").write_text("\n".join([*results(steps), "", *lines, ""]))
    print("\n".join(["", *lines]))
    return 1 if status or n_failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
