# SPDX-License-Identifier: Apache-2.0
r"""The JSON schema of machine files: keys, ranges and defaults are those of the simulator.

Meanings are the comments of host_sim/machines/default.toml.

>>> _meanings("[u]\ndamping = 0.7\nkind = 1  # takes\n          # forces\n")
{'u.damping': '', 'u.kind': 'takes forces'}
"""

from __future__ import annotations

import re

from camtools.part.schema import DRAFT, Schema
from camtools.sim.binding import machine_keys
from camtools.sim.machine_file import BELIEVED, find_machine

_LINE = re.compile(r"(?:\[(\w+)\]|(\w+) *=[^#\n]*)?\s*(?:#\s*(.*))?")


def _meanings(text: str) -> dict[str, str]:
    """Return the comments of the keys of a machine file by table and key."""
    found: dict[str, str] = {}
    table = last = ""
    for line in text.splitlines():
        match = _LINE.match(line.strip() if last else line)
        header, key, comment = match.groups() if match else (None, None, None)
        if header:
            table, last = header, ""
        elif key:
            last = f"{table}.{key}"
            found[last] = comment or ""
        elif comment and last:
            found[last] = f"{found[last]} {comment}".strip()
        else:
            last = ""
    return found


def _key(kind: str, low: float, high: float, default: float, words: list[str]) -> Schema:
    if kind == "choice":
        return {"enum": words, "default": words[int(default)]}
    if kind == "sign":
        return {"enum": [int(low), int(high)], "default": int(default)}
    sort = "integer" if kind == "whole" else "number"
    return {"type": sort, "minimum": low, "maximum": high, "default": default}


def _object(properties: Schema) -> Schema:
    return {"type": "object", "properties": properties, "additionalProperties": False}


def machine_schema() -> Schema:
    """Return the JSON schema of machine files."""
    meanings = _meanings(find_machine("default").text)
    tables: dict[str, Schema] = {"machine": {"name": {"type": "string", "maxLength": 63}}}
    for line in machine_keys().splitlines():
        table, name, kind, low, high, default, words = line.split("\t")
        numbers = float(low), float(high), float(default)
        key = _key(kind, *numbers, re.findall(r'"([^"]*)"', words))
        meaning = meanings.get(f"{table}.{name}", "")
        tables.setdefault(table, {})[name] = key | ({"description": meaning} if meaning else {})
    found = {name: _object(keys) for name, keys in tables.items()}
    believed = _object({name: one for name, one in found.items() if name != "machine"})
    parameters = {"type": "object", "additionalProperties": {"type": ["integer", "boolean"]}}
    title = {"$schema": DRAFT, "title": "machines"}
    return title | _object(found | {"controller": parameters, BELIEVED: believed})
