"""The component, built once as a user builds it, and a folder for each test in which HAL runs."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.linuxcnc.halbox import Halbox, build, halbox
from tests.tools.cases.linuxcnc import NotHereError, tools
from tests.tools.cases.part_cases import ROOT

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def linuxcnc_root() -> Path:
    """Return where LinuxCNC's programs are, or skip with the reason and what helps."""
    try:
        return tools()
    except NotHereError as error:
        pytest.skip(f"LinuxCNC: {error}")


@pytest.fixture(scope="session")
def modules(linuxcnc_root: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Build the component, which must not warn, and the one that plays recorded cuts to it."""
    folder = tmp_path_factory.mktemp("modules")
    said = build(linuxcnc_root, folder, "-j2", "-f", ROOT / "hal" / "linuxcnc" / "Makefile")
    assert "warning" not in said.lower(), said
    build(linuxcnc_root, folder, "-f", HERE / "replay.mk")
    return [folder / f"{name}.so" for name in ("camturn", "lathe_sim", "replay", "mesa_pins")]


@pytest.fixture
def box(linuxcnc_root: Path, modules: list[Path]) -> Iterator[Halbox]:
    """Return a folder in which HAL runs."""
    with halbox(linuxcnc_root, modules) as box:
        yield box
