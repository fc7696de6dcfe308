"""What a report says of learning, and its picture of convergence."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from camtools.base.quantities import Floats
from camtools.plots.style import drawing, png_of
from camtools.report import motion
from camtools.report.learning import convergence, draw_convergence
from camtools.report.learning_text import learning_rows, numbers_text
from camtools.sim.results import STATES, CutTrace
from tests.tools.cases.report_cases import made_up_summary

LEARNED: dict[str, Any] = {
    "is_on": True,
    "phase": "cutting",
    "reason": "all",
    "turns": 40,
    "masked": [7, 8, 9, 16],
    "k1_ns": 7738,
    "k2_us2": -93638,
    "friction_nm": -120,
    "chip_nm_per_mm2": 34500,
    "begin_error_um": 10.05,
    "error_um": 0.043,
    "correction_um": 4.5,
    "ripple_turns": 16,
    "ripple_nturn": 187628,
    "harmonics": [],
}


def learned(**changes: Any) -> dict[str, Any]:  # noqa: ANN401
    """Return a summary with what was learned, some of it changed."""
    return turns([], []) | {"learning": LEARNED | changes}


def turns(rehearsed: list[float], cut: list[float]) -> dict[str, Any]:
    """Return a summary with the errors of turns; ten turns lie between the two."""
    states = ["rehearsing"] * len(rehearsed) + ["cutting"] * len(cut)
    begin = len(rehearsed) + (10 if rehearsed else 0)
    where = [*range(len(rehearsed)), *range(begin, begin + len(cut))]
    return made_up_summary(
        error_per_turn_um=rehearsed + cut, error_per_turn={"turn": where, "state": states}
    )


def text(summary: dict[str, Any]) -> str:
    """Return the sentence of the summary."""
    return learning_rows(summary)[0].value


def test_what_was_learned_and_masked_is_told() -> None:
    """Turns, error at first and at last, constants, correction, ripple, masks."""
    told = text(learned())
    assert told.startswith("on, 40 turns used: rms error at the scale 10.1 µm at first, 43 nm at")
    assert "k1 corrected by +7.738 µs, k2 by -0.0936 ms²; " in told
    assert "friction corrected by -120 nm, the chip's force learned as 34.5 µm/mm²" in told
    assert "ripple of 1179 µrad learned from 16 turns" in told
    assert told.endswith("harmonics masked: 7 .. 9, 16")
    assert text(learned(masked=[])).endswith("no harmonic is masked")
    assert "the mean of U is not corrected" in text(learned(masked=[0]))
    assert "did not converge" in text(learned(reason="diverged"))
    assert "ripple" not in text(learned(ripple_turns=0))


@pytest.mark.parametrize(
    ("reason", "named"),
    [
        ("not_asked", "off: learn_harmonics = 0"),
        ("not_measured", "off: the port does not measure U"),
        ("modulated", "off: the table modulates"),
        ("slow_turn", "off: a turn has more ticks"),
        ("fast_turn", "off: a turn has too few ticks"),
        ("no_table", "off: no table"),
        ("all", "set rehearse_turns"),
    ],
)
def test_why_nothing_was_learned_is_told(reason: str, named: str) -> None:
    """Every reason of the controller has its words."""
    assert named in text(learned(is_on=False, reason=reason))


def test_summary_without_learning_has_no_row_and_no_picture() -> None:
    """A controller on a bus does not say."""
    assert learning_rows(made_up_summary()) == []
    assert convergence(made_up_summary()) == {}
    assert convergence(turns([], [1.0])) == {}
    assert list(convergence(turns([], [1.0, 2.0]))) == ["learning"]


STEADY = [1.0] * 100


@pytest.mark.parametrize(
    ("um", "changes", "cause"),
    [
        (
            [5.0, *STEADY],
            {"reason": "limited"},
            "of a correction at its limit; drive constants that match",
        ),
        ([5.0, *STEADY], {}, "of the first turns, elsewhere 1 µm; a longer feed_ramp_turns helps"),
        ([*STEADY, 5.0], {}, "of the last turns, elsewhere 1 µm; a longer feed_ramp_turns"),
        (STEADY, {"better_rpm": 2987.0}, "of encoder counts that do not average; 2987 r/min"),
        (STEADY, {"rms_not_turned": 0.1}, "an angle by which the whole part is turned, +300 µrad"),
        (STEADY, {"error_um": 0.9}, "seen by U's scale but not learned: friction"),
        (STEADY, {}, "not seen by U's scale: run-out"),
    ],
)
def test_what_remains_has_a_likely_cause(
    um: list[float], changes: dict[str, Any], cause: str
) -> None:
    """One cause for each kind of remaining error, in the order of their certainty."""
    form = {"max": max(um), "rms": 0.4, "rms_not_turned": 0.4, "turned_urad": 300.0}
    found = (
        turns([], um) | changes | {"form_error_um": form | changes, "learning": LEARNED | changes}
    )
    row = learning_rows(found)[1]
    assert row.name == "what remains"
    assert row.value.startswith(f"{max(um):g} µm, likely {cause}")


def ticks(figure: Figure) -> list[float]:
    """Return the numbers at the y axis that are seen."""
    axes = figure.axes[0]
    low, high = axes.get_ylim()
    return [t for t in axes.get_yticks() if low <= t <= high]


def test_picture_has_all_turns_and_honest_ticks() -> None:
    """No error is cut off, every 1, 2 and 5 is written out, the tolerance is a line."""
    rehearsed, cut = list(np.geomspace(54.0, 0.06, 30)), [0.5, 0.2, 0.1, 0.08]
    with drawing():
        figure = draw_convergence(turns(rehearsed, cut))
        assert png_of(figure)[:4] == b"\x89PNG"
    axes = figure.axes[0]
    drawn = np.concatenate([np.asarray(line.get_ydata()) for line in axes.lines[:2]])
    assert drawn == pytest.approx(rehearsed + cut)
    low, high = axes.get_ylim()
    assert low < 0.06 and high > 54.0
    assert axes.get_yscale() == "log"
    assert ticks(figure) == pytest.approx([0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100], rel=1e-9)
    written = [label.get_text() for label in axes.get_yticklabels()]
    assert {"0.05", "0.1", "50"} <= set(written)
    assert np.asarray(axes.lines[2].get_ydata()) == pytest.approx(5.0)  # of the form error
    names = {one.get_text() for one in axes.texts}
    assert {"rehearsal", "engage", "cut"} <= names
    assert any("tolerance 5 µm" in name for name in names)


def test_names_of_narrow_spans_do_not_overlap() -> None:
    """Of a long cut the rehearsal and the turns of engaging are narrower than their names."""
    with drawing():
        figure = draw_convergence(turns([2.0] * 30, [0.2] * 700))
        png_of(figure)
    boxes = [one.get_window_extent() for one in figure.axes[0].texts]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


def test_picture_of_passes_of_zero_and_of_one_value() -> None:
    """Two rehearsals are two lines; an error of 0 stands at the lower end."""
    one, two = turns([3.0, 2.0], [1.0, 0.0]), turns([3.0, 2.0], [1.0])
    both = one["error_per_turn"]["state"] + two["error_per_turn"]["state"]
    where = [*one["error_per_turn"]["turn"], *(t + 30 for t in two["error_per_turn"]["turn"])]
    summary = made_up_summary(
        error_per_turn_um=one["error_per_turn_um"] + two["error_per_turn_um"],
        error_per_turn={"turn": where, "state": both},
    )
    with drawing():
        assert len(draw_convergence(summary).axes[0].lines) == 5
        png_of(draw_convergence(turns([], [5.0, 5.0])))
        png_of(draw_convergence(turns([], [0.0, 0.0])))


def test_numbers_are_joined_to_ranges() -> None:
    """Two neighbours are no range."""
    assert numbers_text([]) == ""
    assert numbers_text([1, 2]) == "1, 2"
    assert numbers_text([1, 2, 3, 9]) == "1 .. 3, 9"


def test_sequence_has_a_colour_for_every_state() -> None:
    """A cut that rehearses is drawn like any other."""
    assert len(motion.STATE_COLOURS) == len(STATES)
    n = 90 * len(STATES)
    time_s: Floats = np.arange(n, dtype=np.float64) * 50e-6
    state = np.repeat(np.arange(len(STATES), dtype=np.float64), 90)
    zero = np.zeros(n)
    trace = CutTrace(time_s, time_s, zero, zero, zero, state, zero, zero, zero, zero)
    with drawing():
        assert png_of(motion.draw_sequence(trace))[:4] == b"\x89PNG"
