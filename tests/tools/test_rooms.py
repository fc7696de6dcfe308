"""A room of firmware, HAL or simulator sees the rooms below it and no others.

The compiler is asked, not CMake, with the include paths that the host build gives the sources of a
room: whether it finds a header of each other room, and whether a file compiles that includes all
that it finds.
"""

import json
import os
import re
import shlex
import subprocess
from functools import cache
from pathlib import Path

import pytest

from tests.tools.cases.camsim_cases import BUILD, ROOT

# The design: each room with the rooms that it stands on. Whatever these see, it sees as well.
DESIGN = {
    "hal/include": (),
    "hal/common": (),
    "hal/defaults": ("hal/include",),
    "hal/host": ("hal/include",),
    "hal/linux/setup": ("hal/include", "hal/common"),
    "hal/linux/bus": ("hal/linux/setup",),
    "hal/linux/tick": ("hal/include",),
    "hal/linuxcnc": ("hal/include", "firmware/machine"),
    "firmware/base": ("hal/include",),
    "firmware/table": ("firmware/base",),
    "firmware/motion": ("firmware/table",),
    "firmware/record": ("firmware/motion", "firmware/servo"),
    "firmware/servo": ("firmware/base",),
    "firmware/plan": ("firmware/record",),
    "firmware/tick": ("firmware/plan",),
    "firmware/param": ("firmware/table",),
    "firmware/doubles": (),
    "firmware/feasible": ("firmware/doubles", "firmware/param", "firmware/tick"),
    "firmware/build": ("firmware/feasible",),
    "firmware/learning": ("firmware/doubles", "firmware/record"),
    "firmware/recorder": ("firmware/record",),
    "firmware/machine": ("firmware/build", "firmware/learning", "firmware/recorder"),
    "firmware/remote": ("firmware/machine",),
    "firmware": ("firmware/remote",),
    "host_sim/base": ("hal/common",),
    "host_sim/lathe": ("host_sim/base", "hal/include"),
    "host_sim/part": ("host_sim/base", "firmware/table"),
    "host_sim/gauge": ("host_sim/part",),
    "host_sim/bus": ("host_sim/lathe",),
    "host_sim/port": ("host_sim/lathe", "firmware/machine", "hal/host"),
    "host_sim/setup": ("host_sim/lathe", "host_sim/part", "firmware/machine"),
    "host_sim/cut": ("host_sim/setup", "host_sim/gauge", "host_sim/port", "host_sim/bus"),
    "host_sim/results": ("host_sim/cut",),
    "host_sim/live": ("host_sim/results", "firmware/remote"),
    "host_sim/cli": ("host_sim/live",),
    "host_sim/api": ("host_sim/cli",),
    "host_sim/api/judge": ("firmware/machine",),
}
# Ports that the host does not build: nobody there sees their headers.
FOREIGN = ("hal/linux", "hal/mps2", "hal/stm32h743", "hal/template")
# Sources of the room above them.
PARTS = {"host_sim/bus/linux", "host_sim/bus/none", "hal/stm32h743/memory", "firmware/remote/can"}
WITHOUT_HEADERS = {"hal/defaults", "hal/template", "firmware"}
WITHOUT_SOURCES = {"hal/include"}  # in the build of the host


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


def found_by(room: str, headers: list[str], folder: Path) -> set[str]:
    """Return which of some headers the preprocessor finds in a room."""
    source = folder / "all.c"
    lines = [f'#if __has_include("{one}")\n{i}\n#endif\n' for i, one in enumerate(headers)]
    source.write_text("".join(lines))
    done = run_compiler(room, "-E", "-P", str(source))
    assert done.returncode == 0, done.stderr
    return {headers[int(number)] for number in done.stdout.split()}


def compiles(room: str, headers: list[str], folder: Path) -> bool:
    """Return whether a file that only includes some headers compiles in a room."""
    source = folder / "some.c"
    lines = "".join(f'#include "{header}"\n' for header in headers)
    source.write_text(f"{lines}extern int n_room;\n")  # a header may hold macros alone
    return run_compiler(room, "-fsyntax-only", str(source)).returncode == 0


def run_compiler(room: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the compiler of the host build with the options of a room."""
    return subprocess.run([*options(room), *words], capture_output=True, text=True, check=False)


def test_every_folder_of_c_is_a_room_of_the_design() -> None:
    """A new folder takes a place in the design above before anything can be built on it."""
    held = subprocess.run(
        ["git", "-C", ROOT, "ls-files", "firmware/*.[ch]", "hal/*.[ch]", "host_sim/*.[ch]"],
        capture_output=True,
        text=True,
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
    headers = {one: header_of(one) for one in others}
    found = sorted(found_by(room, list(headers.values()), tmp_path))
    allowed = seen_by(room) - {room, *WITHOUT_HEADERS}
    assert {one for one in others if headers[one] in found} == allowed
    bad = [] if compiles(room, found, tmp_path) else found
    assert [one for one in bad if not compiles(room, [one], tmp_path)] == []
    if room not in WITHOUT_HEADERS:
        assert compiles(room, [header_of(room)], tmp_path), "alone in its own room"


def test_no_include_climbs_out_of_its_room() -> None:
    """A path with ".." would go round the include paths, so no file of ours has one."""
    folders = ("firmware", "hal", "host_sim", "tests")
    sources = [path for folder in folders for path in (ROOT / folder).rglob("*.[ch]")]
    climbing = [
        str(path) for path in sources if re.search(r'#include "[^"]*\.\.', path.read_text())
    ]
    assert sources
    assert not climbing
