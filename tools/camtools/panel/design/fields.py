# SPDX-License-Identifier: Apache-2.0
"""What is typed into a field of the form, and how far its dial turns.

>>> typed(Key(("a",), "numbers", None, None, False), "0, 1.5")
[0, 1.5]
"""

from __future__ import annotations

import math
from typing import Any

from camtools.part.schema import Key

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

    Whole numbers stay whole, so that 2500 does not become 2500.0 in the text.

    Raises
    ------
    ValueError
        It is no such value; the message says what is wanted.
    """
    text = text.strip()
    if not text:
        return None
    if key.sort == "text":
        return text
    if key.sort == "switch":
        return text == "true"
    if key.sort == "choice":
        return next((one for one in key.choices if str(one) == text), text)
    if key.sort == "numbers":
        inner = text.strip("[] \t")
        is_list = text.startswith("[") or "," in text or isinstance(key.value, list)
        numbers = [_number(one) for one in inner.replace(";", ",").split(",") if one.strip()]
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
