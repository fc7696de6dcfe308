"""Fails a test that hangs, and only that one: no output and no processor time for minutes.

A thread watches the process of pytest and those below it; a signal interrupts the hanging test,
whose error names what it waited for. A test that computes without end fails, too.
"""

import os
import signal
import threading
import traceback
from collections.abc import Generator
from types import FrameType

import pytest

from checks.progress import Watch, tree, waits_for

STALL_S = float(os.environ.get("CAMTURN_STALL_S", "120"))  # before run_steps.py ends the process
_LOOK_S = min(5.0, STALL_S / 4)
_MOST_CPU_S = 900.0  # of one test


def pytest_configure(config: pytest.Config) -> None:
    """Watch the tests of a run."""
    config.pluginmanager.register(HangPlugin())


class HangPlugin:
    """Watches each phase of each test."""

    def __init__(self) -> None:
        self._is_in_test = False
        self._n_phases = 0
        self._why = ""
        signal.signal(signal.SIGUSR2, self._interrupt)
        threading.Thread(target=self._look, daemon=True).start()

    def _interrupt(self, _number: int, frame: FrameType | None) -> None:
        why, self._why = self._why, ""
        if self._is_in_test:
            place = "".join(traceback.format_stack(frame, limit=4))
            pytest.fail(f"{why}\n{place}", pytrace=False)

    def _look(self) -> None:
        pause = threading.Event()
        main = threading.main_thread().ident
        watch, n_phases = Watch(os.getpid(), STALL_S), 0
        while not pause.wait(_LOOK_S):
            if not self._is_in_test or n_phases != self._n_phases or main is None:
                n_phases = self._n_phases
                watch.restart()
            elif watch.is_stalled():
                others = [waits_for(one) for one in tree(os.getpid())[1:]]
                self._why = "; ".join(["the test hangs: no output, no processor time", *others])
            elif watch.computed_s() > _MOST_CPU_S:
                self._why = f"the test computes without end: {_MOST_CPU_S:.0f} s"
            if self._why and main is not None:
                watch.restart()
                signal.pthread_kill(main, signal.SIGUSR2)

    def _watched(self) -> Generator[None, object, object]:
        self._n_phases += 1
        self._is_in_test = True
        try:
            return (yield)
        finally:
            self._is_in_test = False

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self) -> Generator[None, object, object]:
        """Watch what a test needs."""
        return (yield from self._watched())

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self) -> Generator[None, object, object]:
        """Watch the test."""
        return (yield from self._watched())

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_teardown(self) -> Generator[None, object, object]:
        """Watch its end."""
        return (yield from self._watched())
