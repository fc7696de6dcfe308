# SPDX-License-Identifier: Apache-2.0
"""A room of firmware, HAL or simulator sees the rooms below it and no others.

The compiler is asked, not CMake: a file of one line, which includes a header of another room, is
compiled with the include paths that the host build gives the sources of a room.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import pytest

from part_cases import ROOT

BUILD = Path(os.environ.get("CAMTURN_BUILD") or ROOT / "build" / "host").resolve()

# The design: each room with the rooms that it stands on. Whatever these see, it sees as well.
DESIGN = {
    "hal/include": (),
    "hal/common": (),
    "hal/host": ("hal/include",),
    "hal/template": ("hal/include",),
    "hal/linux/setup": ("hal/include", "hal/common"),
    "hal/linux/bus": ("hal/linux/setup",),
    "hal/linux/tick": ("hal/include",),
    "hal/linuxcnc": ("hal/include", "hal/common", "firmware/machine"),
    "firmware/base": ("hal/include",),
    "firmware/table": ("firmware/base",),
    "firmware/tick": ("firmware/table",),
    "firmware/machine": ("firmware/tick",),
    "firmware/remote": ("firmware/machine",),
    "firmware": ("firmware/remote",),
    "host_sim/base": ("hal/common",),
    "host_sim/lathe": ("host_sim/base", "hal/include"),
    "host_sim/part": ("host_sim/base", "firmware/table"),
    "host_sim/gauge": ("host_sim/part",),
    "host_sim/bus": ("host_sim/lathe",),
    "host_sim/target/pil": ("hal/include",),
    "host_sim/target": ("host_sim/lathe", "firmware/machine", "hal/host", "host_sim/target/pil"),
    "host_sim/session": ("host_sim/gauge", "host_sim/target", "host_sim/bus"),
    "host_sim/live": ("host_sim/session", "firmware/remote"),
    "host_sim/cli": ("host_sim/live",),
    "host_sim/api": ("host_sim/cli",),
}
# Ports that the host does not build: nobody there sees their headers.
FOREIGN = ("hal/linux", "hal/mps2", "hal/stm32h743")
# Sources of the room above them, one for each kind of computer.
PARTS = {"host_sim/bus/linux", "host_sim/bus/none"}
WITHOUT_HEADERS = {"hal/template", "firmware"}
WITHOUT_SOURCES = {"hal/include", "host_sim/target/pil"}  # in the build of the host


def seen_by(room: str) -> set[str]:
    """Return the rooms that the design lets a room see, itself included."""
    return {room}.union(*(seen_by(below) for below in DESIGN[room]))


def headers_in(room: str) -> Path:
    """Return the folder from which others include a room's headers."""
    inner = ROOT / room / "include"
    return inner if inner.is_dir() else ROOT / room


def header_of(room: str) -> str:
    """Return a header of a room as others include it."""
    folder = headers_in(room)
    found = sorted([*folder.glob("*.h"), *folder.glob("hal/*.h")])
    assert found, f"{room} has no header"
    return found[0].relative_to(folder).as_posix()


@cache
def commands() -> dict[str, list[str]]:
    """Return for each folder with sources how the host build compiles one of them."""
    entries = json.loads((BUILD / "compile_commands.json").read_text())
    return {
        os.path.relpath(Path(entry["file"]).parent, ROOT): shlex.split(entry["command"])
        for entry in entries
    }


def options(room: str) -> list[str]:
    """Return compiler and options of a room, without what names its source and its object."""
    words = commands()[room]
    return words[: words.index("-o")]


def sees(room: str, header: str, folder: Path) -> bool:
    """Return whether a file of one line that includes a header compiles in a room."""
    source = folder / "one_line.c"
    done = subprocess.run(
        [*options(room), "-fsyntax-only", str(source)],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0 or f"{header}: No such file" in done.stderr, done.stderr
    return done.returncode == 0


def test_every_folder_of_c_is_a_room_of_the_design() -> None:
    """A new folder takes a place in the design above before anything can be built on it."""
    held = subprocess.run(
        ["git", "-C", ROOT, "ls-files", "firmware/*.[ch]", "hal/*.[ch]", "host_sim/*.[ch]"],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    ).stdout.split()
    folders = {str(Path(name).parent) for name in held}
    rooms = {*DESIGN, *FOREIGN} - {"hal/include"} | {"hal/include/hal"}
    within = {f"{room}/include" for room in rooms if (ROOT / room / "include").is_dir()}
    assert folders - PARTS == rooms | within


@pytest.mark.parametrize("room", sorted({*DESIGN} - WITHOUT_SOURCES))
def test_room_sees_the_rooms_below_it_and_no_others(room: str, tmp_path: Path) -> None:
    """Its sources compile with a header of each room that the design allows, and of no other."""
    others = [one for one in (*DESIGN, *FOREIGN) if one not in {room, *WITHOUT_HEADERS}]

    def look(other: str) -> bool:
        folder = tmp_path / other.replace("/", "_")
        folder.mkdir()
        header = header_of(other)
        (folder / "one_line.c").write_text(f'#include "{header}"\n')
        return sees(room, header, folder)

    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        found = dict(zip(others, pool.map(look, others), strict=True))
    assert {one for one in others if found[one]} == seen_by(room) - {room, *WITHOUT_HEADERS}


def test_wrong_arrow_would_be_found(tmp_path: Path) -> None:
    """The compiler refuses a header of a room above, and says that it finds no such file."""
    (tmp_path / "one_line.c").write_text('#include "cam_machine.h"\n')
    assert not sees("firmware/table", "cam_machine.h", tmp_path)
    assert sees("firmware/remote", "cam_machine.h", tmp_path)


def test_no_include_climbs_out_of_its_room() -> None:
    """A path with ".." would go round the include paths, so no file of ours has one."""
    folders = ("firmware", "hal", "host_sim", "tests")
    sources = [path for folder in folders for path in (ROOT / folder).rglob("*.[ch]")]
    climbing = [
        str(path) for path in sources if re.search(r'#include "[^"]*\.\.', path.read_text())
    ]
    assert sources
    assert not climbing
