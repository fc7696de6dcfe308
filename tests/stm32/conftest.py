"""Sessions that are made once; each test continues from there in a fork.

An emulated start takes seconds, homing as long again, and both are the same every time. A test
that asks for the fixture `started` or `ready` runs in a child of the process in which that session
was made; its changes to the session end with the child.
"""

import os
import traceback
from functools import cache
from pathlib import Path

import pytest

from tests.stm32.remote import DISABLE
from tests.stm32.session import Session

FORKED = {"started", "ready"}
STAGES = ("cut", "ready", "started")  # the last first
HERE = Path(__file__).parent


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
    return session


@cache
def _cut() -> Session:
    session = _ready()
    _ready.cache_clear()
    session.cut()
    session.remote.do(DISABLE)
    session.remote.wait_for("off", 0.1)
    return session


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Have the session of this folder's tests continue from stage to stage."""

    def stage(item: pytest.Item) -> list[bool]:
        names = getattr(item, "fixturenames", ()) if HERE in item.path.parents else ()
        return [name in names for name in STAGES]

    items.sort(key=stage)


@pytest.fixture
def started() -> Session:
    """Return a session with a good table after its power-on."""
    return _started()


@pytest.fixture
def ready() -> Session:
    """Return a session of the ideal machine, homed, its spindle at speed."""
    return _ready()


@pytest.fixture
def cut() -> Session:
    """Return a session from power-on through a cut to off, for all tests: none changes it."""
    return _cut()


def _play(item: pytest.Function) -> str:
    """Call the test; return how it failed, or ""."""
    try:
        item.obj(**{name: item.funcargs[name] for name in item._fixtureinfo.argnames})
    except BaseException:  # of whichever kind: the child has no other caller
        return traceback.format_exc()
    return ""


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Call a test that continues from a kept session in a child, and any other as usual."""
    if not FORKED & set(pyfuncitem.fixturenames) or HERE not in pyfuncitem.path.parents:
        return None
    pipe, out = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(pipe)
        with os.fdopen(out, "w") as text:
            text.write(_play(pyfuncitem))
        os._exit(0)
    os.close(out)
    with os.fdopen(pipe) as text:
        why = text.read()
    _, status = os.waitpid(child, 0)
    if why or status:
        pytest.fail(why or f"the child of this test ended with wait status {status}", pytrace=False)
    return True
