"""The runner of all tests: what it counts, reports and stops; CTest itself runs the steps."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil

from checks.patience import SLOWNESS, until

TOOLS = Path(__file__).resolve().parents[3] / "tools"
GOOD = '<testsuite tests="5" failures="0" errors="0" skipped="2"/>'
ONE_FAILED = '<testsuite tests="5" failures="1" errors="0" skipped="0"/>'


def started(root: Path, *words: str, **scripts: str) -> subprocess.Popen[str]:
    """Start the runner on steps of its own, each a script; "needy" needs "fails"."""
    folder = root / "tools" / "steps"
    folder.mkdir(parents=True)
    (root / "build").mkdir()
    lines = ["cmake_minimum_required(VERSION 3.25)", "project(s NONE)", "enable_testing()"]
    for name, script in scripts.items():
        file = root / f"{name}.sh"
        file.write_text(script)
        lines += [f"add_test(NAME {name} COMMAND bash {file} WORKING_DIRECTORY {root})"]
        more = "FIXTURES_REQUIRED f" if name == "needy" else ""
        more = "FIXTURES_SETUP f" if name == "fails" else more
        lines += [f"set_tests_properties({name} PROPERTIES LABELS test {more})"]
    (folder / "CMakeLists.txt").write_text("\n".join(lines))
    program = (
        "import sys, pathlib, run_steps as r; r.ROOT = pathlib.Path(sys.argv[1]); "
        "r.BUILD = r.ROOT / 'build'; r.REPORTS = r.BUILD / 'reports'; r.KILL_AFTER_S = 0.5; "
        "r.STALL_S = 1.0; r.LOOK_S = 0.2; "
        "sys.exit(r.main('test', *sys.argv[2:]))"
    )
    return subprocess.Popen(
        [sys.executable, "-c", program, str(root), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=os.environ | {"PYTHONPATH": str(TOOLS), SLOWNESS: "2"},
    )


def is_running(pid: int) -> bool:
    """Return whether a process is there and no zombie."""
    try:
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    except psutil.NoSuchProcess:
        return False


def pid_in(file: Path) -> int:
    """Wait until a file has the number of a process; return it."""
    return int(until(lambda: file.exists() and file.read_text().strip(), f"{file.name}"))


def test_tests_of_all_steps_are_counted(tmp_path: Path) -> None:
    """Those in JUnit files, one for each other step; what a step hides counts."""
    runner = started(
        tmp_path,
        gate="echo begun; echo 12 files are well",
        good=f"echo '{GOOD}' >build/reports/test/good.xml",
        bad=f"echo '{ONE_FAILED}' >build/reports/test/bad.xml; echo why; exit 1",
        hides=f"echo '{ONE_FAILED}' >build/reports/test/hides.xml",
        crashes=f"echo '{GOOD}' >build/reports/test/crashes.xml; exit 9",
        fails="exit 3",
        needy="true",
    )
    said, _ = runner.communicate()
    assert runner.returncode == 1
    assert said.splitlines()[-1] == "15 passed, 4 failed, 5 skipped"
    assert {f"failed: {name}" for name in ("bad", "hides", "crashes", "fails")} <= set(
        said.splitlines()
    )
    assert "not run: needy" in said and "\nwhy\n" in said
    rows = (tmp_path / "build" / "reports" / "test.txt").read_text()
    assert "12 files are well" in rows and "begun" not in rows


def test_one_step_is_run_with_what_it_needs(tmp_path: Path) -> None:
    """And no other."""
    runner = started(tmp_path, "needy", fails="true", needy="true", other="touch other")
    said, _ = runner.communicate()
    assert runner.returncode == 0 and said.splitlines()[-1] == "2 passed, 0 failed"
    assert not (tmp_path / "other").exists()


def test_unknown_step_is_refused_with_those_that_there_are(tmp_path: Path) -> None:
    """Nothing is run."""
    runner = started(tmp_path, "good", "bod", good="touch good", bad="true")
    said, _ = runner.communicate()
    assert runner.returncode == 2
    assert said == "tools/test: no step 'bod'; there are: good, bad\n"
    assert not (tmp_path / "good").exists()


def test_child_that_a_step_leaves_behind_is_stopped(tmp_path: Path) -> None:
    """The step's verdict is its own."""
    runner = started(tmp_path, leaves="sleep 600 >/dev/null 2>&1 & echo $! >left")
    said, _ = runner.communicate()
    assert runner.returncode == 0, said
    assert not is_running(pid_in(tmp_path / "left"))


def test_signal_stops_all_steps(tmp_path: Path) -> None:
    """Exit status 128 + n, and no process is left, of a session of its own neither."""
    script = "trap '' TERM; setsid sleep 600 & echo $! >far; sleep 600 & echo $! >near; wait; wait"
    runner = started(tmp_path, hangs=script)
    left = [pid_in(tmp_path / name) for name in ("far", "near")]
    runner.send_signal(signal.SIGTERM)
    said, _ = runner.communicate()
    assert runner.returncode == 128 + signal.SIGTERM
    assert said.splitlines()[-1] == "SIGTERM: stopping all steps"
    assert not any(map(is_running, left))


def test_step_without_progress_is_ended_and_what_it_waits_for_is_named(tmp_path: Path) -> None:
    """One that computes goes on, however long it takes; so does one whose only child hung."""
    runner = started(
        tmp_path,
        hangs="sleep 600; echo continued >after; exit 1",
        computes="SECONDS=0; while ((SECONDS < 4)); do :; done",
    )
    said, _ = runner.communicate()
    assert "hang: 'sleep 600' waits in " in said
    assert (tmp_path / "after").exists()
    assert "failed: hangs" in said.splitlines() and "failed: computes" not in said


HANGING = """
import subprocess

def test_hangs():
    subprocess.run(["sleep", "600"])

def test_passes():
    pass

def test_hangs_too():
    import threading
    threading.Event().wait()
"""


def test_only_the_hanging_tests_fail_and_name_what_they_wait_for(tmp_path: Path) -> None:
    """In a pytest of its own, whose watch is impatient."""
    (tmp_path / "test_some.py").write_text(HANGING)
    words = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "tests.hang", str(tmp_path))
    paths = f"{TOOLS}{os.pathsep}{TOOLS.parent}"
    env = os.environ | {"PYTHONPATH": paths, "CAMTURN_STALL_S": "1", SLOWNESS: "2"}
    said = subprocess.run(
        [sys.executable, *words], env=env, cwd=tmp_path, capture_output=True, text=True, check=False
    ).stdout
    assert "2 failed, 1 passed" in said
    assert "'sleep 600' waits in " in said and "threading.Event().wait()" in said
