"""What the tests of the tools share."""

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from hypothesis import settings

from camtools.link.controller import Link
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.generate import GeneratedSkirt
from tests.tools.cases.camctl_bench import Act, Bench, Refusal, linked
from tests.tools.cases.command_cases import command, signals_kept, undraw
from tests.tools.cases.cut_cases import geometry_of_part, skirt_of
from tests.tools.cases.linuxcnc import Interpreter, NotHereError, interpreter
from tests.tools.cases.part_cases import PERKINS, Command, load_part

# The same examples every time, however busy the machine is: what fails once fails again.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def perkins() -> SkirtPart:
    """Load the Perkins 240 skirt, the example of MATHS.md (6)."""
    return load_part(PERKINS)


@pytest.fixture(scope="session")
def geometry() -> Geometry:
    """Return its exact geometry."""
    return geometry_of_part("perkins240")


@pytest.fixture(scope="session")
def generated() -> GeneratedSkirt:
    """Return its table at 1 nm."""
    return skirt_of("perkins240")


@pytest.fixture(scope="session")
def mktables() -> Command:
    """Return mktables as a shell starts it."""
    return partial(command, "camtools.cli.mktables")


@pytest.fixture
def run(tmp_path: Path) -> Command:
    """Return tools/run as a shell starts it, in a folder of its own."""
    return partial(command, "camtools.cli.run", cwd=tmp_path)


@pytest.fixture(autouse=True)
def _signals() -> Iterator[None]:
    """Restore the handlers of signals that commands replace."""
    with signals_kept():
        yield


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave pictures empty, for tests of other results: drawing takes most of the time."""
    undraw(monkeypatch)


@pytest.fixture
def bench(request: pytest.FixtureRequest) -> Iterator[Bench]:
    """Return a fresh controller."""
    one = Bench(request.node.name)
    yield one
    one.close()


@pytest.fixture
def strict(request: pytest.FixtureRequest) -> Iterator[Bench]:
    """Return a controller with a button and a key switch."""
    one = Bench(request.node.name, is_strict=True)
    yield one
    one.close()


@pytest.fixture
def refusal(capsys: pytest.CaptureFixture[str]) -> Refusal:
    """Return a function that runs what must end with a status, and gives its one line."""

    def run(bench: Bench, status: int, words: str, on: str = "", act: Act = print) -> str:
        capsys.readouterr()
        assert bench.run(*words.split(), on=on, act=act)[0] == status
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1, lines
        assert lines[0].startswith("camctl: ")
        return lines[0]

    return run


@pytest.fixture(scope="session")
def linuxcnc() -> Interpreter:
    """Return LinuxCNC's interpreter, or skip with the reason and what helps."""
    try:
        return interpreter()
    except NotHereError as error:
        pytest.skip(f"LinuxCNC's interpreter: {error}")


@pytest.fixture
def no_bus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Name no bus, and return a runtime folder of the test's own, where no lathe lives."""
    runtime = tmp_path / "runtime"
    runtime.mkdir()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(runtime))
    monkeypatch.setenv("HOME", str(runtime))
    for name in [name for name in os.environ if name.startswith("CAN_")]:
        monkeypatch.delenv(name)
    return runtime


@pytest.fixture
def link(bench: Bench) -> Iterator[Link]:
    """Return a link of the test's own."""
    with linked(bench) as one:
        yield one
