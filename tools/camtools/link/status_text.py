"""The status of a controller as text: who commands, how far the cut is; dashboard and CSV.

>>> commander_text({"commander": 0.0})
'nobody commands'
>>> acknowledge_text({"acknowledge": 1.0, "acknowledge_left": 42.0})
'acknowledged; enable within 42 s'
>>> level_text({"level": 0.0})
'locked: limits, constants and tables do not change; to unlock, turn the key switch at the \
machine off and on'

>>> signals = {"has_end": 1, "turns_left": 250.0, "turns_whole": 1000.0, "pass_speed": 500.0,
...            "pass": 2, "passes": 3}
>>> cut_progress("cutting", signals)
CutProgress(fraction=0.75, left_s=30.0, text='pass 2 of 3: 75 %, 0:30 left')
>>> cut_progress("cutting", {"has_end": 0, "pass_speed": 500.0}).text
'Z is moved by another controller: only a stop ends this cut'

>>> gauge(0.0, 1.0, 9)
'    |    '
>>> sparkline([0.0, 1.0, 2.0], 2.0)
' ▄█'
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from camtools.link.controller import Status
from camtools.link.kept_values import learning_report
from camtools.link.messages import FAULT_TEXTS, NAMES
from camtools.link.refusal_text import FAULTS
from camtools.link.rights import sender_text

Signals = Mapping[str, float]
PRESS = "Press acknowledge at the machine for half a second"


def name_of(signals: Signals, signal: str) -> str:
    """Return the word for the value of a signal; "" where it was not received."""
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
    level = name_of(signals, "level")
    if level == "key":
        left = f", for {left_s:.0f} s more" if left_s else ""
        return f"unlocked by the key switch{left}"
    if level == "locked":
        return (
            "locked: limits, constants and tables do not change; to unlock, turn the key switch "
            "at the machine off and on"
        )
    return "unknown"


def rights_report(signals: Signals) -> list[str]:
    """Return a line for each of the three."""
    names = {"taken over": "take_overs", "lost": "command_losses"}
    counts = [f"{what} {int(signals[s])} times" for what, s in names.items() if signals.get(s)]
    return [
        f"command           {'; '.join([commander_text(signals), *counts])}",
        f"level             {level_text(signals)}",
        f"acknowledge       {acknowledge_text(signals)}",
    ]


IN_CUT = ("rehearsing", "engaging", "cutting", "holding", "disengaging")
_NEEDED = {"has_end", "turns_left", "turns_whole", "pass_speed"}


class CutProgress(NamedTuple):
    """How far a pass is; None where that is not known.

    left_s: to the end of the pass; of one that is held, if it were resumed at once; in ready, of
    the next one. What the axes take to approach the start is not in it.
    """

    fraction: float | None  # of the turns of the pass, its rehearsal included, 0 .. 1
    left_s: float | None
    text: str  # both for people


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
    """Return how far the pass is; signals that are missing make it unknown."""
    if state not in (*IN_CUT, "ready"):
        return CutProgress(None, None, "no cut")
    if not signals.keys() >= {"has_end", "pass_speed"}:
        return CutProgress(None, None, "the controller does not report its progress")
    if not signals["has_end"]:
        text = "Z is moved by another controller: only a stop ends this cut"
        return CutProgress(None, None, text if signals["pass_speed"] else "no table")
    if not signals.keys() >= _NEEDED:
        return CutProgress(None, None, "the controller does not report its progress")
    left, whole, rpm = signals["turns_left"], signals["turns_whole"], signals["pass_speed"]
    fraction = min(max(1.0 - left / whole, 0.0), 1.0) if whole > 0 else None
    left_s = left / rpm * 60.0 if rpm > 0 else None
    return CutProgress(fraction, left_s, _text(state, signals, fraction, left_s))


def _text(state: str, signals: Signals, fraction: float | None, left_s: float | None) -> str:
    number, n_passes = int(signals.get("pass", 0)), int(signals.get("passes", 0))
    which = f"pass {number} of {n_passes}" if n_passes > 1 else ""
    time = duration_text(left_s) if left_s is not None else "unknown time"
    if state == "ready":
        return f"next{' ' + which if which else ''}: {time}"
    share = f"{math.floor(100 * fraction)} %" if fraction is not None else "?"
    left = f"{time} left"
    if state == "holding" or signals.get("is_held"):
        left = f"held, {time} left after resume"
    return f"{which + ': ' if which else ''}{share}, {left}"


class TickLoad(NamedTuple):
    """How long the interrupt takes."""

    share: float | None  # the longest since the start, of the period; None where not measured
    text: str  # for people, with the mean over the last quarter of a second


def tick_load(signals: Mapping[str, float]) -> TickLoad:
    """Return how busy the interrupt keeps the controller.

    >>> tick_load({"tick_time_max": 7.1, "tick_time_mean": 3.2, "tick_rate": 20000}).text
    'longest 7.1 of 50 us (14 %), mean 3.2 us (6 %)'
    >>> tick_load({"tick_time_max": 0.0, "tick_rate": 20000}).text
    'the port does not measure it'
    """
    longest_us = signals.get("tick_time_max") or None
    mean_us = signals.get("tick_time_mean") or None
    rate_hz = signals.get("tick_rate")
    if longest_us is None or not rate_hz:
        is_reported = "tick_time_max" in signals and bool(rate_hz)
        return TickLoad(None, "the port does not measure it" if is_reported else "unknown")
    period_us = 1e6 / rate_hz
    share = longest_us / period_us
    text = f"longest {longest_us:.1f} of {period_us:.4g} us ({share:.0%})".replace("%", " %")
    if mean_us is not None:
        text += f", mean {mean_us:.1f} us ({100 * mean_us / period_us:.0f} %)"
    return TickLoad(share, text)


_BARS = " ▁▂▃▄▅▆▇█"
_BESIDE = 27  # columns of words, number and brackets beside a scale, and a free one at the margin
_HOME, _BELOW, _RIGHT = "\x1b[H", "\x1b[J", "\x1b[K"
_KEPT = {
    "none": "not kept: a restart uses the defaults",
    "same": "kept",
    "changed": "not kept: a restart uses other values; `params keep` keeps these",
    "damaged": "not kept: the kept ones are damaged and a restart uses the defaults",
}
_CELLS = {  # column of a record: signal and decimals
    "angle_deg": ("angle", 4),
    "speed_rpm": ("speed", 3),
    "z_mm": ("z", 6),
    "u_set_mm": ("u_set", 6),
    "u_actual_mm": ("u_actual", 6),
    "following_error_mm": ("following_error", 6),
}
COLUMNS = ("t_s", "state", "faults", *_CELLS)


def gauge(value: float, full: float, width: int) -> str:
    """Return a scale from -full to full with a mark at the value."""
    share = max(-1.0, min(1.0, value / full if full > 0 else 0.0))
    at = round((share + 1) / 2 * (width - 1))
    return " " * at + "|" + " " * (width - 1 - at)


def sparkline(values: Iterable[float], full: float) -> str:
    """Return a bar for each value, from 0 to full."""
    top = len(_BARS) - 1
    return "".join(_BARS[round(min(abs(v) / full, 1.0) * top) if full > 0 else 0] for v in values)


def row(status: Status, t_s: float) -> list[str]:
    """Return the cells of COLUMNS."""
    cells = (f"{status.signals[signal]:.{decimals}f}" for signal, decimals in _CELLS.values())
    return [f"{t_s:.4f}", status.state, "+".join(status.faults), *cells]


def line(status: Status) -> str:
    """Return what matters in one line."""
    s = status.signals
    faults = f"  faults: {', '.join(status.faults)}" if status.faults else ""
    return (
        f"{status.state:<11} {s['speed']:9.1f} r/min  angle {s['angle']:6.1f} deg  "
        f"Z {s['z']:9.4f} mm  U set {s['u_set']:8.4f} actual {s['u_actual']:8.4f} mm  "
        f"following error {s['following_error'] * 1e3:+8.2f} um{faults}"
    )


class Dashboard:
    """The same as a page that a terminal draws over and over, with the past of what moves."""

    def __init__(self, width: int) -> None:
        self.width = max(width, 40)
        self._errors: deque[float] = deque(maxlen=self.width - _BESIDE)
        self._u_full = 0.05

    def add(self, status: Status) -> None:
        """Remember a row."""
        s = status.signals
        self._errors.append(s["following_error"])
        self._u_full = max(self._u_full, abs(s["u_set"]), abs(s["u_actual"]))

    def page(self, status: Status) -> str:
        """Return the page, with the codes that draw it in place."""
        return _HOME + "".join(f"{text}{_RIGHT}\n" for text in self.lines(status)) + _BELOW

    def lines(self, status: Status) -> list[str]:
        """Return the lines of the page."""
        s, room = status.signals, self.width - _BESIDE
        full_um = max((abs(e) for e in self._errors), default=0.0) * 1e3
        full_u = f"-{self._u_full:.3f} .. {self._u_full:.3f} mm"
        faults = [f"  {name}: {FAULT_TEXTS[name]}" for name in status.faults]
        return [
            f"{status.table_name or 'no table'}   state: {status.state.upper()}",
            "",
            f"speed     {s['speed']:9.1f} r/min   Z {s['z']:10.4f} mm",
            f"angle     {s['angle']:9.1f} deg [{gauge(s['angle'] / 180 - 1, 1.0, room)}]",
            f"U set     {s['u_set']:9.4f} mm  [{gauge(s['u_set'], self._u_full, room)}]",
            f"U actual  {s['u_actual']:9.4f} mm  [{gauge(s['u_actual'], self._u_full, room)}]",
            f"                       {full_u}",
            f"following {s['following_error'] * 1e3:+9.2f} um  "
            f"[{sparkline(self._errors, full_um / 1e3):>{room}}]",
            f"                       0 .. {full_um:.2f} um",
            "",
            "faults: " + ("" if faults else "none"),
            *faults,
        ]


def _box_report(status: Status) -> list[str]:
    """Return a line where the black box of a fault has not been read."""
    s = status.signals
    if (name_of(s, "recorder_use"), name_of(s, "recorder_phase")) != ("box", "done"):
        return []
    bits = int(s["recorder_faults"])
    names = [name for i, name in enumerate(FAULT_TEXTS) if bits >> i & 1]
    return [f"black box         of {', '.join(names)}: camctl blackbox FILE reads it"]


def report(status: Status) -> list[str]:
    """Return everything in the status, a line each."""
    s = status.signals
    table_err = NAMES["result"].get(int(s["table_result"]), str(int(s["table_result"])))
    yes = {0.0: "no", 1.0: "yes"}
    cut, errors = cut_progress(status.state, s), s["memory_errors"]
    return [
        f"state             {status.state}",
        f"faults            {', '.join(status.faults) or 'none'}",
        *(f"  {name}: {FAULT_TEXTS[name]} {FAULTS[name].remedy}" for name in status.faults),
        *_box_report(status),
        *rights_report(s),
        f"angle             {s['angle']:.3f} deg, known: {yes[s['is_synced']]}",
        f"speed             {s['speed']:.3f} r/min{_steady_text(s)}",
        f"Z                 {s['z']:.6f} mm",
        f"U set, actual     {s['u_set']:.6f} mm, {s['u_actual']:.6f} mm, "
        f"retracted: {yes[s['is_retracted']]}",
        f"following error   {s['following_error'] * 1e3:+.3f} um",
        f"emergency stop    {yes[s['is_estop']]}; drives ready: {yes[s['is_drive_ready']]}"
        + ("; a node of the field bus is silent" if s["is_bus_lost"] else ""),
        *hands_report(status),
        *([f"pass              {s['pass']:.0f} of {s['passes']:.0f}"] if s["passes"] else []),
        *([f"cut               {cut.text}"] if status.state in (*IN_CUT, "ready") else []),
        f"tick              {s['tick_rate']:.0f} Hz, late {s['late_ticks']:.0f}; "
        f"interrupt: {tick_load(s).text}",
        *([f"memory            {errors:.0f} errors corrected"] if errors else []),
        f"last start        {name_of(s, 'reset_reason')}",
        f"parameters        version {s['params_version']:.0f}, checksum "
        f"{int(s['params_checksum']):08x}, {kept_text(s)}",
        *learning_report(status),
        *table_report(status),
        f"table check       {table_err}",
    ]


def _steady_text(signals: Mapping[str, float]) -> str:
    texts = {
        "waits": "; the cut waits until it is steady",
        "unsteady": "; it was not steady, so the last start was ended: check the spindle's drive",
    }
    return texts.get(name_of(signals, "start_wait"), "")


def kept_text(signals: Mapping[str, float]) -> str:
    """Return whether the controller keeps its parameters over a restart."""
    return _KEPT.get(name_of(signals, "params_kept"), "unknown")


def hands_report(status: Status) -> list[str]:
    """Return where X is, what is homed, and what was done by hand."""
    s = status.signals
    homed = ", ".join(axis for axis in "uxz" if s[f"homed_{axis}"]) or "no axis"
    on = ", ".join(axis for axis in "uxz" if s[f"on_home_{axis}"]) or "none"
    tool = f", tool {s['tool']:.0f}" if s["tool"] else ""
    by_hand = f"{name_of(s, 'hand_phase')}, last order: {name_of(s, 'hand_end')}"
    return [
        f"X                 {s['x']:.6f} mm, diameter {2 * s['x']:.6f} mm at U = 0{tool}",
        f"homed             {homed}; on a home switch: {on}",
        *([f"by hand           {by_hand}"] if s["hand_orders"] else []),
    ]


def table_report(status: Status) -> list[str]:
    """Return what is known of the table in use."""
    s = status.signals
    if not s["table_size"]:
        return ["table             none"]
    return [
        f"table             {status.table_name}",
        f"table image       {s['table_size']:.0f} bytes, CRC-32 {int(s['table_crc']):08x}, "
        f"generation {s['table_generation']:.0f}",
    ]
