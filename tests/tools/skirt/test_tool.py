"""A skirt's tool: path of a round nose, what does not fit, heel, wear, what a report states."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.cli.run import main as run
from camtools.part.common import Tool, check_tracks
from camtools.polygon.generate import generate_polygon
from camtools.polygon.part import example_polygon
from camtools.sim.simulate import Result
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart, example_part
from camtools.skirt.report.outcome import track_row
from camtools.skirt.table.generate import generate
from camtools.skirt.tool.nose import NoseGeometry, tip_geometry
from camtools.skirt.tool.turning import check_heel, steepest_heel
from camtools.table.image import pack
from tests.tools.cases.camsim_cases import cut, form_um
from tests.tools.cases.command_cases import job_of
from tests.tools.cases.cut_cases import PARTS, made_skirt, skirt_of, written
from tests.tools.cases.part_cases import PERKINS, changed, load_part, points_text, refused, sure

NM = 1e6


def part_of(heights: list[float], diameters: list[float], **tables: object) -> SkirtPart:
    """Return a skirt with a profile of its own."""
    profile = {"height_mm": heights, "diameter_mm": diameters}
    return changed(example_part(), {"piston.profile": profile} | tables)


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
    """By r (1 / cos - 1) of the slope, MATHS.md (108); beyond an end the tangent counts."""
    oval = {"height_mm": [0, 60], "ovality_mm": [0.2, 0.2]}
    values = {"piston.ovality": oval, "piston.section": {"shape": "cosine"}}
    drawing = make_geometry(changed(part_of([0, 20, 40, 60], [90, 80, 70, 60]), values))
    tip, z = tip_of(drawing, 0.8), np.linspace(1, 59, 30)
    out_mm = 0.8 * (np.hypot(1, 0.25) - 1)
    assert np.abs(tip.radius_mm(z) - drawing.radius_mm(z) - out_mm).max() * NM < 1e-3
    assert np.abs(tip.delta(0.7, z).delta - drawing.delta(0.7, z).delta).max() * NM < 1e-3
    drawing = make_geometry(part_of([0, 20, 40, 60], [60, 70, 80, 90]))
    tip, z = tip_of(drawing, 0.8), np.array([0, 59.7, 59.9, 60.0])
    assert np.abs(tip.radius_mm(z) - drawing.radius_mm(z) - out_mm).max() * NM < 1e-3


def test_a_hollow_that_is_too_narrow_is_refused_with_the_largest_nose() -> None:
    """What the message calls the largest radius does, a hundredth more does not."""
    heights = [2.0 * i for i in range(31)]
    drawing = make_geometry(part_of(heights, [80 - 2 / (1 + ((z - 30) / 4) ** 2) for z in heights]))
    line = refused(lambda: tip_of(drawing, 100.0))
    assert "100 mm does not fit into the hollow of " in line
    largest_mm = float(line.split("give at most ")[1].split(" mm")[0])
    tip_of(drawing, largest_mm)
    with pytest.raises(CamtoolsError):
        tip_of(drawing, 1.01 * largest_mm)


def test_a_crease_is_refused_by_what_it_keeps() -> None:
    """A polygon of the ovality may leave 0.1 um between two of its sides, not more."""
    ovality = {"height_mm": [0, 30, 62], "ovality_mm": [0.1, 4.0, 0.1]}
    drawing = make_geometry(changed(example_part(), {"piston.ovality": ovality}))
    line = refused(lambda: tip_of(drawing, 0.8))
    assert "fit into the crease of 7.2" in line
    assert "at 90 degrees, height 30 mm; give at most 0.05" in line
    largest_mm = float(line.split("give at most ")[1].split(" mm")[0])
    half = (np.arctan(1.95 / 30 + 0.0015) + np.arctan(1.95 / 32 - 0.0015)) / 2
    assert largest_mm * (1 / np.cos(half) - 1) * 1000 == pytest.approx(0.1, rel=0.03)
    tip_of(drawing, largest_mm)


@pytest.mark.parametrize("name", ["perkins240", "weichai3a"])
def test_a_point_changes_no_byte(name: str) -> None:
    """The table with a [tool] of a point, another flank and wear, is the table without [tool]."""
    bare = pack(skirt_of(name).table)
    part = load_part(PARTS / f"{name}.toml")
    tool = Tool(nose_radius_mm=0, clearance_deg=9, wear_um=12)
    assert pack(generate(part.model_copy(update={"tool": tool})).table) == bare


def coarse(part: SkirtPart, folder: Path, *words: str | Path, status: int = 0) -> Result:
    """Cut a part by a table of 10 nm."""
    return cut(written(made_skirt(part, 10.0), folder), "--feed", "1", *words, status=status)


@pytest.mark.long
def test_the_gauge_shows_a_nose_that_the_table_does_not_know(tmp_path: Path) -> None:
    """A cone cut with 0.8 mm: 13 um too deep by a table for a point, by its own table none."""
    pointed = steep(0.0)
    found = coarse(pointed, tmp_path, "--nose-mm", "0.8", status=1)
    z = np.linspace(0, 62, 2001)
    slope = make_geometry(pointed).radius_mm(z, 1) - 0.5 * 0.1 / 42
    assert found.form_error_um == pytest.approx(800 * (np.hypot(1, slope).max() - 1), abs=0.3)
    assert form_um(coarse(pointed, tmp_path)) < 0.1
    table = written(made_skirt(steep(0.8), 10.0), tmp_path)
    assert form_um(cut(table, "--feed", "1")) < 0.1
    # the machine file names the tool in use: a point leaves what the nose would have taken
    found = cut(table, "--feed", "1", status=None, machine="[tool]\nnose_mm = 0\n")
    assert 11 < form_um(found) < 14
    assert "the table is made for another nose" in found.message


@pytest.mark.parametrize("run_mm", [0, 3])
def test_an_end_that_rises_comes_out_well(run_mm: float, tmp_path: Path) -> None:
    """A cone that rises to its upper end: there the nose touches the surface in the air."""
    part = part_of([0, 20, 40, 60], [60, 66, 72, 78], tool={"nose_radius_mm": 0.8})
    values: dict[str, object] = {"process.run_in_mm": run_mm, "process.run_out_mm": run_mm}
    values["piston.ovality"] = {"height_mm": [0, 60], "ovality_mm": [0.15, 0.3]}
    assert form_um(coarse(changed(part, values), tmp_path)) < 0.2


def test_a_worn_tool_cuts_well_with_its_offset(tmp_path: Path) -> None:
    """25 um of wear show in full, and x_trim_nm takes them back; the table is the same."""
    worn = tmp_path / "worn.toml"
    worn.write_text("[tool]\nwear_um = 25\n")
    found = coarse(example_part(), tmp_path, "--machine", worn, status=1)
    assert round(form_um(found)) == 25
    assert "the tool is worn: set x_trim_nm" in found.message
    words = ("--machine", worn, "--set", "x_trim_nm=-25000")
    assert form_um(coarse(example_part(), tmp_path, *words)) < 0.1


RINGS = """\
path = "ring-helix"
[[process.pass]]
allowance_um = 30
[[process.pass]]
allowance_um = 0
[tool]
nose_radius_mm = 0.8
wear_um = 12
[machine.limits]"""


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_run_tells_of_the_tool_and_of_rings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """tools/run with a worn round nose along rings in passes: good, and its offset is set.

    The report names nose, wear and clearance. The forces of rings are not measured, so none is
    told; the table may be less accurate.
    """
    text = PERKINS.read_text().replace("[machine.limits]", RINGS)
    path = tmp_path / "rings.toml"
    path.write_text(text.replace("spindle_rpm = 2500", "spindle_rpm = 500"))
    words = ["--feed", "1.5", "--tolerance-nm", "3", "-o", str(tmp_path / "out")]
    assert run([str(path), *words]) == 0
    shown = capsys.readouterr().out
    told = "nose radius 0.8 mm, worn by 12 um; clearance angle 7 degrees, required 0.19 (at "
    assert told in shown
    assert told in (tmp_path / "out" / "report.html").read_text()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["parameters"]["x_trim_nm"] == -12_000
    assert summary["tool"] == {"nose_mm": 0.8, "made_for_mm": 0.8, "wear_um": 12}
    passes = [line for line in shown.splitlines() if line.lstrip().startswith("pass ")]
    assert len(passes) == 2
    assert not any("force" in line for line in passes)
    assert re.search(r"accurate to 2\.\d nm", shown)


def test_ridges_and_tracks() -> None:
    """1.5 mm of feed leave 0.522 mm with a nose of 0.8 mm; tracks that do not meet are refused."""
    told = track_row({"cut": {"feed_mm": 1.5}}, Tool(nose_radius_mm=0.8)).value
    assert told.startswith("522 µm in theory")
    fed = track_row({"cut": {"feed_mm": 0.5}}, Tool(nose_radius_mm=0.8), peak=3.0).value
    assert fed == told
    assert "do not meet" in track_row({"cut": {"feed_mm": 1.6}}, Tool(nose_radius_mm=0.8)).value
    assert "not judged" in track_row({"cut": {"feed_mm": 0.1}}, Tool()).value
    with_nose = {"cut": {"feed_mm": 1.5}, "tool": {"nose_mm": 0.8}}
    assert track_row(with_nose, Tool()).value == told
    with pytest.raises(CamtoolsError, match=r"tolerance_nm = 1e\+09: must be above 0"):
        job_of("--tolerance-nm", "1e9")
    check_tracks(Tool(nose_radius_mm=0.8), 1.59)
    check_tracks(Tool(), 2.0)
    with pytest.raises(CamtoolsError, match=r"metal stays; feed less than 1\.6 mm"):
        check_tracks(Tool(nose_radius_mm=0.8), 1.6)
    part = example_part().model_copy(update={"tool": Tool(nose_radius_mm=0.04)})
    with pytest.raises(CamtoolsError, match=r"feed of 0\.1 mm"):
        generate(part)
    with pytest.raises(CamtoolsError, match=r"feed of 0\.5 mm"):
        job_of("--feed", "0.5").check_feed(part)


ANGLES_DEG = np.arange(0, 360, 0.5)


def hexagon(across_mm: float, corner_mm: float) -> Floats:
    """Return the polar radius of a hexagon with rounded corners, from its sides and circles."""
    sixth = np.pi / 3
    away = (np.radians(ANGLES_DEG) + sixth / 2) % sixth - sixth / 2  # from the middle of a side
    side = across_mm / 2 / np.cos(away)
    centre = (across_mm / 2 - corner_mm) / np.cos(np.pi / 6)
    off = np.pi / 6 - np.abs(away)  # from the corner
    root = np.maximum(0, corner_mm**2 - (centre * np.sin(off)) ** 2)
    circle = centre * np.cos(off) + np.sqrt(root)
    joint = np.arctan2(corner_mm / 2, centre + corner_mm * np.cos(np.pi / 6))
    radius = np.where(off < joint, circle, side)
    return np.asarray(radius, dtype=np.float64)


def scanned(radius_mm: Floats, folder: Path, **tables: object) -> SkirtPart:
    """Return a part whose sections are these polar radii, at every half degree."""
    largest = float(radius_mm.max())
    text = points_text("angle_deg,z_mm,reduction_um", ANGLES_DEG, 0, (largest - radius_mm) * 1000)
    (folder / "scan.csv").write_text(text)
    profile = {"height_mm": [0, 20], "diameter_mm": [2 * largest, 2 * largest]}
    section = {"shape": "table", "csv": str(folder / "scan.csv"), "single_height": True}
    piston = {"profile": profile, "section": section}
    return changed(example_part(), {"piston": piston} | tables)


def rubs(geometry: Geometry, clearance_deg: float, heel_mm: float, direction: int) -> bool:
    """Return whether any point of a flank lies inside the section, the edge at any angle."""
    dense = np.linspace(0, 2 * np.pi, 40_001)
    contour = geometry.radius_mm(10.0) - geometry.delta(dense, 10.0).delta
    alpha = np.radians(clearance_deg)
    t = np.geomspace(1e-3, heel_mm, 400)
    for phi in np.radians(np.arange(0.03, 360, 0.1)):
        edge = np.interp(phi, dense, contour) * np.exp(1j * phi)
        back = -1j * direction * np.exp(1j * phi)
        flank = edge + t * (np.cos(alpha) * back + np.sin(alpha) * np.exp(1j * phi))
        work = np.interp(np.angle(flank) % (2 * np.pi), dense, contour)
        if (np.abs(flank) < work).any():
            return True
    return False


def skewed(angle_rad: Floats) -> Floats:
    """Return a section that rises slowly and falls quickly: M3 and M4 differ."""
    slow = 20 + 0.9 * np.cos(angle_rad) + 0.35 * np.cos(2 * angle_rad - 1)
    return np.asarray(slow + 0.1 * np.cos(5 * angle_rad))


SECTIONS = {
    "hexagon": hexagon(36.0, 6.0),
    "sharp": hexagon(36.0, 2.0),
    "skewed": skewed(np.radians(ANGLES_DEG)),
    "P3G": 20 + 0.8 * np.cos(3 * np.radians(ANGLES_DEG)),
}


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "heel_mm", "direction"),
    [
        ("hexagon", 12.0, 1),
        ("sharp", 0.5, -1),
        ("skewed", 0.5, 1),
        ("skewed", 12.0, -1),
        ("P3G", 12.0, 1),
    ],
)
def test_needed_clearance_against_brute_force(
    name: str, heel_mm: float, direction: int, tmp_path: Path
) -> None:
    """A tenth of a degree more clears the work, a tenth less lies in it."""
    geometry = make_geometry(scanned(SECTIONS[name], tmp_path))
    needed = steepest_heel(geometry, direction).needed_deg
    assert not rubs(geometry, needed + 0.1, heel_mm, direction)
    assert rubs(geometry, needed - 0.1, heel_mm, direction)


def test_a_skewed_section_needs_more_in_one_sense(tmp_path: Path) -> None:
    """With M4 the tool climbs where it fell with M3, and the places follow."""
    geometry = make_geometry(scanned(SECTIONS["skewed"], tmp_path))
    m3, m4 = steepest_heel(geometry, 1), steepest_heel(geometry, -1)
    assert abs(m3.needed_deg - m4.needed_deg) > 0.2
    slope = geometry.delta(np.radians([m3.angle_deg, m4.angle_deg]), 10.0).d1
    assert slope[0] > 0 > slope[1]  # the section falls in the sense of cutting


def test_a_hexagon_is_refused_with_the_angle_that_does(tmp_path: Path) -> None:
    """The default tool rubs; the message tells where, and a tool of its angle is taken."""
    part = scanned(SECTIONS["hexagon"], tmp_path)
    line = refused(lambda: generate(part, 1000.0))
    assert line.startswith("tool.clearance_deg: the heel of 7 degrees rubs: at ")
    assert ", height 0 mm the work after the edge rises by " in line
    least_deg = float(line.split("give a tool with at least ")[1].split(",")[0])
    geometry = make_geometry(part)
    heel = check_heel(geometry, Tool(clearance_deg=least_deg), 1)
    assert least_deg - 0.21 < heel.needed_deg < least_deg
    with pytest.raises(CamtoolsError):
        check_heel(geometry, Tool(clearance_deg=least_deg - 0.21), 1)


def test_a_polygon_tells_what_it_needs_and_refuses_what_rubs() -> None:
    """P3G: tan of the needed angle is p' / p of its tangents; the default tool is refused, too."""
    alpha = np.linspace(0, 2 * np.pi, 100_001)
    part = example_polygon()
    assert part.polygon.eccentricity_mm == 0.8
    p = sure(part.polygon.mean_diameter_mm) / 2 - 0.8 * np.cos(3 * alpha)
    steepest = float(np.degrees(np.arctan(2.4 * np.sin(3 * alpha) / p).max()))
    for tool in (Tool(), Tool(clearance_deg=steepest - 0.01)):
        with pytest.raises(CamtoolsError, match=r"rubs: at .* give a tool with at least 1"):
            generate_polygon(part.model_copy(update={"tool": tool}))
    fits = part.model_copy(update={"tool": Tool(clearance_deg=steepest + 0.05)})
    assert generate_polygon(fits).heel.needed_deg == pytest.approx(steepest, abs=2e-3)
