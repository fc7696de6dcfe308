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
COURSE_NM = np.array([10_000, 10_000, 100_000])  # off the course of the unstruck run
DEPTH_NM = 20_000  # deeper than the unstruck run ever is, behind a fault
SPINDLE_MRPM = 25_000  # 1 % of its speed
MOST_TICKS = 4000  # the retract is over by then
IDLE_TICKS = 400  # the main loop rests at least this often

CLASSES = ("none", "small", "detected", "stopped", "main", "limits", "course")
WRONG = ("limits", "course")


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
    wrong_after: int | None = None
    seen_after: int | None = None
    faults: int = 0


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


def _first(mask: NDArray[np.bool_]) -> int | None:
    return int(np.argmax(mask)) if mask.any() else None


def _beyond(nm: NDArray[np.int64], limits: Limits) -> list[tuple[str, NDArray[np.bool_]]]:
    """Return what is beyond the limits in which tick."""
    step = np.diff(nm, axis=0, prepend=nm[:1])
    change = np.diff(step, axis=0, prepend=step[:1])
    change[:2] = 0  # what was before the checkpoint is not known here
    found = []
    for axis, name in enumerate("UXZ"):
        found.append((f"{name} speed", np.abs(step[:, axis]) > limits.speed[axis]))
        found.append((f"{name} acceleration", np.abs(change[:, axis]) > limits.change[axis]))
    found.append(("U range", np.abs(nm[:, U]) > limits.u_range))
    return found


def _lasting(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return where something lasts longer than the reaction may take: no drive obeys a blink."""
    kept = mask.copy()
    for i in range(1, IN_TIME + 1):
        kept[:-i] &= mask[i:]
        kept[-i:] = False
    return kept


def _off(ticks: NDArray[np.void], golden: NDArray[np.void]) -> list[tuple[str, NDArray[np.bool_]]]:
    """Return what is off its course, in ticks without a fault, and too deep in those with one."""
    is_faulty = (ticks["outputs"] & FAULT) != 0
    n = min(len(ticks), len(golden))
    off = np.zeros((len(ticks), 3), dtype=bool)
    off[:n] = np.abs(ticks["nm"][:n].astype(np.int64) - golden["nm"][:n]) > COURSE_NM
    found = [(f"{name} off", off[:, axis] & ~is_faulty) for axis, name in enumerate("UXZ")]
    spindle = np.zeros(len(ticks), dtype=bool)
    spindle[:n] = (
        np.abs(ticks["spindle_mrpm"][:n].astype(np.int64) - golden["spindle_mrpm"][:n])
        > SPINDLE_MRPM
    )
    found.append(("spindle off", _lasting(spindle & ~is_faulty)))
    outputs = np.zeros(len(ticks), dtype=bool)
    outputs[:n] = ((ticks["outputs"][:n] ^ golden["outputs"][:n]) & ENABLE) != 0
    found.append(("enable off", _lasting(outputs & ~is_faulty)))
    radius = ticks["nm"][:, X].astype(np.int64) - ticks["nm"][:, U]
    least = (golden["nm"][:, X].astype(np.int64) - golden["nm"][:, U]).min()
    found.append(("too deep", is_faulty & (radius < least - DEPTH_NM)))
    endless = np.zeros(len(ticks), dtype=bool)
    endless[MOST_TICKS - 2 :] = (ticks["outputs"][MOST_TICKS - 2 :] & ENABLE) != 0
    found.append(("retract without end", is_faulty & endless))
    return found


def whole(result: Result, golden: Result) -> NDArray[np.void]:
    """Return the whole trace: that of the unstruck run up to where they differ."""
    return np.concatenate([golden.ticks[: result.first], result.ticks])


def _reaction(result: Result, ticks: NDArray[np.void]) -> tuple[int | None, str]:
    """Return the tick of the reaction and its class."""
    fault = _first((ticks["outputs"] & FAULT) != 0)
    if fault is not None:
        return fault, "detected"
    if result.end in (EXCEPTION, HALT, LOCKUP, WATCHDOG):
        return len(ticks), "stopped"
    if result.n_ticks - result.idle_tick > IDLE_TICKS:
        return len(ticks), "main"
    return None, "small" if result.first < result.n_ticks else "none"


def _is_late(wrong: tuple[int, str, str], seen: int, kind: str) -> bool:
    """Return whether the reaction came too late, or was wrong itself."""
    return kind == "main" or seen - wrong[0] > IN_TIME or wrong[0] > seen + IN_TIME


def judge(result: Result, golden: Result, limits: Limits, tick: int) -> Verdict:
    """Judge one run, struck in `tick`."""
    if result.end == LOCKUP:
        return Verdict("stopped", "lock-up")
    ticks = whole(result, golden)[1:]  # tick 0 is before the checkpoint
    nm = ticks["nm"].astype(np.int64)
    seen, kind = _reaction(result, ticks)
    faults = int(np.bitwise_or.reduce(ticks["faults"])) if len(ticks) else 0
    first_seen = None if seen is None else seen + 1 - tick
    wrong: list[tuple[int, str, str]] = []
    for name, masks in (("limits", _beyond(nm, limits)), ("course", _off(ticks, golden.ticks[1:]))):
        for what, mask in masks:
            at = _first(mask)
            if at is not None:
                wrong.append((at, name, what))
    late = [w for w in wrong if seen is None or _is_late(w, seen, kind)]
    if late:
        at, name, what = min(late, key=lambda w: (w[1] != "limits", w[0]))
        return Verdict(name, what, at + 1 - tick, first_seen, faults)
    at_first = min((w[0] for w in wrong), default=None)
    what = "exception" if result.end == EXCEPTION else "watchdog" if result.end == WATCHDOG else ""
    return Verdict(
        kind, what, None if at_first is None else at_first + 1 - tick, first_seen, faults
    )
