"""The following error by angle, and pictures of the axes: the sequence in time, a fault.

>>> thin(np.array([0.0, 5.0, 1.0, -3.0]), 2).tolist()
[[0.0, -3.0], [5.0, 1.0]]
"""

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from camtools.base.quantities import NM_PER_MM, UM_PER_MM, Floats
from camtools.plots import style
from camtools.report.surface import over_turn
from camtools.sim.results import CUTTING, FAULT, STATES, CutTrace

_NAMES = "PALE PURPLE SKY ORANGE GREEN ORANGE RED BLUE GREY PURPLE SKY"  # as STATES
STATE_COLOURS = tuple(vars(style)[name] for name in _NAMES.split())
_N_BINS = 360
_AXES = ("Z, mm", "X (radius),\nmm", "U towards\nthe axis, µm")
_N_POINTS = 600  # across a picture: more cannot be seen
_MS_PER_S = 1000.0


def thin(values: Floats, n: int) -> Floats:
    """Return smallest and largest of n stretches of values, shape (2, n or fewer)."""
    n = max(1, min(n, values.size))
    starts = np.linspace(0, values.size, n, endpoint=False).astype(np.int64)
    return np.stack([np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)])


def following_by_angle(trace: CutTrace) -> Floats:
    """Return angle [degrees], smallest, largest, mean following error [um] of cutting, (4, n)."""
    rows = trace.state == CUTTING
    return over_turn(trace.turn[rows], trace.following_um[rows], _N_BINS)


def state_spans(trace: CutTrace) -> list[tuple[float, float, int]]:
    """Return begin [s], end [s] and number of every stretch of one state."""
    edges = (np.flatnonzero(np.diff(trace.state)) + 1).tolist()
    return [
        (float(trace.t_s[begin]), float(trace.t_s[end]), int(trace.state[begin]))
        for begin, end in pairwise([0, *edges, trace.t_s.size - 1])
        if end > begin
    ]


def windows_s(trace: CutTrace, whole: CutTrace) -> list[tuple[str, float, float]]:
    """Return title, begin and end [s] of the begin, the whole and the end of a cut."""
    cutting, last_s = whole.t_s[whole.state == CUTTING], float(whole.t_s[-1])
    if not cutting.size:
        return [("whole run", 0.0, last_s)]
    begin_s = min(float(trace.t_s[-1]), float(cutting[0]) + 0.15)
    end_s = max(0.0, float(cutting[-1]) - 0.15)
    return [("begin", 0.0, begin_s), ("all of it", 0.0, last_s), ("end", end_s, last_s)]


def _strip(axes: Axes, spans: list[tuple[float, float, int]], begin_s: float, end_s: float) -> None:
    for low, high, state in spans:
        axes.axvspan(low, high, color=STATE_COLOURS[state], lw=0, alpha=0.75)
        middle = (max(low, begin_s) + min(high, end_s)) / 2
        room = 0.03 * len(STATES[state]) * (end_s - begin_s)
        if min(high, end_s) - max(low, begin_s) > room:
            axes.text(middle, 0.5, STATES[state], ha="center", va="center", fontsize=8.5)
    axes.set(yticks=[], ylim=(0, 1))
    axes.spines["left"].set_visible(False)


def _state_handles(spans: list[tuple[float, float, int]]) -> list[Patch]:
    names: dict[str, dict[str, None]] = {}  # keys are ordered and there once
    for _, _, state in spans:
        names.setdefault(STATE_COLOURS[state], {})[STATES[state]] = None
    return [
        Patch(color=colour, alpha=0.75, label=", ".join(states)) for colour, states in names.items()
    ]


def _envelope(axes: Axes, t_s: Floats, values: Floats, colour: str) -> None:
    low, high = thin(values, _N_POINTS)
    middle_s = thin(t_s, _N_POINTS).mean(axis=0)
    axes.fill_between(middle_s, low, high, color=colour, lw=0.8)


def _between(trace: CutTrace, begin_s: float, end_s: float) -> CutTrace:
    return trace.pick(slice(*np.searchsorted(trace.t_s, [begin_s, end_s])))


def draw_sequence(trace: CutTrace, overview: CutTrace | None = None) -> Figure:
    """Return states, Z, X and U over time; `overview`: of a cut longer than its trace."""
    whole = trace if overview is None else overview
    windows = windows_s(trace, whole)
    figure = style.new_figure(10, 7.0)
    ratios = {"height_ratios": [0.28, 1, 1, 1]}
    panels = figure.subplots(4, len(windows), sharex="col", squeeze=False, gridspec_kw=ratios)
    spans = state_spans(whole)
    for column, (title, begin_s, end_s) in enumerate(windows):
        part = _between(trace if column == 0 else whole, begin_s, end_s)
        strip, z, x, u = panels[:, column]
        _strip(strip, spans, begin_s, end_s)
        strip.set_title(title)
        _envelope(z, part.t_s, part.z_mm, style.GREEN)
        _envelope(x, part.t_s, part.x_nm / NM_PER_MM, style.BLUE)
        _envelope(u, part.t_s, part.u_act_nm / NM_PER_MM * UM_PER_MM, style.RED)
        u.set(xlim=(begin_s, end_s), xlabel="time, s")
    panels[0, 0].set_ylabel("state", rotation=0, ha="right", va="center")
    for row, name in enumerate(_AXES, start=1):
        panels[row, 0].set_ylabel(name)
    figure.align_ylabels(panels[1:, 0])
    figure.legend(handles=_state_handles(spans), loc="outside lower center", ncols=6, frameon=False)
    return figure


def draw_fault(trace: CutTrace, retract_s: float) -> Figure:
    """Return U, X, the gap to the part and the spindle around the first fault of a trace."""
    fault_s, room_s = float(trace.t_s[trace.state == FAULT][0]), max(0.02, 0.5 * retract_s)
    part = _between(trace, fault_s - room_s, fault_s + retract_s + room_s)
    ms = (part.t_s - fault_s) * _MS_PER_S
    figure = style.new_figure(10, 6.6)
    names = (*_AXES[:0:-1], "tool tip off\nthe drawing, mm", "spindle, r/min")
    panels = style.stacked(figure, names)
    panels[0].plot(ms, part.u_act_nm / 1e3, color=style.RED, lw=1.4)
    panels[1].plot(ms, part.x_nm / NM_PER_MM, color=style.BLUE, lw=1.4)
    panels[2].plot(ms, part.error_nm / NM_PER_MM, color=style.GREEN, lw=1.4)
    panels[3].plot(ms, part.speed_rpm, color=style.PURPLE, lw=1.4)
    for axes in panels:
        axes.axvline(0, color=style.GREY, lw=1.2, ls="--")
    panels[0].set_title("dashed line: the tick in which the controller saw the fault")
    panels[-1].set(xlabel="time from the fault, ms", xlim=(ms[0], ms[-1]))
    return figure
