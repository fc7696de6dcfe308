# SPDX-License-Identifier: Apache-2.0
r"""Subcommand of camctl about all parameters: files, and what the controller keeps.

>>> print(*table({"lead_ns": (50000, 60000)}, ("file", "controller")), sep="\n")
parameter           file  controller
lead_ns            50000       60000
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path

from camtools.base.errors import CamtoolsError
from camtools.base.input_file import read_limited
from camtools.base.output import write_all
from camtools.link.controller import Link
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
FILES = {
    "save": "save all parameters to a TOML file",
    "load": "set the parameters of a file, all or none",
    "diff": "compare a file with the controller; status 1 where they differ",
}
Say = Callable[[str], None]


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


def _save(link: Link, path: Path, say: Say) -> None:
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


def _load(link: Link, path: Path, say: Say) -> None:
    values = _read(path, say)
    try:
        changes = set_all(link, values)
    except Refused as refused:
        raise Refused(f"{path}: nothing is changed: {refused}") from refused
    for line in table(changes, ("before", "now")) if changes else []:
        say(line)
    say(f"{path}: {len(changes)} of {len(values)} parameters changed")


def _diff(link: Link, path: Path, say: Say) -> None:
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


def params(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Save, load or compare a file, or change what the controller keeps.

    Raises
    ------
    Refused
        The controller refuses, or a comparison finds a difference.
    """
    action: str = arguments.action
    if action in MEMORY:
        say(change_kept(link, action))
        return
    {"save": _save, "load": _load, "diff": _diff}[action](link, arguments.file, say)
    if action == "load" and arguments.keep:
        say(change_kept(link, "keep"))
