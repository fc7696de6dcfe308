"""Progress, load and convergence from the status: also what is not known, and says so."""

import itertools

import pytest

from camtools.link.controller import Link
from camtools.link.lessons import Convergence
from camtools.link.messages import NUMBERS
from camtools.link.status_text import cut_progress, tick_load

CUT = {"has_end": 1.0, "turns_left": 300.0, "turns_whole": 400.0, "pass_speed": 600.0}


def test_a_cut_tells_share_and_time() -> None:
    """30 s at 600 r/min for 300 turns, a quarter of which is over."""
    now = cut_progress("cutting", CUT)
    assert (now.fraction, now.left_s, now.text) == (0.25, 30.0, "25 %, 0:30 left")
    two = cut_progress("engaging", CUT | {"pass": 1, "passes": 2})
    assert two.text == "pass 1 of 2: 25 %, 0:30 left"
    ready = cut_progress("ready", CUT | {"turns_left": 400.0, "pass": 2, "passes": 2})
    assert (ready.fraction, ready.text) == (0.0, "next pass 2 of 2: 0:40")


@pytest.mark.parametrize("more", [{}, {"is_held": 1.0}])
def test_a_hold_says_that_the_time_stands(more: dict[str, float]) -> None:
    """In holding, and on the way to it."""
    state = "cutting" if more else "holding"
    assert cut_progress(state, CUT | more).text == "25 %, held, 0:30 left after resume"


@pytest.mark.parametrize(
    ("state", "signals", "text"),
    [
        (
            "cutting",
            {"has_end": 0.0, "pass_speed": 500.0},
            "Z is moved by another controller: only a stop",
        ),
        ("ready", {"has_end": 0.0, "pass_speed": 0.0}, "no table"),
        ("fault", CUT, "no cut"),
        ("off", CUT, "no cut"),
        ("unknown", {}, "no cut"),
        ("cutting", {}, "the controller does not report"),
        ("cutting", {"has_end": 1.0, "pass_speed": 500.0}, "the controller does not report"),
    ],
)
def test_what_is_not_known_is_not_guessed(state: str, signals: dict[str, float], text: str) -> None:
    """Neither a share nor a time."""
    now = cut_progress(state, signals)
    assert now.fraction is None and now.left_s is None
    assert now.text.startswith(text)


def test_a_share_stays_within_its_bounds() -> None:
    """Whatever rounding does; without a speed there is no time."""
    assert cut_progress("cutting", CUT | {"turns_left": 401.0}).fraction == 0.0
    standing = cut_progress("cutting", CUT | {"pass_speed": 0.0})
    assert standing.left_s is None and standing.text == "25 %, unknown time left"
    assert cut_progress("cutting", CUT | {"turns_whole": 0.0}).fraction is None


def test_the_load_is_a_share_of_the_period() -> None:
    """Also where nothing is measured, or not yet told."""
    assert tick_load({"tick_time_max": 25.0, "tick_rate": 10000.0}).share == 0.25
    assert tick_load({"tick_time_max": 25.0}).text == "unknown"
    assert tick_load({}).share is None


def test_lessons_are_bounded_and_begin_anew() -> None:
    """A new rehearsal counts from the beginning; the newest pair of a turn stands."""
    seen = Convergence(most=3)
    seen.add({"learn_turns": 5.0})
    assert seen.lessons() == []
    for turn, more in itertools.product(range(6), (0.5, 0.0)):
        seen.add({"learn_turns": turn, "learn_error": 10.0 - turn + more})
    assert seen.lessons() == [(3, 7.0), (4, 6.0), (5, 5.0)]
    seen.add({"learn_turns": 1.0, "learn_error": 9.0})
    assert seen.lessons() == [(1, 9.0)]


def test_the_controller_tells_all_of_it(link: Link) -> None:
    """Before the first order: the next pass, its time, and a port that measures no interrupt."""
    signals = link.listen().signals
    now = cut_progress("ready", signals)
    index = NUMBERS["parameter"]["spindle_mrpm"]
    assert link.ask("get_parameter", parameter=index).value == 0  # so that of the table holds
    assert signals["pass_speed"] == 2500.0
    assert now.left_s == pytest.approx(signals["turns_left"] * 60 / 2500)
    assert now.fraction == 0.0
    assert tick_load(signals).text == "the port does not measure it"
