# SPDX-License-Identifier: Apache-2.0
"""The recorder of a controller: signals of its ticks, and U excited by a wave.

>>> mask_of(["u_set_q6", "u_actual_nm"]) == 1 << 2 | 1 << 5
True
>>> mask_of(["u_set"])
Traceback (most recent call last):
    ...
camtools.base.errors.CamtoolsError: u_set: no such signal; give some of tick, state, u_set_q6, \
u_due_q6, u_command_nm, u_actual_nm, u_vel_q10, u_acc_q10, turn, angle_q32, speed_q32, counts, \
index_counts, n_index, edge_clock, clock, x_command_nm, x_actual_nm, z_command_nm, z_actual_nm, \
z_nm, swing_q32, spindle_mrpm, faults, inputs, outputs, config
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camtools.base.errors import CamtoolsError
from camtools.link.controller import DATABASE, NUMBERS, Answer, Link, Refused
from camtools.link.download import bring

Ints = npt.NDArray[np.int64]


def _words(table: str) -> tuple[str, ...]:
    assert DATABASE.dbc is not None
    return tuple(str(word) for _, word in sorted(DATABASE.dbc.value_tables[table].items()))


SIGNALS, FIELDS, PHASES, ENDS, EXCITED = (
    _words(table)
    for table in ("scope_signal", "scope_field", "scope_phase", "scope_end", "excited")
)
DEFAULT_SIGNALS = ("u_set_q6", "u_command_nm", "u_actual_nm")
PIECE_WORDS = 252
MOST_REPEATS = 5
ALIVE_S = 0.1  # well within the 500 ms after which the controller takes the tool for lost
_UNSIGNED = ("first_tick", "n_lost", "signals", "number")
_REMEDIES = {
    "scope_memory": "record fewer signals, fewer rows or every n-th tick",
    "scope_on": "stop the recording that runs",
    "scope_trace": "set trace_on 1",
    "state": "the state must be ready: home first",
    "wave_none": "download a wave",
}
_UNITS = {"wave_stroke": "nm", "wave_speed": "um/s", "wave_acceleration": "mm/s2"}
_LIMITS = {
    "wave_stroke": "u_stroke_nm",
    "wave_speed": "u_speed_um_per_s",
    "wave_acceleration": "u_acceleration_mm_per_s2",
}


@dataclass(frozen=True, eq=False)
class Recording:
    """What a controller recorded.

    Attributes
    ----------
    signals : tuple of str
        names of the columns; the last word is the unit, see SIGNALS
    rows : ndarray of int32, shape (n, len(signals))
        a row for each tick that was recorded
    tick_hz, every : int
        [Hz] rate of the ticks, and [ticks] from row to row
    first_tick : int
        number of the tick of the first row, modulo 2^32
    end : str
        why it ended, one of ENDS
    n_lost : int
        ticks that were lost at the end; the rows have no gap
    n_fall : int
        rows at the end of an excitation in which its amplitude falls; 0 without one
    """

    signals: tuple[str, ...]
    rows: npt.NDArray[np.int32]
    tick_hz: int
    every: int
    first_tick: int
    end: str
    n_lost: int
    n_fall: int = 0

    def __getitem__(self, signal: str) -> Ints:
        """Return a column."""
        return self.rows[:, self.signals.index(signal)].astype(np.int64)

    @property
    def tick(self) -> Ints:
        """Numbers of the ticks of the rows, not wrapped."""
        return self.first_tick + self.every * np.arange(len(self.rows), dtype=np.int64)

    @property
    def is_whole(self) -> bool:
        """Whether no tick was lost."""
        return self.n_lost == 0 and self.end != "gap"

    def played(self) -> Recording:
        """Return the rows before the amplitude falls."""
        n = max(len(self.rows) - self.n_fall, 0)
        return Recording(**(vars(self) | {"rows": self.rows[:n], "n_fall": 0}))


def mask_of(signals: Sequence[str]) -> int:
    """Return signals as the controller takes them: a bit each."""
    for name in signals:
        if name not in SIGNALS:
            raise CamtoolsError([f"{name}: no such signal; give some of {', '.join(SIGNALS)}"])
    return sum(1 << SIGNALS.index(name) for name in set(signals))


def _require(link: Link, what: str, answer: Answer) -> Answer:
    if answer.result == "done":
        return answer
    text = f"{what}: refused: {answer.result.replace('_', ' ')}"
    if unit := _UNITS.get(answer.result):
        index = NUMBERS["parameter"][_LIMITS[answer.result]]
        limit = link.ask("get_parameter", parameter=index).value
        found = f"it would take {answer.value:.0f} {unit}, {_LIMITS[answer.result]} is {limit:.0f}"
        raise Refused(f"{text}: {found}; make the wave smaller or slower")
    if answer.result == "wave_length" and answer.value:
        raise Refused(f"{text}: fade 16 .. 65535 ticks, in all at most {answer.value:.0f} ticks")
    if answer.result == "wave_clear":
        raise Refused(f"{text}: move X to {answer.value:.0f} nm or further out")
    remedy = _REMEDIES.get(answer.result)
    raise Refused(text + (f"; {remedy}" if remedy else ""))


def check_excitation(periods: int, fade_ticks: int, place_nm: int) -> None:
    """Raise when a number has no place in its message."""
    for name, value, low, high in (
        ("periods", periods, 1, 65535),
        ("fade_ticks", fade_ticks, 16, 65535),
        ("place_nm", place_nm, -15_000_000, 15_000_000),
    ):
        if not low <= value <= high:
            raise CamtoolsError([f"{name} {value}: give {low} .. {high}"])


def get(link: Link, field: str) -> int:
    """Return a field of the recorder."""
    answer = link.ask("get_scope", parameter=FIELDS.index(field))
    value = int(_require(link, f"recorder: {field}", answer).value)
    return value & 0xFFFFFFFF if field in _UNSIGNED else value


def put(link: Link, field: str, value: int) -> None:
    """Set a field of the recorder."""
    signed = value - (1 << 32) if value >= 1 << 31 else value
    answer = link.ask("set_scope", parameter=FIELDS.index(field), value=signed)
    _require(link, f"recorder: {field} = {value}", answer)


def configure(
    link: Link, signals: Sequence[str] = DEFAULT_SIGNALS, every: int = 1, rows: int = 0
) -> None:
    """Choose what the next recording holds; rows 0: as many as fit."""
    put(link, "signals", mask_of(signals))
    put(link, "every", every)
    put(link, "rows", rows)


def start(link: Link) -> None:
    """Begin a recording; what was recorded before is lost."""
    _require(link, "record", link.ask("start_scope"))


def stop(link: Link) -> None:
    """End the recording that runs; what is recorded stays."""
    _require(link, "record", link.ask("stop_scope"))


def phase(link: Link) -> str:
    """Return what the recorder does, one of PHASES."""
    return PHASES[get(link, "phase")]


class Reader:
    """Reads a recording piece by piece; after a failure read() goes on where it was.

    Parameters
    ----------
    link : Link
        may be another one for the same controller after the bus was lost
    """

    def __init__(self) -> None:
        self._data = bytearray()
        self._number = 0

    def read(self, link: Link, progress: Callable[[int, int], None] | None = None) -> Recording:
        """Return the recording that is there.

        Parameters
        ----------
        progress : callable
            called with the bytes that are there and those in all

        Raises
        ------
        Refused
            There is none, it still runs, or the bus loses too much.
        """
        if phase(link) != "done":
            raise Refused(f"{link.where}: the recorder is {phase(link)}: no recording is complete")
        told = {name: get(link, name) for name in FIELDS}
        if told["number"] != self._number:
            self._number = told["number"]
            self._data.clear()
        n_bytes = 4 * told["n_rows"] * told["n_signals"]
        while len(self._data) < n_bytes:
            n_words = min(PIECE_WORDS, (n_bytes - len(self._data)) // 4)
            self._data += _piece(link, len(self._data) // 4, n_words)
            if progress is not None:
                progress(len(self._data), n_bytes)
        names = tuple(name for i, name in enumerate(SIGNALS) if told["signals"] >> i & 1)
        rows = np.frombuffer(bytes(self._data), "<i4").reshape(told["n_rows"], len(names))
        is_excited = ENDS[told["end"]] == "state_left" and EXCITED[told["excited"]] == "done"
        return Recording(
            *(names, rows, told["tick_hz"], told["every"], told["first_tick"]),
            *(ENDS[told["end"]], told["n_lost"], told["n_fall"] if is_excited else 0),
        )


def _piece(link: Link, offset: int, n_words: int) -> bytes:
    """Return words of the recording, asked for again until they are sound."""
    problem = ""
    for _ in range(MOST_REPEATS):
        link.parts.clear()
        try:
            answer = link.ask("read_scope", offset=offset, count=n_words)
        except Refused as error:
            problem = str(error)
            continue
        _require(link, "read recording", answer)
        by_number = {part[0]: part[1:] for part in link.parts}
        data = b"".join(by_number[i] for i in sorted(by_number))[: 4 * n_words]
        if len(data) == 4 * n_words and zlib.crc32(data) == int(answer.value):
            return data
        problem = f"{link.where}: the piece at word {offset} came damaged"
    raise Refused(f"{problem}; the recording is kept, read it again")


def read(link: Link, progress: Callable[[int, int], None] | None = None) -> Recording:
    """Return the recording that is there (Reader, for one that may be interrupted)."""
    return Reader().read(link, progress)


def wait(link: Link, timeout_s: float) -> None:
    """Wait until the recording has ended.

    Raises
    ------
    Refused
        It has not in time.
    """
    end_s = time.monotonic() + timeout_s
    while phase(link) not in ("done", "idle"):
        if time.monotonic() > end_s:
            raise Refused(f"{link.where}: the recording has not ended after {timeout_s:.0f} s")
        link.wait(lambda: False, ALIVE_S)


def download_wave(
    link: Link,
    samples_nm: npt.ArrayLike,
    progress: Callable[[int, float], None] = lambda stored, seconds: None,
) -> int:
    """Bring the samples of a period [nm] to the controller, one per tick; return how many.

    Raises
    ------
    CamtoolsError
        They are no whole numbers of 32 bits.
    Refused
        The controller refuses them, or the bus loses too much.
    """
    samples = np.asarray(samples_nm)
    rounded = np.rint(samples.astype(np.float64))
    if samples.ndim != 1 or not np.all(np.abs(rounded) < 2**31):
        raise CamtoolsError(["wave: give finite samples in nm, below 2^31, in one row"])
    data = rounded.astype("<i4").tobytes()
    begin = link.ask("begin_wave", size=len(data))
    if begin.result == "scope_memory":
        most = get(link, "n_words") // 2
        what = f"{len(rounded)} samples, the controller holds {most}"
        raise Refused(f"wave: refused: {what}; give a shorter period")
    _require(link, "wave", begin)
    bring(link, data, "no wave is there, download again", progress)
    _require(link, "wave", link.ask("end_wave", crc=zlib.crc32(data)))
    return len(rounded)


def _follow(link: Link, timeout_s: float) -> str:
    """Give signs of life until the excitation has ended; return what came of it."""
    end_s = time.monotonic() + timeout_s
    while time.monotonic() < end_s:
        _require(link, "keep alive", link.ask("keep_alive"))
        excited = EXCITED[get(link, "excited")]
        if excited != "runs" and phase(link) == "done":
            return excited
        link.wait(lambda: False, ALIVE_S)
    raise Refused(f"{link.where}: the excitation has not ended after {timeout_s:.0f} s")


def excite(
    link: Link,
    samples_nm: npt.ArrayLike,
    periods: int,
    *,
    fade_ticks: int = 2000,
    place_nm: int = 0,
    signals: Sequence[str] = DEFAULT_SIGNALS,
    progress: Callable[[int, int], None] | None = None,
) -> Recording:
    """Let U play a wave in the state ready, and return what was recorded meanwhile.

    U moves to its place, the amplitude rises, the wave plays, the amplitude falls, and U goes back
    to where it stood. Whatever ends this function early brings U to rest.

    Parameters
    ----------
    samples_nm : array_like
        [nm] one period, a sample for each tick
    periods : int
        how often it plays in full
    fade_ticks : int
        [ticks] in which the amplitude rises, and falls; 16 .. 65535
    place_nm : int
        [nm] of U, about which the wave plays
    signals : sequence of str
        to record in every tick
    progress : callable
        called with the bytes of the recording that are there and those in all

    Raises
    ------
    CamtoolsError
        A number or a signal has no place in its message.
    Refused
        The controller refuses with its numbers, it was cut short, or ticks were lost.
    """
    check_excitation(periods, fade_ticks, place_nm)
    mask_of(signals)
    n = download_wave(link, samples_nm)
    configure(link, signals)
    put(link, "place_nm", place_nm)
    seconds = (n * periods + 2 * fade_ticks) / get(link, "tick_hz")
    _require(link, "excite", link.ask("excite", periods=periods, fade=fade_ticks))
    try:
        excited = _follow(link, seconds + 10.0)
    except BaseException:
        link.ask("stop")  # U comes to rest at once, not after the controller's patience
        raise
    if excited != "done":
        raise Refused(f"{link.where}: the excitation was cut short: {excited}")
    recording = read(link, progress)
    if recording.end != "state_left":
        why = "the memory is full" if recording.end == "full" else "ticks were lost"
        raise Refused(f"{link.where}: the recording is not whole, {why}; fewer signals or periods")
    return recording
