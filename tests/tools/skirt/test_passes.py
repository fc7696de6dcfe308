# SPDX-License-Identifier: Apache-2.0
"""Passes and feed against height of a part file: what is refused, what the table holds."""

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import quad, solve_ivp

from camtools.base.errors import CamtoolsError
from camtools.part.passes import FeedLaw
from camtools.skirt.part.part_file import SkirtPart, example_part
from camtools.skirt.table.generate import generate
from camtools.skirt.tool.feed_law import TOLERANCE_NM, height_at_mm, largest_share, way_channel
from camtools.table.channel import ImageError
from camtools.table.evaluate import evaluate_x
from camtools.table.image import pack, unpack

LAW = {"height_mm": [0.0, 10.0, 50.0, 62.0], "feed_mm": [0.05, 0.15, 0.15, 0.08]}
PASSES = [
    {"allowance_um": 60.0, "feed_mm": 0.3, "spindle_rpm": 1000.0},
    {"allowance_um": 10.0},
    {"allowance_um": 0.0, "feed_mm": 0.08},
]


def part_with(**process: object) -> SkirtPart:
    """Return the example with other keys of [process]; None takes one away."""
    raw = example_part().model_dump()
    wanted = raw["process"] | process
    raw["process"] = {key: value for key, value in wanted.items() if value is not None}
    return SkirtPart.model_validate(raw)


def test_records_are_the_passes() -> None:
    """Feed and speed that a pass leaves out are those of the process; the header has the last."""
    table = generate(part_with(**{"pass": PASSES, "passes": None})).table
    assert [tuple(one) for one in table.passes] == [
        (60_000, 300_000, 1_000_000),
        (10_000, 100_000, 2_500_000),
        (0, 80_000, 2_500_000),
    ]
    assert (table.feed_nm, table.spindle_mrpm) == (80_000, 2_500_000)
    image = pack(table)
    assert image[12:16] == b"\x01\x00\x01\x00"
    assert unpack(image).passes == table.passes


def test_part_without_stays_version_1_0() -> None:
    """Neither passes nor law change an image that has none."""
    assert pack(generate(example_part()).table)[12:16] == b"\x01\x00\x00\x00"


@pytest.mark.parametrize(
    ("stock", "told"),
    [
        ([120.0, 0.0], "leaves 120 um of 100 um"),
        ([50.0, 50.0, 0.0], "number 2 leaves 50 um of 50 um"),
        ([50.0, 20.0], "last one leaves 20 um"),
    ],
)
def test_stock_must_fall_to_the_drawing(stock: list[float], told: str) -> None:
    """A pass without depth, or a last one that leaves stock, is refused."""
    passes = [{"allowance_um": one} for one in stock]
    with pytest.raises(ValidationError, match=told):
        part_with(**{"pass": passes, "passes": None})


def test_equal_volume_is_refused_with_passes() -> None:
    """One law of the speed is made for one depth."""
    with pytest.raises(ValidationError, match="constant spindle speed"):
        part_with(**{"pass": PASSES, "passes": None, "mode": "equal-volume", "spindle_rpm": 100})


def test_infeasible_pass_is_named() -> None:
    """The speed of the second pass is beyond the machine."""
    passes = [PASSES[0], PASSES[1] | {"spindle_rpm": 3500.0}, PASSES[2]]
    with pytest.raises(CamtoolsError) as refused:
        generate(part_with(**{"pass": passes, "passes": None}))
    assert "process.pass number 2: machine.limits.spindle_rpm" in str(refused.value)


def test_mean_feed_is_height_over_turns() -> None:
    """By quadrature of 1 / f over the heights, run-in included."""
    part = part_with(feed_law=LAW, feed_mm=None, run_in_mm=2.0)
    law = FeedLaw(**LAW)
    turns = quad(lambda z: 1 / float(law.at_mm(np.array(z))), -2, 62, points=[0, 10, 50])[0]
    assert part.process.feed_mm == pytest.approx(64 / turns, rel=1e-8)


def test_way_is_the_solution_of_its_equation() -> None:
    """Z over the turns by Runge-Kutta of dZ/dt = f(Z), MATHS.md (103)."""
    law, ends = FeedLaw(**LAW), (0.0, 62.0)
    mean = law.mean_mm(*ends)
    turns = np.linspace(0, 62 / mean, 300)
    found = solve_ivp(
        lambda _, z: law.at_mm(z), (0, turns[-1]), [0.0], t_eval=turns, rtol=1e-11, atol=1e-12
    )
    assert height_at_mm(law, ends, mean * turns)[:-1] == pytest.approx(found.y[0][:-1], abs=1e-6)
    channel = way_channel(law, (0, 62_000_000))
    z_nm = np.minimum(mean * turns * 1e6, 62e6)
    ahead = evaluate_x(channel, z_nm).value
    assert np.abs(ahead + z_nm - found.y[0] * 1e6).max() < TOLERANCE_NM + 2
    assert largest_share(channel) == pytest.approx(0.15 / mean, rel=1e-3)


def test_table_with_a_way_is_accepted_and_checked() -> None:
    """The image is of version 1.1; a way that turns back or does not end at 0 is refused."""
    table = generate(part_with(feed_law=LAW, feed_mm=None)).table
    image = pack(table)
    assert image[12:16] == b"\x01\x00\x01\x00"
    assert unpack(image).way is not None
    way = table.way
    assert way is not None
    for place, column in ((-1, 0), (3, 1)):
        knots = way.knots.copy()
        knots[place, 0, column] -= way.v_max * (1 if column == 0 else 3)
        low, high = int(knots[..., 0].min()), int(knots[..., 0].max())
        wrong = replace(way, knots=knots, p_min=low, p_max=high, v_max=3 * way.v_max + 1)
        with pytest.raises(ImageError):
            unpack(pack(replace(table, channels=(*table.channels[:-1], wrong))))


def test_law_beside_a_feed_is_refused() -> None:
    """The mean of the law is the feed, so there is one of the two."""
    with pytest.raises(ValidationError, match="cannot be combined"):
        part_with(feed_law=LAW)
    with pytest.raises(ValidationError, match="helix"):
        part_with(feed_law=LAW, feed_mm=None, path="ring-helix")


def test_feed_far_below_its_mean_is_refused() -> None:
    """Z would nearly stand."""
    with pytest.raises(CamtoolsError, match="nearer together"):
        way_channel(FeedLaw(height_mm=[0.0, 1.0, 60.0], feed_mm=[0.0001, 0.5, 0.5]), (0, 62000000))
