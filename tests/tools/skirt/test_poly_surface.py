"""Surfaces of polynomial pieces, and the skirts that are made of them."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import PPoly

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.skirt.geometry.poly_surface import PolySurface, angle_pieces, over_height
from camtools.skirt.geometry.refit import refit
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from tests.tools.cases.part_cases import ROOT, load_part, parse_part

LARGE_BORE = ROOT / "tools" / "parts" / "16v240zj.toml"
SECTION = """shape = "ellipse-arc"
trim_mm = {trim}
joint_deg = {joint}
{more}
[piston.section.refit]
{refit}"""
PART = """[part]
name = "arc"
kind = "piston"
source = "invented"
[piston.profile]
height_mm = [0, 30, 60]
diameter_mm = [119.9, 120.0, 119.8]
overshoot_um = 10
[piston.ovality]
height_mm = [0, 30, 60]
ovality_mm = [0.3, 0.35, 0.45]
[piston.section]
{section}
[process]
spindle_rpm = 600
feed_mm = 0.1
"""


def arc_part(trim: str = "0.3", joint: str = "50", more: str = "", refit: str = "") -> Geometry:
    """Make the geometry of a part of shape ellipse-arc."""
    section = SECTION.format(trim=trim, joint=joint, more=more, refit=refit)
    return make_geometry(parse_part(PART.format(section=section).encode(), "arc.toml"))


@pytest.fixture(scope="module")
def large_bore() -> Geometry:
    """Make the 210 mm skirt."""
    return make_geometry(load_part(LARGE_BORE))


def difference_nm(geometry: Geometry, z_mm: float) -> float:
    """Return how far the surface is from the refit made for this very height."""
    corner = geometry.corner
    assert corner is not None
    assert corner.recipe is not None
    phi = np.radians(np.linspace(0, 90, 1801))
    exact = refit(corner.joint(z_mm), corner.recipe, corner.n_ellipse)
    return float(np.abs(exact(phi) - geometry.delta(phi, z_mm).delta).max()) * 1e6


@pytest.mark.parametrize("z_mm", [0.0, 3.3, 20.0, 65.4321, 125.0, 208.9, 210.0])
def test_surface_is_the_refit_at_every_height(large_bore: Geometry, z_mm: float) -> None:
    """Between the heights that were fitted, too, to a thousandth of a nanometre."""
    assert difference_nm(large_bore, z_mm) < 1e-3


@pytest.mark.parametrize(
    ("trim", "joint", "refit_keys"),
    [
        ("[0.2, 0.3, 0.25]", "50", ""),
        ("0.3", "[47, 50, 52.5]", ""),
        ("[0.2, 0.3, 0.25]", "[47.2, 50, 52.5]", 'spline = "cubic"\ndelete = [1, 2]'),
        ("0.3", "49.5", 'ends = "as-paper"\ndelete = [2, 3]'),
        ("0.3", "49.5", 'ends = "as-paper"\ndelete = [0, 0]\nspline = "cubic"'),
    ],
)
def test_what_varies_with_height(trim: str, joint: str, refit_keys: str) -> None:
    """Lists of trim and joint, both splines, both kinds of ends."""
    geometry = arc_part(trim, joint, "", refit_keys)
    for z_mm in (0.0, 7.7, 30.0, 41.3, 60.0):
        assert difference_nm(geometry, z_mm) < 1e-3


def test_rows_and_points_agree_and_derivatives_are_consistent(large_bore: Geometry) -> None:
    """The fast way for rows gives the numbers of single points; slopes are those of the values."""
    phi, z_mm = np.radians(np.arange(-30, 400, 0.37)), np.array([[1.0], [99.0], [209.0]])
    rows = large_bore.delta(phi, z_mm)
    points = large_bore.delta(*np.broadcast_arrays(phi, z_mm))
    for one, other in zip(rows, points, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12, rtol=1e-12)
    step = 1e-6
    below, above = (large_bore.delta(phi + k * step, z_mm) for k in (-1, 1))
    for order in range(2):
        slope = (above[order] - below[order]) / (2 * step)
        np.testing.assert_allclose(slope, rows[order + 1], atol=1e-6)


def test_refit_has_continuous_acceleration(large_bore: Geometry) -> None:
    """Value and two derivatives have no step anywhere on the turn."""
    phi = np.linspace(0, 2 * np.pi, 720_001)
    u = large_bore.delta(phi, 210.0)
    for values, next_one in ((u.delta, u.d1), (u.d1, u.d2), (u.d2, u.d3)):
        steps = np.abs(np.diff(values)).max()
        assert steps <= 1.01 * np.abs(next_one).max() * (phi[1] - phi[0])


def test_document_holds_everything(large_bore: Geometry) -> None:
    """A surface made from the report's numbers is the same."""
    assert isinstance(large_bore.surface, PolySurface)
    told = json.loads(json.dumps(large_bore.surface.document()))
    assert told["angle"] == "joint"
    joint = told["joint_turn"]
    n, m = len(told["breaks"]) - 1, len(told["breaks_mm"]) - 1
    again = PolySurface(
        np.array(told["breaks"]),
        np.array(told["breaks_mm"]),
        np.array(told["coefficients"]).reshape(m, n, 6, 8),
        PPoly(np.array(joint["coefficients"]).T, joint["breaks_mm"]),
    )
    phi = np.linspace(0, 7, 500)
    np.testing.assert_array_equal(
        again.delta(phi, 77.7).delta, large_bore.surface.delta(phi, 77.7).delta
    )


def test_heights_beyond_the_part_go_on_as_at_its_end(large_bore: Geometry) -> None:
    """The surface is clamped, not extrapolated."""
    phi = np.linspace(0, 3, 50)
    top = large_bore.surface.delta(phi, 210.0).delta
    np.testing.assert_array_equal(large_bore.surface.delta(phi, 250.0).delta, top)


def test_pieces_reproduce_a_polynomial() -> None:
    """A quintic over several stretches, and a height law of degree 7, come back exactly."""
    curve = PPoly(np.array([[1.0], [-2], [0.5], [3], [-1], [0.25]]), np.array([0.0, 2.0]))
    breaks = np.array([0.0, 0.3, 1.1, 2.0])
    t = 0.7
    for i, row in enumerate(angle_pieces(curve, breaks)):
        x = breaks[i] + t * (breaks[i + 1] - breaks[i])
        assert row @ t ** np.arange(6) == pytest.approx(float(curve(x)), abs=1e-13)
    law = np.zeros((1, 6))
    heights, found = over_height(lambda z: law + z**7 / 1e7, np.array([0.0, 5.0]))
    assert heights.tolist() == [0.0, 5.0]
    assert found[0, 0, 0] @ 0.3 ** np.arange(8) == pytest.approx(1.5**7 / 1e7, abs=1e-13)


def test_steep_laws_are_halved_until_they_fit() -> None:
    """A law that no polynomial of degree 7 follows is cut into pieces that do."""
    heights, found = over_height(
        lambda z: np.full((1, 6), 1e-3 * np.exp(z / 2)), np.array([0.0, 20.0])
    )
    assert heights.size > 2
    assert found.shape == (heights.size - 1, 1, 6, 8)


@pytest.mark.parametrize(
    ("words", "names", "remedy"),
    [
        ({"trim": "20"}, "piston.section.trim_mm: no circle reaches", "trim less"),
        ({"trim": "-0.2"}, "piston.section.trim_mm: the circle would bulge", "trim more"),
        ({"more": "eccentricity_mm = 1.9"}, "eccentricity_mm: 1.9 mm leaves a step", "consistent"),
        (
            {"joint": "[47, 50, 52]", "refit": 'ends = "as-paper"'},
            'piston.section.refit.ends: ends = "as-paper" is defined for one joint',
            "mirror",
        ),
        ({"refit": "jerk_limit_mm_s3 = 1"}, "jerk_limit_mm_s3: no deletion keeps 1 mm", "allow"),
    ],
)
def test_impossible_corners_are_refused(words: dict[str, str], names: str, remedy: str) -> None:
    """One line that names the field, the numbers and what to do."""
    with pytest.raises(GeometryError) as info:
        arc_part(**words)
    (line,) = info.value.lines
    assert names in line
    assert remedy in line


def test_consistent_eccentricity_is_accepted_and_told() -> None:
    """The value that the refusal tells is accepted, one for each height as well."""
    with pytest.raises(GeometryError, match="consistent value there is") as info:
        arc_part(more="eccentricity_mm = [1.5, 1.5, 1.5]")
    geometry = arc_part()
    assert geometry.corner is not None
    right = geometry.corner.joint(np.array([0.0, 30.0, 60.0])).arc().eccentricity_mm
    assert any(f"{e:.6f}" in info.value.lines[0] for e in right)
    arc_part(more=f"eccentricity_mm = {[round(float(e), 6) for e in right]}")


def test_scan_is_named_in_errors(tmp_path: Path) -> None:
    """A missing file is the part file's fault."""
    text = LARGE_BORE.read_text().split("[piston.ovality]")[0] + (
        '[piston.section]\nshape = "table"\ncsv = "none.csv"\n'
        "[process]\nspindle_rpm = 1\nfeed_mm = 0.1\n"
    )
    path = tmp_path / "p.toml"
    path.write_text(text)
    with pytest.raises(CamtoolsError, match=r"piston.section.csv: none.csv: cannot be read"):
        make_geometry(load_part(path))
