# SPDX-License-Identifier: Apache-2.0
"""The runner of all tests: what a step's end counts, and that a step that hangs ends."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import pytest

import test_steps


def is_running(pid: int) -> bool:
    """Tell whether a process is there and no zombie."""
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False


def test_status_of_a_step(capfd: pytest.CaptureFixture[str]) -> None:
    """The command's own, and 127 where there is no command."""
    assert test_steps.run("good", ["true"]) == 0
    assert test_steps.run("bad", [sys.executable, "-c", "raise SystemExit(3)"]) == 3
    assert test_steps.run("none", ["/no/such/command"]) == 127
    out = capfd.readouterr().out
    assert "--- good: ok" in out and "--- bad: FAILED (exit status 3)" in out


@pytest.mark.alone
def test_step_that_hangs_is_stopped_with_its_children(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """A failure, told; a child that would go on is gone."""
    script = f"sleep 600 & echo $! > {tmp_path}/pid; wait"
    assert test_steps.run("hangs", ["bash", "-c", script], limit_s=1.0) == 124
    assert "not done after 1 s" in capfd.readouterr().out
    child = int((tmp_path / "pid").read_text())
    end_s = time.monotonic() + 10.0
    while is_running(child) and time.monotonic() < end_s:
        time.sleep(0.05)
    assert not is_running(child)


def test_step_counts() -> None:
    """A gate is one test; a report that cannot be read is one failure."""
    tally = test_steps.Tally()
    assert test_steps.gate(tally, "good", "true")
    assert not test_steps.gate(tally, "bad", "false")
    tally.add_junit("broken", Path("/no/such/report.xml"), 0)
    assert tally.summary() == "1 passed, 2 failed"
    assert tally.failed_steps == ["bad", "broken"]
