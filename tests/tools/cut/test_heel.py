"""The heel against brute force: a flank swept over a dense polygon of the work, point by point."""

from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.part.tool import Tool
from camtools.polygon.generate import generate_polygon
from camtools.polygon.part import example_polygon
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.part.part_file import SkirtPart, example_part
from camtools.skirt.table.generate import generate
from camtools.skirt.tool.heel import check_heel, steepest_heel
from tests.tools.cases.part_cases import ROOT, load_part

PARTS = ROOT / "tools" / "parts"
ANGLES_DEG = np.arange(0, 360, 0.5)


def hexagon(across_mm: float, corner_mm: float) -> Floats:
    """Return the polar radius of a hexagon with rounded corners, from its sides and circles."""
    away = (np.radians(ANGLES_DEG) + np.pi / 6) % (
        np.pi / 3
    ) - np.pi / 6  # from the middle of a side
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
    rows = [
        f"{angle:g},0,{(largest - one) * 1000:.9g}"
        for angle, one in zip(ANGLES_DEG, radius_mm, strict=True)
    ]
    (folder / "scan.csv").write_text("angle_deg,z_mm,reduction_um\n" + "\n".join(rows) + "\n")
    profile = {"height_mm": [0, 20], "diameter_mm": [2 * largest, 2 * largest]}
    section = {"shape": "table", "csv": str(folder / "scan.csv"), "single_height": True}
    tree = example_part().model_dump() | {"piston": {"profile": profile, "section": section}}
    return SkirtPart.model_validate(tree | tables)


def rubs(part: SkirtPart, clearance_deg: float, heel_mm: float, direction: int) -> bool:
    """Return whether any point of a flank lies inside the section, the edge at any angle."""
    geometry = make_geometry(part)
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


def cam(angle_rad: Floats) -> Floats:
    """Return a section that rises slowly and falls quickly: M3 and M4 differ."""
    return (
        20
        + 0.9 * np.cos(angle_rad)
        + 0.35 * np.cos(2 * angle_rad - 1)
        + 0.1 * np.cos(5 * angle_rad)
    )


SECTIONS = {
    "hexagon": hexagon(36.0, 6.0),
    "sharp": hexagon(36.0, 2.0),
    "skewed": cam(np.radians(ANGLES_DEG)),
    "P3G": 20 + 0.8 * np.cos(3 * np.radians(ANGLES_DEG)),
}


@pytest.mark.parametrize("name", sorted(SECTIONS))
@pytest.mark.parametrize("heel_mm", [0.5, 12.0])
@pytest.mark.parametrize("direction", [1, -1])
def test_needed_clearance_against_brute_force(
    name: str, heel_mm: float, direction: int, tmp_path: Path
) -> None:
    """A tenth of a degree more clears the work, a tenth less lies in it."""
    part = scanned(SECTIONS[name], tmp_path)
    needed = steepest_heel(make_geometry(part), direction).needed_deg
    assert not rubs(part, needed + 0.1, heel_mm, direction)
    assert rubs(part, needed - 0.1, heel_mm, direction)


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
    with pytest.raises(CamtoolsError) as refused:
        generate(part, 1000.0)
    (line,) = refused.value.lines
    assert line.startswith("tool.clearance_deg: the heel of 7 degrees rubs: at ")
    assert ", height 0 mm the work after the edge rises by " in line
    least_deg = float(line.split("give a tool with at least ")[1].split(",")[0])
    geometry = make_geometry(part)
    heel = check_heel(geometry, Tool(clearance_deg=least_deg), 1)
    assert least_deg - 0.21 < heel.needed_deg < least_deg
    with pytest.raises(CamtoolsError):
        check_heel(geometry, Tool(clearance_deg=least_deg - 0.21), 1)


@pytest.mark.parametrize(
    "name", ["perkins240", "perkins240_x30", "weichai3a", "16v240zj", "scan90"]
)
def test_pistons_are_far_from_it(name: str) -> None:
    """An ellipse needs atan(delta' / rho), and the default tool cuts every piston of the parts."""
    part = load_part(PARTS / f"{name}.toml")
    geometry = make_geometry(part)
    found = check_heel(geometry, part.tool, part.process.direction)
    phi = np.radians(np.arange(0, 360, 0.05))
    u = geometry.delta(phi, found.z_mm)
    steepest = np.degrees(np.arctan(u.d1 / (geometry.radius_mm(found.z_mm) - u.delta)).max())
    assert found.needed_deg == pytest.approx(steepest, abs=2e-3)


def test_a_polygon_tells_what_it_needs_and_refuses_what_rubs() -> None:
    """P3G: tan of the needed angle is p' / p of its tangents; the default tool is refused, too."""
    alpha = np.linspace(0, 2 * np.pi, 100_001)
    part = example_polygon()
    assert part.polygon.mean_diameter_mm is not None
    assert part.polygon.eccentricity_mm == 0.8
    p = part.polygon.mean_diameter_mm / 2 - 0.8 * np.cos(3 * alpha)
    steepest = float(np.degrees(np.arctan(2.4 * np.sin(3 * alpha) / p).max()))
    for tool in (Tool(), Tool(clearance_deg=steepest - 0.01)):
        with pytest.raises(CamtoolsError, match=r"rubs: at .* give a tool with at least 1"):
            generate_polygon(part.model_copy(update={"tool": tool}))
    fits = part.model_copy(update={"tool": Tool(clearance_deg=steepest + 0.05)})
    assert generate_polygon(fits).heel.needed_deg == pytest.approx(steepest, abs=2e-3)
