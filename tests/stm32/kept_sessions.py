# SPDX-License-Identifier: Apache-2.0
"""What many tests begin with is computed once: each of them goes on from there in a fork.

An emulated start takes seconds, homing as long again, and both are the same every time. A test that
asks for the fixture `started` or `ready` runs in a child of the process in which that session was
made; what it does to the session ends with the child.
"""

import json
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

from tests.stm32.remote import DISABLE
from tests.stm32.session import Session


@cache
def _started() -> Session:
    session = Session()
    session.start()
    return session


@cache
def _ready() -> Session:
    session = _started()
    _started.cache_clear()  # it goes on
    session.make_ready()
    session.turn_spindle()
    return session


@cache
def _cut() -> Session:
    session = _ready()
    _ready.cache_clear()
    session.cut()
    session.remote.do(DISABLE)
    session.remote.wait_for("off", 0.1)
    return session


KEPT: dict[str, Callable[[], Session]] = {"started": _started, "ready": _ready}
STAGES = ("started", "ready", "cut")
HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Have the session of this folder's tests go on from stage to stage."""

    def stage(item: pytest.Item) -> list[bool]:
        names = getattr(item, "fixturenames", ()) if HERE in item.path.parents else ()
        return [name in names for name in STAGES[::-1]]

    items.sort(key=stage)


@pytest.fixture
def started() -> Session:
    """Return a session with a good table behind its power-on."""
    return _started()


@pytest.fixture
def ready() -> Session:
    """Return a session of the ideal machine, homed, its spindle at speed."""
    return _ready()


@pytest.fixture
def cut() -> Session:
    """Return a session from power-on through a cut to off, for all tests: none changes it."""
    return _cut()


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
