"""The command line tools/flash: what it refuses, and what it asks a programmer to do."""

import re
import struct
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from camtools.cli.flash import FIRMWARE, FIRST_PLACE, LOG, TABLE
from camtools.skirt.table.generate import GeneratedSkirt
from camtools.table.image import pack
from tests.tools.cases.camsim_cases import camsim, only_error
from tests.tools.cases.command_cases import command
from tests.tools.cases.part_cases import ROOT

PROGRAMMERS = ("openocd", "st-flash", "pyocd")
Flash = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def table(generated: GeneratedSkirt, tmp_path: Path) -> Path:
    """Write the Perkins table."""
    path = tmp_path / "perkins240.camtab"
    path.write_bytes(pack(generated.table))
    return path


@pytest.fixture
def firmware(tmp_path: Path) -> Path:
    """Write what begins like firmware."""
    path = tmp_path / "firmware.bin"
    path.write_bytes(struct.pack("<II", 0x2000_4000, 0x0800_0081) + bytes(1000))
    return path


@pytest.fixture
def flash(tmp_path: Path, firmware: Path) -> Flash:
    """Run the command with nothing but fake programmers on the path."""

    def run(*words: str | Path) -> subprocess.CompletedProcess[str]:
        (tmp_path / "bin").mkdir(exist_ok=True)
        path = str(tmp_path / "bin")
        return command("camtools.cli.flash", *words, CAMTURN_FIRMWARE=str(firmware), PATH=path)

    return run


def install(folder: Path, name: str, status: int = 0) -> Path:
    """Put a programmer on the path that writes down its words; return where."""
    (folder / "bin").mkdir(exist_ok=True)
    program, notes = folder / "bin" / name, folder / f"{name}.txt"
    script = f'#!/bin/sh\nprintf "%s\\n" "$@" >>"{notes}"\nexit {status}\n'
    program.write_text(script)
    program.chmod(0o755)
    return notes


_PYOCD = ("flash", "--target", "stm32h743zitx", "--format", "bin", "--base-address")
# What a programmer is asked to do; with the table its record, that it is in use, is written.
ORDERS = {
    ("openocd", "--firmware"): (
        *("-f", "board/st_nucleo_h743zi.cfg"),
        *("-c", "program {FIRMWARE} verify 0x08000000"),
        *("-c", "program {TABLE} verify 0x08100000"),
        *("-c", "program {PLACE} verify 0x080E0000"),
        *("-c", "reset run", "-c", "shutdown"),
    ),
    ("st-flash", ""): (
        *("--connect-under-reset", "write", "TABLE", "0x08100000"),
        *("--connect-under-reset", "--reset", "write", "PLACE", "0x080E0000"),
    ),
    ("pyocd", "--firmware"): (
        *(*_PYOCD, "0x08000000", "FIRMWARE", *_PYOCD, "0x08100000", "TABLE"),
        *(*_PYOCD, "0x080E0000", "PLACE"),
    ),
}


@pytest.mark.parametrize(("programmer", "more"), ORDERS)
def test_files_go_to_their_addresses(
    flash: Flash, tmp_path: Path, firmware: Path, table: Path, programmer: str, more: str
) -> None:
    """Each is verified, and the firmware starts; a new part leaves the firmware alone."""
    notes = install(tmp_path, programmer)
    done = flash(*more.split(), "--table", table)
    assert done.returncode == 0, done.stderr
    told = notes.read_text()
    for name, file in (("FIRMWARE", firmware), ("TABLE", table), ("PLACE", FIRST_PLACE)):
        told = told.replace(str(file), name)
    assert told.splitlines() == list(ORDERS[programmer, more])


@pytest.mark.parametrize("programmer", PROGRAMMERS)
def test_dry_run_starts_nothing(flash: Flash, tmp_path: Path, table: Path, programmer: str) -> None:
    """The printed lines are those that would run; no programmer needs to be there."""
    notes = install(tmp_path, programmer)
    dry = flash("--firmware", "--table", table, "--programmer", programmer, "--dry-run")
    assert dry.returncode == 0, dry.stderr
    assert not notes.exists()
    assert flash("--firmware", "--table", table).stdout == dry.stdout
    assert notes.exists()


def test_damaged_table_is_refused_by_the_check(flash: Flash, tmp_path: Path, table: Path) -> None:
    """A flipped bit stops everything, firmware included, before a programmer starts."""
    notes = install(tmp_path, "openocd")
    image = bytearray(table.read_bytes())
    image[-40] ^= 1
    table.write_bytes(bytes(image))
    done = flash("--firmware", "--table", table)
    assert done.returncode == 2
    check = only_error(camsim("eval", table)).removeprefix("camsim: ")
    assert done.stderr == f"flash: {check}\n"
    assert "refused" in check
    assert not notes.exists()


def test_too_long_files_are_refused(flash: Flash, firmware: Path, table: Path) -> None:
    """Neither file may run over into what lies behind it."""
    for file, region, words in (
        (firmware, FIRMWARE, ("--firmware",)),
        (table, TABLE, ("--table", table)),
    ):
        file.write_bytes(file.read_bytes().ljust(region.size + 1, b"\0"))
        done = flash(*words, "--dry-run")
        assert done.returncode == 2
        assert f"do not fit into the {region.size} bytes of {region.name}" in done.stderr


@pytest.mark.parametrize("start", [b"", b"\x7fELF\1\1\1\0", struct.pack("<II", 0x2000_4000, 0x80)])
def test_what_is_no_firmware_is_refused(flash: Flash, firmware: Path, start: bytes) -> None:
    """The ELF file, an empty file and a vector that points elsewhere would not start."""
    firmware.write_bytes(start)
    done = flash("--firmware", "--dry-run")
    assert done.returncode == 2
    assert "not firmware for this board" in done.stderr


def test_failure_of_the_programmer_is_ours(flash: Flash, tmp_path: Path, table: Path) -> None:
    """The second file is not written when the first one failed."""
    notes = install(tmp_path, "pyocd", status=3)
    done = flash("--firmware", "--table", table)
    assert done.returncode == 1
    assert "pyocd ended with status 3" in done.stderr
    assert str(table) not in notes.read_text()


def test_bad_usage_is_told_in_one_line(flash: Flash, tmp_path: Path, table: Path) -> None:
    """Nothing to write, nobody to write, a file that is not there."""
    for words, told in (
        ((), "nothing to write"),
        (("--table", table), "no programmer is installed"),
        (("--table", table, "--programmer", "pyocd"), "pyocd: not installed"),
        (("--table", tmp_path / "none.camtab", "--dry-run"), "cannot be read"),
    ):
        done = flash(*words)
        assert done.returncode == 2
        assert re.fullmatch(rf"flash: .*{told}.*\n", done.stderr)


def test_openocd_cannot_take_braces(flash: Flash, tmp_path: Path, table: Path) -> None:
    """A name that would end the word early in openocd's language is refused."""
    odd = table.rename(tmp_path / "a} exit {b.camtab")
    done = flash("--table", odd, "--dry-run", "--programmer", "openocd")
    assert done.returncode == 2
    assert "rename it" in done.stderr
    assert flash("--table", odd, "--dry-run", "--programmer", "pyocd").returncode == 0


def test_regions_are_those_of_the_linker_script() -> None:
    """Firmware, log and table here and in stm32h743.ld."""
    text = (ROOT / "hal" / "stm32h743" / "stm32h743.ld").read_text()
    for name, region in (("FLASH", FIRMWARE), ("LOG", LOG), ("TABLE", TABLE)):
        found = re.search(rf"{name}\s*\(\w+\)\s*: ORIGIN = (\w+), LENGTH = (\d+)K", text)
        assert found is not None
        assert (int(found[1], 16), int(found[2]) * 1024) == (region.address, region.size)
