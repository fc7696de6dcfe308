# SPDX-License-Identifier: Apache-2.0
r"""A change of one field in the text of a part file: comments and layout of the rest stay.

>>> edited("[process]\nfeed_mm = 0.1   # per turn\n", ("process", "feed_mm"), 0.2)
'[process]\nfeed_mm = 0.2   # per turn\n'
>>> edited("[process]\nfeed_mm = 0.1\nrun_in_mm = 2\n", ("process", "run_in_mm"), None)
'[process]\nfeed_mm = 0.1\n'
"""

from __future__ import annotations

from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from camtools.base.errors import CamtoolsError
from camtools.base.toml_text import toml_tree
from camtools.panel.design.key_lines import Path

Value = float | str | list[Any] | None


def edited(text: str, path: Path, value: Value) -> str:
    """Return the text with a field set, or removed.

    Parameters
    ----------
    path : tuple
        Names of the tables and of the key; numbers are places in lists of tables.
    value : number, bool, str, list or None
        What the field becomes; None removes it.

    Raises
    ------
    CamtoolsError
        The text is not TOML, or the change would touch something else.
    """
    before = _tree(text)
    wanted = _with(before, path, value)
    # Is it of the same type too? 1 and 1.0 and true are equal in Python.
    if before == wanted and repr(_at(before, path)) == repr(_at(wanted, path)):
        return text
    try:
        document = tomlkit.parse(text)
        _change(document, path, value)
        changed = document.as_string()
    except (TOMLKitError, KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        raise _by_hand(path) from error
    if text and not text.endswith("\n"):
        changed = changed.removesuffix("\n")
    if _tree(changed) != wanted:
        raise _by_hand(path)
    return changed


def _at(tree: Any, path: Path) -> Any:  # noqa: ANN401 (values of TOML)
    for step in path:
        try:
            tree = tree[step]
        except (KeyError, IndexError, TypeError):
            return None
    return tree


def _tree(text: str) -> dict[str, Any]:
    try:
        return toml_tree(text)
    except ValueError as error:
        problem = f"not TOML: {error}"
        raise CamtoolsError([f"{problem}; correct it in the text"]) from error


def _by_hand(path: Path) -> CamtoolsError:
    name = ".".join(map(str, path))
    return CamtoolsError([f"{name}: the form cannot change it here; change it in the text"])


def _with(tree: Any, path: Path, value: Value) -> Any:  # noqa: ANN401 (values of TOML)
    """Return a copy of the values with one of them changed."""
    step, rest = path[0], path[1:]
    if isinstance(tree, list):
        if not isinstance(step, int) or not 0 <= step < len(tree):
            raise _by_hand(path)
        return [_with(one, rest, value) if i == step else one for i, one in enumerate(tree)]
    if not isinstance(tree, dict) or isinstance(step, int):
        raise _by_hand(path)
    if not rest:
        return {k: v for k, v in tree.items() if k != step} | (
            {} if value is None else {step: value}
        )
    if value is None and step not in tree:
        return tree
    return tree | {step: _with(tree.get(step, {}), rest, value)}


def _change(container: Any, path: Path, value: Value) -> None:  # noqa: ANN401 (tomlkit's kinds)
    step, rest = path[0], path[1:]
    if rest:
        if isinstance(step, str) and step not in container:
            if value is None:
                return
            is_super = len(rest) > 1
            container.append(step, tomlkit.table(is_super_table=is_super))
        _change(container[step], rest, value)
    elif value is None:
        if step in container:
            container.remove(step)
    elif step in container:
        _replace(container, step, value)
    else:
        container.append(step, value)


def _replace(container: Any, step: str | int, value: Value) -> None:  # noqa: ANN401 (as above)
    """Set a value; of a list of the same length only the entries that differ."""
    there = container[step]
    if isinstance(value, list) and isinstance(there, list) and len(there) == len(value):
        for i, (old, new) in enumerate(zip(list(there), value, strict=True)):
            if repr(old) != repr(new):
                there[i] = new
        return
    container[step] = value
