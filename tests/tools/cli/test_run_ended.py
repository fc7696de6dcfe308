# SPDX-License-Identifier: Apache-2.0
"""A tools/run that does not come to its end: what it says, and that nothing is left behind."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.output import staged
from tests.tools.cases.camsim_cases import CAMSIM
from tests.tools.cases.part_cases import Command, environment, listing

built = pytest.mark.skipif(not CAMSIM.exists(), reason="camsim is not built")


@built
def test_failed_run_leaves_earlier_results(run: Command, tmp_path: Path) -> None:
    """What an earlier run wrote stays as it was, byte for byte and nothing beside it."""
    for name in ("report.html", "summary.json", "notes.txt"):
        (tmp_path / name).write_text("older")
    assert run("--rpm", "4000", "-o", tmp_path).returncode == 2
    assert listing(tmp_path) == ["notes.txt", "report.html", "summary.json"]
    assert {path.read_text() for path in tmp_path.iterdir()} == {"older"}


def test_missing_simulator_is_told(run: Command, tmp_path: Path) -> None:
    """Without a build the remedy is named."""
    done = run("-o", tmp_path / "out", CAMTURN_BUILD=str(tmp_path / "nowhere"))
    assert done.returncode == 2
    assert "cannot be started: No such file or directory; start tools/run" in done.stderr
    assert listing(tmp_path) == []


@built
def test_full_disk_leaves_nothing(run: Command, tmp_path: Path) -> None:
    """When the trace does not fit, nothing appears and the status is 2."""
    done = run("--feed", "2", "-o", "out", largest_file=200_000)
    assert (done.returncode, done.stdout) == (2, "")
    assert "File too large" in done.stderr
    assert listing(tmp_path) == []


def test_interrupted_run_leaves_nothing(tmp_path: Path) -> None:
    """A signal ends the simulator too, removes the stage and the new folder."""
    camsim = tmp_path / "build" / "host_sim" / "camsim"
    camsim.parent.mkdir(parents=True)
    camsim.write_text('#!/bin/sh\necho $$ > "$0.pid"\nexec sleep 60\n')
    camsim.chmod(0o755)
    command = [sys.executable, "-m", "camtools.cli.run", "-o", str(tmp_path / "out")]
    env = environment() | {"CAMTURN_BUILD": str(tmp_path / "build")}
    with subprocess.Popen(command, env=env, stderr=subprocess.PIPE, text=True) as job:
        pid_file = camsim.with_name("camsim.pid")
        end_s = time.monotonic() + 30
        while not (pid_file.exists() and pid_file.read_text()) and time.monotonic() < end_s:
            time.sleep(0.05)
        time.sleep(0.3)  # by then the command has left the fork and knows its child
        job.send_signal(signal.SIGTERM)
        _, err = job.communicate(timeout=20)
    assert job.returncode == 128 + signal.SIGTERM
    assert err.endswith("run: interrupted; nothing was written\n")
    assert listing(tmp_path) == ["build"]
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid_file.read_text()), 0)


def test_crashed_simulator_is_told(run: Command, tmp_path: Path) -> None:
    """A simulator that dies of a signal gives one line and status 2."""
    camsim = tmp_path / "build" / "host_sim" / "camsim"
    camsim.parent.mkdir(parents=True)
    camsim.write_text("#!/bin/sh\nkill -SEGV $$\n")
    camsim.chmod(0o755)
    done = run("-o", tmp_path / "out", CAMTURN_BUILD=str(tmp_path / "build"))
    assert done.returncode == 2
    assert "camsim: ended by signal 11" in done.stderr
    assert listing(tmp_path) == ["build"]


def test_stage_publishes_over_earlier_files(tmp_path: Path) -> None:
    """Files of the stage replace those of the same name; others stay."""
    (tmp_path / "a").write_text("older")
    (tmp_path / "b").write_text("older")
    with staged(tmp_path) as stage:
        (stage.folder / "a").write_text("new")
        assert (tmp_path / "a").read_text() == "older"
        stage.publish()
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {
        "a": "new",
        "b": "older",
    }


def test_name_taken_by_a_folder_changes_nothing(tmp_path: Path) -> None:
    """When one name cannot be given, none is."""
    (tmp_path / "b").mkdir()
    with (
        pytest.raises(CamtoolsError, match="/b: cannot write: Is a directory; "),
        staged(tmp_path) as stage,
    ):
        (stage.folder / "a").write_text("new")
        (stage.folder / "b").write_text("new")
        stage.publish()
    assert listing(tmp_path) == ["b"]
