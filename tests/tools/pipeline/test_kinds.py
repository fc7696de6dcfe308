"""The kinds of parts: the registry, unknown kinds, and commands that are not for a kind."""

from pathlib import Path
from typing import Any

import pytest

from camtools.base.text import toml_tree
from camtools.cli.mkgcode import main as mkgcode
from camtools.cli.mktables import main as mktables
from camtools.pipeline.load import kinds, parse
from tests.tools.cases.command_cases import complaint
from tests.tools.cases.part_cases import PERKINS, Capture


def test_kinds_are_those_of_the_packages(tmp_path: Path, capsys: Capture) -> None:
    """The registry finds them in their order; errors name all that a command takes."""
    assert [kind.name for kind in kinds()] == ["piston", "cam", "polygon"]
    gear = tmp_path / "gear.toml"
    gear.write_text(PERKINS.read_text().replace('kind = "piston"', 'kind = "gear"'))
    line = complaint(mktables, [str(gear), "-o", str(tmp_path / "out")], capsys)
    assert "use one of: 'piston', 'cam' or 'polygon'" in line
    hexagon = str(PERKINS.with_name("hexagon.toml"))
    line = complaint(mkgcode, [hexagon, "-o", str(tmp_path / "out")], capsys)
    assert "part.kind = 'polygon': polygons are for " in line


def test_a_part_file_is_parsed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its kind is found in the same tables that its model is checked against."""
    calls: list[str] = []

    def tree(text: str) -> dict[str, Any]:
        calls.append(text)
        return toml_tree(text)

    monkeypatch.setattr("camtools.part.model.toml_tree", tree)
    assert parse(PERKINS.read_bytes(), "p.toml").kind.name == "piston"
    assert len(calls) == 1
