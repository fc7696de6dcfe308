# SPDX-License-Identifier: Apache-2.0
"""What the status tells of who commands, of the level and of acknowledge, in words.

>>> commander_text({"commander": 0.0})
'nobody commands'
>>> acknowledge_text({"acknowledge": 1.0, "acknowledge_left": 42.0})
'acknowledged; enable within 42 s'
>>> level_text({"level": 0.0})
'locked: limits, constants and tables do not change; to unlock, turn the key switch at the \
machine off and on, or give the secret'
"""

from __future__ import annotations

from collections.abc import Mapping

from camtools.link.messages import NAMES
from camtools.link.rights import sender_text

Signals = Mapping[str, float]
PRESS = "Press acknowledge at the machine for half a second"


def name_of(signals: Signals, signal: str) -> str:
    """Return the word for a value of page 25; "" where the controller does not tell it."""
    number = signals.get(signal)
    return "" if number is None else NAMES[signal].get(int(number), "unknown")


def commander_text(signals: Signals) -> str:
    """Return who commands."""
    sender = signals.get("commander")
    if sender is None:
        return "the controller does not report who commands"
    return f"{sender_text(int(sender))} commands" if sender else "nobody commands"


def acknowledge_text(signals: Signals) -> str:
    """Return whether somebody must press the button at the machine."""
    left_s = signals.get("acknowledge_left", 0.0)
    texts = {
        "needed": f"needed: {PRESS[:1].lower()}{PRESS[1:]}, then enable",
        "given": f"acknowledged; enable within {left_s:.0f} s" if left_s else "acknowledged",
        "none": "the port has no such button, so the drives stay off; wire one, or waive it in "
        "the port's settings",
        "waived": "not required, waived by the builder of this port",
    }
    return texts.get(name_of(signals, "acknowledge"), "unknown")


def level_text(signals: Signals) -> str:
    """Return whether limits, constants and tables may change, and what to do about it."""
    left_s = signals.get("level_left", 0.0)
    how = {"key": "by the key switch", "challenge": "by the secret"}
    level = name_of(signals, "level")
    if level in how:
        left = f", for {left_s:.0f} s more" if left_s else ""
        return f"unlocked {how[level]}{left}"
    if level == "locked":
        return (
            "locked: limits, constants and tables do not change; to unlock, turn the key switch "
            "at the machine off and on, or give the secret"
        )
    return "unknown"


def rights_report(signals: Signals) -> list[str]:
    """Return a line for each of the three."""
    counts = [
        f"{what} {int(signals.get(name, 0.0))} times"
        for what, name in (("taken over", "take_overs"), ("lost", "command_losses"))
        if signals.get(name)
    ]
    return [
        f"command           {'; '.join([commander_text(signals), *counts])}",
        f"level             {level_text(signals)}",
        f"acknowledge       {acknowledge_text(signals)}",
    ]
