"""What live pictures show: the following error over the angle, by samples of single ticks.

A controller sends them (message Strobe of firmware/remote/can/camturn.dbc) while somebody asks for
them; recorder and black box are left alone. A subscription holds for 2 s and is renewed here with
every frame that comes, so that it ends with the program that reads the bus.

    strobe = Strobe(link)
    strobe.begin(best_every(tick_hz, rpm))     # or strobe.follow(), which does it by the status
    ... link.pump() ...; strobe.renew()        # in the loop that owns the link
    strobe.samples()                           # from any thread
    strobe.end()

>>> best_every(20000, 1000.0)                  # 40 would meet the same 30 angles in every turn
43
"""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camtools.link.controller import ANSWER_S, Link
from camtools.link.messages import Refused
from camtools.link.scope import require

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MOST_HZ = 500  # samples a second at most
MOST_SAMPLES, MOST_TURNS = 6000, 50  # that are kept
SETTLED = 400  # samples by which a period is judged: about a second
RENEW_S = 0.5  # well within the 2 s after which the controller takes the reader for gone
BROKEN_S = 2.0  # without a sample: what comes then is of another time
SAME_SPEED, STANDING_RPM = 0.001, 1.0  # changes of speed that ask for no other period
WIDE_TURN = 0.02  # gap between angles from which on another period is looked for
SYNCED, SATURATED = 0x10, 0x20  # bits beside the state


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of single ticks, the oldest first; all arrays have the shape (n,).

    angle_turn: angle in the sense of cutting, [0, 1): the drawing's with M3, 1 less the drawing's
    with M4.
    """

    tick: Ints  # numbers of the ticks, from that of the first sample since begin() on
    turn: Ints  # whole turns in the sense of cutting, without wrap; only differences mean anything
    angle_turn: Floats
    error_um: Floats  # following error [um] of the same tick: U measured less U due
    state: Ints  # number of the state, as in NAMES["state"]
    is_synced: Flags  # whether the angle was known
    is_saturated: Flags  # whether the error is larger than 8388.607 um, which then stands for it
    n_lost: int  # samples that were lost since begin(), on the bus or because they found no room


class Strobe:
    """A subscription to the samples of a controller. All but samples(): in the link's thread.

    most, most_turns: samples and whole turns that are kept; older ones are forgotten. every: ticks
    between samples; 0: nothing was asked for; last_s: when the newest sample came, by
    time.monotonic(); -1e9 before the first.
    """

    def __init__(self, link: Link, most: int = MOST_SAMPLES, most_turns: int = MOST_TURNS) -> None:
        self.every, self.last_s = 0, -1e9
        self._link, self._most, self._most_q16 = link, most, most_turns << 16
        self._lock = threading.Lock()
        self._rows = np.zeros((most, 4), np.int64)  # number, position [turn / 2^16], error, state
        self._n = self._n_lost = self._number = self._pos_q16 = 0
        self._judged_rpm = self._asked_s = 0.0
        self._asked_at = 0  # number of the sample that was the newest then
        link.on_strobe = self._take

    def begin(self, every: int) -> None:
        """Ask for a sample every so many ticks and forget those that are there.

        Raises Refused: the controller says no (out of range, with the range), or nothing; or it is
        older than this command.
        """
        self.every = 0  # no renewal of the last period comes between
        answer = self._link.ask("strobe", every=every)
        while answer.result == "done" and answer.value != every:  # to a renewal of before
            answer = self._link.next_answer("strobe", ANSWER_S)
        if answer.limits is not None:
            low, high = answer.limits
            raise Refused(f"strobe every {every} ticks: out of range; give {low:.0f} .. {high:.0f}")
        require(self._link, "strobe", answer)
        self._forget()
        self.every = every
        self._asked_s, self._asked_at = time.monotonic(), 0

    def follow(self) -> None:
        """Begin by tick rate and speed of the status, anew where the speed asks for another period.

        To be called now and then (10 Hz will do), and renews as well; what is there is kept as long
        as the period fits. Raises Refused: as begin(); no status comes.
        """
        signals = self._link.status.signals
        if not {"tick_rate", "speed"} <= signals.keys():
            signals = self._link.listen().signals
        tick_hz, rpm = int(signals["tick_rate"]), abs(signals["speed"])
        if self.every == 0 or self._leaves_a_gap(tick_hz, rpm):
            every = best_every(tick_hz, rpm)
            if every != self.every:
                self.begin(every)
        self.renew()

    def _leaves_a_gap(self, tick_hz: int, rpm: float) -> bool:
        """Return whether the period meets the same few angles again and again at this speed.

        A small change of speed is enough for that: 40 ticks fill the turn at 2490 r/min, and meet
        12 angles at 2500 r/min.
        """
        is_same = abs(rpm - self._judged_rpm) <= SAME_SPEED * self._judged_rpm
        if rpm < STANDING_RPM or is_same:
            return False
        self._judged_rpm = rpm
        return _gap(self.every * rpm / 60.0 / tick_hz) > WIDE_TURN

    def renew(self) -> None:
        """Ask again when it is due, without waiting for an answer; to be called at 2 Hz or more.

        Every sample that comes does it as well, so that long reads and downloads do not end it.
        Raises Refused: the bus is gone.
        """
        tick_hz = self._link.status.signals.get("tick_rate", 0.0)
        is_old = (self._number - self._asked_at) * self.every > RENEW_S * tick_hz > 0
        if self.every and (is_old or time.monotonic() - self._asked_s > RENEW_S):
            self._asked_s, self._asked_at = time.monotonic(), self._number
            self._link.send_command("strobe", every=self.every)

    def end(self) -> None:
        """Ask for no more samples; those that are there stay."""
        if self.every:
            self.every = 0
            self._link.send_command("strobe", every=0)

    def samples(self) -> Samples:
        """Return what is there; from any thread."""
        with self._lock:
            n, n_lost = self._n, self._n_lost
            first = max(n - self._most, 0)
            rows = self._rows[np.arange(first, n) % self._most]
        number, pos_q16, error_nm, state = rows.T
        is_kept = np.abs(pos_q16 - (pos_q16[-1] if n else 0)) < self._most_q16
        return Samples(
            tick=number[is_kept] * self.every,
            turn=pos_q16[is_kept] >> 16,
            angle_turn=(pos_q16[is_kept] & 0xFFFF) / 65536.0,
            error_um=error_nm[is_kept] / 1000.0,
            state=state[is_kept] & 0xF,
            is_synced=(state[is_kept] & SYNCED) != 0,
            is_saturated=(state[is_kept] & SATURATED) != 0,
            n_lost=n_lost,
        )

    def _forget(self) -> None:
        with self._lock:
            self._n = self._n_lost = self._number = self._pos_q16 = 0
            self.last_s = -1e9

    def _take(self, data: bytes) -> None:
        """Take a frame: what wraps in it counts on from the last one."""
        number, low_q16 = data[0], int.from_bytes(data[1:4], "little")
        error_nm, now_s = int.from_bytes(data[4:7], "little", signed=True), time.monotonic()
        if now_s - self.last_s > BROKEN_S:
            self._forget()
        with self._lock:
            if self._n:
                step = (number - self._number - 1) % 256
                self._n_lost += step
                self._number += step + 1
                self._pos_q16 += (low_q16 - self._pos_q16 + 2**23) % 2**24 - 2**23
            else:
                self._number, self._pos_q16, self._asked_at = number, low_q16, number
            row = (self._number, self._pos_q16, error_nm, data[7])
            self._rows[self._n % self._most] = row
            self._n += 1
            self.last_s = now_s
        self.renew()


def best_every(tick_hz: int, rpm: float, most_hz: int = MOST_HZ) -> int:
    """Return the number of ticks between samples whose angles fill the turn best.

    tick_hz: [Hz] rate of the ticks; rpm: [r/min] speed of the spindle, of either sign; most_hz:
    [Hz] samples at most. Returns every: [ticks] from 1 / most_hz to half as much again.

    Source: MATHS.md (191) .. (193).
    """
    least = max(1, math.ceil(tick_hz / most_hz))
    turns_per_tick = abs(rpm) / 60.0 / tick_hz
    return min(range(least, least + least // 2 + 1), key=lambda n: _gap(n * turns_per_tick))


def _gap(step_turn: float) -> float:
    """Return the largest gap [turn] that the angles of samples of about a second leave.

    A speed is never what it is said to be: the worst of five within 0.1 per cent is taken.
    """
    k = np.arange(SETTLED)
    worst = 0.0
    for factor in np.linspace(0.999, 1.001, 5):
        angles = np.sort(k * step_turn * factor % 1.0)
        worst = max(worst, float(np.max(np.diff(angles, append=angles[0] + 1.0))))
    return worst
