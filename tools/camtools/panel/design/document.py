r"""The text of a part file: a key changed with comments kept, and what is typed into its field.

>>> edited('[process]\nfeed_mm = 0.1   # per turn\n', ("process", "feed_mm"), 0.2)
'[process]\nfeed_mm = 0.2   # per turn\n'
"""

import copy
import math
import re
from collections.abc import Iterable
from typing import Any, NamedTuple

import tomlkit
from tomlkit.exceptions import TOMLKitError

from camtools.base.errors import CamtoolsError
from camtools.base.text import toml_tree
from camtools.part.schema import Key, Step

Path = tuple[Step, ...]
Value = float | str | list[Any] | None

_FIELD = re.compile(r"([a-z_][a-z0-9_]*(?:\.(?:[a-z_][a-z0-9_]*|\d+))+)\b")
_AT_LINE = re.compile(r"not TOML.*at line (\d+)")
_NUMBER = re.compile(r"process\.pass number (\d+): ")
_REFUSALS = (TOMLKitError, KeyError, IndexError, TypeError, ValueError, AttributeError)


class Problem(NamedTuple):
    """One thing that is wrong."""

    field: str  # dotted; "" where no field is to blame
    line: int | None  # of the text, from 1 on
    text: str  # place, value, what is wrong, remedy


def edited(text: str, path: Path, value: Value) -> str:
    """Return the text with a key set, or removed by None; numbers are places in lists of tables.

    Raises CamtoolsError: the text is not TOML, or the change would touch something else.
    """
    before = _tree(text)
    try:
        wanted = _changed(copy.deepcopy(before), path, value)
        if repr(before) == repr(wanted):  # 1, 1.0 and true are equal in Python, but not here
            return text
        changed: str = _changed(tomlkit.parse(text), path, value).as_string()
    except _REFUSALS as error:
        raise _by_hand(path) from error
    if text and not text.endswith("\n"):
        changed = changed.removesuffix("\n")
    if _tree(changed) != wanted:
        raise _by_hand(path)
    return changed


def _tree(text: str) -> dict[str, Any]:
    try:
        return toml_tree(text)
    except ValueError as error:
        problem = f"not TOML: {error}"
        raise CamtoolsError([f"{problem}; correct it in the text"]) from error


def _by_hand(path: Path) -> CamtoolsError:
    name = ".".join(map(str, path))
    return CamtoolsError([f"{name}: the form cannot change it here; change it in the text"])


def _changed(root: Any, path: Path, value: Value) -> Any:  # noqa: ANN401 (dict, or tomlkit's)
    is_document, at = isinstance(root, tomlkit.TOMLDocument), root
    for i, step in enumerate(path[:-1]):
        if isinstance(step, str) and step not in at:
            if value is None:
                return root
            is_super = i + 2 < len(path)
            at.update({step: tomlkit.table(is_super_table=is_super) if is_document else {}})
        at = at[step]
    last = path[-1]
    old = at[last] if isinstance(last, int) or last in at else None
    if value is None:
        at.pop(last, None)
    elif isinstance(value, list) and isinstance(old, list) and len(old) == len(value):
        for i, (before, new) in enumerate(zip(list(old), value, strict=True)):
            if repr(before) != repr(new):  # the digits of the others stay
                old[i] = new
    else:
        at[last] = value
    return root


def problems_of(lines: list[str], text: str, file: str = "") -> list[Problem]:
    """Return messages with their places in the text of a part file, whose name is left out."""
    found = []
    for line in lines:
        message = line.removeprefix(f"{file}: ") if file else line
        named = _FIELD.match(_NUMBER.sub("", message))
        at_line = _AT_LINE.match(message)
        number = int(at_line[1]) if at_line else None
        found.append(Problem(named[1] if named else "", number, message))
    places = lines_of(text, {problem.field for problem in found if problem.field})
    return [problem._replace(line=places.get(problem.field, problem.line)) for problem in found]


def lines_of(text: str, fields: Iterable[str]) -> dict[str, int]:
    r"""Return the line of each field, of a missing one that of its table, from 1 on.

    >>> lines_of('[process]\nspindle_rpm = 100\n[[cam.lobe]]\nz_mm = [\n0, 1]\n',
    ...          ["process.spindle_rpm", "process.feed_mm", "cam.lobe.0", "cam.lobe.0.z_mm"])
    {'process.spindle_rpm': 2, 'process.feed_mm': 1, 'cam.lobe.0': 3, 'cam.lobe.0.z_mm': 4}
    """
    try:
        toml_tree(text)  # refuses what would keep tomlkit busy
        document = tomlkit.parse(text)
    except (*_REFUSALS, RecursionError):
        return {}
    steps: dict[str, list[str]] = {}  # the marks of a field and of the tables around it
    for field in fields:
        at: Any = document
        marks = steps.setdefault(field, [])
        for step in field.split("."):
            try:
                around, at = at, at[int(step) if step.isdigit() else step]
                if isinstance(at, bool):  # as an item it has a place
                    at = around.value.item(step)
            except _REFUSALS:
                break
            if trivia := getattr(at, "trivia", None):  # tables in parts have none
                if not trivia.indent.startswith("\0"):
                    trivia.indent = f"\0{id(trivia)}\0{trivia.indent}"  # no TOML has a NUL
                marks.append(trivia.indent.split("\0")[1])
    numbers: dict[str, int] = {}
    for number, line in enumerate(document.as_string().split("\n"), start=1):
        numbers |= dict.fromkeys(line.split("\0")[1::2], number)
    shown = {field: [numbers[m] for m in marks if m in numbers] for field, marks in steps.items()}
    return {field: found[-1] for field, found in shown.items() if found}


_MOST_SHOWN = 2000  # entries of a list: a longer one is changed in the text


def shown_text(value: object) -> str:
    """Return a value as somebody would type it.

    >>> shown_text([0, 1.5]), shown_text(None), shown_text(True)
    ('0, 1.5', '', 'true')
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return ", ".join(map(str, value)) if is_short(value) else f"{len(value)} values"
    return str(value)


def is_short(value: object) -> bool:
    """Return whether a value is no list, or a list that the form can change."""
    return not isinstance(value, list) or len(value) <= _MOST_SHOWN


def typed(key: Key, text: str) -> Any:  # noqa: ANN401 (a value of TOML)
    """Return what somebody typed as a value of the key; None where it was emptied.

    Whole numbers stay whole: 2500 does not become 2500.0. Raises ValueError with what is wanted.
    """
    text = text.strip()
    if not text:
        return None
    if key.sort == "text":
        return text
    if key.sort == "switch":
        return text == "true"
    if key.sort == "choice":
        return next((choice for choice in key.choices if str(choice) == text), text)
    if key.sort == "numbers":
        inner = text.strip("[] \t")
        is_list = text.startswith("[") or "," in text or isinstance(key.value, list)
        numbers = [_number(item) for item in inner.replace(";", ",").split(",") if item.strip()]
        return numbers if is_list or len(numbers) != 1 else numbers[0]
    return _number(text)


def _number(text: str) -> float | int:
    text = text.strip()
    for kind in (int, float):
        try:
            found = kind(text)
        except ValueError:
            continue
        if not math.isfinite(found):
            raise ValueError("give a finite number")
        return found
    raise ValueError(f"{text[:40]!r} is not a number; give digits with a point")


def step_of(value: float) -> float:
    """Return how far a step button moves a number: a tenth of its first digit's worth.

    >>> step_of(2500), step_of(0.1), step_of(0)
    (100.0, 0.01, 0.1)
    """
    return float(f"1e{int(f'{value:e}'.split('e')[1]) - 1}")


def within(key: Key, value: float) -> float:
    """Return the nearest value in the range of a key."""
    low = value if key.low is None else max(value, key.low)
    return low if key.high is None else min(low, key.high)


def dial_of(key: Key, value: float) -> tuple[float, float]:
    """Return the ends of a slider around a value: half of it to one and a half, within the range.

    >>> dial_of(Key(("a",), "number", 4, None, True, low=3.0), 4.0)
    (3.0, 6.0)
    """
    low, high = sorted((0.5 * value, 1.5 * value)) if value else (-1.0, 1.0)
    return within(key, low), within(key, high)
