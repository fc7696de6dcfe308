# SPDX-License-Identifier: Apache-2.0
"""Judges a run from outside: what the axes were told against the limits and the unstruck run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flips_image import EXCEPTION, HALT, LOCKUP, WATCHDOG, Result
from numpy.typing import NDArray

IN_TIME = 3  # ticks from the first wrong set-point to the reaction
ENABLE, FAULT = 1, 2
PLAN_TICKS = 8
MARGIN = 1.0 + 1.0 / 16.0  # that of the guard
CHANGE_MARGIN = MARGIN + 1.0 / 8.0  # and what a move takes to end within its way
U, X, Z = range(3)
COURSE_NM = (10_000, 10_000, 100_000)  # off the course of the unstruck run
EARLY_TICKS = 16  # X and Z may be before or behind it: two plans
DEPTH_NM = 20_000  # deeper than the unstruck run ever is, behind a fault
SPINDLE_MRPM = 25_000  # 1 % of its speed
MOST_TICKS = 4000  # the retract is over by then
IDLE_TICKS = 400  # the main loop rests at least this often

CLASSES = ("none", "small", "out", "detected", "stopped", "main", "limits", "course")
WRONG = ("limits", "course")
ORDER = (*WRONG, "out")  # what is worst comes first


@dataclass(frozen=True)
class Limits:
    """Of the machine, per tick."""

    speed: NDArray[np.float64]
    change: NDArray[np.float64]
    u_range: float


@dataclass(frozen=True)
class Verdict:
    """Class of a run; ticks since the strike of the first wrong set-point and of the reaction."""

    kind: str
    what: str = ""
    most: int = 0  # of what is wrong: nm, nm per tick, and so on
    wrong_after: int | None = None
    seen_after: int | None = None
    faults: int = 0


@dataclass(frozen=True)
class Wrong:
    """Something that is wrong in some ticks."""

    kind: str
    what: str
    ticks: NDArray[np.int64]
    most: int

    @property
    def begin(self) -> int:
        """The first of these ticks."""
        return int(self.ticks[0])

    def is_late(self, seen: int | None) -> bool:
        """Return whether any of them is far from the reaction."""
        return seen is None or bool((np.abs(self.ticks - seen) > IN_TIME).any())


def limits_of(told: dict[str, tuple[int, int]]) -> Limits:
    """Return the limits that follow from the parameters of the image."""

    def value(name: str) -> float:
        return float(told[f"limit.{name}"][1])

    hz = value("tick_hz")
    speed = [value(f"{a}_speed_um_per_s") * 1e3 / hz for a in "uxz"]
    change = [value(f"{a}_acceleration_mm_per_s2") * 1e6 / hz**2 for a in "uxz"]
    change[X] *= PLAN_TICKS  # speeds of X and Z change from plan to plan
    change[Z] *= PLAN_TICKS
    return Limits(
        np.array(speed) * MARGIN + 2.0,
        np.array(change) * CHANGE_MARGIN + 3.0,
        value("u_stroke_nm") / 2 + 1.0,
    )


def _found(kind: str, what: str, size: NDArray[np.int64], mask: NDArray[np.bool_]) -> list[Wrong]:
    """Return what is wrong, if it is in any tick."""
    if not mask.any():
        return []
    return [Wrong(kind, what, np.flatnonzero(mask), int(np.abs(size[mask]).max()))]


def _beyond(nm: NDArray[np.int64], limits: Limits) -> list[Wrong]:
    """Return what is beyond the limits."""
    step = np.diff(nm, axis=0, prepend=nm[:1])
    change = np.diff(step, axis=0, prepend=step[:1])
    change[:2] = 0  # what was before the checkpoint is not known here
    found = []
    for i, axis in enumerate("UXZ"):
        is_fast = np.abs(step[:, i]) > limits.speed[i]
        is_hard = np.abs(change[:, i]) > limits.change[i]
        found += _found("limits", f"{axis} speed", step[:, i], is_fast)
        found += _found("limits", f"{axis} acceleration", change[:, i], is_hard)
    return found + _found("limits", "U range", nm[:, U], np.abs(nm[:, U]) > limits.u_range)


def _lasting(mask: NDArray[np.bool_], ticks: int) -> NDArray[np.bool_]:
    """Return where something lasts longer than that: nothing obeys a blink."""
    kept = mask.copy()
    for i in range(1, ticks + 1):
        kept[:-i] &= mask[i:]
        kept[-i:] = False
    return kept


def _off(nm: NDArray[np.int64], golden: NDArray[np.int64], early: int) -> NDArray[np.int64]:
    """Return how far a course is off that of the unstruck run, at the nearest of some ticks."""
    n = min(len(nm), len(golden))
    off = np.full(len(nm), np.iinfo(np.int64).max)
    for shift in range(-early, early + 1):
        other = golden[np.clip(np.arange(n) + shift, 0, len(golden) - 1)]
        off[:n] = np.where(np.abs(nm[:n] - other) < np.abs(off[:n]), nm[:n] - other, off[:n])
    off[n:] = 0
    return off


def _off_course(ticks: NDArray[np.void], golden: NDArray[np.void]) -> list[Wrong]:
    """Return what is off its course in ticks without a fault."""
    is_good = (ticks["outputs"] & FAULT) == 0
    n = min(len(ticks), len(golden))
    spindle = np.zeros(len(ticks), dtype=np.int64)
    spindle[:n] = ticks["spindle_mrpm"][:n].astype(np.int64) - golden["spindle_mrpm"][:n]
    enable = np.zeros(len(ticks), dtype=np.int64)
    enable[:n] = (ticks["outputs"][:n] ^ golden["outputs"][:n]) & ENABLE
    found = []
    radius = ticks["nm"][:, X].astype(np.int64) - ticks["nm"][:, U]
    golden_radius = golden["nm"][:, X].astype(np.int64) - golden["nm"][:, U]
    is_deep = (_off(radius, golden_radius, EARLY_TICKS) < -COURSE_NM[X]).any()
    for i, axis in enumerate("UXZ"):
        early = 0 if i == U else EARLY_TICKS  # U follows the angle, not the time
        off = _off(ticks["nm"][:, i].astype(np.int64), golden["nm"][:, i].astype(np.int64), early)
        kind = "course" if i == Z or is_deep else "out"
        found += _found(kind, f"{axis} off", off, (np.abs(off) > COURSE_NM[i]) & is_good)
    is_off = np.abs(spindle) > SPINDLE_MRPM
    found += _found("course", "spindle off", spindle, _lasting(is_off & is_good, PLAN_TICKS))
    return found + _found(
        "course", "enable off", enable, _lasting((enable != 0) & is_good, IN_TIME)
    )


def _retract(ticks: NDArray[np.void], golden: NDArray[np.void]) -> list[Wrong]:
    """Return what is wrong in ticks with a fault."""
    is_faulty = (ticks["outputs"] & FAULT) != 0
    radius = ticks["nm"][:, X].astype(np.int64) - ticks["nm"][:, U]
    least = (golden["nm"][:, X].astype(np.int64) - golden["nm"][:, U]).min()
    depth = least - radius
    endless = np.zeros(len(ticks), dtype=bool)
    endless[MOST_TICKS - 2 :] = (ticks["outputs"][MOST_TICKS - 2 :] & ENABLE) != 0
    found = _found("course", "too deep", depth, is_faulty & (depth > DEPTH_NM))
    return found + _found("course", "retract without end", depth, is_faulty & endless)


def whole(result: Result, golden: Result) -> NDArray[np.void]:
    """Return the whole trace: that of the unstruck run up to where they differ."""
    return np.concatenate([golden.ticks[: result.first], result.ticks])


def _reaction(result: Result, ticks: NDArray[np.void]) -> tuple[int | None, str]:
    """Return the tick of the reaction and its class."""
    is_faulty = (ticks["outputs"] & FAULT) != 0
    if is_faulty.any():
        return int(np.argmax(is_faulty)), "detected"
    if result.end in (EXCEPTION, HALT, LOCKUP, WATCHDOG):
        return len(ticks), "stopped"
    if result.n_ticks - result.idle_tick > IDLE_TICKS:
        return len(ticks), "main"
    return None, "small" if result.first < result.n_ticks else "none"


def judge(result: Result, golden: Result, limits: Limits, tick: int) -> Verdict:
    """Judge one run, struck in `tick`."""
    if result.end == LOCKUP:
        return Verdict("stopped", "lock-up")
    ticks = whole(result, golden)[1:]  # tick 0 is before the checkpoint
    seen, kind = _reaction(result, ticks)
    faults = int(np.bitwise_or.reduce(ticks["faults"])) if len(ticks) else 0
    seen_after = None if seen is None else seen + 1 - tick
    wrong = _beyond(ticks["nm"].astype(np.int64), limits)
    wrong += _off_course(ticks, golden.ticks[1:]) + _retract(ticks, golden.ticks[1:])
    late = [w for w in wrong if kind == "main" or w.is_late(seen)]
    if seen is not None:  # it may have left the work before that
        late = [w for w in late if w.kind != "out"]
    if late:
        one = min(late, key=lambda w: (ORDER.index(w.kind), w.begin))
        return Verdict(one.kind, one.what, one.most, one.begin + 1 - tick, seen_after, faults)
    at = min((w.begin + 1 - tick for w in wrong), default=None)
    what = {EXCEPTION: "exception", WATCHDOG: "watchdog"}.get(result.end, "")
    return Verdict(kind, what, 0, at, seen_after, faults)
