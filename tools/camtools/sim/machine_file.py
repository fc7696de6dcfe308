r"""Machine files of the simulator: found, made from limits, read, changed, written, described.

A machine is a tree: tables of keys, as TOML has them; `host_sim/machines/default.toml` lists every
key. What the controller is configured from stands in `[believed.TABLE]`.

>>> tree = read_machine('[u]\ndelay_us = 75\n', "a.toml")
>>> print(emit_machine(mistaken(tree, {"u.delay_us": 80.0})))
[u]
delay_us = 80.0
[believed.u]
delay_us = 75
<BLANKLINE>
>>> "real" in names(), machine_path("real").name
(True, 'real.toml')
"""

import copy
import json
import math
import re
from codecs import BOM_UTF8
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from camtools.base.errors import CamtoolsError, InputError
from camtools.base.files import read_text
from camtools.base.project import ROOT
from camtools.base.quantities import NM_PER_UM
from camtools.base.text import toml_tree
from camtools.part.common import MachineLimits
from camtools.part.schema import DRAFT, Schema
from camtools.sim.binding import key_lines

Tree = dict[str, Any]
MACHINES = ROOT / "host_sim" / "machines"
BELIEVED = "believed"
_MAX_BYTES = 1 << 20
_INERTIA_KGM2 = 0.1  # of the default machine


class Machine(NamedTuple):
    """A machine file."""

    name: str  # for messages: the file as the user named it
    text: str  # TOML


def names() -> list[str]:
    """Return the names of all machines that come with the simulator."""
    return sorted(path.stem for path in MACHINES.glob("*.toml"))


def machine_path(word: str) -> Path:
    """Return the file of a machine by its name in host_sim/machines or its path, or refuse it."""
    if word in names():
        return MACHINES / f"{word}.toml"
    path = Path(word)
    if word and path.is_file():
        return path
    known = ", ".join(names())
    raise CamtoolsError([f"--machine {word}: no such machine; give one of {known}, or a file"])


def machine_bytes(word: str) -> bytes:
    """Return what the file of a machine holds, without a byte-order mark; see `machine_path`."""
    path = machine_path(word)
    try:
        return path.read_bytes().removeprefix(BOM_UTF8)
    except OSError as error:
        problem = f"--machine {word}: cannot be read: {error.strerror}"
        raise CamtoolsError([f"{problem}; give a readable file"]) from error


def find_machine(word: str | Path) -> Machine:
    """Return a machine by its name or by the path of its file."""
    path = machine_path(str(word))
    return Machine(path.name if str(word) == path.stem else str(word), read_text(path, _MAX_BYTES))


def machine_text(limits: MachineLimits, wear_um: float = 0.0) -> str:
    """Return a machine file with a part's limits, as far as the simulator's ranges go.

    A worn tool stands back, and the controller's offset of X makes up for it.

    >>> print(*machine_text(MachineLimits(), 25.0).splitlines()[-4:], sep=" | ")
    [tool] | wear_um = 25.0 | [controller] | x_trim_nm = -25000
    """
    inertia = limits.spindle_inertia_kgm2 or _INERTIA_KGM2
    tree: Tree = {
        "machine": {"name": "default, limits of the part file", "tick_hz": limits.tick_hz},
        "spindle": {
            "limit_rpm": limits.spindle_rpm,
            "torque_Nm": inertia * limits.alpha_rad_s2,
            "inertia_kgm2": inertia,
            "bandwidth_rad_per_s": limits.spindle_bandwidth_rad_s,
            "ripple": limits.spindle_ripple,
        },
        "u": {
            "speed_mm_per_s": min(max(limits.u_speed_mm_s, 0.1), 10_000.0),
            "acceleration_mm_per_s2": min(max(limits.u_acceleration_mm_s2, 10.0), 1e7),
            "stroke_mm": limits.u_stroke_mm,
        },
        "z": {
            "speed_mm_per_s": limits.z_speed_mm_s,
            "acceleration_mm_per_s2": limits.z_acceleration_mm_s2,
        },
    }
    if wear_um:
        trim_nm = round(-wear_um * NM_PER_UM)
        tree |= {"tool": {"wear_um": wear_um}, "controller": {"x_trim_nm": trim_nm}}
    return (
        f"# The simulator's default machine with the limits of the part file.\n{emit_machine(tree)}"
    )


def read_machine(text: str, name: str) -> Tree:
    """Return the tree of a machine's text; only the simulator knows which keys exist."""
    try:
        return toml_tree(text)
    except ValueError as error:
        raise InputError(name, "", None, f"not TOML: {error}", "correct it") from error


def emit_machine(tree: Mapping[str, Any]) -> str:
    """Return a tree as text that the simulator reads."""
    lines: list[str] = []
    for table, keys in tree.items():
        plain = {key: value for key, value in keys.items() if not isinstance(value, dict)}
        nested = {key: value for key, value in keys.items() if isinstance(value, dict)}
        if plain or not nested:
            lines.append(f"[{table}]")
            lines += [f"{key} = {_value(value)}" for key, value in plain.items()]
        for name, inner in nested.items():
            lines.append(f"[{table}.{name}]")
            lines += [f"{key} = {_value(value)}" for key, value in inner.items()]
    return "\n".join(lines) + "\n"


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)


@cache
def _defaults() -> Tree:
    path = MACHINES / "default.toml"
    return read_machine(read_text(path, _MAX_BYTES), path.name)


def nominal_of(tree: Mapping[str, Any], key: str) -> float | None:
    """Return a number as the controller believes it, else that of the machine, else its default.

    None where this is no number.

    >>> nominal_of({}, "u.delay_us"), nominal_of({"u": {"delay_us": 80}}, "u.delay_us")
    (75.0, 80.0)
    """
    table, _, name = key.rpartition(".")
    for source in (tree.get(BELIEVED, {}), tree, _defaults()):
        value = source.get(table, {}).get(name)
        if isinstance(value, int | float) and math.isfinite(value):
            return float(value)
    return None


def mistaken(tree: Tree, truth: Mapping[str, float]) -> Tree:
    """Return the machine whose truth differs from what its controller believes.

    The controller goes on believing the numbers that it has: those of `[believed]`, else those that
    were the truth before.
    """
    changed = copy.deepcopy(tree)
    for key, value in truth.items():
        table, _, name = key.rpartition(".")
        nominal = nominal_of(tree, key)
        beliefs = changed.setdefault(BELIEVED, {}).setdefault(table, {})
        if nominal is not None:
            written = tree.get(table, {}).get(name, nominal)
            beliefs.setdefault(name, written)
        changed.setdefault(table, {})[name] = value
    believed = changed.pop(BELIEVED, None)
    return changed | ({BELIEVED: believed} if believed else {})


class MachineKey(NamedTuple):
    """A key of machine files that holds a number or a choice."""

    table: str
    name: str
    kind: str  # number, whole, sign or choice
    low: float
    high: float
    default: float  # of a choice its index
    choices: list[str]
    meaning: str


def machine_keys() -> list[MachineKey]:
    """Return the keys in the order of host_sim/setup/sim_config.c."""
    found = []
    for line in key_lines().splitlines():
        table, name, kind, low, high, default, words, meaning = line.split("\t")
        numbers = float(low), float(high), float(default)
        choices = re.findall(r'"([^"]*)"', words)
        found.append(MachineKey(table, name, kind, *numbers, choices, meaning))
    return found


def _key(key: MachineKey) -> Schema:
    meaning = {"description": key.meaning} if key.meaning else {}
    if key.kind == "choice":
        return {"enum": key.choices, "default": key.choices[int(key.default)]} | meaning
    if key.kind == "sign":
        return {"enum": [int(key.low), int(key.high)], "default": int(key.default)} | meaning
    kind = "integer" if key.kind == "whole" else "number"
    span = {"minimum": key.low, "maximum": key.high}
    return {"type": kind, **span, "default": key.default} | meaning


def _object(properties: Schema) -> Schema:
    return {"type": "object", "properties": properties, "additionalProperties": False}


def machine_schema() -> Schema:
    """Return the JSON schema of machine files."""
    tables: dict[str, Schema] = {"machine": {"name": {"type": "string", "maxLength": 63}}}
    for key in machine_keys():
        tables.setdefault(key.table, {})[key.name] = _key(key)
    found = {name: _object(keys) for name, keys in tables.items()}
    believed = _object({name: keys for name, keys in found.items() if name != "machine"})
    parameters = {"type": "object", "additionalProperties": {"type": ["integer", "boolean"]}}
    title = {"$schema": DRAFT, "title": "machines"}
    return title | _object(found | {"controller": parameters, BELIEVED: believed})
