"""What is not known: read from V.toml, drawn evenly, judged by statistics with printed values."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import scipy
from scipy.integrate import quad

from camtools.base.quantities import Floats
from camtools.forecast.result import effects, quantile, share_within
from camtools.forecast.vary import Unknown, default_vary, draw, read_vary
from camtools.sim.machine_file import find_machine, mistaken, names, read_machine
from tests.tools.cases.part_cases import refused

SHARES = np.array([0.0, 0.025, 0.1, 0.5, 0.77, 0.975, 1.0])


def one(text: str, key: str = "u.delay_us") -> Unknown:
    """Return the only unknown of a V.toml with one table."""
    return read_vary(f"[{key}]\n{text}".encode(), "v.toml", {})[0]


def refusal(text: str) -> str:
    """Return the line that refuses a V.toml."""
    return refused(lambda: read_vary(text.encode(), "v.toml", {}))


def gauss(value: float) -> float:
    """Return the density of a normal number about 75 with a deviation of 7.5."""
    return float(np.exp(-(((value - 75) / 7.5) ** 2) / 2))


def log_gauss(value: float) -> float:
    """Return the density of a number whose logarithm is normal: median 2, factor 1.5."""
    return float(np.exp(-((np.log(value / 2) / np.log(1.5)) ** 2) / 2) / value)


@pytest.mark.parametrize(
    ("text", "key", "ends", "density"),
    [
        ('"uniform"\nlow = 60\nhigh = 100', "u.delay_us", (60, 100), lambda _: 1.0),
        ('"normal"\nof = "nominal"\nsd = 0.1\nlow = 0.95', "u.delay_us", (71.25, 97.5), gauss),
        ('"lognormal"\nmedian = 2\nfactor = 1.5\nhigh = 6', "u.damping", (16 / 27, 6), log_gauss),
    ],
)
def test_shares_are_those_of_the_truncated_density(
    text: str, key: str, ends: tuple[float, float], density: Callable[[float], float]
) -> None:
    """MATHS.md (162): the integral of the density between the ends gives the share back."""
    unknown = one(f"distribution = {text}\n", key)
    assert (unknown.low, unknown.high) == pytest.approx(ends)
    values: Floats = unknown.at(SHARES)
    whole = quad(density, unknown.low, unknown.high)[0]
    found = [quad(density, unknown.low, value)[0] / whole for value in values]
    assert np.allclose(found, SHARES, atol=1e-9)


def test_what_is_believed_is_nominal() -> None:
    """Where the controller is told something else than the truth, the draw is around that."""
    machine = read_machine("[u]\ndelay_us = 90\n[believed.u]\ndelay_us = 80\n", "m.toml")
    text = b'[u.delay_us]\ndistribution = "normal"\nof = "nominal"\nsd = 0.05\n'
    assert read_vary(text, "v.toml", machine)[0].at(0.5) == pytest.approx(80)
    changed = mistaken(machine, {"u.delay_us": 83.0})
    assert changed["u"]["delay_us"] == 83.0
    assert changed["believed"]["u"]["delay_us"] == 80


def test_usual_unknowns_fit_every_machine() -> None:
    """Multiples of what a machine does not have are left out, and no other."""
    for name in names():
        machine = find_machine(name)
        unknowns, left_out = default_vary(read_machine(machine.text, machine.name))
        assert len(unknowns) + len(left_out) == 20
        assert set(left_out) <= {"u.mode_hz"}
        assert all(one.low < one.high for one in unknowns)


@pytest.mark.parametrize(
    ("key", "stated"), [("u.scale_latency_us", 3.6), ("encoder.eccentricity_counts", 0.5)]
)
def test_usual_errors_of_scale_and_encoder_are_around_what_is_stated(
    key: str, stated: float
) -> None:
    """A machine file that states them keeps them within its deviation; others have small ones."""
    real = find_machine("real")
    for tree, value in ((read_machine(real.text, real.name), stated), ({}, 0.0)):
        drawn = next(one for one in default_vary(tree)[0] if one.key == key)
        least, most = drawn.at(np.array([0.01, 0.99]))
        assert max(0.0, value - 0.75) <= least <= value + 0.01 < most <= value + 0.75


LATE = "[u.delay_us]\ndistribution = "


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[u\n", "v.toml: not TOML"),
        ("", "v.toml: 0 numbers to vary; give 1 .. 100"),
        ("u = 1\n", "v.toml: u: not a table of a machine file; write [TABLE.KEY]"),
        ("[u]\ndelay_us = 1\n", "v.toml: u.delay_us: not a table; write [u.delay_us]"),
        ('[u.x]\ndistribution = "uniform"\nlow = 0\nhigh = 1\n', "u.x: not a number of a machine"),
        (LATE + '"flat"\n', "u.delay_us.distribution = 'flat'"),
        (LATE + '"uniform"\nlow = 0\n', "u.delay_us.high: is missing"),
        (LATE + '"uniform"\nlow = 0\nhigh = 1\nsd = 1\n', "u.delay_us.sd = 1.0: does not belong"),
        (LATE + '"uniform"\nlow = 3\nhigh = 1\n', "u.delay_us.low = 3.0: must be below high = 1"),
        (LATE + '"normal"\nsd = 0\n', "u.delay_us.sd = 0: "),
        (LATE + '"normal"\nsd = inf\n', "u.delay_us.sd = inf: "),
        (LATE + '"lognormal"\nfactor = 1\n', "u.delay_us.factor = 1: "),
        (LATE + '"normal"\nsd = 1\nlow = 200\nhigh = 300\n', "leaves 0 of the distribution"),
        (LATE.replace("delay_us", "mode_hz") + '"normal"\nof = "nominal"\nsd = 0.1\n',
         "u.mode_hz.of = 'nominal': is 0 on this machine"),
        (LATE + '"normal"\nsd = 1\nwidth = 1\n', "u.delay_us.width: unkn"),
    ],
)  # fmt: skip
def test_bad_files_are_refused_in_one_line(text: str, told: str) -> None:
    """File, field, value, remedy."""
    line = refusal(text)
    assert told in line
    assert line.startswith("v.toml: ")


KEYS = ("bandwidth_hz", "damping", "delay_us", "friction_m_per_s2", "mass_kg", "scale_error_nm")
TEXT = "".join(f'[u.{key}]\ndistribution = "uniform"\nlow = 1\nhigh = 2\n' for key in KEYS)
UNKNOWNS = read_vary(TEXT.encode(), "v.toml", {})


def test_draw_is_even_and_grows() -> None:
    """MATHS.md (162): more runs add to those that are there, evenly."""
    assert np.array_equal(draw(UNKNOWNS, 100, seed=3), draw(UNKNOWNS, 300, seed=3)[:100])
    assert not np.array_equal(draw(UNKNOWNS, 100, seed=3), draw(UNKNOWNS, 100, seed=4))
    drawn = draw(UNKNOWNS, 1024, seed=1) - 1
    for column in drawn.T:
        assert scipy.stats.kstest(column, "uniform").statistic < 0.002
    assert np.abs(np.corrcoef(drawn.T) - np.eye(len(KEYS))).max() < 0.02


def test_independent_machines_are_not_even() -> None:
    """MATHS.md (168): the mean of n uniform numbers spreads by 1/sqrt(12 n), and a draw grows."""
    drawn = [draw(UNKNOWNS, 64, seed=seed, is_independent=True) - 1 for seed in range(50)]
    assert np.array_equal(draw(UNKNOWNS, 9, seed=3, is_independent=True) - 1, drawn[3][:9])
    spread = np.std([one.mean(axis=0) for one in drawn])
    assert spread * np.sqrt(12 * 64) == pytest.approx(1, abs=0.15)


def sum_of(drawn: Floats) -> Floats:
    """Return a known function of a draw: the sum of six uniform numbers."""
    return np.asarray((drawn - 1).sum(axis=1))


def test_interval_of_the_share_holds() -> None:
    """MATHS.md (164): in 95 % of all seeds or more the true share lies within."""
    limit = 4.0
    # Irwin and Hall: the sum of six uniform numbers is below 4 with the probability
    true = (4**6 - 6 * 3**6 + 15 * 2**6 - 20) / 720
    hits = 0
    for seed in range(100):
        found = sum_of(draw(UNKNOWNS, 128, seed=seed))
        share = share_within(int((found <= limit).sum()), found.size)
        hits += share.low <= true <= share.high
    assert hits >= 97


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
    """MATHS.md (163): of 1000 samples of a known distribution 95 % or more hold the quantile."""
    rng = np.random.default_rng(5)
    for percent in (50.0, 95.0):
        true = float(scipy.stats.expon.ppf(percent / 100))
        held = 0
        for _ in range(1000):
            one = quantile(rng.exponential(size=100), percent)
            held += one.low <= true <= one.high
            assert one.low <= one.value <= one.high
        assert held >= 0.94 * 1000


def test_small_and_failed_samples() -> None:
    """MATHS.md (163): of 10 cuts nothing bounds the 99 % quantile; few cuts have no effects."""
    one = quantile(np.arange(1.0, 11.0), 99.0)
    assert one.value == 10.0
    assert math.isinf(one.high)
    assert quantile(np.array([3.0]), 50.0) == (50.0, 3.0, 0.0, math.inf)
    errors = np.array([*range(1, 9), math.inf, math.inf], dtype=float)
    assert quantile(errors, 50.0).value == 5.0
    assert math.isinf(quantile(errors, 90.0).value)
    rng = np.random.default_rng(1)
    assert effects(["a"], rng.random((63, 1)), rng.random(63), seed=1) == []
    assert effects(["a"], rng.random((100, 1)), np.ones(100), seed=1) == []


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
