"""A third kind of part is one package: from its file to its report, with no change elsewhere."""

import json
from pathlib import Path
from typing import Any

import pytest

import camtools
from camtools.base.text import toml_tree
from camtools.cli.mkgcode import main as mkgcode
from camtools.cli.mktables import main as mktables
from camtools.cli.run import main as run
from camtools.pipeline.load import kinds, parse
from camtools.table.image import unpack
from tests.tools.cases.part_cases import PERKINS

PACKAGE = Path(__file__).parents[1] / "cases" / "third_kind"
RING = """\
[part]
name = "ring"
kind = "ring"
source = "made up for this test"
[ring]
radius_mm = 30.0
offset_mm = 0.25
z_mm = [0, 10]
[process]
spindle_rpm = 600
feed_mm = 0.5
"""


@pytest.fixture
def ring(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make the package part of camtools; return a part file of its kind."""
    monkeypatch.setattr(camtools, "__path__", [*camtools.__path__, str(PACKAGE)])
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "ring.toml"
    path.write_text(RING)
    return path


def only_line(capsys: pytest.CaptureFixture[str]) -> str:
    """Return the one line on standard error."""
    [line] = capsys.readouterr().err.splitlines()
    return line


def test_kinds_are_those_of_the_packages(ring: Path) -> None:
    """The registry finds the package by its place alone."""
    assert [kind.name for kind in kinds()] == ["piston", "cam", "polygon", "ring"]


def test_table_of_the_third_kind(ring: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Command writes the files that every part has."""
    assert mktables([str(ring), "-o", "out"]) == 0
    assert capsys.readouterr().out.startswith("ring: ring, table of ")
    names = sorted(path.name for path in Path("out").iterdir())
    assert names == ["ring.camtab", "ring.json", "ring_table.c", "ring_table.h"]
    table = unpack(Path("out/ring.camtab").read_bytes())
    assert (table.part_name, table.bounds.u_max_nm) == ("ring", 500_001)


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_cut_of_the_third_kind(ring: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Run makes, cuts, gauges and reports it on the simulator."""
    assert run([str(ring), "--rpm", "500", "-o", "out"]) == 0
    assert capsys.readouterr().out.startswith("ring: within tolerance\n")
    summary = json.loads(Path("out/summary.json").read_text())
    assert summary["is_good"] and summary["cut"]["spindle_rpm"] == 500
    assert summary["form_error_um"]["max"] < 1 < summary["comparison"][-1]["max_um"]
    assert summary["table_error"] == {"tolerance_nm": 1.0}
    page = Path("out/report.html").read_text()
    assert "made up for this test" in page and "WITHIN TOLERANCE" in page


def test_errors_name_the_third_kind(ring: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its fields are checked, unknown kinds are told of it, other commands refuse it."""
    ring.write_text(RING.replace("offset_mm = 0.25", "offset_mm = 9"))
    assert mktables([str(ring), "-o", "out"]) == 2
    assert "ring.offset_mm = 9: " in only_line(capsys)
    ring.write_text(RING.replace('kind = "ring"', 'kind = "gear"'))
    assert mktables([str(ring), "-o", "out"]) == 2
    assert "use one of: 'piston', 'cam', 'polygon' or 'ring'" in only_line(capsys)
    ring.write_text(RING)
    assert mkgcode([str(ring), "-o", "ring.ngc"]) == 2
    refusal = "part.kind = 'ring': rings are for mktables and run; give the part file of a piston"
    assert refusal in only_line(capsys)


def test_a_part_file_is_parsed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its kind is found in the same tables that its model is checked against."""
    calls: list[str] = []

    def tree(text: str) -> dict[str, Any]:
        calls.append(text)
        return toml_tree(text)

    monkeypatch.setattr("camtools.part.model.toml_tree", tree)
    assert parse(PERKINS.read_bytes(), "p.toml").kind.name == "piston"
    assert len(calls) == 1
