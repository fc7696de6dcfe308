# SPDX-License-Identifier: Apache-2.0
"""What many tests begin with is computed once: each of them goes on from there in a fork.

An emulated start takes seconds, homing as long again, and both are the same every time. A test that
asks for the fixture `started` or `ready` runs in a child of the process in which that session was
made; what it does to the session ends with the child.
"""

import json
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

from tests.stm32.host import make_table
from tests.stm32.session import Session


def _new() -> Session:
    with tempfile.TemporaryDirectory() as folder:
        return Session(make_table(Path(folder) / "short.camtab"))


@cache
def _started() -> Session:
    session = _new()
    session.start()
    return session


@cache
def _ready() -> Session:
    session = _new()
    session.make_ready()
    session.turn_spindle()
    return session


KEPT: dict[str, Callable[[], Session]] = {"started": _started, "ready": _ready}


@pytest.fixture
def started() -> Session:
    """Return a session with a good table behind its power-on."""
    return _started()


@pytest.fixture
def ready() -> Session:
    """Return a session of the ideal machine, homed, its spindle at speed."""
    return _ready()


def _in_child(item: pytest.Item, out: int) -> None:
    """Run the test and write its reports."""
    reports = runtestprotocol(item, log=False, nextitem=item)
    to_text = item.config.hook.pytest_report_to_serializable
    text = json.dumps([to_text(config=item.config, report=report) for report in reports])
    with os.fdopen(out, "w") as pipe:
        pipe.write(text)


def _in_fork(item: pytest.Item) -> list[pytest.TestReport]:
    """Let a child run the test; return its reports."""
    pipe, out = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(pipe)
            _in_child(item, out)
        finally:
            os._exit(0)
    os.close(out)
    with os.fdopen(pipe) as said:
        text = said.read()
    _, status = os.waitpid(child, 0)
    if not text:
        how = f"the child of this test ended without a report, wait status {status}"
        return [pytest.TestReport(item.nodeid, item.location, {}, "failed", how, "call")]
    from_text = item.config.hook.pytest_report_from_serializable
    return [from_text(config=item.config, data=data) for data in json.loads(text)]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Run a test that goes on from a kept session in a fork, and any other as usual."""
    kept = [KEPT[name] for name in KEPT if name in getattr(item, "fixturenames", ())]
    if not kept:
        return None
    try:
        kept[0]()
    except Exception:  # it comes again, and is reported, when the fixture is made
        return None
    hook = item.ihook
    hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in _in_fork(item):
        hook.pytest_runtest_logreport(report=report)
    # What an earlier test of the file has set up in this process may end with this one.
    item.session._setupstate.teardown_exact(nextitem)
    hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True
