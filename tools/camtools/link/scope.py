"""The recorder of a controller: signals of its ticks, read piece by piece.

>>> mask_of(["u_set_q6", "u_actual_nm"]) == 1 << 2 | 1 << 5
True
"""

from __future__ import annotations

import contextlib
import time
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from camtools.base.errors import CamtoolsError
from camtools.link.controller import Link
from camtools.link.messages import DATABASE, NOT_COMMANDER, NUMBERS, OLDER, Answer, Refused
from camtools.link.refusal_text import REMEDIES, explain

Ints = npt.NDArray[np.int64]


def _words(table: str) -> tuple[str, ...]:
    assert DATABASE.dbc is not None
    return tuple(str(word) for _, word in sorted(DATABASE.dbc.value_tables[table].items()))


SIGNALS, FIELDS, PHASES, ENDS, USES, TRIGGERS, EXCITED = (
    _words(table)
    for table in (
        *("scope_signal", "scope_field", "scope_phase", "scope_end", "scope_use"),
        *("trigger", "excited"),
    )
)
DEFAULT_SIGNALS = ("u_set_q6", "u_command_nm", "u_actual_nm")
MOST_REPEATS = 5
ALIVE_S = 0.1  # well within the 500 ms after which the controller takes the tool for lost
_UNSIGNED = ("first_tick", "n_lost", "signals", "number", "trigger_tick", "faults")
_AS_THEY_ARE = ("tick_hz", "every", "first_tick", "n_lost", "n_before", "faults")
_REMEDIES = {
    **{name: REMEDIES[name] for name in ("locked", "lock_none")},
    "command": OLDER,
    "scope_memory": "record fewer signals, fewer rows or every n-th tick",
    "scope_on": "stop the recording that runs",
    "scope_unread": "the last fault would be lost; camctl blackbox FILE reads it, --clear drops it",
    "scope_before": "the rows before the trigger leave none after it; record longer",
    "state": "the state must be ready: home first",
    "wave_none": "download a wave",
    "wave_unit": "U of this machine takes positions: give a wave of nm, with the heading u_nm",
}
_LIMITS = {  # of a wave: the parameter, and the unit of both
    "wave_stroke": ("u_stroke_nm", "nm"),
    "wave_speed": ("u_speed_um_per_s", "um/s"),
    "wave_acceleration": ("u_acceleration_mm_per_s2", "mm/s2"),
    "wave_force": ("servo_force_limit_mn", "mN"),
}


@dataclass(frozen=True, eq=False)
class Recording:
    """What a controller recorded."""

    signals: tuple[str, ...]  # names of the columns; the last word is the unit, see SIGNALS
    rows: npt.NDArray[np.int32]  # shape (n, len(signals)); a row for each tick that was recorded
    tick_hz: int  # [Hz] rate of the ticks
    every: int  # [ticks] from row to row
    first_tick: int  # number of the tick of the first row, modulo 2^32
    end: str  # why it ended, one of ENDS
    n_lost: int  # ticks that were lost at the end; the rows have no gap
    n_fall: int = 0  # rows at the end of an excitation in which its amplitude falls; 0 without one
    n_before: int = 0  # rows of before the trigger
    trigger_tick: int = 0  # in which the trigger fired, not wrapped against the ticks of the rows
    faults: int = 0  # that were latched in that tick, a bit each

    def __getitem__(self, signal: str) -> Ints:
        """Return a column."""
        return self.rows[:, self.signals.index(signal)].astype(np.int64)

    @property
    def tick(self) -> Ints:
        """Numbers of the ticks of the rows, not wrapped."""
        return self.first_tick + self.every * np.arange(len(self.rows), dtype=np.int64)

    @property
    def t_s(self) -> npt.NDArray[np.float64]:
        """Times [s] of the rows from the trigger on."""
        return (self.tick - self.trigger_tick) / self.tick_hz

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


def require(link: Link, what: str, answer: Answer) -> Answer:
    """Return an answer that is done; a refusal has the limit, or what to do."""
    if answer.result == "done":
        return answer
    if answer.result == NOT_COMMANDER:
        raise Refused(f"{what}: {explain(link, answer)}")
    text = f"{what}: refused: {answer.result.replace('_', ' ')}"
    if answer.result in _LIMITS:
        name, unit = _LIMITS[answer.result]
        limit = link.ask("get_parameter", parameter=NUMBERS["parameter"][name]).value
        found = f"it would take {answer.value:.0f} {unit}, {name} is {limit:.0f}"
        raise Refused(f"{text}: {found}; make the wave smaller or slower")
    if answer.result == "wave_length" and answer.value:
        raise Refused(f"{text}: fade 16 .. 65535 ticks, in all at most {answer.value:.0f} ticks")
    if answer.result == "wave_clear":
        raise Refused(f"{text}: move X to {answer.value:.0f} nm or further out")
    remedy = _REMEDIES.get(answer.result)
    raise Refused(text + (f"; {remedy}" if remedy else ""))


def get(link: Link, field: str) -> int:
    """Return a field of the recorder."""
    answer = link.ask("get_scope", parameter=FIELDS.index(field))
    value = int(require(link, f"recorder: {field}", answer).value)
    return value & 0xFFFFFFFF if field in _UNSIGNED else value


def put(link: Link, field: str, value: int) -> None:
    """Set a field of the recorder."""
    signed = value - (1 << 32) if value >= 1 << 31 else value
    answer = link.ask("set_scope", parameter=FIELDS.index(field), value=signed)
    require(link, f"recorder: {field} = {value}", answer)


def configure(
    link: Link, signals: Sequence[str] = DEFAULT_SIGNALS, every: int = 1, rows: int = 0
) -> None:
    """Choose what the next recording holds; rows 0: as many as fit."""
    put(link, "signals", mask_of(signals))
    put(link, "every", every)
    put(link, "rows", rows)


def start(link: Link) -> None:
    """Begin a recording; what was recorded before is lost."""
    require(link, "record", link.ask("start_scope"))


def stop(link: Link) -> None:
    """End the recording that runs; what is recorded stays."""
    require(link, "record", link.ask("stop_scope"))


def release(link: Link) -> None:
    """Give the memory back: the controller's black box begins anew, the last one is gone."""
    require(link, "release recorder", link.ask("release_scope"))


def phase(link: Link) -> str:
    """Return what the recorder does, one of PHASES."""
    return PHASES[get(link, "phase")]


class _Transfer(NamedTuple):
    """How pieces come: by which command, of how many words, in which unit they are counted."""

    command: str
    n_words: int
    grain: int


_CLASSIC = _Transfer("read_scope", 252, 1)
_FD = _Transfer("read_scope_fd", 4032, 16)


def read(link: Link, progress: Callable[[int, int], None] | None = None) -> Recording:
    """Return the recording that is there.

    Over a bus that was opened for CAN FD it asks for long messages, and for classic ones when none
    of those arrives: the controller's side of the bus may be classic. progress: called with the
    bytes that are there and those in all. Raises Refused: there is none, it still runs, or the bus
    loses too much.
    """
    if phase(link) != "done":
        raise Refused(f"{link.where}: the recorder is {phase(link)}: no recording is complete")
    fields = {name: get(link, name) for name in FIELDS}
    data, n_bytes = bytearray(), 4 * fields["n_rows"] * fields["n_signals"]
    transfer = _FD if link.is_fd and _carries_fd(link) else _CLASSIC
    while len(data) < n_bytes:
        n_words = min(transfer.n_words, (n_bytes - len(data)) // 4)
        data += _piece(link, transfer, len(data) // 4, n_words)
        if progress is not None:
            progress(len(data), n_bytes)
    return _recording(fields, bytes(data))


def _recording(fields: dict[str, int], data: bytes) -> Recording:
    names = tuple(name for i, name in enumerate(SIGNALS) if fields["signals"] >> i & 1)
    is_excited = ENDS[fields["end"]] == "state_left" and EXCITED[fields["excited"]] == "done"
    since_first = (fields["trigger_tick"] - fields["first_tick"]) % 2**32  # ticks wrap
    return Recording(
        signals=names,
        rows=np.frombuffer(data, "<i4").reshape(fields["n_rows"], len(names)),
        end=ENDS[fields["end"]],
        n_fall=fields["n_fall"] if is_excited else 0,
        trigger_tick=fields["first_tick"] + since_first,
        **{name: fields[name] for name in _AS_THEY_ARE},
    )


def _carries_fd(link: Link) -> bool:
    """Ask for one long message."""
    link.parts.clear()
    with contextlib.suppress(Refused):
        answer = link.ask(_FD.command, offset=0, count=1)
        return answer.result == "done" and len(link.parts) > 0
    return False


def _piece(link: Link, transfer: _Transfer, offset: int, n_words: int) -> bytes:
    """Return words of the recording, asked for again until they are sound."""
    problem = ""
    count = -(-n_words // transfer.grain)
    for _ in range(MOST_REPEATS):
        link.parts.clear()
        try:
            answer = link.ask(transfer.command, offset=offset, count=count)
        except Refused as error:
            problem = str(error)
            continue
        require(link, "read recording", answer)
        by_number = {part[0]: part[1:] for part in link.parts}
        data = b"".join(by_number[i] for i in sorted(by_number))[: 4 * n_words]
        if len(data) == 4 * n_words and zlib.crc32(data) == int(answer.value):
            return data
        problem = f"{link.where}: the block at word {offset} arrived damaged"
    raise Refused(f"{problem}; the recording is kept, read it again")


def wait(link: Link, timeout_s: float) -> None:
    """Wait until the recording has ended; refused where it has not in time."""
    end_s = time.monotonic() + timeout_s
    while phase(link) not in ("done", "idle"):
        if time.monotonic() > end_s:
            raise Refused(f"{link.where}: the recording has not ended after {timeout_s:.0f} s")
        link.wait(lambda: False, ALIVE_S)
