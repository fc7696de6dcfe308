"""Sections against the worked numbers of MATHS.md (1) .. (5)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camtools.skirt.geometry.sections import DoubleEllipse, Ellipse, Section, make_section

A_MM = 46.0
DEGREES = [0, 10, 15, 30, 45, 60, 75, 90]
TABLE_VALUES = {
    "exact": "0.000000000 0.003024932 0.006719165 0.025061263 0.050081610 0.075061152 "
    "0.093321641 0.100000000",
    "cosine": "0.000000000 0.003015369 0.006698730 0.025000000 0.050000000 0.075000000 "
    "0.093301270 0.100000000",
    "plus": "0.000000000 0.003483280 0.007698730 0.028000000 0.054000000 0.078000000 "
    "0.094301270 0.100000000",
    "minus": "0.000000000 0.002547458 0.005698730 0.022000000 0.046000000 0.072000000 "
    "0.092301270 0.100000000",
}
SHAPES: dict[str, Section] = {
    "exact": Ellipse(),
    "cosine": make_section("cosine", 0.0),
    "plus": DoubleEllipse(1.0),
    "minus": DoubleEllipse(-1.0),
}
EXACT_LESS_COSINE = [  # G, largest difference nm, at degrees, first term of the series nm
    (0.2, "81.610", "44.9740", "81.522"),
    (0.25, "127.551", "44.9675", "127.378"),
    (0.3, "183.724", "44.9610", "183.424"),
    (0.35, "250.136", "44.9545", "249.660"),
    (0.38, "294.903", "44.9506", "294.293"),
    (0.4, "326.798", "44.9480", "326.087"),
]

radii = st.floats(10, 200)
ovalities = st.floats(0.001, 2)
betas = st.floats(-6.25, 6.25)
angles = st.floats(-10, 10)


@pytest.mark.parametrize("name", list(TABLE_VALUES))
def test_delta_has_the_printed_values(name: str) -> None:
    """Radius reductions at a = 46, G = 0.2 are those of the table of values."""
    delta = SHAPES[name].evaluate(np.radians(DEGREES), A_MM, 0.2).delta
    assert [f"{mm:.9f}" for mm in delta] == TABLE_VALUES[name].split()


def test_polar_radius_has_the_printed_values() -> None:
    """The exact polar radius is the printed one, from the direct formula too."""
    printed = "46.000000000 45.996975068 45.993280835 45.974938737 45.949918390 45.924938848"
    phi, b = np.radians(DEGREES[:6]), A_MM - 0.1
    direct = A_MM * b / np.sqrt((b * np.cos(phi)) ** 2 + (A_MM * np.sin(phi)) ** 2)
    ours = A_MM - Ellipse().evaluate(phi, A_MM, 0.2).delta
    assert [f"{mm:.9f}" for mm in ours] == printed.split()
    np.testing.assert_allclose(ours, direct, atol=1e-13)


@pytest.mark.parametrize(("g_mm", "most_nm", "at_degrees", "series_nm"), EXACT_LESS_COSINE)
def test_exact_lies_inside_cosine(
    g_mm: float, most_nm: str, at_degrees: str, series_nm: str
) -> None:
    """The difference of ellipse and cosine form peaks where and as high as printed."""
    degrees = np.linspace(44.9, 45.0, 100_001)
    phi = np.radians(degrees)
    cosine = make_section("cosine", 0.0).evaluate(phi, A_MM, g_mm).delta
    gap_nm = (Ellipse().evaluate(phi, A_MM, g_mm).delta - cosine) * 1e6
    assert f"{gap_nm.max():.3f}" == most_nm
    assert degrees[np.argmax(gap_nm)] == pytest.approx(float(at_degrees), abs=1.1e-4)
    assert f"{3 * g_mm**2 / (32 * A_MM) * 1e6:.3f}" == series_nm


def test_second_derivatives_at_the_axes_are_the_closed_forms() -> None:
    """Curvature is a(a^2-b^2)/b^2 at the long, -b(a^2-b^2)/a^2 at the short axis; beta likewise."""
    g, b = 0.3, A_MM - 0.15
    d2 = Ellipse().evaluate(np.array([0, np.pi / 2]), A_MM, g).d2
    np.testing.assert_allclose(
        d2, [A_MM * (A_MM**2 - b**2) / b**2, -b * (A_MM**2 - b**2) / A_MM**2], rtol=1e-12
    )
    d2 = DoubleEllipse(2.0).evaluate(np.array([0, np.pi / 2]), A_MM, g).d2
    np.testing.assert_allclose(d2, [g * (1 + 8 / 25), -g * (1 - 8 / 25)], rtol=1e-12)


def test_beta_adds_one_fiftieth_of_the_ovality_at_45_degrees() -> None:
    """The double ellipse is deeper by G beta / 50 at 45 degrees and the same at the axes."""
    phi = np.radians([0.0, 45.0, 90.0])
    extra = DoubleEllipse(3.0).evaluate(phi, A_MM, 0.2).delta
    extra = extra - DoubleEllipse(0.0).evaluate(phi, A_MM, 0.2).delta
    np.testing.assert_allclose(extra, [0, 0.2 * 3 / 50, 0], atol=1e-16)


def _sections(beta: float) -> list[Section]:
    return [Ellipse(), DoubleEllipse(beta)]


@given(angles, radii, ovalities, betas)
def test_sections_have_two_fold_symmetry(phi: float, a: float, g: float, beta: float) -> None:
    """delta(phi) = delta(pi - phi) = delta(phi + pi) for every shape."""
    for section in _sections(beta):
        values = section.evaluate(np.array([phi, np.pi - phi, phi + np.pi]), a, g).delta
        np.testing.assert_allclose(values, values[0], atol=1e-13)


@given(radii, ovalities, betas)
def test_sections_rise_from_long_to_short_axis(a: float, g: float, beta: float) -> None:
    """Between the axes the reduction never falls, and it is 0 and G/2 at the axes."""
    phi = np.linspace(0, np.pi / 2, 201)
    for section in _sections(beta):
        delta = section.evaluate(phi, a, g).delta
        assert np.diff(delta).min() >= -1e-15
        assert delta[0] == 0
        assert delta[-1] == pytest.approx(g / 2, rel=1e-12)


@given(st.floats(0, 3.2), radii, ovalities, betas)
def test_derivatives_are_those_of_the_value(phi: float, a: float, g: float, beta: float) -> None:
    """Each derivative is the five-point difference of the one before."""
    step = 1e-3
    places = phi + step * np.array([-2.0, -1.0, 1.0, 2.0])
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12 * step)
    for section in _sections(beta):
        around = section.evaluate(places, a, g)
        here = section.evaluate(np.array([phi]), a, g)
        for order in range(3):
            slope = float(weights @ around[order])
            assert slope == pytest.approx(float(here[order + 1][0]), abs=1e-7 * g * (1 + abs(beta)))
