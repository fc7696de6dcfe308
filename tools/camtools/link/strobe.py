# SPDX-License-Identifier: Apache-2.0
"""Samples of single ticks for a live picture of the following error over the angle.

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
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camtools.link.controller import Link

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MOST_HZ = 500  # samples a second at most
MOST_SAMPLES, MOST_TURNS = 6000, 50  # that are kept
SETTLED = 400  # samples by which a period is judged: about a second


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of single ticks, the oldest first; all arrays have the shape (n,).

    Attributes
    ----------
    tick : ndarray of int64
        numbers of the ticks, from that of the first sample since begin() on
    turn : ndarray of int64
        whole turns in the sense of cutting, without wrap; only differences mean anything
    angle_turn : ndarray of float
        angle in the sense of cutting, [0, 1): the drawing's with M3, 1 less the drawing's with M4
    error_um : ndarray of float
        following error [um] of the same tick: U measured less U due
    state : ndarray of int64
        number of the state, as in NAMES["state"]
    is_synced : ndarray of bool
        whether the angle was known
    is_saturated : ndarray of bool
        whether the error is larger than 8388.607 um, which then stands for it
    n_lost : int
        samples that were lost since begin(), on the bus or because they found no room
    """

    tick: Ints
    turn: Ints
    angle_turn: Floats
    error_um: Floats
    state: Ints
    is_synced: Flags
    is_saturated: Flags
    n_lost: int


class Strobe:
    """A subscription to the samples of a controller. All but samples(): in the link's thread.

    Parameters
    ----------
    link : Link
        its `on_strobe` is taken
    most, most_turns : int
        samples and whole turns that are kept; older ones are forgotten

    Attributes
    ----------
    every : int
        ticks between samples; 0: nothing was asked for
    """

    def __init__(self, link: Link, most: int = MOST_SAMPLES, most_turns: int = MOST_TURNS) -> None:
        self.every = 0

    def begin(self, every: int) -> None:
        """Ask for a sample every so many ticks and forget those that are there.

        Raises
        ------
        Refused
            The controller says no (trace_on is 0, out of range: the text tells the range), or
            nothing; or it is older than this command.
        """
        raise NotImplementedError

    def follow(self) -> None:
        """Begin by tick rate and speed of the status, anew where the speed has changed much.

        To be called now and then (10 Hz will do); what is there is kept as long as the period fits.

        Raises
        ------
        Refused
            As begin().
        """
        raise NotImplementedError

    def renew(self) -> None:
        """Ask again when it is due, without waiting for an answer; to be called at 2 Hz or more.

        Raises
        ------
        Refused
            The bus is gone.
        """
        raise NotImplementedError

    def end(self) -> None:
        """Ask for no more samples; those that are there stay."""
        raise NotImplementedError

    def samples(self) -> Samples:
        """Return what is there; from any thread."""
        raise NotImplementedError


def best_every(tick_hz: int, rpm: float, most_hz: int = MOST_HZ) -> int:
    """Return the number of ticks between samples whose angles fill the turn best.

    Parameters
    ----------
    tick_hz : int
        [Hz] rate of the ticks
    rpm : float
        [r/min] speed of the spindle, of either sign
    most_hz : int
        [Hz] samples at most

    Returns
    -------
    every : int
        [ticks] from 1 / most_hz to half as much again

    Source: MATHS.md (191) to (193).
    """
    least = max(1, math.ceil(tick_hz / most_hz))
    turns_per_tick = abs(rpm) / 60.0 / tick_hz
    return min(range(least, least + least // 2 + 1), key=lambda n: _gap(n * turns_per_tick))


def _gap(step_turn: float) -> float:
    """Return the largest gap between the angles of neighbouring speeds [turn], of samples of a second.

    A speed is never what it is said to be: the worst of five within 0.1 per cent is taken.
    """
    k = np.arange(SETTLED)
    worst = 0.0
    for factor in np.linspace(0.999, 1.001, 5):
        angles = np.sort(k * step_turn * factor % 1.0)
        worst = max(worst, float(np.max(np.diff(angles, append=angles[0] + 1.0))))
    return worst
