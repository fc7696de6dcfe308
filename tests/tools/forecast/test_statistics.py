# SPDX-License-Identifier: Apache-2.0
"""What is said of a sample agrees with printed values and with counting."""

import math

import numpy as np
import pytest
from scipy import stats

from camtools.forecast.statistics import effects, quantile, share_within


@pytest.mark.parametrize(
    ("n_within", "n", "low", "high"),
    [
        # R. G. Newcombe, Statistics in Medicine 17 (1998) 857-872, table I, method 3 (Wilson).
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_share_has_the_interval_of_newcombe(n_within: int, n: int, low: float, high: float) -> None:
    """MATHS.md (164): the printed figures."""
    share = share_within(n_within, n)
    assert share.share == n_within / n
    assert (share.low, share.high) == pytest.approx((low, high), abs=5e-5)


def test_quantile_holds_with_its_probability() -> None:
    """MATHS.md (163): of 2000 samples of a known distribution 95 % or more hold the quantile."""
    rng = np.random.default_rng(5)
    for percent in (50.0, 95.0):
        true = float(stats.expon.ppf(percent / 100))
        held = 0
        for _ in range(2000):
            one = quantile(rng.exponential(size=100), percent)
            held += one.low <= true <= one.high
            assert one.low <= one.value <= one.high
        assert held >= 0.94 * 2000


def test_quantile_of_a_small_sample_is_open() -> None:
    """MATHS.md (163): of 10 cuts nothing bounds the 99 % quantile from above."""
    one = quantile(np.arange(1.0, 11.0), 99.0)
    assert one.value == 10.0
    assert math.isinf(one.high)
    assert quantile(np.array([3.0]), 50.0) == (50.0, 3.0, 0.0, math.inf)


def test_cut_without_a_result_is_worse_than_any() -> None:
    """Two of ten are infinite: the 90 % quantile is, the median is not."""
    errors = np.array([*range(1, 9), math.inf, math.inf], dtype=float)
    assert quantile(errors, 50.0).value == 5.0
    assert math.isinf(quantile(errors, 90.0).value)


def test_effects_are_those_of_a_known_function() -> None:
    """MATHS.md (165): y = exp(4 a + 2 b), c without effect: shares 4/5 and 1/5 of the variance."""
    rng = np.random.default_rng(1)
    inputs = rng.random((1024, 3))
    errors = np.exp(4 * inputs[:, 0] + 2 * inputs[:, 1])
    found = effects(["a", "b", "c"], inputs, errors, seed=1)
    assert [one.key for one in found] == ["a", "b", "c"]
    assert [one.is_noise for one in found] == [False, False, True]
    assert found[0].first_order == pytest.approx(0.8, abs=0.06)
    assert found[1].first_order == pytest.approx(0.2, abs=0.06)
    assert found[2].first_order == pytest.approx(0.0, abs=0.06)


def test_ishigami_has_its_printed_shares() -> None:
    """MATHS.md (165): T. Ishigami and T. Homma (1990): 0.314, 0.442 and 0 of the variance alone."""
    angles = np.random.default_rng(2).uniform(-np.pi, np.pi, (2048, 3))
    a, b, c = angles.T
    logs = np.sin(a) + 7 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)
    found = {one.key: one for one in effects(["a", "b", "c"], angles, np.exp(logs), seed=1)}
    assert found["a"].first_order == pytest.approx(0.314, abs=0.05)
    assert found["b"].first_order == pytest.approx(0.442, abs=0.05)
    assert found["c"].first_order == pytest.approx(0.0, abs=0.05)
    assert not any(one.is_noise for one in found.values())


def test_few_cuts_tell_nothing() -> None:
    """Nothing is said rather than something random."""
    rng = np.random.default_rng(1)
    assert effects(["a"], rng.random((63, 1)), rng.random(63), seed=1) == []
    assert effects(["a"], rng.random((100, 1)), np.ones(100), seed=1) == []
