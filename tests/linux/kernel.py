# SPDX-License-Identifier: Apache-2.0
"""Where the Linux port meets a kernel: this computer's own, or one in User-Mode Linux.

This computer's own is used where it has vcan and gpio-sim and the user may use them (in practice:
root); time is then real. Otherwise tools/uml boots a kernel of our own, in virtual time unless a
test asks for real time.
"""

import csv
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from tests.tools.cases.camsim_cases import ROOT, camsim

HERE = Path(__file__).parent
UML = ROOT / "tools" / "uml"
MACHINE = ROOT / "tools" / "linux_kernel" / "machine"
CONTROLLER = ROOT / "build" / "linux" / "hal" / "linux" / "camturn-linux"
MACHINE_FILE = HERE / "machine.toml"
SPEED_RPM, FEED_MM = 300, 2
BUILD_LIMIT_S = 1200
PLAY_LIMIT_S = 120
END_S = 60  # more than a kernel takes to end on a busy machine


class NoKernelError(Exception):
    """Neither kernel can be had; the message tells why and what helps."""


class BrokenKernelError(Exception):
    """The kernel is there but does not run; the message ends with its own last words."""


@dataclass
class Result:
    """What a scenario left behind."""

    status: int
    message: str
    folder: Path

    @cached_property
    def seen(self) -> dict[str, Any]:
        """What the process inside wrote down."""
        seen: dict[str, Any] = json.loads((self.folder / "result.json").read_text())
        return seen

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Summary of camsim bus."""
        summary: dict[str, Any] = json.loads((self.folder / "summary").read_text())
        return summary

    @cached_property
    def trace(self) -> list[dict[str, str]]:
        """Rows of the trace of camsim bus."""
        with (self.folder / "trace").open() as file:
            return list(csv.DictReader(file))

    def log(self, name: str) -> str:
        """Return what a program said."""
        return (self.folder / f"{name}.log").read_text()

    def report(self) -> str:
        """Return what is known of a failure: what was said, and what was written down."""
        written = self.folder / "result.json"
        return self.message + (written.read_text() if written.exists() else "nothing written down")


@dataclass
class PortTests:
    """The port's own tests, running inside, and where their report will be."""

    process: subprocess.Popen[str]
    report: Path
    limit_s: int

    def wait(self) -> str:
        """Wait for their end; return what they said."""
        return wait_said(self.process, self.limit_s)


def wait_said(process: subprocess.Popen[str], limit_s: int) -> str:
    """Wait for a kernel's end; return what its program said.

    It ends itself after its limit. Should that fail, too, it is killed here, as a failure.
    """
    try:
        return process.communicate(timeout=limit_s + END_S)[0]
    except subprocess.TimeoutExpired:
        process.kill()
        said, _ = process.communicate(timeout=END_S)
        raise AssertionError(f"the kernel did not end in {limit_s + END_S} s: {said}") from None


class Kernel:
    """A kernel with vcan0, vcan1 and simulated GPIO lines, in which scenarios are played."""

    def __init__(self, is_own: bool) -> None:
        self.is_own = is_own

    def command(self, out: Path, limit_s: int, is_virtual: bool) -> list[str]:
        """Return the words in front of a command that is to run there."""
        if not self.is_own:
            return ["timeout", str(limit_s), "unshare", "-n", str(MACHINE)]
        time = ["-v"] if is_virtual else []
        return [str(UML), "run", *time, "-t", str(limit_s), "-o", str(out)]

    def start(
        self, out: Path, *words: str, limit_s: int = PLAY_LIMIT_S, is_virtual: bool = True
    ) -> subprocess.Popen[str]:
        """Start a command; only files in `out` stay."""
        command = [*self.command(out, limit_s, is_virtual), *words]
        pipe = subprocess.PIPE
        return subprocess.Popen(command, stdout=pipe, stderr=subprocess.STDOUT, text=True, cwd=ROOT)

    def play(self, scenario: str, setup: dict[str, Any], *, is_virtual: bool) -> Result:
        """Play a scenario of scenarios.py.

        Parameters
        ----------
        scenario : name of its function
        setup : see inside.Session; `out` is the folder for everything
        is_virtual : virtual time where the kernel can
        """
        out = Path(setup["out"])
        (out / "setup.json").write_text(json.dumps(setup))
        words = [sys.executable, "-m", "tests.linux.scenarios", scenario, str(out / "setup.json")]
        process = self.start(out, *words, is_virtual=is_virtual)
        message = wait_said(process, PLAY_LIMIT_S)
        return Result(process.returncode, message, out)


def is_direct_possible() -> bool:
    """Return whether this computer's kernel will do, by trying."""
    if os.geteuid() != 0 or not shutil.which("unshare"):
        return False
    trial = ["unshare", "-n", str(MACHINE), "true"]
    done = subprocess.run(trial, capture_output=True, check=False, timeout=END_S)
    return done.returncode == 0


def find_kernel() -> Kernel:
    """Return the kernel to be used; build it when need be, and boot it once.

    Raises
    ------
    NoKernelError
        when there is none; the message is the last line of the attempt
    BrokenKernelError
        when it does not boot
    """
    if is_direct_possible():
        return Kernel(is_own=False)
    built = try_uml("build")
    if built.returncode != 0:
        raise NoKernelError(built.stderr.strip().splitlines()[-1])
    booted = try_uml("run", "true")
    if booted.returncode != 0:
        raise BrokenKernelError(f"{built.stdout.strip()} does not boot\n{booted.stderr}")
    return Kernel(is_own=True)


def try_uml(*words: str) -> subprocess.CompletedProcess[str]:
    """Run tools/uml to its end."""
    command = [str(UML), *words]
    return subprocess.run(
        command, capture_output=True, text=True, timeout=BUILD_LIMIT_S, check=False
    )


class InProcess:
    """The same cut by camsim run: its results, and the parameters that it gave the firmware."""

    def __init__(self, table: Path, folder: Path) -> None:
        self.surface, summary = folder / "surface.csv", folder / "summary.json"
        done = camsim(
            "run", table, "--rpm", str(SPEED_RPM), "--feed", str(FEED_MM),
            "--machine", MACHINE_FILE, "--surface", self.surface, "--summary", summary,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        self.summary: dict[str, Any] = json.loads(summary.read_text())
