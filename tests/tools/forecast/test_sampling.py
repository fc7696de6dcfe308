# SPDX-License-Identifier: Apache-2.0
"""Machines are drawn evenly, repeatably, and so that intervals hold."""

import numpy as np
from scipy import stats

from camtools.base.quantities import Floats
from camtools.forecast.sampling import draw
from camtools.forecast.statistics import share_within
from camtools.forecast.vary import read_vary

KEYS = ("bandwidth_hz", "damping", "delay_us", "friction_m_per_s2", "mass_kg", "scale_error_nm")
TEXT = "".join(f'[u.{key}]\ndistribution = "uniform"\nlow = 1\nhigh = 2\n' for key in KEYS)
UNKNOWNS = read_vary(TEXT.encode(), "v.toml", {})


def test_longer_draw_begins_with_the_shorter_one() -> None:
    """More runs add to those that are there."""
    assert np.array_equal(draw(UNKNOWNS, 100, seed=3), draw(UNKNOWNS, 300, seed=3)[:100])
    assert not np.array_equal(draw(UNKNOWNS, 100, seed=3), draw(UNKNOWNS, 100, seed=4))


def test_numbers_are_spread_as_stated() -> None:
    """MATHS.md (162): the draw is uniform, more evenly than independent numbers are."""
    drawn = draw(UNKNOWNS, 1024, seed=1) - 1
    for column in drawn.T:
        assert stats.kstest(column, "uniform").statistic < 0.002
    assert np.abs(np.corrcoef(drawn.T) - np.eye(len(KEYS))).max() < 0.02


def sum_of(drawn: Floats) -> Floats:
    """Return a known function of a draw: the sum of six uniform numbers."""
    return np.asarray((drawn - 1).sum(axis=1))


def test_interval_of_the_share_holds() -> None:
    """MATHS.md (164): in 95 % of all seeds or more the true share lies within."""
    limit = 4.0
    # Irwin and Hall: the sum of six uniform numbers is below 4 with the probability
    true = (4**6 - 6 * 3**6 + 15 * 2**6 - 20) / 720
    hits = 0
    for seed in range(200):
        found = sum_of(draw(UNKNOWNS, 128, seed=seed))
        share = share_within(int((found <= limit).sum()), found.size)
        hits += share.low <= true <= share.high
    assert hits >= 195
