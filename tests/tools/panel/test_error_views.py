"""Following error over the angle: scale, series that change, bounded payload."""

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camtools.panel.views.error_chart import (
    BINS,
    MOST_POINTS,
    POLAR,
    SHOWN_TURNS,
    SLOTS,
    UNROLLED,
    Scale,
    Ticks,
    Trail,
    change,
    mean_by_angle,
    recent,
    statistics,
    step_above,
    whole,
)


def samples(first_turn: int, turns: int, per_turn: int) -> Ticks:
    """Return an error of two waves a turn."""
    turn = np.arange(turns * per_turn) // per_turn
    at = np.arange(turns * per_turn) / per_turn
    return Ticks(first_turn + turn, at % 1.0, 0.1 * np.cos(4 * math.pi * at))


NO_TICKS = Ticks(*(np.array([]) for _ in range(3)))


def test_turns_that_begin_anew_leave_no_older_ones() -> None:
    """The controller counts turns from each enable on; a series is never in a change twice."""
    before, after = samples(300, 60, 6), samples(0, 3, 6)
    both = Ticks(*(np.append(getattr(before, one), getattr(after, one)) for one in vars(before)))
    assert recent(both).turn.tolist() == after.turn.tolist()
    trail = Trail()
    trail.changes(before)
    slots = [one.slot for one in trail.changes(both)]
    assert len(slots) == len(set(slots)) and all(0 <= slot < SLOTS for slot in slots)


@given(st.floats(1e-9, 1e9))
def test_the_step_above_is_1_2_or_5_and_not_too_large(value: float) -> None:
    """At most two and a half times the value."""
    step = step_above(value)
    mantissa = float(f"{step:.3e}".split("e")[0])
    assert mantissa in (1.0, 2.0, 5.0)
    assert value * (1 - 1e-6) <= step <= 2.5 * value * (1 + 1e-6)


def test_a_peak_that_wavers_about_a_step_does_not_move_the_scale() -> None:
    """Up at once, down only when it has been smaller for a while."""
    scale = Scale(0.1)
    wavering = [scale.follow(0.19 if i % 2 else 0.17) for i in range(200)]
    assert set(wavering) == {0.2}
    assert scale.follow(0.21) == 0.5
    down = [scale.follow(0.1) for _ in range(60)]
    assert down[0] == 0.5 and down[-1] == 0.2 and down.index(0.2) >= 20
    assert scale.follow(float("nan")) == 0.2


def test_only_what_is_new_is_told() -> None:
    """A second look at the same samples tells nothing, one more turn only its own series."""
    trail = Trail()
    assert len(trail.changes(samples(0, 50, 24))) == 10
    assert trail.changes(samples(0, 50, 24)) == []
    more = trail.changes(samples(0, 52, 24))
    assert [one.slot for one in more if one.points] == [10], "the eleventh series begins"
    assert [one.age for one in more if one.points is None] == list(range(9, 0, -1)) or len(more) > 1


def test_turns_that_are_too_old_leave() -> None:
    """The chart has the last 50 turns and no others, whatever was told before."""
    trail, drawn = Trail(), {}
    for first in range(0, 400, 7):
        for one in trail.changes(samples(first, 60, 6)):
            if one.points is not None:
                drawn[one.slot] = len(one.points)
    assert len(recent(samples(0, 60, 6)).turn) == SHOWN_TURNS * 6
    assert sum(drawn.values()) <= (SHOWN_TURNS + 5) * 6
    trail.changes(NO_TICKS)
    assert set(drawn) == set(range(SLOTS))


def test_statistics_are_those_of_the_wave() -> None:
    """A wave of amplitude a has the rms a / sqrt 2."""
    told = statistics(samples(3, 50, 100))
    assert told.max_um == pytest.approx(0.1) and told.turns == 50 and told.samples == 5000
    assert told.rms_um == pytest.approx(0.1 / math.sqrt(2))
    empty = statistics(NO_TICKS)
    assert empty.samples == 0 and math.isnan(empty.max_um)


def test_the_mean_has_a_gap_where_nothing_was_seen() -> None:
    """None, not zero: nobody takes what was not measured for good."""
    told = mean_by_angle(Ticks(np.array([1, 1]), np.array([0.0, 0.999999]), np.array([2.0, 4.0])))
    assert told == [[2.5, 2.0], [355.0, None], [357.5, 4.0]]


def test_the_mean_is_joined_where_samples_are_close() -> None:
    """Single ticks of a steady spindle meet few angles; every third part has one."""
    at = np.arange(0, BINS, 3) / BINS
    told = mean_by_angle(Ticks(np.ones(len(at), dtype=np.int64), at, np.full(len(at), 0.5)))
    assert [mean for _, mean in told] == [0.5] * (BINS // 3)


@pytest.mark.parametrize("kind", [UNROLLED, POLAR])
def test_a_tolerance_beyond_the_scale_is_not_drawn(kind: str) -> None:
    """On the polar axis it would come out on the other side of the centre."""
    for full_um, is_drawn in ((1.0, False), (5.0, True)):
        lines = {one["id"]: one["data"] for one in change(kind, [], [], (full_um, 2.0))["series"]}
        assert [bool(lines[name]) for name in ("limit-high", "limit-low")] == [is_drawn] * 2


@pytest.mark.parametrize("kind", [UNROLLED, POLAR])
def test_an_update_stays_small(kind: str) -> None:
    """Bounded by the points of all series, however many samples come."""
    trail = Trail()
    flood = samples(0, 50, 2000)
    first = trail.changes(flood)
    assert all(len(one.points or []) <= MOST_POINTS for one in first)
    option = change(kind, first, mean_by_angle(flood), (0.2, 5.0))
    assert len(json.dumps(option)) < 250_000
    steady = change(kind, trail.changes(samples(0, 50, 2000)), mean_by_angle(flood))
    assert len(json.dumps(steady)) < 5_000


@pytest.mark.parametrize("kind", [UNROLLED, POLAR])
def test_an_update_speaks_of_series_that_the_chart_has(kind: str) -> None:
    """Otherwise ECharts would add series without a look."""
    ids = {one["id"] for one in whole(kind, 0.1, 5.0)["series"]}
    turns = samples(0, 50, 8)
    option: dict[str, Any] = change(kind, Trail().changes(turns), mean_by_angle(turns), (0.1, 2.0))
    assert {one["id"] for one in option["series"]} <= ids
