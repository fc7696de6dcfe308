"""The simulator as a library in this process: `host_sim/api/sim_api.h`, called by ctypes.

`simulate.py` is the interface for people.

>>> library_path().name
'libcamsim.so'
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Sequence
from ctypes import c_bool, c_char_p, c_double, c_int, c_size_t, c_uint64, c_void_p
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from camtools.base.errors import CamtoolsError
from camtools.base.shared_library import Prototypes, loaded
from camtools.sim.camsim import camsim_path

Rows = npt.NDArray[Any]  # structured: a field of float64 for each column

WORDS, SIZE = ctypes.POINTER(c_char_p), ctypes.POINTER(c_size_t)
# Name, result and arguments of every function of the header.
PROTOTYPES: Prototypes = {
    "sim_api_open": (c_void_p, []),
    "sim_api_close": (None, [c_void_p]),
    "sim_api_version": (c_char_p, []),
    "sim_api_error": (c_char_p, [c_void_p]),
    "sim_api_begin": (c_bool, [c_void_p, WORDS, c_int, c_char_p, c_size_t, c_char_p, c_bool]),
    "sim_api_run": (c_bool, [c_void_p, c_uint64]),
    "sim_api_progress": (c_double, [c_void_p]),
    "sim_api_finish": (c_int, [c_void_p, c_double]),
    "sim_api_surface": (ctypes.POINTER(c_double), [c_void_p, SIZE]),
    "sim_api_trace": (ctypes.POINTER(c_double), [c_void_p, SIZE]),
    "sim_api_surface_header": (c_char_p, [c_void_p]),
    "sim_api_trace_header": (c_char_p, [c_void_p]),
    "sim_api_summary": (c_char_p, [c_void_p]),
    "sim_api_end": (None, [c_void_p]),
}
_BAD_INPUT = 2


def library_path() -> Path:
    """Return where the library is built: beside camsim."""
    return camsim_path().with_name("libcamsim.so")


@cache
def _library(path: Path) -> ctypes.CDLL:
    return loaded(path, PROTOTYPES, "tools/run")


class RawResult(NamedTuple):
    """What a cut left."""

    status: int  # exit status of `camsim run`: 0 good, 1 not good
    message: str  # why it is not good, "" when it is
    surface: Rows  # a field for each column of the file; trace is empty when none was asked for
    trace: Rows
    summary_text: str  # JSON, as the file


class SimSession:
    """One simulator; use it by `with`.

    Only one cut is open in a process at a time, by whatever session.
    """

    def __init__(self) -> None:
        self._library = _library(library_path())
        self._session = self._library.sim_api_open()
        if not self._session:
            raise CamtoolsError(["simulator: not enough memory; free some"])

    def __enter__(self) -> SimSession:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free everything; the second call does nothing."""
        if self._session:
            self._library.sim_api_close(self._session)
        self._session = None

    def begin(self, words: Sequence[str], machine: str | None, name: str, *, traced: bool) -> None:
        """Begin a cut.

        Parameters
        ----------
        words : list of str
            Of `camsim run`, the table included, without outputs.
        machine : str or None
            Text of a machine file; None: that of --machine, or the default machine.
        traced : bool
            Keep every tick, or one of --trace-every.

        Raises
        ------
        CamtoolsError
            The simulator refuses; its line says why.
        """
        coded = [os.fsencode(word) for word in words]
        array = (c_char_p * len(coded))(*coded)
        text = None if machine is None else machine.encode("utf-8")
        size = len(text or b"")
        begin = self._library.sim_api_begin
        label = name.encode("utf-8", "replace")
        if not begin(self._session, array, len(coded), text, size, label, traced):
            raise CamtoolsError([self.error()])

    def run(self, n_ticks: int) -> bool:
        """Go on by so many ticks at most; return whether there is more to do."""
        return bool(self._library.sim_api_run(self._session, n_ticks))

    def progress(self) -> float:
        """Return the share of the turns that are done, 0 .. 1."""
        return float(self._library.sim_api_progress(self._session))

    def error(self) -> str:
        """Return the line of the last call that failed."""
        return str(self._library.sim_api_error(self._session).decode("utf-8", "replace"))

    def finish(self, wall_s: float) -> RawResult:
        """Return what the cut left, in memory of Python's own; the cut is ended.

        Raises
        ------
        CamtoolsError
            Not enough memory.
        """
        library, session = self._library, self._session
        status = int(library.sim_api_finish(session, wall_s))
        summary = library.sim_api_summary(session).decode("ascii")
        if status == _BAD_INPUT and not summary:
            raise CamtoolsError([self.error()])
        surface = self._rows(library.sim_api_surface, library.sim_api_surface_header)
        trace = self._rows(library.sim_api_trace, library.sim_api_trace_header)
        message = self.error()
        library.sim_api_end(session)
        return RawResult(status, message, surface, trace, summary)

    def _rows(self, values: Callable[..., Any], header: Callable[..., bytes]) -> Rows:
        """Return a copy of a table."""
        n = c_size_t()
        pointer = values(self._session, ctypes.byref(n))
        names = header(self._session).decode("ascii").split(",")
        kinds = [(name, np.float64) for name in names if name]
        if not n.value or not kinds:
            return np.empty(0, dtype=kinds)
        flat = np.ctypeslib.as_array(pointer, shape=(n.value,)).copy()
        return flat.view(np.dtype(kinds))
