# SPDX-License-Identifier: Apache-2.0
"""What is not known is read from V.toml, and refused where it cannot be."""

import numpy as np
import pytest
from scipy.integrate import quad

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.forecast.vary import Unknown, default_vary, read_vary
from camtools.sim.machine_file import find_machine, mistaken, read_machine
from camtools.sim.machines import names

SHARES = np.array([0.0, 0.025, 0.1, 0.5, 0.77, 0.975, 1.0])


def one(text: str, key: str = "u.delay_us") -> Unknown:
    """Return the only unknown of a V.toml with one table."""
    return read_vary(f"[{key}]\n{text}".encode(), "v.toml", {})[0]


def refusal(text: str) -> str:
    """Return the line that refuses a V.toml."""
    with pytest.raises(CamtoolsError) as error:
        read_vary(text.encode(), "v.toml", {})
    return str(error.value)


def share_below(density: object, value: float, low: float, high: float) -> float:
    """Integrate a density between its ends, as no distribution of scipy does."""
    above, below = quad(density, low, value)[0], quad(density, low, high)[0]
    return float(above / below)


def test_uniform_is_a_straight_line() -> None:
    """MATHS.md (162): equal shares between the ends."""
    unknown = one('distribution = "uniform"\nlow = 60\nhigh = 100\n')
    assert np.allclose(unknown.at(SHARES), 60 + 40 * SHARES)
    assert unknown.nominal == 75


def test_normal_is_truncated() -> None:
    """MATHS.md (162): the integral of Gauss's density between the ends gives the share back."""
    unknown = one('distribution = "normal"\nof = "nominal"\nsd = 0.1\nlow = 0.95\n')
    assert (unknown.low, unknown.high) == pytest.approx((0.95 * 75, 1.3 * 75))

    def density(value: float) -> float:
        return float(np.exp(-(((value - 75) / 7.5) ** 2) / 2))

    values: Floats = unknown.at(SHARES)
    found = [share_below(density, value, unknown.low, unknown.high) for value in values]
    assert np.allclose(found, SHARES, atol=1e-9)


def test_lognormal_has_a_median_and_a_factor() -> None:
    """MATHS.md (162): the density of a number whose logarithm is normal."""
    unknown = one('distribution = "lognormal"\nmedian = 2\nfactor = 1.5\nhigh = 6\n', "u.damping")
    assert (unknown.low, unknown.high) == pytest.approx((2 / 1.5**3, 6))

    def density(value: float) -> float:
        return float(np.exp(-((np.log(value / 2) / np.log(1.5)) ** 2) / 2) / value)

    values: Floats = unknown.at(SHARES)
    found = [share_below(density, value, unknown.low, unknown.high) for value in values]
    assert np.allclose(found, SHARES, atol=1e-9)


def test_what_is_believed_is_nominal() -> None:
    """Where the controller is told something else than the truth, the draw is around that."""
    machine = read_machine("[u]\ndelay_us = 90\n[believed.u]\ndelay_us = 80\n", "m.toml")
    text = b'[u.delay_us]\ndistribution = "normal"\nof = "nominal"\nsd = 0.05\n'
    assert read_vary(text, "v.toml", machine)[0].at(0.5) == pytest.approx(80)
    changed = mistaken(machine, {"u.delay_us": 83.0})
    assert changed["u"]["delay_us"] == 83.0
    assert changed["believed"]["u"]["delay_us"] == 80


@pytest.mark.parametrize("name", names())
def test_usual_unknowns_fit_every_machine(name: str) -> None:
    """Multiples of what a machine does not have are left out, and no other."""
    machine = find_machine(name)
    tree = read_machine(machine.text, machine.name)
    unknowns, left_out = default_vary(tree)
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


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[u\n", "v.toml: not TOML"),
        ("", "v.toml: 0 numbers to vary; give 1 .. 100"),
        ("u = 1\n", "v.toml: u = 1: not a table of a machine file; write [TABLE.KEY]"),
        ("[u]\ndelay_us = 1\n", "v.toml: u.delay_us = 1: not a table; write [u.delay_us]"),
        (
            '[u.x]\ndistribution = "uniform"\nlow = 0\nhigh = 1\n',
            "u.x: not a number of a machine file",
        ),
        ('[u.delay_us]\ndistribution = "flat"\n', "u.delay_us.distribution = 'flat'"),
        ('[u.delay_us]\ndistribution = "uniform"\nlow = 0\n', "u.delay_us.high: is missing"),
        (
            '[u.delay_us]\ndistribution = "uniform"\nlow = 0\nhigh = 1\nsd = 1\n',
            "u.delay_us.sd = 1.0: does not belong to a uniform distribution; remove it",
        ),
        (
            '[u.delay_us]\ndistribution = "uniform"\nlow = 3\nhigh = 1\n',
            "u.delay_us.low = 3.0: must be below high = 1",
        ),
        ('[u.delay_us]\ndistribution = "normal"\nsd = 0\n', "u.delay_us.sd = 0: "),
        ('[u.delay_us]\ndistribution = "normal"\nsd = inf\n', "u.delay_us.sd = inf: "),
        ('[u.delay_us]\ndistribution = "lognormal"\nfactor = 1\n', "u.delay_us.factor = 1: "),
        (
            '[u.delay_us]\ndistribution = "normal"\nsd = 1\nlow = 200\nhigh = 300\n',
            "u.delay_us: leaves 0 of the distribution between 200 and 300",
        ),
        (
            '[u.mode_hz]\ndistribution = "normal"\nof = "nominal"\nsd = 0.1\n',
            "u.mode_hz.of = 'nominal': is 0 on this machine",
        ),
        (
            '[u.delay_us]\ndistribution = "normal"\nsd = 1\nwidth = 1\n',
            "u.delay_us.width = 1: unkn",
        ),
    ],
)
def test_bad_files_are_refused_in_one_line(text: str, told: str) -> None:
    """File, field, value, remedy."""
    line = refusal(text)
    assert told in line
    assert line.startswith("v.toml: ")
    assert len(line.splitlines()) == 1
