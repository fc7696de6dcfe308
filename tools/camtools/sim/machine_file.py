r"""Machine files of the simulator as data: read, changed, written.

A machine is a tree: tables of keys, as TOML has them; `host_sim/machines/default.toml` lists every
key. What the controller is configured from stands in `[believed.TABLE]`.

>>> tree = read_machine('[u]\ndelay_us = 75\n', "a.toml")
>>> print(emit_machine(mistaken(tree, {"u.delay_us": 80.0})))
[u]
delay_us = 80.0
[believed.u]
delay_us = 75
<BLANKLINE>
"""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from camtools.base.errors import InputError
from camtools.base.input_file import read_text
from camtools.base.toml_text import toml_tree
from camtools.sim.machines import MACHINES, machine_path

Tree = dict[str, Any]
BELIEVED = "believed"
_MAX_BYTES = 1 << 20


class Machine(NamedTuple):
    """A machine file."""

    name: str  # for messages: the file as the user named it
    text: str  # TOML


def find_machine(word: str | Path) -> Machine:
    """Return a machine by its name or by the path of its file.

    Raises
    ------
    CamtoolsError
        There is neither such a name nor such a file, or it cannot be read.
    """
    path = machine_path(str(word))
    return Machine(path.name if str(word) == path.stem else str(word), read_text(path, _MAX_BYTES))


def read_machine(text: str, name: str) -> Tree:
    """Return the tree of a machine's text; only the simulator knows which keys exist.

    Raises
    ------
    InputError
        It is no TOML.
    """
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

    Parameters
    ----------
    key : str
        Table and key, such as "u.bandwidth_hz".

    Returns
    -------
    float or None
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
