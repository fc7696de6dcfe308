"""Machines by name or file: what is found, what is refused, and that all of them can be read."""

from pathlib import Path

import pytest
from pytest import MonkeyPatch

from camtools.base.errors import CamtoolsError
from camtools.cli.run import main
from camtools.sim.machine_file import MACHINES, machine_bytes, machine_path, names
from tests.tools.cases.camsim_cases import camsim
from tests.tools.cases.command_cases import job_of
from tests.tools.cases.part_cases import Capture

LEARN = Path(__file__).parents[2] / "learn" / "machines"


@pytest.mark.parametrize(
    "name", ["analog_position", "cam", "default", "piezo", "real", "rough", "step_servo"]
)
def test_machines_of_the_simulator_are_found_by_name(name: str) -> None:
    """The name is that of the file, and the machine calls itself so."""
    assert name in names()
    assert machine_path(name) == MACHINES / f"{name}.toml"
    assert f'name = "{name}"'.encode() in machine_bytes(name)


def test_any_file_is_a_machine(tmp_path: Path) -> None:
    """A path is taken as it is, and tools/run keeps the bytes."""
    path = tmp_path / "mine.toml"
    path.write_bytes(b"[u]\nfriction_m_per_s2 = 4\n")
    assert machine_path(str(path)) == path
    assert job_of("--machine", str(path)).machine == path.read_bytes()
    assert job_of().machine is None


@pytest.mark.parametrize("word", ["nosuch", "", "tools", "no/such.toml"])
def test_unknown_machine_is_refused_in_one_line(word: str, capsys: Capture) -> None:
    """The message names the word and every machine there is."""
    assert main(["--machine", word]) == 2
    told = capsys.readouterr().err.strip()
    assert told.startswith(
        f"run: --machine {word}: no such machine; give one of analog_position, cam"
    )
    assert "\n" not in told


def test_machine_that_cannot_be_read_is_refused(tmp_path: Path, monkeypatch: MonkeyPatch) -> None:
    """The reason of the system is told."""
    path = tmp_path / "mine.toml"
    path.touch()

    def refuse(_path: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(CamtoolsError, match="cannot be read: Permission denied; give a readable"):
        machine_bytes(str(path))


@pytest.mark.parametrize(
    "path", sorted([*MACHINES.glob("*.toml"), *LEARN.glob("*.toml")]), ids=lambda path: path.stem
)
def test_every_machine_file_is_accepted(path: Path, tmp_path: Path) -> None:
    """Camsim reads the machine before it misses the table."""
    done = camsim("run", tmp_path / "no.camtab", "--machine", path)
    assert done.returncode == 2
    assert "no.camtab: cannot be opened" in done.stderr
