# SPDX-License-Identifier: Apache-2.0
r"""Commands of camctl about all parameters: files, and what the controller keeps.

>>> print(*table({"lead_ns": (50000, 60000)}, ("file", "controller")), sep="\n")
parameter           file  controller
lead_ns            50000       60000
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

from camtools.base.arguments import Commands, Option, Word
from camtools.base.errors import CamtoolsError
from camtools.base.input_file import read_limited
from camtools.base.output import write_all
from camtools.cli.camctl_control import Control
from camtools.link.messages import Refused
from camtools.link.parameters import (
    INFOS,
    MEMORY,
    change_kept,
    checksum,
    get_all,
    parse,
    set_all,
    text_of,
)

_MOST_BYTES = 1024 * 1024
Say = Callable[[str], None]
TomlFile = Annotated[Path, Word("TOML file")]


def table(pairs: Mapping[str, tuple[int, int]], heads: tuple[str, str]) -> list[str]:
    """Return a line for each parameter with two values, below a line of heads."""
    width = max((len(name) for name in pairs), default=0)
    rows = [("parameter", *heads), *((name, *map(str, two)) for name, two in pairs.items())]
    return [f"{name:<{max(width, 12)}}{a:>12}{b:>12}" for name, a, b in rows]


def _read(path: Path, say: Say) -> dict[str, int]:
    try:
        return parse(read_limited(path, _MOST_BYTES), str(path), say)
    except OSError as error:
        raise CamtoolsError([f"{path}: {error.strerror}; check the path"]) from error


def save(control: Control, file: TomlFile) -> None:
    """Save all parameters to a TOML file."""
    link, path, say = control.link, file, control.say
    values = get_all(link)
    s = link.listen().signals
    if int(s["params_checksum"]) != checksum(values):
        raise Refused(
            f"{path}: not written: the checksum of the controller, "
            f"{int(s['params_checksum']):08x}, does not match its parameters, "
            f"{checksum(values):08x}; is its version different, or is somebody setting parameters?"
        )
    origin = f"version {s['params_version']:.0f}, checksum {checksum(values):08x}"
    write_all(path.parent, {path.name: text_of(values, origin).encode()})
    say(f"{path}: {len(values)} parameters, {origin}")


def load(
    control: Control,
    file: TomlFile,
    *,
    keep: Annotated[bool, Option("also store them in the controller, for its next start")] = False,
) -> None:
    """Set the parameters of a file, all or none."""
    link, path, say = control.link, file, control.say
    values = _read(path, say)
    try:
        changes = set_all(link, values)
    except Refused as refused:
        raise Refused(f"{path}: nothing is changed: {refused}") from refused
    for line in table(changes, ("before", "now")) if changes else []:
        say(line)
    say(f"{path}: {len(changes)} of {len(values)} parameters changed")
    if keep:
        say(change_kept(link, "keep"))


def diff(control: Control, file: TomlFile) -> None:
    """Compare a file with the controller; status 1 where they differ."""
    link, path, say = control.link, file, control.say
    values = _read(path, say)
    is_whole = len(values) == len(INFOS)
    if is_whole and int(link.listen().signals["params_checksum"]) == checksum(values):
        say(f"{path}: equal, checksum {checksum(values):08x}")
        return
    there = get_all(link)
    pairs = {name: (values[name], there[name]) for name in values if values[name] != there[name]}
    for line in table(pairs, ("file", "controller")) if pairs else []:
        say(line)
    if pairs:
        raise Refused(f"{path}: {len(pairs)} of {len(values)} parameters differ")
    say(f"{path}: equal; {len(INFOS) - len(values)} parameters are not in the file")


def _memory(action: str, text: str) -> Callable[[Control], None]:
    def carry_out(control: Control) -> None:
        control.say(change_kept(control.link, action))

    carry_out.__doc__ = text
    return carry_out


COMMANDS: Commands = {
    "save": save,
    "load": load,
    "diff": diff,
    **{name: _memory(name, text) for name, (_, text) in MEMORY.items()},
}
