"""What all command lines share: a signal is a signal, whatever a library makes of it."""

import os
import re
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from io import StringIO
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest

from camtools.base.command import run_command
from camtools.base.errors import CamtoolsError
from camtools.base.signals import signals_held
from tests.tools.cases.part_cases import Capture


def _reads() -> int:
    """Read a number with a converter, during which the signal comes: numpy says ValueError."""

    def convert(_: str) -> NoReturn:
        signal.raise_signal(signal.SIGTERM)
        raise AssertionError

    np.loadtxt(StringIO("1\n"), converters={0: convert})
    return 0


class _Finalised:
    """Python swallows whatever is raised while it removes one."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGINT)


def _removes_one() -> int:
    _Finalised()
    time.sleep(5.0)
    return 0


@pytest.mark.parametrize(
    ("act", "number"), [(_reads, signal.SIGTERM), (_removes_one, signal.SIGINT)]
)
def test_a_signal_is_a_signal(act: Callable[[], int], number: int, capsys: Capture) -> None:
    """One line and 128 + its number, no trace back; from a finaliser it comes a moment later."""
    assert run_command("demo", act) == 128 + number
    assert capsys.readouterr().err == "demo: interrupted; nothing was written\n"


def _warns() -> int:
    np.float64(1) / np.float64(0)
    return 0


def test_no_warning_of_python_is_shown(capsys: Capture) -> None:
    """Whatever Python's filters; that of the tests makes an error of it within a command, too."""
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        assert run_command("demo", _warns) == 0
    assert not shown and capsys.readouterr() == ("", "")
    with pytest.raises(RuntimeWarning):
        run_command("demo", _warns)


@pytest.mark.parametrize(
    ("lines", "end"),
    [
        ([f"a.toml: {'k' * 99_999}: unknown key; remove it"], "kkk: unknown key; remove it"),
        ([f"a.toml: key_{i}: unknown key; remove it" for i in range(3000)], " more"),
        (["a.toml: b.csv: " + "\x1b[2J" * 9999 + "; remove it"], "; remove it"),
    ],
)
def test_an_error_is_short(lines: list[str], end: str, capsys: Capture) -> None:
    """Place and remedy stay, of many lines their number; an error in another keeps both."""

    def act() -> NoReturn:
        try:
            raise CamtoolsError(lines)
        except CamtoolsError as error:
            raise CamtoolsError([f"part: {line}" for line in error.lines]) from error

    assert run_command("demo", act) == 2
    text = capsys.readouterr().err
    assert len(text) < 2500
    assert text.startswith("demo: part: a.toml: ") and text.endswith(f"{end}\n")
    counted = text.count("remove it") + sum(map(int, re.findall(r"and (\d+) more", text)))
    assert counted == len(lines)


def test_a_signal_that_is_held_ends_the_command_afterwards(capsys: Capture) -> None:
    """The call is whole, then the signal ends the command."""
    done = list[str]()

    def act() -> int:
        with signals_held():
            signal.raise_signal(signal.SIGINT)
            done.append("call")
        done.append("what follows it")
        return 0

    assert run_command("demo", act) == 128 + signal.SIGINT
    assert done == ["call"]
    assert capsys.readouterr().err == "demo: interrupted; nothing was written\n"


def test_a_defect_is_no_signal() -> None:
    """What is raised without a signal is not hidden."""
    with pytest.raises(ZeroDivisionError):
        run_command("demo", lambda: 1 // 0)


def test_a_reader_that_has_enough_is_no_defect() -> None:
    """As `head` leaves: no trace back, and the status of a broken pipe."""
    code = (
        "from camtools.base.command import run_command\n"
        "def act():\n"
        "    for i in range(100_000): print(i)\n"
        "    return 0\n"
        "raise SystemExit(run_command('demo', act))"
    )
    command, pipe = [sys.executable, "-c", code], subprocess.PIPE
    paths = {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, env=paths) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 128 + signal.SIGPIPE


def test_full_disk_is_one_line() -> None:
    """Output that cannot be written ends the command, with no trace back, not even at its exit."""
    code = "import sys; from camtools.base.command import run_command as r; "
    code += "sys.exit(r('demo', lambda: print('x' * 100_000) or 0))"
    with Path("/dev/full").open("w", encoding="ascii") as full:
        done = subprocess.run(
            [sys.executable, "-c", code],
            env={"PYTHONPATH": os.pathsep.join(sys.path)},
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == (
        "demo: the output cannot be written: No space left on device; free some space, or write "
        "elsewhere\n"
    )
