"""Command line that writes firmware and table into the flash memory of a NUCLEO-H743ZI2.

A table is judged by the firmware's own check before anything is written, as every table is.

>>> print(*command_lines("st-flash", [Write(Path("a.camtab"), TABLE.address)])[0])
st-flash --connect-under-reset --reset write a.camtab 0x08100000
"""

from __future__ import annotations

import os
import shlex
import shutil
import struct
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

from camtools.base.arguments import Option, UsageError, command
from camtools.base.errors import CamtoolsError
from camtools.base.project import ROOT, build_folder

PROGRAMMERS = ("openocd", "st-flash", "pyocd")
_FIRMWARE_FILE = ROOT / "build" / "mcu-stm32h743" / "hal" / "stm32h743" / "firmware.bin"
_EPILOG = """\
Exit status: 0 written, 1 the programmer failed, 2 wrong usage or bad input."""
_TCL_SPECIAL = frozenset("{}\\")


class Region(NamedTuple):
    """A range of the flash memory, as hal/stm32h743/stm32h743.ld divides it."""

    name: str
    address: int
    size: int


FIRMWARE = Region("the first two sectors", 0x0800_0000, 2 << 17)
LOG = Region("the log of places", 0x080E_0000, 1 << 17)
FIRST_PLACE = ROOT / "hal" / "stm32h743" / "first_place.bin"  # record: TABLE is in use
TABLE = Region("place 0", 0x0810_0000, 6 << 17)  # the parameters follow it
_DTCM = range(0x2000_0000, 0x2002_0001)


class Write(NamedTuple):
    """A file and the address of its first byte."""

    file: Path
    address: int


def _refusal(file: Path, problem: str, remedy: str) -> CamtoolsError:
    return CamtoolsError([f"{file}: {problem}; {remedy}"])


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise _refusal(file, f"cannot be read: {error.strerror}", "check the path") from error


def _check_size(file: Path, size: int, region: Region) -> None:
    if size > region.size:
        problem = f"{size} bytes do not fit into the {region.size} bytes of {region.name}"
        raise _refusal(file, problem, "make it smaller")


def check_firmware(file: Path) -> None:
    """Refuse what cannot be firmware: too long, no stack in DTCM, no reset vector inside."""
    image = _read(file)
    _check_size(file, len(image), FIRMWARE)
    stack, reset = struct.unpack_from("<II", image) if len(image) >= 8 else (0, 0)
    is_inside = FIRMWARE.address <= reset < FIRMWARE.address + len(image)
    if stack not in _DTCM or not is_inside or reset % 2 == 0:
        raise _refusal(file, "not firmware for this board", "build the preset mcu-stm32h743")


def check_table(file: Path) -> None:
    """Refuse a table that does not fit, or that the firmware's check refuses, in its words."""
    _check_size(file, len(_read(file)), TABLE)
    camsim = build_folder() / "camsim"
    command = [str(camsim), "eval", str(file.absolute())]
    try:
        done = subprocess.run(
            command, input="turn,z_mm\n", capture_output=True, text=True, check=False
        )
    except OSError as error:
        problem = f"cannot be started: {error.strerror}"
        raise _refusal(camsim, problem, "start tools/flash, which builds it") from error
    if done.returncode != 0:
        lines = done.stderr.replace(str(file.absolute()), str(file)).splitlines()
        ended = f"{file}: the check ended with status {done.returncode}"
        raise CamtoolsError([line.removeprefix("camsim: ") for line in lines] or [ended])


def command_lines(programmer: str, writes: Sequence[Write]) -> list[list[str]]:
    """Return commands, each as words, that write files in turn and start the firmware."""
    if programmer == "st-flash":
        resets: list[list[str]] = [[]] * (len(writes) - 1) + [["--reset"]]
        return [
            ["st-flash", "--connect-under-reset", *reset, "write", str(file), f"0x{address:08X}"]
            for reset, (file, address) in zip(resets, writes, strict=True)
        ]
    if programmer == "pyocd":
        words = ["pyocd", "flash", "--target", "stm32h743zitx", "--format", "bin", "--base-address"]
        return [[*words, f"0x{write.address:08X}", str(write.file)] for write in writes]
    for write in writes:
        if _TCL_SPECIAL & set(str(write.file)):
            raise _refusal(write.file, "openocd cannot handle this name", "rename it")
    words = ["openocd", "-f", "board/st_nucleo_h743zi.cfg"]
    for write in writes:
        words += ["-c", f"program {{{write.file}}} verify 0x{write.address:08X}"]
    return [[*words, "-c", "reset run", "-c", "shutdown"]]


def _choose(wanted: str | None, *, is_dry: bool) -> str:
    """Return the programmer to use; for a dry run any will do."""
    installed = [name for name in PROGRAMMERS if shutil.which(name)]
    if wanted is not None and (is_dry or wanted in installed):
        return wanted
    if wanted is not None:
        raise CamtoolsError([f"{wanted}: not installed; install it, or choose another one"])
    if installed or is_dry:
        return (installed or list(PROGRAMMERS))[0]
    names = ", ".join(PROGRAMMERS)
    raise CamtoolsError([f"no programmer is installed; install one of {names}, or use --dry-run"])


def _checked(table: Path | None, *, firmware: bool) -> list[Write]:
    """Return what is to be written; everything is checked before anything is."""
    writes = []
    if firmware:
        file = Path(os.environ.get("CAMTURN_FIRMWARE") or _FIRMWARE_FILE)
        check_firmware(file)
        writes.append(Write(file, FIRMWARE.address))
    if table is not None:
        check_table(table)
        writes += [Write(table, TABLE.address), Write(FIRST_PLACE, LOG.address)]
    return writes


def flash(
    *,
    firmware: Annotated[bool, Option("build and write the firmware")] = False,
    table: Annotated[Path | None, Option("check this table and write it", "TABLE.camtab")] = None,
    programmer: Annotated[
        str | None,
        Option("program that writes (default: the first one installed)", choices=PROGRAMMERS),
    ] = None,
    dry_run: Annotated[bool, Option("check the files and only print the command lines")] = False,
) -> int:
    """Write firmware, table, or both into a NUCLEO-H743ZI2."""
    if not firmware and table is None:
        raise UsageError("nothing to write: give --firmware, --table or both")
    writes = _checked(table, firmware=firmware)
    chosen = _choose(programmer, is_dry=dry_run)
    for line in command_lines(chosen, writes):
        print(shlex.join(line), flush=True)
        if not dry_run and (status := subprocess.run(line, check=False).returncode) != 0:
            problem = f"{chosen} ended with status {status}; the flash may be incomplete"
            sys.stderr.write(f"flash: {problem}\n")
            return 1
    return 0


main = command(
    *("tools/flash", flash),
    usage="tools/flash [--firmware] [--table TABLE.camtab] [--programmer NAME] [--dry-run]",
    epilog=_EPILOG,
)

if __name__ == "__main__":
    sys.exit(main())
