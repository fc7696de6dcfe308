# SPDX-License-Identifier: Apache-2.0
"""The sample configuration in the whole of LinuxCNC, without its screen: a program of mkgcode's."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.linuxcnc.halbox import Halbox
from tests.tools.cases.part_cases import ROOT

pytest_plugins = ["tests.linuxcnc.halrun_fixtures"]

SIM = ROOT / "hal" / "linuxcnc" / "sim"
MESA = ROOT / "hal" / "linuxcnc" / "mesa" / "lathe.hal"
PROGRAMS = ("linuxcncsvr", "io", "milltask")
BLOCKS = (
    "M3 S500", "G4 P1.5", "M64 P0", "M66 P0 L3 Q10", "G33 Z5 K0.25", "M65 P0", "M66 P0 L4 Q10",
)  # fmt: skip


def _settings(box: Halbox, table: Path, hal: Path = SIM / "lathe.hal") -> None:
    """Copy the configuration; only places of files are others."""
    shutil.copy(table, box.folder / "part.camtab")
    for file in (hal, SIM / "lathe.tbl"):
        shutil.copy(file, box.folder)
    text = (SIM / "lathe.ini").read_text()
    nml = f"NML_FILE = {box.folder / 'linuxcnc.nml'}\n[CAMTURN]"
    for old, new in (
        ("[CAMTURN]", nml),
        ("/tmp/perkins240.camtab", "./part.camtab"),
        ("/tmp/camturn-sim.var", str(box.folder / "sim.var")),
    ):
        assert old in text
        text = text.replace(old, new, 1)
    (box.folder / "lathe.ini").write_text(text)


@pytest.fixture
def lathe(box: Halbox, linuxcnc_root: Path, table_of: Callable[[str], Path]) -> Iterator[Halbox]:
    """Return the simulated lathe."""
    _settings(box, table_of("perkins240"))
    with _started(box, linuxcnc_root):
        yield box


@contextmanager
def _started(box: Halbox, linuxcnc_root: Path) -> Iterator[None]:
    """Start what LinuxCNC's own script starts, in its order."""
    shutil.copy(linuxcnc_root / "usr" / "share" / "linuxcnc" / "linuxcnc.nml", box.folder)
    for name in PROGRAMS:
        shutil.copy(linuxcnc_root / "usr" / "bin" / name, box.folder)
    ini = ("-ini", "lathe.ini")
    try:
        for words in (
            ("./linuxcncsvr", *ini),
            ("./halcmd", "loadusr", "-Wn", "iocontrol", "./io", *ini),
            ("./halcmd", "loadrt", "tpmod"),
            ("./halcmd", "loadrt", "homemod"),
            ("./halcmd", "-i", "lathe.ini", "-f", "lathe.hal"),
            ("./halcmd", "start"),
            ("./halcmd", "loadusr", "-Wn", "inihal", "./milltask", *ini),
        ):
            assert box.run(*words) == 0, (words, box.said())
        yield
    finally:
        _end(box)


def _end(box: Halbox) -> None:
    """End the programs that were started in this folder, and nothing else."""
    for process in Path("/proc").iterdir():
        try:
            is_ours = (process / "cwd").readlink() == box.folder
        except OSError:
            continue
        if (
            is_ours
            and process.name.isdigit()
            and (process / "comm").read_text().strip() in PROGRAMS
        ):
            os.kill(int(process.name), signal.SIGTERM)


def test_a_program_starts_waits_cuts_and_stops(lathe: Halbox, linuxcnc_root: Path) -> None:
    """M64 starts, M66 sees "in cut", G33 moves Z meanwhile, M65 ends it, M66 sees that."""
    modules = str(linuxcnc_root / "usr" / "lib" / "python3" / "dist-packages")
    script = Path(__file__).with_name("mdi.py")
    shutil.copy(script, lathe.folder)
    words = ("/usr/bin/python3", script.name, str(lathe.folder / "linuxcnc.nml"), *BLOCKS)
    assert lathe.run(*words, PYTHONPATH=modules) == 0, lathe.said()
    said = lathe.said().splitlines()
    assert "M66 P0 L3 Q10: 1 1 1 0.000" in said
    assert "G33 Z5 K0.25: 1 1 1 5.000" in said
    assert "M66 P0 L4 Q10: 1 0 0 5.000" in said
    assert lathe.get("camturn.error-number") == "0"
    assert lathe.get("camturn.fault") == "FALSE"


def test_mesa_configuration_is_taken_by_hal(
    box: Halbox, linuxcnc_root: Path, table_of: Callable[[str], Path]
) -> None:
    """Every line of it, with a component that has the pins of the card in place of its drivers."""
    _settings(box, table_of("perkins240"), MESA)
    script = box.folder / "lathe.hal"
    lines = script.read_text().splitlines()
    drivers = [
        i for i, line in enumerate(lines) if line.startswith(("loadrt hostmot2", "loadrt hm2_"))
    ]
    lines[drivers[0] : drivers[-1] + 1] = ["loadrt mesa_pins"]
    script.write_text("\n".join(lines) + "\n")
    with _started(box, linuxcnc_root):
        assert box.get("camturn.tick-hz-used") == "1000"
        assert box.get("camturn.k1-ns") == "0"
        assert float(box.get("u-sum.gain1")) == 0.002
