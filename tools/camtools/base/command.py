"""What all command lines share: one-line errors, exit status, signals.

>>> run_command("demo", lambda: 0)
0
"""

import argparse
import errno
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

from camtools.base.errors import CamtoolsError, first_lines, readable
from camtools.base.project import VERSION, shown_name, with_names
from camtools.base.signals import SIGNALS, Interrupted, arrived

BAD_INPUT = 2
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


class Parser(argparse.ArgumentParser):
    """A parser that knows --version, and whose complaint is one line that names the command."""

    def __init__(self, prog: str, **rest: Any) -> None:  # noqa: ANN401 - those of argparse
        super().__init__(prog=with_names(prog), **rest)
        if " " not in prog:  # not a command of a command
            version = f"{self.prog.removeprefix('tools/')} {VERSION}"
            self.add_argument("--version", action="version", version=version)

    def format_usage(self) -> str:
        """Return the line of usage."""
        return with_names(super().format_usage())

    def format_help(self) -> str:
        """Return the help."""
        return with_names(super().format_help())

    def error(self, message: str) -> NoReturn:
        """End with status 2."""
        name = self.prog.removeprefix("tools/")
        self.exit(BAD_INPUT, f"{name}: {readable(message)}; see {self.prog} --help\n")


def no_warnings() -> None:
    """Show no warning of Python from now on: users read results and errors, tests raise warnings.

    A warning that a filter turns into an exception is raised as before.
    """
    warnings.showwarning = lambda *_args, **_more: None


@contextmanager
def _no_signal_is_lost() -> Iterator[None]:
    """Send a signal again that came in a finaliser, which swallows every exception."""
    hook = sys.unraisablehook

    def send_again(unraisable: Any) -> None:  # noqa: ANN401 - UnraisableHookArgs has no name
        if isinstance(unraisable.exc_value, Interrupted):
            number = unraisable.exc_value.args[0]
            threading.Timer(0.01, os.kill, [os.getpid(), number]).start()
        else:
            hook(unraisable)

    sys.unraisablehook = send_again
    try:
        yield
    finally:
        sys.unraisablehook = hook


def run_command(name: str, action: Callable[[], int], *, kept: str = "nothing was written") -> int:
    """Carry a command out, its name before every line on stderr; return its exit status.

    That of the action; 2 on bad input (CamtoolsError), reported line by line, and where the output
    cannot be written; 128 + n on signal n, with a line about what it leaves (`kept`); 141 where
    nobody reads the output any more.
    """
    no_warnings()
    name = shown_name(name)
    stopped: list[int] = []  # a library may turn the exception into one of its own

    def interrupt(number: int, _frame: FrameType | None) -> None:
        stopped.append(number)
        arrived(number)

    for number in SIGNALS:
        signal.signal(number, interrupt)
    try:
        with _no_signal_is_lost():
            status = action()
        sys.stdout.flush()
        return status
    except CamtoolsError as error:
        for line in first_lines(error.lines):
            sys.stderr.write(with_names(f"{name}: {line}\n"))
        return BAD_INPUT
    except BrokenPipeError:  # who read the output has enough, as `head` does
        _drop_output()
        return 128 + signal.SIGPIPE
    except (Interrupted, Exception) as error:
        if isinstance(error, OSError) and error.errno in _FULL:
            _drop_output()
            place = error.filename or "the output"
            reason = f"{place} cannot be written: {error.strerror}"
            sys.stderr.write(f"{name}: {reason}; free some space, or write elsewhere\n")
            return BAD_INPUT
        if not stopped:
            raise
        sys.stderr.write(f"{name}: interrupted; {kept}\n")
        return 128 + stopped[0]


def _drop_output() -> None:
    """Let the end of the program find no output that it cannot write."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
