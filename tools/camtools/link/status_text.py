# SPDX-License-Identifier: Apache-2.0
"""Status of a controller as text: lines, a dashboard for a terminal, rows of a CSV file.

>>> gauge(0.0, 1.0, 9)
'    |    '
>>> sparkline([0.0, 1.0, 2.0], 2.0)
' ▄█'
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping

from camtools.link.controller import Status
from camtools.link.learned_file import learning_report
from camtools.link.messages import FAULT_TEXTS, NAMES, NUMBERS
from camtools.link.progress import IN_CUT, cut_progress, tick_load
from camtools.link.rights_report import rights_report

_BARS = " ▁▂▃▄▅▆▇█"
_BESIDE = 27  # columns of words, number and brackets beside a scale, and a free one at the margin
_HOME, _BELOW, _RIGHT = "\x1b[H", "\x1b[J", "\x1b[K"
_KEPT = {
    NUMBERS["params_kept"][name]: text
    for name, text in {
        "none": "not kept: a restart uses the defaults",
        "same": "kept",
        "changed": "not kept: a restart uses other values; `params keep` keeps these",
        "damaged": "not kept: the kept ones are damaged and a restart uses the defaults",
    }.items()
}
COLUMNS = (
    *("t_s", "state", "faults", "angle_deg", "speed_rpm", "z_mm"),
    *("u_set_mm", "u_actual_mm", "following_error_mm"),
)


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
    s = status.signals
    return [
        f"{t_s:.4f}",
        status.state,
        "+".join(status.faults),
        f"{s['angle']:.4f}",
        f"{s['speed']:.3f}",
        f"{s['z']:.6f}",
        f"{s['u_set']:.6f}",
        f"{s['u_actual']:.6f}",
        f"{s['following_error']:.6f}",
    ]


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
    use = NAMES["recorder_use"].get(int(s["recorder_use"]))
    if use != "box" or NAMES["recorder_phase"].get(int(s["recorder_phase"])) != "done":
        return []
    bits = int(s["recorder_faults"])
    names = [name for i, name in enumerate(FAULT_TEXTS) if bits >> i & 1]
    return [f"black box         of {', '.join(names)}: camctl blackbox FILE reads it"]


def report(status: Status) -> list[str]:
    """Return everything in the status, a line each."""
    s = status.signals
    table_err = NAMES["result"].get(int(s["table_result"]), str(int(s["table_result"])))
    yes = {0.0: "no", 1.0: "yes"}
    cut = cut_progress(status.state, s)
    return [
        f"state             {status.state}",
        f"faults            {', '.join(status.faults) or 'none'}",
        *(f"  {name}: {FAULT_TEXTS[name]}" for name in status.faults),
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
        *(
            [f"memory            {s['memory_errors']:.0f} errors corrected"]
            if s["memory_errors"]
            else []
        ),
        f"last start        {NAMES['reset_reason'].get(int(s['reset_reason']), 'unknown')}",
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
    return texts.get(NAMES["start_wait"].get(int(signals["start_wait"]), ""), "")


def kept_text(signals: Mapping[str, float]) -> str:
    """Return whether the controller keeps its parameters over a restart."""
    return _KEPT.get(int(signals["params_kept"]), "unknown")


def hands_report(status: Status) -> list[str]:
    """Return where X is, what is homed, and what was done by hand."""
    s = status.signals
    homed = ", ".join(axis for axis in "uxz" if s[f"homed_{axis}"]) or "no axis"
    on = ", ".join(axis for axis in "uxz" if s[f"on_home_{axis}"]) or "none"
    phase = NAMES["hand_phase"].get(int(s["hand_phase"]), "unknown")
    end = NAMES["hand_end"].get(int(s["hand_end"]), "unknown")
    tool = f", tool {s['tool']:.0f}" if s["tool"] else ""
    return [
        f"X                 {s['x']:.6f} mm, diameter {2 * s['x']:.6f} mm at U = 0{tool}",
        f"homed             {homed}; on a home switch: {on}",
        *([f"by hand           {phase}, last order: {end}"] if s["hand_orders"] else []),
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
