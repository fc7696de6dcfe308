# SPDX-License-Identifier: Apache-2.0
"""What all command lines share: a signal is a signal, whatever a library makes of it."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from io import StringIO
from typing import NoReturn

import numpy as np
import pytest

from camtools.base.command import run_command


@pytest.fixture(autouse=True)
def _handlers() -> Iterator[None]:
    """Leave the handlers of signals as they were."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = [signal.getsignal(number) for number in numbers]
    yield
    for number, handler in zip(numbers, before, strict=True):
        signal.signal(number, handler)


def _reads() -> int:
    """Read a number with a converter, during which the signal comes: numpy says ValueError."""

    def convert(_: str) -> NoReturn:
        signal.raise_signal(signal.SIGTERM)
        raise AssertionError

    np.loadtxt(StringIO("1\n"), converters={0: convert})
    return 0


def test_a_signal_within_numpy_is_a_signal(capsys: pytest.CaptureFixture[str]) -> None:
    """One line and 128 + 15, no trace back."""
    assert run_command("demo", _reads) == 128 + signal.SIGTERM
    assert capsys.readouterr().err == "demo: interrupted; nothing was written\n"


def test_a_defect_is_no_signal() -> None:
    """What is raised without a signal is not hidden."""
    with pytest.raises(ZeroDivisionError):
        run_command("demo", lambda: 1 // 0)
