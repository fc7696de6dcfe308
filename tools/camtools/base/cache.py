"""Results that are wanted again while somebody edits: kept where a memory is open, else made anew.

The commands open none, so what they write never depends on it. A preview does: a change of the
speed leaves the shape as it was, and the search for its table need not be repeated.

>>> with remembering(Memory(most=2)):
...     [recall(("sum", 2, 3), lambda: 2 + 3), recall(("sum", 2, 3), lambda: -1)]
[5, 5]
>>> recall(("sum", 2, 3), lambda: -1)
-1
"""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar

Result = TypeVar("Result")


class Memory:
    """The newest `most` results by what they were made of; the longest not asked for goes first."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._kept: OrderedDict[Hashable, Any] = OrderedDict()

    def recall(self, key: Hashable, make: Callable[[], Result]) -> Result:
        """Return what was made for this key, or make it; an exception is not kept."""
        if key not in self._kept:
            self._kept[key] = make()
        self._kept.move_to_end(key)
        found: Result = self._kept[key]
        while len(self._kept) > self._most:
            self._kept.popitem(last=False)
        return found


_open: ContextVar[Memory | None] = ContextVar("camtools_memory", default=None)


@contextmanager
def remembering(memory: Memory) -> Iterator[None]:
    """Let `recall` use a memory within the block."""
    token = _open.set(memory)
    try:
        yield
    finally:
        _open.reset(token)


def recall(key: Hashable, make: Callable[[], Result]) -> Result:
    """Return what was made for a key, all it follows from and a word; without a memory make it."""
    memory = _open.get()
    return make() if memory is None else memory.recall(key, make)


def file_state(name: str) -> Hashable:
    """Return what changes when a file does, for a key; its name where it cannot be read."""
    try:
        state = Path(name).stat()
    except (OSError, ValueError):
        return name
    return name, state.st_mtime_ns, state.st_size, state.st_ino
