"""Samples of single ticks: what the frames say, against the recorder and against cantools."""

import itertools
import math
import time
from fractions import Fraction

import can
import numpy as np
import pytest

from camtools.link import scope
from camtools.link.controller import Link
from camtools.link.messages import DATABASE, Refused
from camtools.link.strobe import Samples, Strobe, best_every
from checks.patience import limit_s
from tests.tools.cases.camctl_bench import Bench

MESSAGE = DATABASE.get_message_by_name("Strobe")
TICK_HZ = 20000


def a_link() -> Link:
    """Return a link that nobody answers."""
    return Link(can.Bus(interface="virtual", channel="nobody"), "nobody")


def until_there(link: Link, strobe: Strobe, n: int) -> Samples:
    """Take frames until so many samples are there."""
    assert link.wait(lambda: len(strobe.samples().tick) >= n, limit_s())
    return strobe.samples()


def frame(number: int, pos_q16: int, error_nm: int = 0, state: int = 4, flags: int = 1) -> bytes:
    """Return the bytes of a message as the DBC has them."""
    return MESSAGE.encode(
        {
            "number": number % 256,
            "angle": pos_q16 % 65536,
            "turn": (pos_q16 >> 16) % 256,
            "error": error_nm,
            "state": state,
            "is_synced": flags & 1,
            "is_saturated": flags >> 1,
        },
        scaling=False,
    )


def fed(frames: list[bytes], most: int = 6000, most_turns: int = 50) -> Samples:
    """Return what frames become that come one behind the other."""
    link = a_link()
    strobe = Strobe(link, most, most_turns)
    for data in frames:
        link.on_strobe(data)
    link.bus.shutdown()
    return strobe.samples()


def test_frames_say_what_the_dbc_says() -> None:
    """Numbers, turns and angles count on over their wraps, in both senses; errors have a sign."""
    places = [(k, 250 * 65536 + 1234 + 70000 * k) for k in range(300)]
    places += [(300 + k, places[-1][1] - 30000 * k) for k in range(100)]
    made = fed([frame(k, at, -8388608 + 40000 * k, k % 11, k % 4) for k, at in places], 500, 9999)
    told = np.array(places)
    place = made.turn + made.angle_turn
    assert np.array_equal(np.diff(place), np.diff(told[:, 1]) / 65536)
    assert made.angle_turn[0] == 1234 / 65536
    assert made.angle_turn.min() >= 0 and made.angle_turn.max() < 1
    assert np.array_equal(made.error_um, (-8388608 + 40000 * told[:, 0]) / 1000)
    assert np.array_equal(made.state, told[:, 0] % 11)
    assert np.array_equal(made.is_synced, told[:, 0] % 2 == 1)
    assert np.array_equal(made.is_saturated, told[:, 0] // 2 % 2 == 1)
    assert made.n_lost == 0


def test_lost_samples_are_counted_and_old_ones_forgotten() -> None:
    """A gap in the numbers is told; what is more than some turns or samples ago is gone."""
    assert fed([frame(k, 0) for k in (250, 251, 255, 3, 4)]).n_lost == 6
    assert fed([]).tick.shape == (0,)
    made = fed([frame(k, 655 * k) for k in range(1000)], most_turns=5)
    assert 499 <= len(made.tick) <= 501
    made = fed([frame(k, 10 * k) for k in range(1000)], most=100)
    assert np.array_equal(made.angle_turn, 10 * np.arange(900, 1000) / 65536)


@pytest.mark.parametrize(
    "rpm", [60.0, 300.0, 997.0, 1000.0, 1200.0, 1500.0, 2400.0, 3000.0, 6000.0]
)
def test_the_period_fills_the_turn(rpm: float) -> None:
    """Counted in whole numbers: more than half of 256 sectors of the turn are met in a second."""
    every = best_every(TICK_HZ, rpm)
    assert 40 <= every <= 60
    assert best_every(TICK_HZ, -rpm) == every
    step = every * round(rpm * 1000)  # of a turn, in 1 / (60 000 ticks a second)
    met = {256 * (k * step % (60000 * TICK_HZ)) // (60000 * TICK_HZ) for k in range(400)}
    assert len(met) > 128
    assert math.gcd(step, 60000 * TICK_HZ) * 160 <= 60000 * TICK_HZ


def test_forty_ticks_meet_thirty_angles_at_1000_rpm() -> None:
    """MATHS.md (191) and (193): the fastest period would be blind, 43 leaves gaps of 0.0055."""
    fastest = {Fraction(k * 1000 * 40, 60 * TICK_HZ) % 1 for k in range(4000)}
    assert len(fastest) == 30
    assert best_every(TICK_HZ, 1000.0) == 43
    gaps = [
        float(max(b - a for a, b in itertools.pairwise([*angles, angles[0] + 1])))
        for e in (-1, -Fraction(1, 2), 0, Fraction(1, 2), 1)
        if (angles := sorted(Fraction(43 * k, 1200) * (1 + e / 1000) % 1 for k in range(400)))
    ]
    assert f"{max(gaps):.4f}" == "0.0055"


def test_samples_are_what_the_recorder_has(bench: Bench, link: Link) -> None:
    """Angle, turn, error and state of the very same ticks; both run side by side."""
    bench.do("home")
    strobe = Strobe(link)
    speed_rpm = link.listen().signals["speed"]
    strobe.follow()
    assert strobe.every == best_every(TICK_HZ, speed_rpm)
    signals = ("angle_q32", "state", "turn", "u_actual_nm", "u_due_q6")
    scope.configure(link, signals, 1, 4000)
    assert link.ask("start").result == "done"
    until_there(link, strobe, 20)
    scope.start(link)
    scope.wait(link, limit_s())
    made = strobe.samples()
    assert made.n_lost == 0
    recording = scope.read(link)  # meanwhile fewer are sent
    assert strobe.samples().n_lost > 0
    strobe.end()
    place = made.turn * 65536 + np.round(made.angle_turn * 65536).astype(np.int64)
    rows = (recording["turn"] % 256 << 16) + (recording["angle_q32"] % 2**32 >> 16)
    first, at = next(
        (i, int(np.flatnonzero(rows == p)[0])) for i, p in enumerate(place % 2**24) if p in rows
    )
    row = at + made.tick - made.tick[first]
    is_there = (row >= 0) & (row < len(rows))
    assert np.count_nonzero(is_there) >= 60
    row = row[is_there]
    assert np.array_equal(place[is_there] % 2**24, rows[row])
    assert np.array_equal(made.state[is_there], recording["state"][row])
    error_nm = recording["u_actual_nm"] - (recording["u_due_q6"] >> 6)
    assert np.array_equal(np.round(made.error_um[is_there] * 1000), error_nm[row])
    assert made.is_synced.all() and not made.is_saturated.any()


@pytest.mark.long
def test_it_is_renewed_as_long_as_frames_are_read_and_then_ends(link: Link) -> None:
    """No more samples 2 s after the last frame was read, and all of them while one reads."""
    strobe = Strobe(link)
    link.listen()
    strobe.begin(400)
    until_there(link, strobe, 150)  # after 2 s without renewal there would be 100
    strobe.every = 0  # as a program that has died
    assert link.wait_in_its_time(lambda: time.monotonic() - strobe.last_s > 0.5, limit_s())


def test_what_is_wrong_is_told_in_a_line(link: Link) -> None:
    """The range, and a controller that does not know the command."""
    strobe = Strobe(link)
    with pytest.raises(Refused, match=r"every 39 ticks: out of range; give 40 \.\. 20000"):
        strobe.begin(39)
    assert strobe.every == 0
