# SPDX-License-Identifier: Apache-2.0
"""Processor in the loop: the firmware on an emulated board does what it does on the host.

Needs camsim and the images of both boards (presets mcu-qemu and mcu-qemu-m4), and the emulator.
"""

import json
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.tools.cases.camsim_cases import CAMSIM, ROOT, camsim, first_difference, only_error

BOARDS = {"mps2-an500": "mcu-qemu", "mps2-an386": "mcu-qemu-m4"}
CAM_LATHE = ROOT / "host_sim" / "machines" / "cam.toml"
FAST_ENDS = ("--set", "engage_turns=1", "--set", "disengage_turns=1")
# Part, exit status and options: engage to disengage, a modulated spindle, a stopped ring-helix,
# faults of the machine and of the table in the target's memory, the operator's stop, a tool that
# swings, several passes with a feed against the height, the other sense, a shaft of eight lobes,
# a drive that is not what is believed, rehearsed and learned, and a U that takes forces, whose
# scale freezes.
CASES = {
    "whole": ("perkins240", 0, ("--feed", "1")),
    "modulated": ("perkins240_equal_volume", 0, ("--rpm", "230", "--feed", "5")),
    "rings": (
        "perkins240_ring_helix",
        0,
        ("--rpm", "900", "--feed", "2", "--set", "z_margin_nm=1000000", "--inject", "stop@1.0"),
    ),
    "u_blocked": (
        "perkins240",
        1,
        ("--feed", "1", "--set", "following_limit_nm=50000", "--inject", "u-block@0.5"),
    ),
    "late_tick": ("perkins240", 1, ("--feed", "1", "--inject", "late-tick@0.4:100")),
    "table_flip": ("perkins240", 1, ("--feed", "1", "--inject", "table-flip@0.3:2000")),
    "passes": (
        "skirt_passes",
        0,
        (
            *("--feed", "4", "--set", "z_margin_nm=2000000"),
            *("--set", "z_acceleration_mm_per_s2=100000"),
        ),
    ),
    "stop": ("perkins240", 0, ("--feed", "1", "--inject", "stop@0.5")),
    "mirrored": ("thrust90", 0, ("--feed", "4")),
    "swung": (
        "cam-345",
        0,
        ("--machine", str(CAM_LATHE), "--feed", "6", "--no-learning", *FAST_ENDS),
    ),
    "shaft": (
        "camshaft8",
        0,
        (
            *("--machine", str(CAM_LATHE), "--feed", "10", "--rpm", "60"),
            *("--tolerance-um", "20", *FAST_ENDS),
        ),
    ),
    "force": (
        "perkins240",
        1,
        (
            *("--machine", str(ROOT / "tests" / "scenarios" / "cases" / "machines" / "force.toml")),
            *("--feed", "1", "--inject", "u-push@0.4:10", "--inject", "u-scale-stuck@0.6"),
        ),
    ),
    "learned": (
        "perkins240",
        0,
        (
            *("--machine", str(ROOT / "tests" / "learn" / "machines" / "perkins.toml")),
            *("--feed", "1", "--set", "rehearse_turns=30", "--turns-limit", "20"),
        ),
    ),
}


@pytest.fixture(scope="session")
def on_host(
    table_of: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], Path]:
    """Run a case in camsim's own process once; return the folder of its results."""
    root = tmp_path_factory.mktemp("host")

    def run(case: str) -> Path:
        folder = root / case
        if not folder.exists():
            folder.mkdir()
            cut(table_of, case, folder)
        return folder

    return run


def cut(table_of: Callable[[str], Path], case: str, folder: Path, *words: str) -> None:
    """Run a case: trace, summary and message are in the folder. A cam is cut without its design."""
    part, status, options = CASES[case]
    table = table_of(part)
    if part.startswith("cam"):
        alone = table.parent / "alone"
        alone.mkdir(exist_ok=True)
        table = Path(shutil.copy(table, alone))
    outputs = ("--trace", folder / "trace.csv", "--summary", folder / "summary.json")
    done = camsim("run", table, *options, *outputs, *words)
    assert done.returncode == status, done.stderr
    (folder / "message").write_text(done.stderr)


def summary_of(folder: Path) -> dict[str, Any]:
    """Return what a summary says of the cut, whatever the clock of this computer says."""
    summary: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    del summary["wall_time_s"], summary["ticks_per_s"]
    return summary


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("board", BOARDS)
def test_target_does_what_the_host_does(
    board: str,
    case: str,
    table_of: Callable[[str], Path],
    on_host: Callable[[str], Path],
    tmp_path: Path,
) -> None:
    """Every tick of the trace, the summary and the message are the same to the byte."""
    host = on_host(case)
    cut(table_of, case, tmp_path, "--target", board)
    assert (tmp_path / "trace.csv").read_bytes().count(b",cutting,") > 1000
    assert first_difference(tmp_path / "trace.csv", host / "trace.csv") == ""
    assert (tmp_path / "message").read_text() == (host / "message").read_text()
    assert summary_of(tmp_path) == summary_of(host)


def test_set_point_differs_where_a_parameter_differs(
    table_of: Callable[[str], Path], on_host: Callable[[str], Path], tmp_path: Path
) -> None:
    """A microsecond of lead more on the target shows in the trace: the comparison can fail."""
    name = "lead_ns"
    summary = summary_of(on_host("whole"))
    more = summary["parameters"][name] + 1000
    cut(table_of, "whole", tmp_path, "--target", "mps2-an500", "--set", f"{name}={more}")
    assert first_difference(tmp_path / "trace.csv", on_host("whole") / "trace.csv") != ""


def test_unknown_target_is_refused(table_of: Callable[[str], Path]) -> None:
    """The message names those that exist."""
    done = camsim("run", table_of("perkins240"), "--target", "mps2-an385")
    assert all(board in only_error(done) for board in BOARDS)


@pytest.mark.parametrize("board", BOARDS)
def test_missing_image_tells_its_preset(
    board: str, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """The message names the image and the command that builds it."""
    image = tmp_path / "none.elf"
    trace = tmp_path / "t.csv"
    table = table_of("perkins240")
    done = camsim("run", table, "--target", board, "--target-image", image, "--trace", trace)
    message = only_error(done)
    assert str(image) in message
    assert message.endswith(f"cmake --workflow --preset {BOARDS[board]}")
    assert not trace.exists()


def test_image_without_target_is_refused(table_of: Callable[[str], Path]) -> None:
    """An image alone is a mistake, not a wish."""
    done = camsim("run", table_of("perkins240"), "--target-image", "pil.elf")
    assert "--target" in only_error(done)


def test_missing_emulator_tells_its_package(
    table_of: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without qemu-system-arm on the path nothing runs, and the message tells what to install."""
    table = table_of("perkins240")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "package qemu-system-arm" in only_error(camsim("run", table, "--target", "mps2-an500"))


def test_image_of_something_else_is_refused(table_of: Callable[[str], Path]) -> None:
    """An image that ends before it greets gives one line with its own words."""
    image = CAMSIM.parents[2] / "mcu-qemu" / "tests" / "image" / "image_main"
    done = camsim("run", table_of("perkins240"), "--target", "mps2-an500", "--target-image", image)
    message = only_error(done)
    assert "qemu-system-arm: ended before the cut did: exit status 0: camturn " in message


def started(
    table: Path, folder: Path, board: str = "mps2-an500"
) -> tuple[subprocess.Popen[str], int]:
    """Start a long cut; return camsim and the process of its emulator."""
    words = ["run", table, "--feed", "0.001", "--target", board, "--trace", folder / "t.csv"]
    process = subprocess.Popen(
        [str(CAMSIM), *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    until_s = time.monotonic() + 20
    while not list(folder.glob("t.csv*")):  # the cut runs
        assert time.monotonic() < until_s and process.poll() is None
        time.sleep(0.02)
    return process, int(children.read_text())


def is_running(pid: int) -> bool:
    """Return whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(") ")[2][0] != "Z"
    except FileNotFoundError:
        return False


def test_dying_emulator_ends_the_run(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """An emulator that is killed in the cut: one line, exit status 2, no files."""
    process, emulator = started(table_of("perkins240"), tmp_path)
    os.kill(emulator, signal.SIGKILL)
    _, message = process.communicate(timeout=20)
    assert process.returncode == 2
    assert message.splitlines() == [
        "camsim: qemu-system-arm: ended before the cut did: killed by signal 9; "
        "hal/mps2/README.md lists why"
    ]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_emulator_does_not_outlive_camsim(
    number: signal.Signals, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """Whatever ends camsim ends the emulator."""
    process, emulator = started(table_of("perkins240"), tmp_path)
    assert is_running(emulator)
    process.send_signal(number)
    process.communicate(timeout=20)
    until_s = time.monotonic() + 10
    while is_running(emulator):
        assert time.monotonic() < until_s
        time.sleep(0.02)
