"""Where the Linux port meets a kernel: this computer's own, or one in User-Mode Linux.

This computer's own is used where it has vcan and gpio-sim and the user may use them (in practice:
root); time is then real. Otherwise tools/uml boots a kernel of our own, in virtual time.
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

UML = ROOT / "tools" / "uml"
MACHINE = ROOT / "tools" / "linux_kernel" / "machine"
CONTROLLER = ROOT / "build" / "linux" / "hal" / "linux" / "camturn-linux"
MACHINE_FILE = Path(__file__).parent / "machine.toml"
SPEED_RPM, FEED_MM = 300, 2


class NoKernelError(Exception):
    """Neither kernel can be had; the message names the reason and the remedy."""


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
        """Return the output of a program."""
        return (self.folder / f"{name}.log").read_text()

    def report(self) -> str:
        """Return what is known of a failure."""
        written = self.folder / "result.json"
        return self.message + (written.read_text() if written.exists() else "nothing written down")


class Kernel:
    """A kernel with vcan0, vcan1 and simulated GPIO lines, in which scenarios are played."""

    def __init__(self, is_own: bool) -> None:
        self.is_own = is_own

    def start(self, out: Path, *words: str) -> subprocess.Popen[str]:
        """Start a command, in virtual time where the kernel can; only files in `out` stay."""
        there = [str(UML), "run", "-v", "-o", str(out)]
        command = there if self.is_own else ["unshare", "-n", str(MACHINE)]
        pipe = subprocess.PIPE
        return subprocess.Popen(
            [*command, *words], stdout=pipe, stderr=subprocess.STDOUT, text=True, cwd=ROOT
        )

    def play(self, scenario: str, setup: dict[str, Any]) -> Result:
        """Play a scenario with the `setup` of inside.Session, whose `out` is for everything."""
        out = Path(setup["out"])
        (out / "setup.json").write_text(json.dumps(setup))
        words = [sys.executable, "-m", "tests.linux.scenarios", scenario, str(out / "setup.json")]
        process = self.start(out, *words)
        message, _ = process.communicate()
        return Result(process.returncode, message, out)


def is_direct_possible() -> bool:
    """Return whether this computer's kernel will do, by trying."""
    if os.geteuid() != 0 or not shutil.which("unshare"):
        return False
    trial = ["unshare", "-n", str(MACHINE), "true"]
    return subprocess.run(trial, capture_output=True, check=False).returncode == 0


def uml(*words: str, root: Path = ROOT) -> subprocess.CompletedProcess[str]:
    """Run tools/uml of a repository to its end."""
    command = [str(root / "tools" / "uml"), *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def find_kernel() -> Kernel:
    """Return the kernel to be used, booted once; where CAMTURN_KERNEL is `build`, it is built."""
    if is_direct_possible():
        return Kernel(is_own=False)
    found = uml("build" if os.environ.get("CAMTURN_KERNEL") == "build" else "path")
    if found.returncode != 0:
        raise NoKernelError(found.stderr.strip().splitlines()[-1])
    if not Path(found.stdout.strip()).exists():
        raise NoKernelError("it is not built yet; tools/uml build, or tools/verify, does it")
    booted = uml("run", "true")
    if booted.returncode != 0:
        raise BrokenKernelError(f"{found.stdout.strip()} does not boot\n{booted.stderr}")
    return Kernel(is_own=True)


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
