# SPDX-License-Identifier: Apache-2.0
"""Straightness against brute force over all pairs of points and a linear program."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.roundness import simplex
from camtools.roundness.lines import straightness


def profile(seed: int, n: int) -> tuple[Floats, Floats]:
    """Return uneven heights and a rough, bent profile [mm]."""
    draw = np.random.default_rng(seed)
    z_mm = np.cumsum(draw.uniform(0.02, 0.2, n))
    bent = 1e-6 * draw.normal() * (z_mm - z_mm.mean()) ** 2 + 1e-4 * z_mm
    return z_mm, bent + 1e-4 * draw.normal(size=n)


@pytest.mark.parametrize("seed", range(5))
def test_zone_is_that_of_all_pairs(seed: int) -> None:
    """The narrowest strip lies along the line through two of the points."""
    z_mm, value_mm = profile(seed, 40)
    widths = []
    for i, k in combinations(range(40), 2):
        slope = (value_mm[k] - value_mm[i]) / (z_mm[k] - z_mm[i])
        widths.append(np.ptp(value_mm - slope * z_mm))
    assert straightness(z_mm, value_mm).zone_mm == pytest.approx(min(widths), abs=1e-13)


def test_zone_is_that_of_a_linear_program() -> None:
    """HiGHS finds the same strip around a thousand points."""
    z_mm, value_mm = profile(9, 1000)
    ones = np.ones((1000, 1))
    rows = np.block([[-ones, -z_mm[:, None], -ones], [ones, z_mm[:, None], -ones]])
    value_um = value_mm * 1e3
    bounds = [(None, None), (None, None), (0, None)]
    program = linprog([0, 0, 1], rows, np.concatenate([-value_um, value_um]), bounds=bounds)
    assert straightness(z_mm, value_mm).zone_mm * 1e3 == pytest.approx(2 * program.fun, abs=1e-5)


def test_least_squares_line_leaves_nothing_along_itself() -> None:
    """Slope and level are those of lstsq; peaks, valley and q follow from what it leaves."""
    z_mm, value_mm = profile(2, 300)
    found = straightness(z_mm, value_mm)
    rows = np.column_stack([np.ones(300), z_mm])
    fitted = np.linalg.lstsq(rows, value_mm, rcond=None)[0]
    left = value_mm - rows @ fitted
    assert found.slope == pytest.approx(fitted[1], abs=1e-12)
    assert found.middle_mm == pytest.approx(fitted @ [1, z_mm.mean()], abs=1e-12)
    assert (found.peak_mm, -found.valley_mm) == pytest.approx((left.max(), left.min()), abs=1e-12)
    assert found.total_mm == pytest.approx(found.peak_mm + found.valley_mm, abs=1e-15)
    assert found.q_mm == pytest.approx(np.sqrt((left**2).mean()), abs=1e-12)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 1000), st.floats(-1, 1), st.floats(-1e-3, 1e-3), st.floats(0.1, 10))
def test_form_does_not_depend_on_level_slope_and_scale(
    seed: int, level_mm: float, slope: float, scale: float
) -> None:
    """A line that is added changes nothing, the zone is no wider than about the LS line."""
    z_mm, value_mm = profile(seed, 60)
    one = straightness(z_mm, value_mm)
    other = straightness(z_mm, scale * (value_mm + level_mm + slope * z_mm))
    for name in ("total_mm", "zone_mm", "q_mm", "peak_mm"):
        expected = scale * getattr(one, name)
        assert getattr(other, name) == pytest.approx(expected, abs=1e-11), name
    assert one.zone_mm <= one.total_mm + 1e-15


def test_what_comes_to_no_end_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A program that is not done after the steps allowed ends in a message, not in a number."""
    monkeypatch.setattr(simplex, "_MOST_STEPS", 1)
    with pytest.raises(CamtoolsError, match="zone of the profile cannot be found"):
        straightness(*profile(1, 50))
