"""Detects hangs without a clock that judges: processes that neither compute nor print for minutes.

Processor time and bytes written are those of a process and all below it, the ended ones included.

>>> Watch(os.getpid()).is_stalled()
False
"""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from typing import NamedTuple

import psutil

from checks.patience import limit_s

STALL_S = 180.0  # on an idle machine; longer on a slow one
LEAST_CPU_S = 0.3  # in that time: what only polls for an event that never comes takes less
_GONE = (psutil.NoSuchProcess, psutil.AccessDenied)


class Work(NamedTuple):
    """What processes have done so far."""

    cpu_s: float
    n_written: int


def tree(pid: int) -> list[psutil.Process]:
    """Return a process and all below it; none when it has ended."""
    with contextlib.suppress(*_GONE):
        top = psutil.Process(pid)
        return [top, *top.children(recursive=True)]
    return []


def work(processes: list[psutil.Process]) -> Work:
    """Return the work of processes and of their ended children."""
    cpu_s, n_written = 0.0, 0
    for process in processes:
        with contextlib.suppress(*_GONE):
            cpu_s += sum(process.cpu_times()[:4])
            if hasattr(process, "io_counters"):  # some kernels do not count
                n_written += process.io_counters().write_chars
    return Work(cpu_s, n_written)


def waits_for(process: psutil.Process) -> str:
    """Return the command of a process and the function of the kernel in which it waits."""
    with contextlib.suppress(*_GONE, OSError):
        where = Path(f"/proc/{process.pid}/wchan").read_text(encoding="utf-8").strip("\0\n0")
        where = where or "no function of the kernel"
        return f"{' '.join(process.cmdline())[:200]!r} waits in {where}"
    return "a process that has ended"


class Watch:
    """Follows the work of a process and those below it."""

    def __init__(self, pid: int, stall_s: float = STALL_S) -> None:
        self._pid, self._stall_s = pid, limit_s(stall_s)
        self.restart()

    def _work(self) -> Work:
        done = work(tree(self._pid))
        own_s = time.thread_time() if self._pid == os.getpid() else 0.0
        return Work(done.cpu_s - own_s, done.n_written)

    def restart(self) -> None:
        """Take the present moment as one of progress."""
        self._since_s = time.monotonic()
        self._seen = self._start = self._work()

    def is_stalled(self) -> bool:
        """Return whether no progress was made for too long. To be asked every few seconds."""
        now, now_s = self._work(), time.monotonic()
        computed = now.cpu_s - self._seen.cpu_s >= LEAST_CPU_S or now.cpu_s < self._seen.cpu_s
        if computed or now.n_written != self._seen.n_written:
            self._seen, self._since_s = now, now_s
        return now_s - self._since_s > self._stall_s

    def computed_s(self) -> float:
        """Return the processor time since the start or the last restart()."""
        return self._work().cpu_s - self._start.cpu_s
