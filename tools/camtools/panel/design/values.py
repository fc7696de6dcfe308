# SPDX-License-Identifier: Apache-2.0
"""The values of a part file by dotted names, as the form shows them.

>>> values_of({"cam": {"lobe": [{"z_mm": [0, 1]}, {"law": "disc"}]}})
{'cam.lobe.0.z_mm': [0, 1], 'cam.lobe.1.law': 'disc'}
"""

from __future__ import annotations

import math
from typing import Any

_MOST_VALUES = 5000
_MOST_ENTRIES = 2000


def values_of(tree: dict[str, Any]) -> dict[str, Any]:
    """Return all values that are no tables; of long lists nothing: they are changed in the text."""
    found: dict[str, Any] = {}
    _collect(tree, (), found)
    return found


def _collect(node: Any, path: tuple[str, ...], found: dict[str, Any]) -> None:  # noqa: ANN401
    if len(found) >= _MOST_VALUES:
        return
    if isinstance(node, dict):
        for name, one in node.items():
            _collect(one, (*path, str(name)), found)
    elif isinstance(node, list) and node and all(isinstance(one, dict) for one in node):
        for i, one in enumerate(node):
            _collect(one, (*path, str(i)), found)
    elif (value := _plain(node)) is not None:
        found[".".join(path)] = value


def _plain(node: Any) -> Any:  # noqa: ANN401 (values of TOML)
    """Return a value that JSON can tell; None for others."""
    if isinstance(node, float) and not math.isfinite(node):
        return str(node)
    if isinstance(node, int) and not isinstance(node, bool) and abs(node) >= 1 << 53:
        return None
    if isinstance(node, bool | int | float | str):
        return node
    if isinstance(node, list) and len(node) <= _MOST_ENTRIES:
        entries = [_plain(one) for one in node]
        return None if any(one is None for one in entries) else entries
    return None
