"""The simulator as a library in this process: `host_sim/api/sim_api.h`, called by ctypes.

`simulate.py` is the interface for people.

>>> Column("z_mm", "3").decimals
3
"""

import ctypes
import json
import os
from collections.abc import Sequence
from ctypes import c_bool, c_char_p, c_double, c_int, c_int64, c_size_t, c_uint64, c_void_p
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from camtools.base.command import BAD_INPUT
from camtools.base.errors import CamtoolsError
from camtools.base.project import Prototypes, library
from camtools.base.text import Json

Rows = npt.NDArray[Any]  # structured: a field of float64 for each column

WORDS, SIZE = ctypes.POINTER(c_char_p), ctypes.POINTER(c_size_t)
DOUBLE = ctypes.POINTER(c_double)
# Name, result and arguments of every function of the header.
PROTOTYPES: Prototypes = {
    "sim_api_open": (c_void_p, []),
    "sim_api_close": (None, [c_void_p]),
    "sim_api_version": (c_char_p, []),
    "sim_api_machine_keys": (c_char_p, []),
    "sim_api_error": (c_char_p, [c_void_p]),
    "sim_api_begin": (c_bool, [c_void_p, WORDS, c_int, c_char_p, c_size_t, c_char_p]),
    "sim_api_plan": (None, [c_void_p, DOUBLE, DOUBLE, DOUBLE]),
    "sim_api_path": (c_char_p, [c_void_p, c_char_p]),
    "sim_api_run": (c_bool, [c_void_p, c_uint64]),
    "sim_api_progress": (c_double, [c_void_p]),
    "sim_api_finish": (c_int, [c_void_p, c_double]),
    "sim_api_columns": (c_char_p, [c_void_p, c_char_p]),
    "sim_api_rows": (ctypes.POINTER(c_int64), [c_void_p, c_char_p, SIZE]),
    "sim_api_drop": (None, [c_void_p, c_char_p]),
    "sim_api_summary": (c_char_p, [c_void_p]),
    "sim_api_end": (None, [c_void_p]),
}


def _library() -> ctypes.CDLL:
    return library("camsim", PROTOTYPES, "tools/run")


def key_lines() -> str:
    """Return the keys of machine files in lines, as `sim_config_keys` writes them."""
    text: bytes = _library().sim_api_machine_keys()
    return text.decode()


class Column(NamedTuple):
    """A column of a table of results."""

    name: str  # ends with its unit
    format: str  # number of decimals; x4: a mask in hexadecimal; s: a state by its number

    @property
    def decimals(self) -> int:
        """Return how many decimals its numbers have."""
        return int(self.format) if self.format.isdigit() else 0


class Table(NamedTuple):
    """Rows of a table of results."""

    columns: tuple[Column, ...]
    numbers: npt.NDArray[np.int64]  # shape (rows, columns), in units of a column's last decimal

    def rows(self) -> Rows:
        """Return all columns as fields of a structured array."""
        if not self.columns:
            return np.empty(0)
        kinds = np.dtype([(column.name, np.float64) for column in self.columns])
        units = [10.0**column.decimals for column in self.columns]
        return (self.numbers / units).view(kinds).reshape(len(self.numbers))


NO_ROWS = Table((), np.empty((0, 0), dtype=np.int64))


class Ending(NamedTuple):
    """How a cut ended."""

    status: int  # exit status of `camsim run`: 0 good, 1 not good, 2 the controller refused
    message: str  # why it is not good, "" when it is
    summary_text: str  # JSON, as the file

    @property
    def summary(self) -> Json:
        """Return the summary as data."""
        summary: Json = json.loads(self.summary_text)
        return summary


class SimSession:
    """One simulator, by `with`; only one cut is open in a process at a time."""

    def __init__(self) -> None:
        self._library = _library()
        self._session = self._library.sim_api_open()
        if not self._session:
            raise CamtoolsError(["simulator: not enough memory; free some"])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free everything; the second call does nothing."""
        if self._session:
            self._library.sim_api_close(self._session)
        self._session = None

    def begin(self, words: Sequence[str], machine: str | None = None, name: str = "") -> None:
        """Begin a cut by the words of `camsim run`, table included, or refuse it with its line.

        Options of outputs ask for tables; nothing is written. `machine` is the text of a machine
        file; without it that of --machine, or the default machine, is taken.
        """
        coded = [os.fsencode(word) for word in words]
        array = (c_char_p * len(coded))(*coded)
        text = None if machine is None else machine.encode("utf-8")
        label = name.encode("utf-8", "replace")
        begin = self._library.sim_api_begin
        if not begin(self._session, array, len(coded), text, len(text or b""), label):
            raise CamtoolsError([self.error()])

    def plan(self) -> tuple[float, float, float]:
        """Return turns of cutting and machine time [s] of all passes, and ticks per second."""
        turns, seconds, tick_hz = c_double(), c_double(), c_double()
        self._library.sim_api_plan(self._session, turns, seconds, tick_hz)
        return turns.value, seconds.value, tick_hz.value

    def path(self, output: str) -> str | None:
        """Return the file that the option of an output names, nothing when it is not given."""
        found: bytes | None = self._library.sim_api_path(self._session, output.encode())
        return None if found is None else os.fsdecode(found)

    def run(self, n_ticks: int) -> bool:
        """Go on by so many ticks at most; return whether there is more to do."""
        return bool(self._library.sim_api_run(self._session, n_ticks))

    def progress(self) -> float:
        """Return the share of the machine time that is done, 0 .. 1."""
        return float(self._library.sim_api_progress(self._session))

    def error(self) -> str:
        """Return the line of the last call that failed."""
        return str(self._library.sim_api_error(self._session).decode("utf-8", "replace"))

    def finish(self, wall_s: float) -> Ending:
        """Make the results that come at the end; they stay until the next cut, or the end."""
        status = int(self._library.sim_api_finish(self._session, wall_s))
        message = self.error()
        text = self._library.sim_api_summary(self._session).decode("ascii")
        if status == BAD_INPUT and not text:
            raise CamtoolsError([message])
        return Ending(status, message, f"{text}\n")

    def columns(self, table: str) -> tuple[Column, ...]:
        """Return the columns of a table, none when it was not asked for."""
        listed = self._library.sim_api_columns(self._session, table.encode()) or b""
        pairs = (column.split(":") for column in listed.decode("ascii").split(",") if column)
        return tuple(Column(name, form) for name, form in pairs)

    def take(self, table: str, at_least: int = 0) -> Table:
        """Return the rows that came since the last call, none when there are fewer."""
        columns, n = self.columns(table), c_size_t()
        if not columns:
            return NO_ROWS
        pointer = self._library.sim_api_rows(self._session, table.encode(), ctypes.byref(n))
        n_rows = n.value // len(columns)
        if not n_rows or n_rows < at_least:
            return Table(columns, np.empty((0, len(columns)), dtype=np.int64))
        numbers = np.ctypeslib.as_array(pointer, shape=(n_rows, len(columns))).copy()
        self._library.sim_api_drop(self._session, table.encode())
        return Table(columns, numbers)
