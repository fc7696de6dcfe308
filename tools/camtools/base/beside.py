# SPDX-License-Identifier: Apache-2.0
"""Work in a second process, beside this one.

>>> with beside(lambda: 6 * 7) as answer:
...     answer()
42
"""

from __future__ import annotations

import os
import pickle
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

_T = TypeVar("_T")


def _answer(work: Callable[[], object], out: int) -> None:
    """Write what the work returns, or what it raises, and end this process."""
    try:
        try:
            said = (True, work())
        except Exception as err:
            said = (False, err)
        with os.fdopen(out, "wb") as pipe:
            pickle.dump(said, pipe)
    finally:
        os._exit(0)


@contextmanager
def beside(work: Callable[[], _T]) -> Iterator[Callable[[], _T]]:
    """Begin work in a fork of this process.

    Parameters
    ----------
    work : callable
        sees all that is here; it must not use threads, and its result can be pickled

    Yields
    ------
    callable
        waits for the result and returns it, or raises what the work raised; the process ends with
        the context, done or not

    Raises
    ------
    EOFError
        from the callable: the process was ended
    """
    source, out = os.pipe()
    child = os.fork()
    if child == 0:
        _answer(work, out)
    os.close(out)

    def result() -> _T:
        is_good, value = pickle.load(pipe)
        if not is_good:
            raise value
        return value  # type: ignore[no-any-return]

    with os.fdopen(source, "rb") as pipe:
        try:
            yield result
        finally:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
