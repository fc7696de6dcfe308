"""The scripted machine and the program, for the tests of the port (port_cases.py)."""

import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.linux.port_cases import ESTOP_LINE, PROGRAMS, READY_LINE, Setup, Start, config_text
from tests.linux.port_nodes import INDEX_LINE, Controller, Nodes, pull


@pytest.fixture(scope="module", params=PROGRAMS, ids=lambda path: path.parts[-4])
def program(request: pytest.FixtureRequest) -> Path:
    """Return each program that is built: with libgpiod 1 and with 2."""
    path: Path = request.param
    return path


@pytest.fixture
def nodes() -> Iterator[Nodes]:
    """Run the scripted machine, its chain closed and its lines ready."""
    for line in (ESTOP_LINE, READY_LINE):
        pull(line, True)
    pull(INDEX_LINE, False)
    machine = Nodes()
    machine.start()
    yield machine
    machine.stop()


@pytest.fixture
def start(program: Path, table_of: Callable[[str], Path], tmp_path: Path) -> Iterator[Start]:
    """Start the controller; it is ended with the test."""
    running: list[Controller] = []

    def make(setup: Setup | None = None, **lines: str) -> Controller:
        setup = setup or Setup()
        table = tmp_path / "table.camtab"
        table.write_bytes(table_of("perkins240").read_bytes())
        config = tmp_path / f"machine{len(running)}.toml"
        config.write_text(config_text(table, lines, setup))
        running.append(Controller([*setup.prefix, program], config, setup.interface))
        return running[-1]

    yield make
    for controller in running:
        if controller.process.poll() is None:
            controller.end(signal.SIGKILL)
