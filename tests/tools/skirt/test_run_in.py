# SPDX-License-Identifier: Apache-2.0
"""Curves continued beyond their ends, and the middle of U."""

import numpy as np
import pytest
from scipy.interpolate import PPoly

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.skirt.geometry.run_in import continued, with_run
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.part.part_file import SkirtPart, example_part
from camtools.skirt.table.generate import generate
from camtools.skirt.tool.u_zero import middle_nm


def part_with(**process: object) -> SkirtPart:
    """Return the example with other keys of [process]."""
    raw = example_part().model_dump()
    raw["process"] |= process
    return SkirtPart.model_validate(raw)


def test_curve_and_its_two_derivatives_go_on() -> None:
    """At both ends of random cubics value, slope and curvature have no jump, inside all is kept."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        x = np.sort(rng.uniform(0, 50, 5))
        curve = PPoly(rng.normal(0, 0.01, (4, 4)), x)
        curve.c[3] = 40 + rng.uniform(0, 1, 4)
        runs = rng.uniform(0.5, 5, 2)
        air = continued(curve, (x[0], x[-1]), list(runs))
        inside = rng.uniform(x[0], x[-1], 50)
        assert air(inside) == pytest.approx(curve(inside), abs=1e-11)
        for end, side in ((x[0], -1), (x[-1], 1)):
            for nu in range(3):
                near = float(air(end + side * 1e-9, nu=nu))
                assert near == pytest.approx(float(curve(end, nu=nu)), abs=1e-7)
        assert air(x[0] - runs[0], nu=2) == pytest.approx(0, abs=1e-9)
        assert air(x[-1] + runs[1], nu=2) == pytest.approx(0, abs=1e-9)


def test_run_follows_its_formula() -> None:
    """MATHS.md (102) at a distance below the lower and above the upper end."""
    curve = PPoly(np.array([[0.001], [-0.02], [0.03], [45.0]]), np.array([0.0, 20.0]))
    air = continued(curve, (0.0, 20.0), [4.0, 3.0])
    d = -2.5
    assert air(d) == pytest.approx(45 + 0.03 * d - 0.04 * (d**2 / 2 + d**3 / 24), abs=1e-12)
    f0, f1, f2 = (float(curve(20.0, nu=n)) for n in range(3))
    d = 1.5
    assert air(20 + d) == pytest.approx(f0 + f1 * d + f2 * (d**2 / 2 - d**3 / 18), abs=1e-10)


def test_ovality_never_falls_below_zero() -> None:
    """An ovality that ends at 0.01 mm on a steep slope stays there."""
    curve = PPoly(np.array([[0.05], [0.01]]), np.array([0.0, 2.0]))
    air = continued(curve, (0.0, 2.0), [3.0, 1.0], is_ovality=True)
    assert float(air(-3.0)) == pytest.approx(0.01)
    assert float(air(3.0)) == pytest.approx(0.16)


def test_half_axis_that_vanishes_is_refused() -> None:
    """A cone of 1 : 1 has no radius 60 mm below its end."""
    raw = example_part().model_dump()
    raw["piston"]["profile"] = {
        "height_mm": [0, 10, 20], "diameter_mm": [60, 80, 100], "spline": "natural"
    }  # fmt: skip
    raw["piston"]["ovality"]["height_mm"] = [0, 10, 20]
    geometry = make_geometry(SkirtPart.model_validate(raw))
    assert with_run(geometry, 5.0, 0.0).z_first_mm == -5.0
    with pytest.raises(GeometryError, match="run_in_mm"):
        with_run(geometry, 60.0, 0.0)


def test_table_reaches_over_the_runs_and_keeps_its_error() -> None:
    """The table of a part with runs covers them, and the skirt is that without."""
    plain, run = generate(part_with()), generate(part_with(run_in_mm=3.0, run_out_mm=1.5))
    assert (run.table.z_first_nm, run.table.z_last_nm) == (-3_000_000, 63_500_000)
    assert run.accuracy_u.value_nm <= 1
    assert run.accuracy_x.value_nm <= 1
    assert run.geometry.skirt_mm == plain.geometry.skirt_mm == (0.0, 62.0)
    z = np.linspace(0, 62, 101)
    assert run.geometry.radius_mm(z) == pytest.approx(plain.geometry.radius_mm(z), abs=0)


def test_feed_may_be_as_long_as_part_and_runs() -> None:
    """The firmware needs a turn over all that is fed."""
    assert part_with(run_in_mm=3.0, run_out_mm=1.5).height_mm == 66.5


def test_knots_are_the_same_about_the_mean() -> None:
    """Only the offsets of both channels differ, by the middle of the reduction."""
    long, mean = generate(part_with()), generate(part_with(u_zero="mean"))
    middle = middle_nm(mean.geometry, "mean")
    assert middle == pytest.approx(75_000, abs=1)
    for one, other in zip(long.table.channels, mean.table.channels, strict=True):
        assert np.array_equal(one.knots, other.knots)
        assert one.value_offset - other.value_offset == middle
    bounds = mean.table.bounds
    assert bounds.u_max_nm == pytest.approx(-bounds.u_min_nm, abs=3)


def test_stroke_of_half_the_part_needs_the_mean() -> None:
    """0.15 mm of travel on 0.16 mm: refused about the long axis, with the remedy."""
    raw = part_with().model_dump()
    raw["machine"]["limits"]["u_stroke_mm"] = 0.16
    with pytest.raises(CamtoolsError) as refused:
        generate(SkirtPart.model_validate(raw))
    assert 'u_zero = "mean", which needs 0.15' in str(refused.value)
    raw["process"]["u_zero"] = "mean"
    assert generate(SkirtPart.model_validate(raw)).table.limits.u_stroke_nm == 160_000
