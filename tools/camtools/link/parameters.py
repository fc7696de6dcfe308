# SPDX-License-Identifier: Apache-2.0
r"""All parameters of a controller as a TOML file, and brought back all at once.

Names, ranges and meanings are those of firmware/param/cam_param.h.

>>> values = {name: info.default for name, info in INFOS.items()}
>>> parse(text_of(values, "defaults").encode(), "all.toml") == values
True
>>> parse(b"[trims]\nx_trim_nm = 20", "trim.toml")
{'x_trim_nm': 20}
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from camtools.base.errors import CamtoolsError
from camtools.base.project_paths import ROOT
from camtools.base.toml_text import toml_tree
from camtools.link.controller import Link
from camtools.link.messages import NUMBERS
from camtools.link.refusal_text import ask_done

_HEADER = ROOT / "firmware" / "param" / "cam_param.h"
_ROW = re.compile(r'X\((\w+),\s*(-?\d+),\s*(-?\d+),\s*(-?\d+),([^"]*),\s*"([^"]*)"')
_HEAD = """\
# Parameters of a camturn controller, {origin}.
# tools/camctl params load brings them into force, all of them or none. Values are whole numbers in
# the unit at the end of the name. A file may leave parameters out: load leaves those as they are.
"""
# In the order of the file; the first group that a name begins with has it.
_GROUPS = {
    "encoder": ("counts_per", "encoder", "index", "jump", "observer", "eccentricity", "late"),
    "learning": ("learn", "probe", "ripple", "rehearse", "u_scale"),
    "axis_u": ("u_", "lead", "k1", "k2", "following", "enable", "servo"),
    "axes_x_z": ("x_", "z_", "xz_"),
    "spindle": ("spindle", "stopped"),
    "swing": ("swing",),
    "cut": ("phase", "amplitude", "engage", "disengage", "feed", "pass"),
    "tools": ("tool",),
    "other": ("",),
}
KEEP_S = 30.0  # flash may have to be erased
MEMORY = {
    "keep": (
        "save_parameters",
        "store the current parameters in the controller, for its next start",
    ),
    "revert": ("revert_parameters", "restore the stored parameters"),
    "defaults": ("restore_defaults", "restore the defaults; the stored parameters stay"),
}
# What the text that a controller keeps for itself has besides.
_KEPT = ("version", "crc32")


@dataclass(frozen=True)
class Info:
    """Range, default, flags (those of cam_flag_t) and meaning of a parameter."""

    low: int
    default: int
    high: int
    flags: tuple[str, ...]
    what: str


def infos_of(text: str) -> dict[str, Info]:
    """Return the parameters of the text of cam_param.h, in their order."""
    body = text.split("#define CAM_PARAMS(X)")[1].split("\n\n")[0]
    return {
        name: Info(
            int(low), int(default), int(high), tuple(re.findall(r"cam_flag_(\w+)", flags)), what
        )
        for name, low, default, high, flags, what in _ROW.findall(body)
    }


_TEXT = _HEADER.read_text("utf-8")
INFOS = infos_of(_TEXT)
_RETIRED = tuple(
    re.findall(r"X\((\w+)\)", _TEXT.split("#define CAM_RETIRED_PARAMS")[1].split("\n")[0])
)


def group_of(name: str) -> str:
    """Return the group of a parameter in a file."""
    return next(group for group, starts in _GROUPS.items() if name.startswith(starts))


def checksum(values: Mapping[str, int]) -> int:
    """Return the checksum of all parameters, as cam_param_store_checksum() has it."""
    return zlib.crc32("".join(f"{name} = {values[name]}\n" for name in INFOS).encode())


def text_of(values: Mapping[str, int], origin: str) -> str:
    """Return parameters as a TOML file, by groups, with ranges and meanings."""
    lines = [_HEAD.format(origin=origin)]
    for group in _GROUPS:
        names = [name for name in INFOS if name in values and group_of(name) == group]
        lines += [f"\n[{group}]\n"] if names else []
        for name in names:
            info = INFOS[name]
            lines.append(f"# {info.what}\n")
            lines.append(f"# {info.low} .. {info.high}, default {info.default}\n")
            lines.append(f"{name} = {values[name]}\n")
    return "".join(lines)


def _flat(table: Mapping[str, object], where: str = "") -> list[tuple[str, str, object]]:
    """Return the group, key and value of all keys."""
    found: list[tuple[str, str, object]] = []
    for key, value in table.items():
        if isinstance(value, dict) and not where:
            found += _flat(value, key)
        else:
            found.append((where, key, value))
    return found


def problem_of(name: str, value: object) -> str:
    """Return what is wrong with a value, "" when nothing is."""
    if name not in INFOS:
        return f"{name}: no such parameter; tools/camctl list prints all"
    if not isinstance(value, int) or isinstance(value, bool):
        return f"{name} = {value}: give a whole number"
    info = INFOS[name]
    if not info.low <= value <= info.high or ("sign" in info.flags and value == 0):
        return f"{name} = {value}: out of range; give {info.low} .. {info.high}"
    return ""


def parse(data: bytes, name: str, note: Callable[[str], object] = lambda _: None) -> dict[str, int]:
    """Return the parameters of a file, in the order of the controller; groups have no meaning.

    Parameters
    ----------
    data : bytes
        TOML.
    name : str
        Of the file, for messages.
    note : function
        Gets a line where the file has retired parameters, which are ignored.

    Raises
    ------
    CamtoolsError
        It is no TOML, or a parameter is unknown, twice there, no number or out of its range: a
        line for each.
    """
    try:
        told = toml_tree(data.decode("utf-8"))
    except ValueError as error:
        text = f"{name}: no parameters: {error}; save them by camctl params save"
        raise CamtoolsError([text]) from error
    retired: list[str] = []
    problems, values = [], {}
    for group, key, value in _flat(told):
        if key in _KEPT and not group:
            continue
        if key.startswith(_RETIRED):
            retired.append(key)
            continue
        problem = f"{key}: appears twice; give it once" if key in values else problem_of(key, value)
        problems += [f"{name}: {problem}"] if problem else []
        values[key] = value
    if problems or not values:
        raise CamtoolsError(problems or [f"{name}: no parameters; give NAME = VALUE"])
    if retired:
        note(f"{name}: retired and ignored: {len(retired)} parameters, first {retired[0]}")
    return {key: int(str(values[key])) for key in INFOS if key in values}


def get_all(link: Link) -> dict[str, int]:
    """Return all parameters in force."""
    numbers = NUMBERS["parameter"]
    return {name: int(ask_done(link, "get_parameter", numbers[name]).value) for name in INFOS}


def set_all(link: Link, values: Mapping[str, int]) -> dict[str, tuple[int, int]]:
    """Bring parameters into force, all of them in the same tick, or none.

    Returns
    -------
    dict
        what was before and what is now, of those that have changed

    Raises
    ------
    Refused
        The controller refuses, or the bus is lost; nothing has changed.
    """
    ask_done(link, "begin_parameters")
    before = get_all(link)
    changes = {name: (before[name], new) for name, new in values.items() if before[name] != new}
    for name, (_, new) in changes.items():
        ask_done(link, "stage_parameter", NUMBERS["parameter"][name], value=new)
    if changes:
        ask_done(link, "commit_parameters")
    return changes


def change_kept(link: Link, action: str) -> str:
    """Keep those in force, or bring others into force, by MEMORY; return what is so now."""
    answer = ask_done(link, MEMORY[action][0], timeout_s=KEEP_S)
    return f"{action}: done, version {answer.value:.0f}"
