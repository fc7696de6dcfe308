r"""How far a forecast is: a line that moves on a terminal, some lines elsewhere.

>>> import io
>>> stream = io.StringIO()
>>> progress = Progress(4, 0, stream, lambda: 0.0)
>>> progress.add(4, 1)
>>> stream.getvalue()
'forecast: 4 of 4 cuts, 1 without a result\n'
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TextIO

_LINES = 10  # where there is no terminal


class Progress:
    """Counts cuts.

    Parameters
    ----------
    n_all, n_done : int
        Cuts in all, and those that were there before.
    stream : text stream
    clock : callable
        Returns seconds.
    """

    def __init__(self, n_all: int, n_done: int, stream: TextIO, clock: Callable[[], float]) -> None:
        self._n_all, self._n_before, self._n_done = n_all, n_done, n_done
        self._n_failed = 0
        self._stream, self._clock = stream, clock
        self._begin_s = clock()
        self._is_open = False
        self._told = n_done * _LINES // max(n_all, 1)
        if n_done:
            stream.write(f"forecast: {n_done} of {n_all} cuts are already done\n")

    def add(self, n_cuts: int, n_failed: int) -> None:
        """Count cuts that have been made."""
        self._n_done += n_cuts
        self._n_failed += n_failed
        if self._stream.isatty():
            self._stream.write(f"\r{self._text()}\033[K")
            self._is_open = True
        elif self._n_done * _LINES // self._n_all > self._told:
            self._told = self._n_done * _LINES // self._n_all
            self._stream.write(f"{self._text()}\n")
        self._stream.flush()

    def _text(self) -> str:
        words = [f"forecast: {self._n_done} of {self._n_all} cuts"]
        if self._n_failed:
            words.append(f"{self._n_failed} without a result")
        since_s, n_here = self._clock() - self._begin_s, self._n_done - self._n_before
        left_s = since_s / n_here * (self._n_all - self._n_done)
        if left_s >= 1:
            words.append(f"{left_s:.0f} s left")
        return ", ".join(words)

    def end(self) -> None:
        """Begin a new line on a terminal."""
        if self._is_open:
            self._stream.write("\n")
            self._stream.flush()
