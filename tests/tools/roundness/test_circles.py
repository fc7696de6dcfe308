# SPDX-License-Identifier: Apache-2.0
"""Reference circles against other methods: scipy's minimisers, its linear programs, brute force."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares as minimise_squares
from scipy.optimize import linprog, minimize

from camtools.base.quantities import Floats
from camtools.roundness.circles import (
    Circle,
    RoundProfile,
    about,
    distances_mm,
    least_squares,
    maximum_inscribed,
    minimum_circumscribed,
    minimum_zone,
    roundness,
)

PHI = 2 * np.pi * np.arange(720) / 720


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


@pytest.mark.parametrize("seed", range(4))
def test_least_squares_circle_is_that_of_a_general_minimiser(seed: int) -> None:
    """Levenberg and Marquardt on the distances themselves find centre and radius within 0.01 nm."""
    profile = made_up(seed)
    at, found = points(profile), least_squares(profile)
    other = minimise_squares(
        lambda x: farther(at, x[:2]) - x[2], [0, 0, 46], xtol=1e-15, ftol=1e-15, gtol=1e-15
    ).x
    assert tuple(found) == pytest.approx(tuple(other), abs=1e-8)


def test_algebraic_circle_is_near_and_no_better() -> None:
    """Kasa's circle by lstsq is off by less than 10 nm and has the larger sum of squares."""
    profile = made_up(7)
    at = points(profile)
    rows = np.column_stack([2 * at, np.ones(len(at))])
    a, b, c = np.linalg.lstsq(rows, (at**2).sum(axis=1), rcond=None)[0]
    kasa, found = Circle(a, b, float(np.sqrt(c + a**2 + b**2))), least_squares(profile)
    assert tuple(found) == pytest.approx(tuple(kasa), abs=1e-5)
    sums = [float((distances_mm(profile, one) ** 2).sum()) for one in (found, kasa)]
    assert sums[0] <= sums[1]


@pytest.mark.parametrize("seed", range(4))
def test_minimum_zone_is_that_of_a_linear_program(seed: int) -> None:
    """HiGHS, linearised about the centre that is found, moves no further and finds no less."""
    profile = made_up(seed)
    zone = minimum_zone(profile)
    here = about(profile, zone.circle.x_mm, zone.circle.y_mm)
    basis = np.stack([np.ones(720), np.cos(here.phi_rad), np.sin(here.phi_rad)], axis=1)
    off_um = (here.radius_mm - 46) * 1e3
    rows = np.block([[basis, -np.ones((720, 1))], [-basis, -np.ones((720, 1))]])
    bounds = [(None, None)] * 3 + [(0, None)]
    program = linprog([0, 0, 0, 1], rows, np.concatenate([off_um, -off_um]), bounds=bounds)
    assert zone.width_mm * 1e3 == pytest.approx(2 * program.fun, abs=1e-5)


@pytest.mark.parametrize("seed", range(3))
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


def test_smallest_circle_is_that_of_all_pairs_and_triples() -> None:
    """Of 24 points: the smallest of all circles by two or three of them that hold them all."""
    profile = made_up(3, 24)
    at, found = points(profile), minimum_circumscribed(profile)
    centres = [(at[i] + at[k]) / 2 for i, k in combinations(range(24), 2)]
    centres += [circle_through(at[list(three)]) for three in combinations(range(24), 3)]
    smallest = min(float(farther(at, centre).max()) for centre in centres)
    assert found.radius_mm == pytest.approx(smallest, abs=1e-9)


def test_largest_circle_within_is_that_of_all_triples() -> None:
    """Of 24 points: the largest by three of them that holds none, as a search confirms."""
    profile = made_up(3, 24)
    at, found = points(profile), maximum_inscribed(profile)
    centres = [circle_through(at[list(three)]) for three in combinations(range(24), 3)]
    near = [centre for centre in centres if np.hypot(*centre) < 0.1]
    assert found.radius_mm == pytest.approx(
        max(float(farther(at, centre).min()) for centre in near), abs=1e-9
    )


def test_ellipse_has_its_known_circles() -> None:
    """Half axes 46 and 45.9 mm: zone 0.1, circles around and within are those of the axes."""
    a, b = 46.0, 45.9
    profile = RoundProfile(PHI, a * b / np.hypot(b * np.cos(PHI), a * np.sin(PHI)))
    assert minimum_zone(profile).width_mm == pytest.approx(a - b, abs=1e-12)
    assert minimum_circumscribed(profile).radius_mm == pytest.approx(a, abs=1e-7)
    assert maximum_inscribed(profile).radius_mm == pytest.approx(b, abs=1e-7)


def figures(profile: RoundProfile) -> list[float]:
    """Return what is told of a profile by each circle [mm]."""
    about_ls = roundness(profile, least_squares(profile))
    zone = minimum_zone(profile)
    around, within = minimum_circumscribed(profile), maximum_inscribed(profile)
    return [about_ls.total_mm, about_ls.q_mm, zone.width_mm, around.radius_mm, within.radius_mm]


@settings(max_examples=40, deadline=None)
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


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_zones_are_nested(seed: int) -> None:
    """The minimum zone is no wider than any other: about LSCI, MCCI or MICI."""
    profile = made_up(seed, 72)
    zone_mm = minimum_zone(profile).width_mm
    for find in (least_squares, minimum_circumscribed, maximum_inscribed):
        assert zone_mm <= roundness(profile, find(profile)).total_mm + 1e-12
    assert maximum_inscribed(profile).radius_mm <= least_squares(profile).radius_mm
    assert least_squares(profile).radius_mm <= minimum_circumscribed(profile).radius_mm
