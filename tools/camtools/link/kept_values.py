r"""Parameters and learned values of a controller as files, and brought back.

Names, ranges and meanings are those of firmware/param/cam_param.h.

>>> values = {name: info.default for name, info in INFOS.items()}
>>> parse(text_of(values, "defaults").encode(), "all.toml") == values
True
>>> parse(b"[trims]\nx_trim_nm = 20", "trim.toml")
{'x_trim_nm': 20}

>>> text = learned_text([0] * N_VALUES, "a part")
>>> learned_values(text.encode(), "kept.toml") == [0] * N_VALUES
True
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from camtools.base.errors import CamtoolsError
from camtools.base.files import utf8_text
from camtools.base.project import ROOT
from camtools.base.text import toml_tree
from camtools.link.controller import Link, Status
from camtools.link.messages import NAMES, NUMBERS, Answer, Refused
from camtools.link.refusal_text import REMEDIES, ask_done

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


_TEXT = _HEADER.read_text("utf-8")
_BODY = _TEXT.split("#define CAM_PARAMS(X)")[1].split("\n\n")[0]
INFOS = {  # in the order of the controller
    name: Info(int(low), int(default), int(high), tuple(re.findall(r"cam_flag_(\w+)", flags)), what)
    for name, low, default, high, flags, what in _ROW.findall(_BODY)
}
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

    note: called with a line where retired parameters are ignored. Raises CamtoolsError: it is no
    TOML, or a parameter is unknown, twice there, no number or out of its range: a line for each.
    """
    try:
        tree = toml_tree(utf8_text(data, f"{name}: no parameters"))
    except ValueError as error:
        text = f"{name}: no parameters: {error}; save them by camctl params save"
        raise CamtoolsError([text]) from error
    retired: list[str] = []
    problems, values = [], {}
    for group, key, value in _flat(tree):
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

    Returns what was before and what is now, of those that have changed. Raises Refused: the
    controller refuses, or the bus is lost; nothing has changed.
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
    """Keep those in force, or bring others into force, by MEMORY; return the outcome."""
    answer = ask_done(link, MEMORY[action][0], timeout_s=KEEP_S)
    return f"{action}: done, version {answer.value:.0f}"


# Values of firmware/learning/cam_learning.h, in their order. The last word of a name is the unit:
# turn / 2^32 per tick, ticks / 2^16, ticks^2 / 2^16, turn / 2^32, nm / 64, 1 / 4096,
# turn / 2^23, 2^-32.
LAYOUT = {
    "speed_q32": 1,
    "k1_q16": 1,
    "k2_q16": 1,
    "masked_bits": 1,
    "phase_q32": 1,
    "correction_q6": 34,
    "gain_q12": 34,
    "ripple_q23": 32,
    "friction_q6": 1,
    "chip_q32": 1,
    "chip_mean_q32": 1,
}
N_VALUES = sum(LAYOUT.values())
_LEARNED_HEAD = """\
# What a camturn controller has learned; camctl learned load FILE brings it back.
# Harmonics 0 .. 16 (ripple: 1 .. 16) as pairs of real and imaginary part.
part = "{part}"
"""


def learned_text(values: Sequence[int], part: str) -> str:
    """Return the values, learned with the table of a part, as a TOML file."""
    name = "".join(c if c.isprintable() and c not in '"\\' else "?" for c in part)
    lines, at = [_LEARNED_HEAD.format(part=name)], 0
    for key, n in LAYOUT.items():
        here, at = list(values[at : at + n]), at + n
        lines.append(f"{key} = {here[0] if n == 1 else here}\n")
    return "".join(lines)


def learned_values(data: bytes, name: str) -> list[int]:
    """Return the values of such a file; an error names file, key and remedy."""

    def refused(problem: str) -> CamtoolsError:
        return CamtoolsError([f"{name}: {problem}; give a file of camctl learned save"])

    try:
        tree = toml_tree(utf8_text(data, f"{name}: no learned values"))
    except ValueError as error:
        raise refused(f"no learned values: {error}") from error
    for key in ("friction_q6", "chip_q32", "chip_mean_q32"):
        tree.setdefault(key, 0)  # files of version 1.0.0 have none
    values: list[int] = []
    for key, n in LAYOUT.items():
        found = tree.get(key)
        here = [found] if n == 1 else found
        if not isinstance(here, list) or len(here) != n or not all(map(_is_word, here)):
            what = f"{n} whole numbers" if n > 1 else "a whole number"
            raise refused(f"{key}: not {what} of 32 bits")
        values += here
    if extra := sorted(tree.keys() - LAYOUT.keys() - {"part"}):
        raise refused(f"{extra[0]}: unknown key")
    return values


def _is_word(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and -(2**31) <= value < 2**31


def _required(index: int, answer: Answer) -> Answer:
    if answer.result == "done":
        return answer
    result = answer.result.replace("_", " ")
    otherwise = REMEDIES.get(answer.result, "nothing is changed")
    remedy = "the state must be off or ready" if "state" in answer.result else otherwise
    raise Refused(f"learned value {index}: refused: {result}; {remedy}")


def get_learned(link: Link) -> list[int]:
    """Return all learned values."""
    answers = (_required(i, link.ask("get_learned", parameter=i)) for i in range(N_VALUES))
    return [int(answer.value) for answer in answers]


def set_learned(link: Link, values: Sequence[int]) -> None:
    """Bring learned values back; when one is refused, those of before come back."""
    before = get_learned(link)
    for index, value in enumerate(values):
        answer = link.ask("set_learned", parameter=index, value=value)
        if answer.result != "done":
            for back in range(index):
                link.ask("set_learned", parameter=back, value=before[back])
        _required(index, answer)


def learning_report(status: Status) -> list[str]:
    """Return the lines of the status about learning."""
    s = status.signals
    phase = NAMES["learn_phase"].get(int(s["learn_phase"]), "unknown")
    reason = NAMES["learn_reason"].get(int(s["learn_reason"]), "unknown")
    masked = [str(k) for k in range(17) if int(s["learn_masked"]) >> k & 1]
    why = "" if reason == "all" else f", {reason.replace('_', ' ')}"
    return [
        f"learning          {phase}{why}; {s['learn_turns']:.0f} turns, harmonics 0 .. "
        f"{s['learn_harmonics']:.0f}, masked: {', '.join(masked) or 'none'}",
        f"  error of U      {s['learn_error']:.3f} um rms, at first {s['learn_begin_error']:.3f}",
        f"  added           k1 {s['learn_k1']:+.3f} us, k2 {s['learn_k2']:+.0f} us2, "
        f"correction {s['learn_correction']:.3f} um",
        f"  spindle         ripple {s['learn_ripple']:.3f} uturn; "
        f"learned at {s['learn_speed']:.1f} r/min",
    ]
