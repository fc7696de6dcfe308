# SPDX-License-Identifier: Apache-2.0
r"""Machine files of the simulator with other numbers for the controller, the rest as it was.

>>> print(with_keys("[u]\nmode_hz = 3\n", "controller", {"k1_ns": 5}), end="")
[u]
mode_hz = 3
<BLANKLINE>
[controller]
k1_ns = 5
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping

from camtools.base.errors import CamtoolsError

_TABLE = re.compile(r"^\s*\[([^\[\]]+)\]\s*(#.*)?$")


def _name_of(line: str) -> str | None:
    found = _TABLE.match(line)
    return re.sub(r"\s", "", found[1]) if found else None


def with_keys(text: str, table: str, keys: Mapping[str, float]) -> str:
    """Return a machine file in which keys of one table have new values; comments stay.

    Raises
    ------
    CamtoolsError
        The table is written in a way that this cannot change.
    """
    lines, inside, at = [], False, None
    for line in text.splitlines():
        name = _name_of(line)
        if name is not None:
            inside = name == table
        key = line.split("=", 1)[0].strip() if "=" in line else ""
        if inside and key in keys:
            continue
        lines.append(line)
        if name == table:
            at = len(lines)
    new = [f"{key} = {value:.10g}" for key, value in keys.items()]
    if at is None:
        lines += ["", f"[{table}]", *new]
    else:
        lines[at:at] = new
    changed = "\n".join(lines) + "\n"
    _check(text, changed, table, keys)
    return changed


def _inner(tree: dict[str, object], table: str) -> dict[str, object]:
    for word in table.split("."):
        found = tree.setdefault(word, {})
        assert isinstance(found, dict)
        tree = found
    return tree


def _check(text: str, changed: str, table: str, keys: Mapping[str, float]) -> None:
    """Compare what a reader sees with what it should see."""
    try:
        wanted, found = tomllib.loads(text), tomllib.loads(changed)
        _inner(wanted, table).update(keys)
        is_good = wanted == found
    except (tomllib.TOMLDecodeError, AssertionError):
        is_good = False
    if not is_good:
        remedy = f"write it as [{table}] with one key a line"
        raise CamtoolsError([f"machine file: {table}: its keys cannot be replaced; {remedy}"])
