"""Cuts on the simulator, one at a time: tools/run as a process that can be stopped.

>>> seen = RunProgress().after("run: cutting 622 turns, 15 s of machine time on the host simulator")
>>> seen = seen.after("camsim:  42.5 %, 6.4 s of machine time, about 3 s left")
>>> seen.share, seen.left_s, seen.text
(0.425, 3.0, 'cutting 622 turns, 15 s of machine time on the host simulator')
"""

import asyncio
import os
import pty
import re
import signal
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from camtools.base.errors import CamtoolsError
from camtools.base.project import child_environment
from camtools.panel.runs.store import DONE, FAILED, PART, RUNNING, STOPPED, RunOptions, RunStore
from camtools.sim.results import SUMMARY

_CAMSIM = re.compile(r"camsim:\s+([\d.]+) %.*?(?:about (\d+) s left)?\s*\Z")
_MOST_CHARS = 300


@dataclass(frozen=True)
class RunProgress:
    """How far a run is."""

    text: str = "starting"  # what is done
    share: float | None = None  # of the cut, 0 .. 1, where it is known
    left_s: float | None = None  # of the cut [s]
    last: str = ""  # the last line that was no progress: why it failed, where it does

    def after(self, line: str) -> "RunProgress":
        """Return the progress after another line."""
        line = line.strip()[:_MOST_CHARS]
        if found := _CAMSIM.match(line):
            left = None if found[2] is None else float(found[2])
            return replace(self, share=float(found[1]) / 100, left_s=left)
        if line.startswith("run: ") and "; " not in line:
            return RunProgress(line.removeprefix("run: "), last=self.last)
        return replace(self, last=line) if line else self


MOST_WAITING = 5
_STOP_S = 5.0
_MOST_LINE = 4096
_GOOD, _POOR = 0, 1  # exit status: cut and gauged, good or not
_BREAK = re.compile(rb"[\r\n]+")


class RunQueue:
    """Runs that wait, and the running one; `command` gets the words of a run as arguments."""

    def __init__(self, store: RunStore, command: list[str] | None = None) -> None:
        self._store = store
        self._command = command or [sys.executable, "-m", "camtools.cli.run"]
        self._waiting: list[tuple[Path, list[str]]] = []
        self._task: asyncio.Task[None] | None = None
        self._process: asyncio.subprocess.Process | None = None
        self._is_stopped = False
        self.running: Path | None = None
        self.progress = RunProgress()
        self.begun_s = 0.0

    def add(self, folder: Path, options: RunOptions, machine: str | None = None) -> None:
        """Let a run begin when those before it have ended; its machine may be a file of one's own.

        Raises CamtoolsError where too many wait. Needs an event loop that runs.
        """
        self.check_room()
        self._waiting.append((folder, options.words(PART, machine)))
        if self._task is None or self._task.done():
            self._task = asyncio.get_running_loop().create_task(self._work())

    def check_room(self) -> None:
        """Refuse another run where too many wait."""
        if len(self._waiting) >= MOST_WAITING:
            raise CamtoolsError([f"{MOST_WAITING} runs are waiting already; stop one, or wait"])

    @property
    def waiting(self) -> list[str]:
        """Return the names of the runs that wait, the next one first."""
        return [folder.name for folder, _ in self._waiting]

    def stop(self, name: str) -> None:
        """Stop a run, or remove it from those that wait."""
        for i, (folder, _) in enumerate(self._waiting):
            if folder.name == name:
                del self._waiting[i]
                self._store.note(folder, {"status": STOPPED, "told": "stopped before it started"})
                return
        if self.running is not None and self.running.name == name:
            self._is_stopped = True
            self._signal(signal.SIGTERM)
            asyncio.get_running_loop().call_later(_STOP_S, self._kill, name)

    def _kill(self, name: str) -> None:
        if self.running is not None and self.running.name == name and self._is_stopped:
            self._signal(signal.SIGKILL)

    def _signal(self, number: int) -> None:
        """Send a signal to the run and to all that it started."""
        if self._process is not None:
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, number)

    async def close(self) -> None:
        """Stop everything."""
        for folder, _ in self._waiting:
            self._store.note(folder, {"status": STOPPED, "told": "the panel was closed"})
        self._waiting.clear()
        if self.running is not None:
            self._is_stopped = True
            self._signal(signal.SIGKILL)
        if self._task is not None:
            with suppress(asyncio.CancelledError):
                await self._task

    async def _work(self) -> None:
        while self._waiting:
            folder, words = self._waiting.pop(0)
            self.running, self.begun_s, self._is_stopped = folder, time.time(), False
            self.progress = RunProgress()
            self._store.note(folder, {"status": RUNNING})
            try:
                status = await self._cut(folder, words)
            except OSError as error:
                status = -1
                self.progress = self.progress.after(f"cannot be started: {error.strerror}")
            self._note_end(folder, status)
            self.running, self._process = None, None
            self._store.tidy()

    def _note_end(self, folder: Path, status: int) -> None:
        has_cut = status in (_GOOD, _POOR) and (folder / SUMMARY).is_file()
        outcome = DONE if has_cut else FAILED
        message = "" if outcome == DONE else self.progress.last or f"ended with status {status}"
        if self._is_stopped and status != _GOOD:
            outcome, message = STOPPED, "stopped"
        took_s = time.time() - self.begun_s
        if folder.is_dir():
            self._store.note(folder, {"status": outcome, "told": message, "took_s": took_s})

    async def _cut(self, folder: Path, words: list[str]) -> int:
        """Carry the command out; return its exit status.

        On a terminal of its own the simulator reports its progress five times a second.
        """
        ours, theirs = pty.openpty()
        try:
            self._process = await asyncio.create_subprocess_exec(
                *self._command,
                *words,
                cwd=folder,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.DEVNULL,
                stderr=theirs,
                start_new_session=True,
                env=child_environment(),
            )
        except BaseException:
            os.close(ours)
            raise
        finally:
            os.close(theirs)
        try:
            await self._follow(ours)
            return await self._process.wait()
        finally:
            os.close(ours)

    async def _follow(self, terminal: int) -> None:
        """Take the lines of a terminal until it is closed."""
        loop = asyncio.get_running_loop()
        ready = asyncio.Event()
        os.set_blocking(terminal, False)
        loop.add_reader(terminal, ready.set)
        rest = b""
        try:
            while True:
                await ready.wait()
                ready.clear()
                try:
                    data = os.read(terminal, _MOST_LINE)
                except BlockingIOError:
                    continue
                except OSError:  # the last one who had it open is gone
                    data = b""
                if not data:
                    self._take(rest)
                    return
                *lines, rest = _BREAK.split(rest + data)
                rest = rest[-_MOST_LINE:]
                for line in lines:
                    self._take(line)
        finally:
            loop.remove_reader(terminal)

    def _take(self, line: bytes) -> None:
        self.progress = self.progress.after(line.decode("utf-8", "replace"))
