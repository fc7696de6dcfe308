"""Signals that end a command, and blocks that they do not break off.

>>> with signals_held():
...     pass
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Interrupted(BaseException):
    """A signal demands the end; unwinding removes what is unfinished."""


class _Held:
    """Whether the main thread is inside `signals_held`, and the signal that arrived there."""

    is_on = False
    number: int | None = None


def arrived(number: int) -> None:
    """Raise Interrupted, or let the end of `signals_held` raise it."""
    _Held.number = number if _Held.is_on else None
    if not _Held.is_on:
        raise Interrupted(number)


@contextmanager
def signals_held() -> Iterator[None]:
    """Delay Interrupted until the end of the block.

    For finished files that get their names, and for short calls of a library whose locks other
    threads need. Only the main thread is interrupted, and only within `run_command`.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    was_on, _Held.is_on = _Held.is_on, True
    try:
        yield
    finally:
        _Held.is_on = was_on
        if _Held.number is not None and not was_on:
            arrived(_Held.number)
