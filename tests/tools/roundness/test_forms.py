"""Circles, straightness and waves against scipy, linear programs, brute force and the standard."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares as minimise_squares
from scipy.optimize import minimize

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.roundness.section import (
    UPR_CHOICES,
    RoundProfile,
    about,
    axes_of,
    distances_mm,
    harmonics,
    least_squares,
    low_pass,
    maximum_inscribed,
    minimum_circumscribed,
    minimum_zone,
    roundness,
    solve,
    straightness,
    transmission,
)


def made_up(seed: int, n: int = 720, radius_mm: float = 46.0) -> RoundProfile:
    """Return a rough, lobed, eccentric profile."""
    draw = np.random.default_rng(seed)
    phi = 2 * np.pi * np.arange(n) / n
    off_mm = 1e-3 * draw.normal(size=n)
    for order in (1, 2, 3, 5, 9):
        off_mm += 1e-2 / order * draw.normal() * np.cos(order * phi + draw.uniform(0, 6))
    return RoundProfile(phi, radius_mm + off_mm)


def points(profile: RoundProfile) -> Floats:
    """Return the points of a profile, shape (n, 2)."""
    direction = np.stack([np.cos(profile.phi_rad), np.sin(profile.phi_rad)], axis=1)
    return np.asarray(profile.radius_mm[:, None] * direction, dtype=np.float64)


def farther(at: Floats, place: Floats) -> Floats:
    """Return the distances of points from a place."""
    return np.asarray(np.hypot(*(at - place).T), dtype=np.float64)


@pytest.mark.parametrize("seed", range(2))
def test_least_squares_circle_is_that_of_a_general_minimiser(seed: int) -> None:
    """Levenberg and Marquardt on the distances themselves find centre and radius within 0.01 nm."""
    profile = made_up(seed)
    at, found = points(profile), least_squares(profile)
    other = minimise_squares(
        lambda x: farther(at, x[:2]) - x[2], [0, 0, 46], xtol=1e-15, ftol=1e-15, gtol=1e-15
    ).x
    assert tuple(found) == pytest.approx(tuple(other), abs=1e-8)


@pytest.mark.parametrize("seed", range(2))
def test_minimum_zone_alternates_and_no_search_finds_a_smaller_one(seed: int) -> None:
    """Two points outside and two inside take turns; a simplex search about it stays above."""
    profile = made_up(seed)
    zone = minimum_zone(profile)
    off_mm = distances_mm(profile, zone.circle)
    touching = np.flatnonzero(np.abs(off_mm) > zone.width_mm / 2 - 1e-9)
    sides = np.sign(off_mm[touching])
    turns = sum(one != other for one, other in pairwise([*sides, sides[0]]))
    assert turns >= 4
    at = points(profile)
    start = [zone.circle.x_mm + 1e-3, zone.circle.y_mm - 1e-3]
    search = minimize(
        lambda x: np.ptp(farther(at, x)), start, method="Nelder-Mead",
        options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 2000},
    )  # fmt: skip
    assert zone.width_mm <= search.fun + 1e-12
    assert zone.width_mm == pytest.approx(search.fun, abs=1e-6)


def circle_through(three: Floats) -> Floats:
    """Return the centre of the circle through three points."""
    rows = 2 * (three[1:] - three[0])
    right = (three[1:] ** 2).sum(axis=1) - (three[0] ** 2).sum()
    return np.asarray(np.linalg.solve(rows, right), dtype=np.float64)


def test_circles_are_those_of_all_pairs_and_triples() -> None:
    """The smallest that holds 24 points, and the largest that holds none."""
    profile = made_up(3, 24)
    at, found = points(profile), minimum_circumscribed(profile)
    centres = [(at[i] + at[k]) / 2 for i, k in combinations(range(24), 2)]
    centres += [circle_through(at[list(three)]) for three in combinations(range(24), 3)]
    smallest = min(float(farther(at, centre).max()) for centre in centres)
    assert found.radius_mm == pytest.approx(smallest, abs=1e-9)
    found = maximum_inscribed(profile)
    centres = [circle_through(at[list(three)]) for three in combinations(range(24), 3)]
    near = [centre for centre in centres if np.hypot(*centre) < 0.1]
    assert found.radius_mm == pytest.approx(
        max(float(farther(at, centre).min()) for centre in near), abs=1e-9
    )


@pytest.mark.parametrize("n", [72, 360, 3600])
def test_circle_around_an_oval_has_its_long_axis(n: int) -> None:
    """Two points touch it, so that its centre is free across them; drawn 0.3 mm off the axis."""
    phi = 2 * np.pi * np.arange(n) / n
    at = (46 - 0.5 * np.sin(phi) ** 2) * np.exp(1j * phi) + 0.3
    found = minimum_circumscribed(RoundProfile(np.angle(at), np.abs(at)))
    assert found.radius_mm == pytest.approx(46, abs=1e-9)
    assert (found.x_mm, found.y_mm) == pytest.approx((0.3, 0), abs=1e-6)


def figures(profile: RoundProfile) -> list[float]:
    """Return what is told of a profile by each circle [mm]."""
    about_ls = roundness(profile, least_squares(profile))
    zone = minimum_zone(profile)
    around, within = minimum_circumscribed(profile), maximum_inscribed(profile)
    return [about_ls.total_mm, about_ls.q_mm, zone.width_mm, around.radius_mm, within.radius_mm]


@settings(max_examples=20)
@given(
    st.integers(0, 1000),
    st.floats(0, 2 * np.pi),
    st.floats(-0.02, 0.02),
    st.floats(-0.02, 0.02),
    st.floats(0.1, 3.0),
)
def test_form_does_not_depend_on_place_angle_and_scale(
    seed: int, turned_rad: float, x_mm: float, y_mm: float, scale: float
) -> None:
    """A part that is turned, moved on the table or of another size has the same form, scaled."""
    profile = made_up(seed, 90)
    moved = about(RoundProfile(profile.phi_rad + turned_rad, profile.radius_mm), x_mm, y_mm)
    other = RoundProfile(moved.phi_rad, scale * moved.radius_mm)
    for one, two in zip(figures(profile), figures(other), strict=True):
        assert two == pytest.approx(scale * one, abs=1e-8)


def profile(seed: int, n: int) -> tuple[Floats, Floats]:
    """Return uneven heights and a rough, bent profile [mm]."""
    draw = np.random.default_rng(seed)
    z_mm = np.cumsum(draw.uniform(0.02, 0.2, n))
    bent = 1e-6 * draw.normal() * (z_mm - z_mm.mean()) ** 2 + 1e-4 * z_mm
    return z_mm, bent + 1e-4 * draw.normal(size=n)


@pytest.mark.parametrize("seed", range(2))
def test_zone_is_that_of_all_pairs(seed: int) -> None:
    """The narrowest strip lies along the line through two of the points."""
    z_mm, value_mm = profile(seed, 40)
    widths = []
    for i, k in combinations(range(40), 2):
        slope = (value_mm[k] - value_mm[i]) / (z_mm[k] - z_mm[i])
        widths.append(np.ptp(value_mm - slope * z_mm))
    assert straightness(z_mm, value_mm).zone_mm == pytest.approx(min(widths), abs=1e-13)


def test_least_squares_line_leaves_nothing_along_itself() -> None:
    """Slope and level are those of lstsq; peak to valley and q follow from what it leaves."""
    z_mm, value_mm = profile(2, 300)
    found = straightness(z_mm, value_mm)
    rows = np.column_stack([np.ones(300), z_mm])
    fitted = np.linalg.lstsq(rows, value_mm, rcond=None)[0]
    left = value_mm - rows @ fitted
    assert found.slope == pytest.approx(fitted[1], abs=1e-12)
    assert found.middle_mm == pytest.approx(fitted @ [1, z_mm.mean()], abs=1e-12)
    assert found.total_mm == pytest.approx(np.ptp(left), abs=1e-12)
    assert found.q_mm == pytest.approx(np.sqrt((left**2).mean()), abs=1e-12)


def test_zone_without_an_end_is_refused() -> None:
    """A program of which no solution is the best ends in a message, not in a number."""
    with pytest.raises(CamtoolsError, match="zone of the profile: no solution was found"):
        solve(np.eye(2), np.zeros(2), np.array([1.0, -1.0]))


N = 3600
ROUND = 2 * np.pi * np.arange(N) / N


def convolved(profile: Floats, cutoff_upr: float) -> Floats:
    """Return the filtered profile by ISO 16610-21: sums with the weights, around the turn."""
    alpha, wave = np.sqrt(np.log(2) / np.pi), 1 / cutoff_upr
    x = np.arange(-N, N + 1) / N  # one turn to both sides is where the weights have vanished
    weights = np.exp(-np.pi * (x / (alpha * wave)) ** 2) / (alpha * wave) / N
    around = np.concatenate([profile, profile, profile])
    sums = np.convolve(around, weights, mode="same")
    return np.asarray(sums[N : 2 * N], dtype=np.float64)


@pytest.mark.parametrize("upr", UPR_CHOICES)
def test_filter_is_the_convolution_of_the_standard(upr: int) -> None:
    """Steps, noise and waves come out the same by both ways, up to what sampled weights alias."""
    draw = np.random.default_rng(upr)
    profile = draw.normal(size=N) + 3.0 * (ROUND > 2) + np.cos(upr * ROUND)
    aliased = 1e-9 + float(transmission(N / 2, upr))  # 1e-4 of the noise at 500, else nothing
    assert low_pass(profile, upr) == pytest.approx(convolved(profile, upr), abs=aliased)


def test_harmonics_are_those_of_least_squares() -> None:
    """Cosines and sines fitted by lstsq have the amplitudes and the crests of the sums."""
    draw = np.random.default_rng(5)
    profile = draw.normal(size=N).cumsum() * 1e-3
    rows = [np.ones(N)]
    for order in range(1, 51):
        rows += [np.cos(order * ROUND), np.sin(order * ROUND)]
    fitted = np.linalg.lstsq(np.column_stack(rows), profile, rcond=None)[0]
    for one, (a, b) in zip(harmonics(profile), fitted[1:].reshape(50, 2), strict=True):
        assert one.amplitude == pytest.approx(np.hypot(a, b), abs=1e-12)
        crest_rad = np.radians(one.phase_deg) * one.order
        assert one.amplitude * np.cos(crest_rad) == pytest.approx(a, abs=1e-12)
        assert one.amplitude * np.sin(crest_rad) == pytest.approx(b, abs=1e-12)
        assert 0 <= one.phase_deg < 360 / one.order + 1e-9


@settings(max_examples=20)
@given(st.floats(-80, 80), st.floats(0.01, 0.5), st.floats(0, 0.002))
def test_axes_of_an_ellipse(phase_deg: float, g_mm: float, off_mm: float) -> None:
    """Half axes, phase, and what an eccentricity adds: less than its square over the radius."""
    a, b, at = 46.0, 46.0 - g_mm / 2, ROUND - np.radians(phase_deg)
    radius_mm = a * b / np.hypot(b * np.cos(at), a * np.sin(at))
    found = axes_of(radius_mm + off_mm * np.cos(ROUND))
    sampled_mm = 2 * g_mm * (np.pi / N) ** 2
    assert found.long_mm == pytest.approx(2 * a, abs=1e-12 + sampled_mm)
    assert found.short_mm == pytest.approx(2 * b, abs=1e-12 + sampled_mm)
    assert found.ovality_mm == pytest.approx(g_mm, abs=2 * sampled_mm + 1e-12)
    assert found.phase_deg == pytest.approx(phase_deg, abs=1e-6)
