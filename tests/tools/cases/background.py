"""A program that runs beside a test, which hears what it says and may type to it.

>>> with background(sys.executable, "-c", "print('ready'); print(input())") as echo:
...     echo.wait_for("ready")
...     echo.type("hello")
...     echo.wait_for("hello")
'ready'
'hello'
"""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from checks.patience import limit_s
from tests.tools.cases.part_cases import environment


class Background:
    """A command in a group of processes of its own, in the session of the test.

    So it can be ended with its children here, and by the runner of all steps, who ends a session.
    process: the command's first process; said: lines of both its outputs up to now.
    """

    def __init__(self, words: tuple[str | Path, ...], more: Mapping[str, str]) -> None:
        self.process = subprocess.Popen(
            [str(word) for word in words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            bufsize=1,
            process_group=0,
            env=environment() | {"PYTHONUNBUFFERED": "1"} | dict(more),
        )
        self.said: list[str] = []
        self._n_heard = 0
        self._is_silent = False
        self._news = threading.Condition()
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            with self._news:
                self.said.append(line.rstrip("\n"))
                self._news.notify_all()
        with self._news:
            self._is_silent = True
            self._news.notify_all()

    def text(self) -> str:
        """Return all that it has said."""
        return "\n".join(self.said)

    def wait_for(self, words: str) -> str:
        """Return the first line with some words, behind the one that was waited for last."""
        with self._news:
            while True:
                while self._n_heard < len(self.said):
                    self._n_heard += 1
                    if words in self.said[self._n_heard - 1]:
                        return self.said[self._n_heard - 1]
                assert not self._is_silent, f"ended without {words!r}:\n{self.text()}"
                assert self._news.wait(limit_s()), f"no {words!r}:\n{self.text()}"

    def type(self, line: str) -> None:
        """Type a line."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def end(self, number: int = signal.SIGTERM) -> int:
        """Send a signal, and kill what it did not end; return the exit status."""
        with suppress(ProcessLookupError):
            self.process.send_signal(number)
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(limit_s())
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        status = self.process.wait()
        self._listener.join(limit_s())
        assert self.process.stdin is not None and self.process.stdout is not None
        with suppress(BrokenPipeError):
            self.process.stdin.close()
        self.process.stdout.close()
        return status


@contextmanager
def background(*words: str | Path, **more: str) -> Iterator[Background]:
    """Run a command beside the block; `more` are variables of its environment."""
    one = Background(words, more)
    try:
        yield one
    finally:
        one.end()


def python(module: str, *words: str | Path) -> tuple[str | Path, ...]:
    """Return the command of a Python module, with the interpreter of the tests."""
    return (sys.executable, "-m", module, *words)
