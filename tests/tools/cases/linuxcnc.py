"""LinuxCNC itself, for tests only: installed, or unpacked from its Debian packages.

Unpacking needs no root and leaves the system alone: the package itself would bring a desktop.
"""

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from camtools.base.quantities import Floats
from tests.tools.cases.linuxcnc_reader import REFUSED
from tests.tools.cases.part_cases import ROOT

FOLDER = ROOT / "build" / "linuxcnc"
PACKAGES = (
    "linuxcnc-uspace", "linuxcnc-uspace-dev", "python3-yapps",
    "libboost-python1.74.0", "libtirpc3", "libedit2", "libpython3.11",
)  # fmt: skip
REMEDY = "on Debian 12: apt-get install linuxcnc-uspace, or apt-get update for apt-get download"
UNPACKED = FOLDER / "root"
DEVELOPMENT = ("bin/halcompile", "include/linuxcnc/hal.h", "share/linuxcnc/Makefile.modinc")
READER = Path(__file__).with_name("linuxcnc_reader.py")
AXES = "XYZABCUVW"


class NotHereError(Exception):
    """The interpreter cannot be had; the message tells why and what helps."""


@dataclass(frozen=True)
class Interpreter:
    """LinuxCNC's interpreter; `root` is "/" where it is installed."""

    root: Path

    def _environment(self) -> dict[str, str]:
        lib = self.root / "usr" / "lib"
        return {
            "PATH": os.environ["PATH"],
            "HOME": str(FOLDER),  # its table of tools lies there, else in a place for all users
            "LD_LIBRARY_PATH": f"{lib}:{lib / 'x86_64-linux-gnu'}",
            "PYTHONPATH": str(lib / "python3" / "dist-packages"),
        }

    def _run(self, *words: str | Path) -> subprocess.CompletedProcess[str]:
        env = self._environment()
        return subprocess.run(
            list(map(str, words)), env=env, capture_output=True, text=True, check=False
        )

    def rs274(self, program: Path) -> subprocess.CompletedProcess[str]:
        """Run the stand-alone interpreter, which knows the axes X Y Z A B C."""
        tools, variables = program.with_suffix(".tbl"), program.with_suffix(".var")
        tools.write_text("T1 P1 D0\n")
        variables.touch()
        command = self.root / "usr" / "bin" / "rs274"
        return self._run(command, "-t", tools, "-v", variables, "-g", program)

    def points(self, program: Path) -> tuple[str, Floats]:
        """Read a program for a machine with all nine axes.

        Returns message: "" or the interpreter's error; points: shape (n, 10), 0 rapid, 1 feed; then
        X radius, Y, Z, A, B, C, U, V, W [mm, degrees].
        """
        found = program.with_suffix(".points")
        done = self._run("/usr/bin/python3", READER, program, found, program.with_suffix(".var"))
        if done.returncode not in (0, REFUSED):
            raise NotHereError(f"its library does not work ({_last(done.stderr)}); {REMEDY}")
        return done.stdout.strip(), np.fromfile(found).reshape(-1, 10)


def _last(told: str) -> str:
    return (told.strip() or "no reason told").splitlines()[-1]


def _unpack() -> None:
    for needed in ("apt-get", "dpkg-deb"):
        if shutil.which(needed) is None:
            raise NotHereError(f"no {needed} here; {REMEDY}")
    debs = FOLDER / "debs"
    debs.mkdir(parents=True, exist_ok=True)
    command = ["apt-get", "-qq", "-o", "APT::Sandbox::User=root", "download", *PACKAGES]
    done = subprocess.run(command, cwd=debs, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        told = _last(done.stderr)
        raise NotHereError(f"its Debian package cannot be downloaded ({told}); {REMEDY}")
    parts = FOLDER / f"root.{os.getpid()}"
    for deb in sorted(debs.glob("*.deb")):
        subprocess.run(["dpkg-deb", "-x", deb, parts], check=True)
    shutil.rmtree(UNPACKED, ignore_errors=True)
    parts.replace(UNPACKED)
    shutil.rmtree(debs)


def _is_complete(root: Path) -> bool:
    return all((root / "usr" / part).exists() for part in ("bin/rs274", *DEVELOPMENT))


def tools() -> Path:
    """Return LinuxCNC's folder of programs, modules, headers, halcompile: "/" or unpacked."""
    root = Path("/") if _is_complete(Path("/")) else UNPACKED
    if not _is_complete(root):
        _unpack()
    return root


def interpreter() -> Interpreter:
    """Return the interpreter, tried; NotHereError where there is none."""
    is_installed = Path("/usr/bin/rs274").exists()
    if not is_installed and not UNPACKED.exists():
        _unpack()
    found = Interpreter(Path("/") if is_installed else UNPACKED)
    FOLDER.mkdir(parents=True, exist_ok=True)
    probe = FOLDER / "probe.ngc"
    probe.write_text("G21\nM2\n")
    done = found.rs274(probe)
    if done.returncode != 0:
        raise NotHereError(f"it does not start ({_last(done.stderr)}); {REMEDY}")
    found.points(probe)
    return found
