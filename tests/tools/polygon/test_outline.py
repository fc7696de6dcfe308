"""Outlines against other constructions of the same drawings."""

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.polygon.outline import Outline, measures_of
from camtools.polygon.shapes import cornered, p3g, p4c, regular
from camtools.polygon.standard_sizes import P3G, P4C
from tests.tools.cases import polygon_cases as cases
from tests.tools.cases.part_cases import ROOT

_SAME_MM = 1e-11
PHI = np.linspace(-1.0, 7.5, 701)


def derivatives_hold(outline: Outline, at: cases.Floats, h: float = 1e-4) -> None:
    """Compare the derivatives with differences of the radius of one curve."""
    for phi in at:
        curve = outline.curve_at(float(phi))
        low, here, high = (curve.polar(np.array([phi + k * h])) for k in (-1, 0, 1))
        for n, step in (("d1", "r"), ("d2", "d1"), ("d3", "d2")):
            slope = (getattr(high, step) - getattr(low, step)) / (2 * h)
            size = 1 + abs(float(getattr(here, n)[0]))
            assert float(slope[0]) == pytest.approx(float(getattr(here, n)[0]), abs=2e-4 * size)


@pytest.mark.parametrize("size", P3G.values(), ids=str)
def test_p3g_is_the_envelope_of_its_tangents(size: tuple[float, float]) -> None:
    """Every nominal size of DIN 32711."""
    phi = PHI[::35]
    r = p3g(*size, 0.0).polar(phi).r
    assert np.abs(r - cases.p3g_mm(phi, *size)).max() < _SAME_MM


@pytest.mark.parametrize("size", P3G.values(), ids=str)
def test_p3g_has_one_width(size: tuple[float, float]) -> None:
    """A calliper finds the mean diameter in every direction; the circles are d2 and d3."""
    measures, (mean, e) = measures_of(p3g(*size, 0.1)), size
    assert measures.least_width_mm == pytest.approx(mean, abs=1e-5)
    assert measures.largest_width_mm == pytest.approx(mean, abs=1e-5)
    assert measures.outer_circle_mm == pytest.approx(mean + 2 * e, abs=1e-9)
    assert measures.inner_circle_mm == pytest.approx(mean - 2 * e, abs=1e-6)


@pytest.mark.parametrize("size", P4C.values(), ids=str)
def test_p4c_is_cut_by_its_circle(size: tuple[float, float, float]) -> None:
    """Every nominal size of DIN 32712 against chords of the contour; their sagitta is 1e-9 mm."""
    phi = PHI[::5]
    outline = p4c(*size, 0.0)
    assert np.abs(outline.polar(phi).r - cases.p4c_mm(phi, *size)).max() < 2e-8
    measures = measures_of(outline)
    assert measures.outer_circle_mm == pytest.approx(size[0], abs=1e-12)
    assert measures.inner_circle_mm == pytest.approx(size[1], abs=1e-6)


def test_published_sizes() -> None:
    """What catalogues print: P4C 35 x 30 / 5.0 (Polygona); d2 - d1 = d1 - d3 = 2 e1."""
    assert P4C[35.0] == (35.0, 30.0, 5.0)
    assert (P3G[25.0].outer_mm, P3G[25.0].inner_mm) == (26.6, 23.4)
    assert all(one.mean_mm > 16 * one.eccentricity_mm for one in P3G.values())


@pytest.mark.parametrize("n", [3, 4, 5, 6, 8, 12])
@pytest.mark.parametrize("radius", [0.0, 0.6, 4.0])
def test_regular_polygon_is_a_core_with_a_border(n: int, radius: float) -> None:
    """The outline is what lies within the corner radius of the inset polygon."""
    r = regular(n, 20.0, radius, 0.0).polar(PHI).r
    there = cases.rounded_mm(PHI, cases.regular_corners(n, 20.0), radius)
    assert np.abs(r - there).max() < _SAME_MM


def test_random_convex_polygons() -> None:
    """Corners anywhere on an ellipse round the axis, one radius for all."""
    rng = np.random.default_rng(32711)
    for _ in range(25):
        n = int(rng.integers(4, 9))
        angle = 2 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
        corners = np.stack([18 * np.cos(angle), 14 * np.sin(angle)], axis=-1)
        outline = cornered(corners.tolist(), [0.7] * n, 0.0)
        assert np.abs(outline.polar(PHI).r - cases.rounded_mm(PHI, corners, 0.7)).max() < _SAME_MM
        derivatives_hold(outline, rng.uniform(0, 2 * np.pi, 5), 1e-5)


@pytest.mark.parametrize(
    "outline",
    [p3g(25, 0.8, 0.3), p4c(14, 11, 1.6, -0.2), p4c(35, 30, 5, 1.0), regular(6, 20, 1, 0.1)],
)
def test_derivatives(outline: Outline) -> None:
    """Three derivatives of every curve."""
    derivatives_hold(outline, np.linspace(0.02, 6.2, 23))


def test_phase_turns_counter_clockwise() -> None:
    """A corner at 30 degrees of the drawing lies in the direction of +x and +y."""
    outline = regular(4, 10.0, 0.5, float(np.radians(30)))
    corner = outline.polar(np.radians([30.0, 120.0, 75.0])).r
    assert corner[0] == pytest.approx(corner[1], abs=1e-12)
    assert corner[2] == pytest.approx(5.0, abs=1e-12)


def test_repeats() -> None:
    """A rectangle repeats twice, a square given by its corners four times, a kite never."""
    assert cornered([[9, 5], [-9, 5], [-9, -5], [9, -5]], [1.0] * 4, 0.0).repeat == 2
    assert cornered([[5, 5], [-5, 5], [-5, -5], [5, -5]], [1.0] * 4, 0.0).repeat == 4
    assert cornered([[9, 0], [0, 5], [-6, 0], [0, -5]], [1.0] * 4, 0.0).repeat == 1
    assert cornered([[5, 5], [-5, 5], [-5, -5], [5, -5]], [1.0, 2.0] * 2, 0.0).repeat == 2


def test_impossible_outlines() -> None:
    """Each is refused with the key to change."""
    with pytest.raises(CamtoolsError, match=r"polygon\.eccentricity_mm: 1.6 makes loops"):
        p3g(25.0, 1.6, 0.0)
    with pytest.raises(CamtoolsError, match=r"polygon\.outer_diameter_mm: 45: the sides meet"):
        p4c(45.0, 30.0, 5.0, 0.0)
    with pytest.raises(CamtoolsError, match=r"polygon\.inner_diameter_mm: 35 is not below"):
        p4c(35.0, 35.0, 5.0, 0.0)
    with pytest.raises(CamtoolsError, match=r"polygon\.corner_radius_mm: 10 leaves nothing"):
        regular(6, 20.0, 10.0, 0.0)
    with pytest.raises(CamtoolsError, match="does not turn left"):
        cornered([[9, 0], [0, -5], [-6, 0], [0, 5]], [1.0] * 4, 0.0)
    with pytest.raises(CamtoolsError, match="is outside of the side"):
        cornered([[9, 1], [9, 5], [-6, 5], [-6, 1]], [1.0] * 4, 0.0)
    with pytest.raises(CamtoolsError, match=r"rises 8\d\.\d degrees"):
        cornered([[9, -0.5], [0, 5], [-6, 0], [0, -0.6]], [0.1] * 4, 0.0)
    with pytest.raises(CamtoolsError, match="use up the whole following side"):
        cornered([[9, 0], [0, 5], [-6, 0], [0, -5]], [5.0] * 4, 0.0)


def test_sizes_of_the_manual_are_those_that_are_made() -> None:
    """P3G with both circles, d1 + 2 e1 and d1 - 2 e1, and P4C, line by line."""
    text = (ROOT / "tools" / "docs" / "POLYGONS.md").read_text().split("## Nominal sizes")[1]
    lines = [line.strip("| ").split(" | ") for line in text.splitlines() if line[:1] == "|"]
    rows = [[float(cell) for cell in line] for line in lines if line[0].isdecimal()]
    assert [[row[0], row[3]] for row in rows] == [
        [one.mean_mm, one.eccentricity_mm] for one in P3G.values()
    ]
    for d1, d2, d3, e1, *_ in rows:
        assert (d2, d3) == pytest.approx((d1 + 2 * e1, d1 - 2 * e1), abs=1e-9)
    assert [(row[0], *row[4:]) for row in rows] == list(P4C.values())
