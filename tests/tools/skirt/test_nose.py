"""A round nose: the path of its tip against a search among all heights, what does not fit, ends."""

import json
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.cli.mktables import main
from camtools.part.tool import Tool
from camtools.pipeline.run import run
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart, example_part
from camtools.skirt.report.summary import make_summary
from camtools.skirt.table.generate import generate
from camtools.skirt.tool.nose import NoseGeometry, tip_geometry
from camtools.table.image import pack
from camtools.table.summary import table_files
from tests.tools.cases.camsim_cases import camsim
from tests.tools.cases.part_cases import ROOT, load_part

PARTS = ROOT / "tools" / "parts"
NM = 1e6


def part_of(heights: list[float], diameters: list[float], **tables: object) -> SkirtPart:
    """Return a skirt with a profile of its own."""
    tree = example_part().model_dump() | tables
    profile = {"height_mm": heights, "diameter_mm": diameters}
    tree["piston"] = tree["piston"] | {"profile": profile}
    return SkirtPart.model_validate(tree)


def steep(nose_mm: float) -> SkirtPart:
    """Return a skirt that ends in a cone: its slope reaches -0.18 at 62 mm."""
    heights = [0.0, 10, 20, 30, 40, 50, 54, 56, 58, 60, 62]
    half = [46 - 7.5e-5 * (z - 20) ** 2 - 0.0147 * max(z - 56, 0) ** 2 for z in heights]
    return part_of(heights, [2 * a for a in half], tool={"nose_radius_mm": nose_mm})


def surface(drawing: Geometry, phi: float, z: Floats) -> Floats:
    """Return the radius of the drawing, beyond its ends that of the tangents there."""
    low, high, h = drawing.z_first_mm, drawing.z_last_mm, 1e-4
    z_all = np.concatenate([np.clip(z, low, high), [low, low + h, high - h, high]])
    radius = drawing.radius_mm(z_all) - drawing.delta(phi, z_all).delta
    below, above = (radius[-3] - radius[-4]) / h, (radius[-1] - radius[-2]) / h
    beyond = np.minimum(z - low, 0) * below + np.maximum(z - high, 0) * above
    return np.asarray(radius[:-4] + beyond, dtype=np.float64)


def deepest(drawing: Geometry, phi: float, z_mm: float, nose_mm: float) -> float:
    """Return where the tip must stand, by ever narrower searches over the nose's heights."""
    low, high = z_mm - nose_mm, z_mm + nose_mm
    for _ in range(5):
        z = np.linspace(low, high, 2001)
        inner = np.maximum(0, nose_mm**2 - (z - z_mm) ** 2)
        tip = surface(drawing, phi, z) + np.sqrt(inner) - nose_mm
        best, step = int(tip.argmax()), z[1] - z[0]
        low, high = max(z[0], z[best] - 2 * step), min(z[-1], z[best] + 2 * step)
    return float(tip.max())


def tip_of(drawing: Geometry, nose_mm: float) -> NoseGeometry:
    """Return the path of a round nose."""
    tip = tip_geometry(drawing, Tool(nose_radius_mm=nose_mm))
    assert isinstance(tip, NoseGeometry)
    return tip


@pytest.mark.parametrize(
    ("part", "nose_mm"),
    [
        (example_part(), 0.8),
        (example_part(), 25.0),
        (steep(0.0), 0.4),
        (steep(0.0), 12.0),
        (load_part(PARTS / "weichai3a.toml"), 0.8),
        (load_part(PARTS / "scan90.toml"), 2.0),
    ],
)
def test_the_tip_touches_and_nowhere_cuts_in(part: SkirtPart, nose_mm: float) -> None:
    """At random places, at the ends and where pieces of the shape meet: within 0.001 nm."""
    drawing = make_geometry(part)
    tip, random = tip_of(drawing, nose_mm), np.random.default_rng(14)
    z = random.uniform(drawing.z_first_mm, drawing.z_last_mm, 60)
    z = np.concatenate([z, drawing.breaks_mm(), tip.breaks_mm()])
    phi = random.uniform(0, 2 * np.pi, z.size)
    found = tip.radius_mm(z) - tip.delta(phi, z).delta
    exact = [deepest(drawing, *place, nose_mm) for place in zip(phi.tolist(), z, strict=True)]
    assert np.abs(found - exact).max() * NM < 1e-3


@pytest.mark.parametrize("nose_mm", [0.8, 12.0])
def test_derivatives_are_those_of_the_tip(nose_mm: float) -> None:
    """By angle and by height, against differences of the tip's own radius."""
    drawing = make_geometry(steep(0.0))
    tip, random, h = tip_of(drawing, nose_mm), np.random.default_rng(3), 1e-4
    z, phi = random.uniform(0.1, 61.9, 400), random.uniform(0, 7, 400)
    below, here, above = (tip.delta(phi + k * h, z) for k in (-1, 0, 1))
    for n in range(3):
        slope = (above[n] - below[n]) / (2 * h)
        assert np.abs(slope - here[n + 1]).max() < 2e-6 * np.abs(here[n + 1]).max()
    for n in range(2):
        slope = (tip.radius_mm(z + h, n) - tip.radius_mm(z - h, n)) / (2 * h)
        error = np.abs(slope - tip.radius_mm(z, n + 1))
        assert np.median(error) < 1e-7  # it has a step where the contact passes a kink
        assert np.quantile(error, 0.95) < 1e-5


def test_on_a_cone_the_tip_stands_out_by_the_closed_form() -> None:
    """By r (1 / cos - 1) of the slope, MATHS.md (108); the ovality does not change with height."""
    oval = {"height_mm": [0, 60], "ovality_mm": [0.2, 0.2]}
    tree = part_of([0, 20, 40, 60], [90, 80, 70, 60]).model_dump()
    tree["piston"] |= {"ovality": oval, "section": {"shape": "cosine"}}
    drawing = make_geometry(SkirtPart.model_validate(tree))
    tip, z = tip_of(drawing, 0.8), np.linspace(1, 59, 30)
    out_mm = 0.8 * (np.hypot(1, 0.25) - 1)
    assert np.abs(tip.radius_mm(z) - drawing.radius_mm(z) - out_mm).max() * NM < 1e-3
    assert np.abs(tip.delta(0.7, z).delta - drawing.delta(0.7, z).delta).max() * NM < 1e-3


def test_beyond_an_end_the_surface_goes_on_as_its_tangent() -> None:
    """Where the surface rises to its end the tip follows the closed form up to the end."""
    drawing = make_geometry(part_of([0, 20, 40, 60], [60, 70, 80, 90]))
    tip, z = tip_of(drawing, 0.8), np.array([0, 59.7, 59.9, 60.0])
    out_mm = 0.8 * (np.hypot(1, 0.25) - 1)
    assert np.abs(tip.radius_mm(z) - drawing.radius_mm(z) - out_mm).max() * NM < 1e-3


def test_a_hollow_that_is_too_narrow_is_refused_with_the_largest_nose() -> None:
    """What the message calls the largest radius does, a hundredth more does not."""
    heights = [2.0 * i for i in range(31)]
    drawing = make_geometry(part_of(heights, [80 - 2 / (1 + ((z - 30) / 4) ** 2) for z in heights]))
    with pytest.raises(CamtoolsError, match="100 mm does not fit into the hollow of ") as refused:
        tip_of(drawing, 100.0)
    largest_mm = float(str(refused.value).split("give at most ")[1].split(" mm")[0])
    tip_of(drawing, largest_mm)
    with pytest.raises(CamtoolsError):
        tip_of(drawing, 1.01 * largest_mm)


def test_a_crease_is_refused_by_what_it_keeps() -> None:
    """A polygon of the ovality may leave 0.1 um between two of its sides, not more."""
    tree = example_part().model_dump()
    tree["piston"]["ovality"] = {"height_mm": [0, 30, 62], "ovality_mm": [0.1, 4.0, 0.1]}
    drawing = make_geometry(SkirtPart.model_validate(tree))
    with pytest.raises(CamtoolsError, match=r"fit into the crease of 7\.2") as refused:
        tip_of(drawing, 0.8)
    line = str(refused.value)
    assert "at 90 degrees, height 30 mm; give at most 0.05" in line
    largest_mm = float(line.split("give at most ")[1].split(" mm")[0])
    half = (np.arctan(1.95 / 30 + 0.0015) + np.arctan(1.95 / 32 - 0.0015)) / 2
    assert largest_mm * (1 / np.cos(half) - 1) * 1000 == pytest.approx(0.1, rel=0.03)
    tip_of(drawing, largest_mm)


@pytest.mark.parametrize("name", ["perkins240", "weichai3a", "scan90"])
def test_a_point_changes_no_byte(name: str) -> None:
    """The table with a [tool] of a point, another flank and wear, is the table without [tool]."""
    part = load_part(PARTS / f"{name}.toml")
    tool = Tool(nose_radius_mm=0, clearance_deg=9, wear_um=12)
    bare = pack(generate(part).table)
    assert pack(generate(part.model_copy(update={"tool": tool})).table) == bare


def cut(part: SkirtPart, folder: Path, *words: str) -> tuple[float, int]:
    """Make and cut a part; return the largest form error [um] and camsim's exit status."""
    made = generate(part, 10.0)
    for name, data in table_files(made.table, make_summary(made)).items():
        (folder / name).write_bytes(data)
    summary = folder / "summary.json"
    done = camsim("run", folder / "example.camtab", "--summary", summary, *words)
    (folder / "stderr.txt").write_text(done.stderr)
    return json.loads(summary.read_text())["form_error_um"]["max"], done.returncode


def test_the_gauge_shows_a_nose_that_the_table_does_not_know(tmp_path: Path) -> None:
    """A cone cut with 0.8 mm: 13 um too deep by a table for a point, by its own table none."""
    pointed = steep(0.0).model_copy(update={"process": example_part().process})
    error_um, status = cut(pointed, tmp_path, "--nose-mm", "0.8")
    drawing = make_geometry(pointed)
    z = np.linspace(0, 62, 2001)
    slope = drawing.radius_mm(z, 1) - 0.5 * 0.1 / 42
    assert error_um == pytest.approx(800 * (np.hypot(1, slope).max() - 1), abs=0.3)
    assert status == 1
    assert cut(pointed, tmp_path)[0] < 0.1
    error_um, status = cut(steep(0.8), tmp_path)
    assert (error_um < 0.1, status) == (True, 0)


@pytest.mark.parametrize("run_mm", [0, 3])
def test_an_end_that_rises_comes_out_well(run_mm: float, tmp_path: Path) -> None:
    """A cone that rises to its upper end: there the nose touches the surface in the air."""
    tree = part_of([0, 20, 40, 60], [60, 66, 72, 78], tool={"nose_radius_mm": 0.8}).model_dump()
    tree["process"] |= {"run_in_mm": run_mm, "run_out_mm": run_mm}
    oval = {"height_mm": [0, 60], "ovality_mm": [0.15, 0.3]}
    tree["piston"] |= {"ovality": oval}
    error_um, status = cut(SkirtPart.model_validate(tree), tmp_path)
    assert (error_um < 0.2, status) == (True, 0)


def test_the_machine_file_tells_the_tool_in_use(tmp_path: Path) -> None:
    """A table for 0.8 mm cut with a point leaves what the nose would have taken."""
    machine = tmp_path / "machine.toml"
    machine.write_text("[tool]\nnose_mm = 0\n")
    error_um, _ = cut(steep(0.8), tmp_path, "--machine", str(machine))
    assert 11 < error_um < 14
    assert "the table is made for another nose" in (tmp_path / "stderr.txt").read_text()


def test_a_worn_tool_cuts_well_with_its_offset(tmp_path: Path) -> None:
    """25 um of wear show in full, and x_trim_nm takes them back; the table is the same."""
    worn, offset = tmp_path / "worn.toml", ("--set", "x_trim_nm=-25000")
    worn.write_text("[tool]\nwear_um = 25\n")
    error_um, status = cut(example_part(), tmp_path, "--machine", str(worn))
    assert (round(error_um), status) == (25, 1)
    assert "the tool is worn: set x_trim_nm" in (tmp_path / "stderr.txt").read_text()
    error_um, status = cut(example_part(), tmp_path, "--machine", str(worn), *offset)
    assert (error_um < 0.1, status) == (True, 0)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("nose_radius_mm = 0.005", "nose_radius_mm = 0.005: must be 0 or at least 0.01 mm"),
        ("nose_radius_mm = -1", "nose_radius_mm = -1: "),
        ("clearance_deg = 0", "clearance_deg = 0: "),
        ("wear_um = -1", "wear_um = -1: "),
        ("radius = 1", "radius = 1: unknown key"),
    ],
)
def test_a_wrong_tool_is_refused_by_name(
    line: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line with field, value and remedy, exit status 2, no file."""
    text = (PARTS / "perkins240.toml").read_text()
    path = tmp_path / "part.toml"
    path.write_text(f"{text}\n[tool]\n{line}\n")
    assert main([str(path), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert f"{path}: tool.{message}" in error.replace("mktables: ", "")
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("undrawn")
def test_run_tells_of_the_tool_and_sets_its_offset(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """tools/run with a worn round nose: good, and the report names nose, wear and clearance."""
    text = (PARTS / "perkins240.toml").read_text()
    path = tmp_path / "part.toml"
    path.write_text(f"{text}\n[tool]\nnose_radius_mm = 0.8\nwear_um = 12\n")
    assert run([str(path), "--feed", "1.5", "-o", str(tmp_path / "out")]) == 0
    told = "nose radius 0.8 mm, worn by 12 um; clearance angle 7 degrees, required 0.19 (at "
    assert told in capsys.readouterr().out
    assert told in (tmp_path / "out" / "report.html").read_text()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["parameters"]["x_trim_nm"] == -12_000
    assert summary["tool"] == {"nose_mm": 0.8, "made_for_mm": 0.8, "wear_um": 12}
