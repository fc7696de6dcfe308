# SPDX-License-Identifier: Apache-2.0
"""How far a cut is, how long it still takes, and how busy the controller is, from the status.

>>> signals = {"has_end": 1, "turns_left": 250.0, "turns_whole": 1000.0, "pass_speed": 500.0,
...            "pass": 2, "passes": 3}
>>> cut_progress("cutting", signals)
CutProgress(fraction=0.75, left_s=30.0, text='pass 2 of 3: 75 %, 0:30 left')
>>> cut_progress("cutting", {"has_end": 0, "pass_speed": 500.0}).text
'Z is led by others: only a stop ends this cut'
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

IN_CUT = ("rehearsing", "engaging", "cutting", "holding", "disengaging")
_NEEDED = {"has_end", "turns_left", "turns_whole", "pass_speed"}


@dataclass(frozen=True)
class CutProgress:
    """How far a pass is.

    Attributes
    ----------
    fraction : float or None
        share of the turns of the pass that is over, 0 .. 1, its rehearsal included; None: not known
    left_s : float or None
        [s] to the end of the pass; of one that is held, if it were resumed at once; in ready, of
        the next one. What the axes take to approach the start is not in it. None: not known
    text : str
        both for people
    """

    fraction: float | None
    left_s: float | None
    text: str


def duration_text(seconds: float) -> str:
    """Return a duration as minutes and seconds, rounded up; with hours from an hour on.

    >>> duration_text(59.2), duration_text(3725.0)
    ('1:00', '1:02:05')
    """
    whole = math.ceil(seconds)
    hours, minutes = whole // 3600, whole // 60 % 60
    clock = f"{minutes}:{whole % 60:02d}"
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else clock


def cut_progress(state: str, signals: Mapping[str, float]) -> CutProgress:
    """Return how far the pass is.

    Parameters
    ----------
    signals : Mapping
        of the status; what is missing makes the answer unknown
    """
    if state not in (*IN_CUT, "ready"):
        return CutProgress(None, None, "no cut")
    if not signals.keys() >= {"has_end", "pass_speed"}:
        return CutProgress(None, None, "the controller does not tell how far it is")
    if not signals["has_end"]:
        led = "Z is led by others: only a stop ends this cut"
        return CutProgress(None, None, led if signals["pass_speed"] else "no table")
    if not signals.keys() >= _NEEDED:
        return CutProgress(None, None, "the controller does not tell how far it is")
    left, whole, rpm = signals["turns_left"], signals["turns_whole"], signals["pass_speed"]
    fraction = min(max(1.0 - left / whole, 0.0), 1.0) if whole > 0 else None
    left_s = left / rpm * 60.0 if rpm > 0 else None
    return CutProgress(fraction, left_s, _text(state, signals, fraction, left_s))


def _text(
    state: str, signals: Mapping[str, float], fraction: float | None, left_s: float | None
) -> str:
    number, of = int(signals.get("pass", 0)), int(signals.get("passes", 0))
    which = f"pass {number} of {of}" if of > 1 else ""
    time = duration_text(left_s) if left_s is not None else "unknown time"
    if state == "ready":
        return f"next{' ' + which if which else ''}: {time}"
    share = f"{math.floor(100 * fraction)} %" if fraction is not None else "?"
    left = f"{time} left"
    if state == "holding" or signals.get("is_held"):
        left = f"held, {time} left when it goes on"
    return f"{which + ': ' if which else ''}{share}, {left}"


@dataclass(frozen=True)
class TickLoad:
    """How long the interrupt takes.

    Attributes
    ----------
    longest_us, mean_us : float or None
        [us] since the start, and over the last quarter of a second; None: the port does not measure
    period_us : float or None
        [us] from tick to tick
    share : float or None
        the longest as a share of the period
    text : str
        for people
    """

    longest_us: float | None
    mean_us: float | None
    period_us: float | None
    share: float | None
    text: str


def tick_load(signals: Mapping[str, float]) -> TickLoad:
    """Return how busy the interrupt keeps the controller.

    >>> tick_load({"tick_time_max": 7.1, "tick_time_mean": 3.2, "tick_rate": 20000}).text
    'longest 7.1 of 50 us (14 %), mean 3.2 us (6 %)'
    >>> tick_load({"tick_time_max": 0.0, "tick_rate": 20000}).text
    'the port does not measure it'
    """
    longest_us = signals.get("tick_time_max") or None
    mean_us = signals.get("tick_time_mean") or None
    rate_hz = signals.get("tick_rate") or None
    period_us = 1e6 / rate_hz if rate_hz else None
    if longest_us is None or period_us is None:
        told = "tick_time_max" in signals and period_us is not None
        text = "the port does not measure it" if told else "unknown"
        return TickLoad(longest_us, mean_us, period_us, None, text)
    share = longest_us / period_us
    text = f"longest {longest_us:.1f} of {period_us:.4g} us ({share:.0%})".replace("%", " %")
    if mean_us is not None:
        text += f", mean {mean_us:.1f} us ({100 * mean_us / period_us:.0f} %)"
    return TickLoad(longest_us, mean_us, period_us, share, text)
