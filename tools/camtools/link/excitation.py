"""U excited by a wave, and what the controller records of it.

>>> check_excitation(1, 15, 0)
Traceback (most recent call last):
    ...
camtools.base.errors.CamtoolsError: fade_ticks 15: give 16 .. 65535
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from camtools.base.errors import CamtoolsError
from camtools.link.controller import PATIENCE_S, PERIOD_S, Link
from camtools.link.download import bring
from camtools.link.messages import Refused
from camtools.link.scope import (
    ALIVE_S,
    DEFAULT_SIGNALS,
    EXCITED,
    Recording,
    configure,
    get,
    mask_of,
    phase,
    put,
    read,
    release,
    require,
)

Unit = Literal["nm", "mN"]
# Headings of files of waves, in the order in which the controller numbers the units.
HEADINGS: dict[Unit, str] = {"nm": "u_nm", "mN": "force_mn"}


def check_excitation(periods: int, fade_ticks: int, place_nm: int) -> None:
    """Raise when a number has no place in its message."""
    for name, value, low, high in (
        ("periods", periods, 1, 65535),
        ("fade_ticks", fade_ticks, 16, 65535),
        ("place_nm", place_nm, -15_000_000, 15_000_000),
    ):
        if not low <= value <= high:
            raise CamtoolsError([f"{name} {value}: give {low} .. {high}"])


def download_wave(link: Link, samples: npt.ArrayLike) -> int:
    """Bring the samples of a period to the controller, one per tick; return how many.

    Raises CamtoolsError: they are no whole numbers of 32 bits; Refused: the controller refuses
    them, or the bus loses too much.
    """
    period = np.asarray(samples)
    rounded = np.rint(period.astype(np.float64))
    if period.ndim != 1 or not np.all(np.abs(rounded) < 2**31):
        raise CamtoolsError(["wave: give finite samples, below 2^31, in one row"])
    data = rounded.astype("<i4").tobytes()
    begin = link.ask("begin_wave", size=len(data))
    if begin.result == "scope_memory":
        most = get(link, "n_words") // 2
        what = f"{len(rounded)} samples, the controller holds {most}"
        raise Refused(f"wave: refused: {what}; give a shorter period")
    require(link, "wave", begin)
    bring(link, data, "the controller has no wave; download again", lambda *_: None)
    require(link, "wave", link.ask("end_wave", crc=zlib.crc32(data)))
    return len(rounded)


def _follow(link: Link, timeout_s: float) -> str:
    """Give signs of life until the excitation ends, by the controller's time; return its end."""
    end_row = link.status.n_rows + timeout_s / PERIOD_S
    while link.status.n_rows < end_row:
        require(link, "keep alive", link.ask("keep_alive"))
        excited = EXCITED[get(link, "excited")]
        if excited != "runs" and phase(link) == "done":
            return excited
        link.wait(lambda: False, ALIVE_S)
        if not link.next_row(PATIENCE_S):
            raise Refused(f"{link.where}: the status ended during the excitation; excite again")
    raise Refused(f"{link.where}: the excitation has not ended after {timeout_s:.0f} s")


def excite(
    link: Link,
    samples: npt.ArrayLike,
    periods: int,
    *,
    unit: Unit = "nm",
    fade_ticks: int = 2000,
    place_nm: int = 0,
    signals: Sequence[str] = DEFAULT_SIGNALS,
    progress: Callable[[int, int], None] | None = None,
) -> Recording:
    """Let U play a wave in the state ready, and return what was recorded meanwhile.

    U moves to its place, the amplitude rises, the wave plays, the amplitude falls, and U goes back
    to where it stood. Whatever ends this function early brings U to rest. A force does not fall: it
    drops at the end, and at once when this function ends early.

    samples: [unit] one period, a sample for each tick; forces are added to those of U's loop, and
    each is in the row of the next tick. periods: at full amplitude. fade_ticks: 16 .. 65535.
    place_nm: of U, about which the wave plays. progress: called with the bytes read and those in
    all. Raises CamtoolsError: a number or a signal does not fit its message; Refused: the
    controller refuses with its numbers, it was cut short, or ticks were lost.
    """
    check_excitation(periods, fade_ticks, place_nm)
    mask_of(signals)
    n = download_wave(link, samples)
    if unit != "nm":
        put(link, "wave_unit", [*HEADINGS].index(unit))
    configure(link, signals)
    put(link, "place_nm", place_nm)
    seconds = (n * periods + 2 * fade_ticks) / get(link, "tick_hz")
    require(link, "excite", link.ask("excite", periods=periods, fade=fade_ticks))
    try:
        excited = _follow(link, seconds + 10.0)
    except BaseException:
        link.ask("stop")  # U comes to rest at once, not after the controller's patience
        raise
    if excited != "done":
        raise Refused(f"{link.where}: the excitation was cut short: {excited}")
    recording = read(link, progress)
    release(link)  # the black box has its memory back
    if recording.end != "state_left":
        why = "the memory is full" if recording.end == "full" else "ticks were lost"
        problem = f"the recording is incomplete, {why}"
        raise Refused(f"{link.where}: {problem}; give fewer signals or periods")
    return recording
