"""Pictures: numbers in full, none over another; every recording can be drawn."""

import re
from itertools import pairwise

import numpy as np
import pytest

from camtools.link.signals import INPUTS, OUTPUTS
from camtools.plots.recording import angle_picture, set_spans, time_picture, turns_of
from camtools.plots.style import drawing, log_axis, new_figure, png_of
from tests.tools.cases.part_cases import ROOT


@pytest.mark.parametrize(
    ("low", "high"), [(45.99998, 46.00002), (0.0, 3e7), (-1e6, 1e6), (1e-6, 2e-6), (9e5, 9.00001e5)]
)
def test_axes_have_no_offset_beside_them(low: float, high: float) -> None:
    """Numbers stand at their ticks in full, whatever the range, in both directions."""
    figure = new_figure(4, 3)
    axes = figure.add_subplot()
    values = np.linspace(low, high, 5)
    axes.plot(values, values)
    assert png_of(figure)[1:4] == b"PNG"
    for axis in (axes.xaxis, axes.yaxis):
        assert axis.get_offset_text().get_text() == ""
        shown = [float(text.get_text().replace("\u2212", "-")) for text in axis.get_ticklabels()]
        assert shown == pytest.approx(axis.get_ticklocs(), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("high", [0.1, 0.4, 5.0, 49.0, 1e4])
def test_numbers_of_a_logarithmic_axis_stand_apart(high: float) -> None:
    """Across a picture no wider than a forecast's, no number touches its neighbour."""
    with drawing():
        figure = new_figure(5.5, 3.7)
        axes = figure.add_subplot()
        log_axis(axes, "x", 0.05, high)
        png_of(figure)
    boxes = [one.get_window_extent() for one in axes.get_xticklabels(which="both")]
    shown = sorted((box.x0, box.x1) for box in boxes if box.width > 1)
    assert len(shown) >= 2
    assert all(end < begin for (_, end), (begin, _) in pairwise(shown))


N = 400
ANGLE = np.linspace(100.0, 100.0 + 5 * 360.0, N) % 360
COLUMNS = {
    "state": np.full(N, 4.0),
    "u_due_um": np.sin(np.radians(2 * ANGLE)),
    "u_actual_um": np.sin(np.radians(2 * ANGLE)) + 0.01,
    "angle_deg": ANGLE,
    "faults": np.zeros(N),
}


@pytest.mark.parametrize("sense", [1, -1])
def test_turns_are_counted_in_both_senses(sense: int) -> None:
    """A turn ends where the angle passes 0; each row is of one turn."""
    turns = turns_of(ANGLE[::sense])
    assert turns.min() == 0
    assert turns.max() == 5
    assert set(np.diff(turns)) == {0, sense}
    wraps = np.flatnonzero(np.abs(np.diff(ANGLE[::sense])) > 180)
    assert np.array_equal(wraps, np.flatnonzero(np.diff(turns)))


@pytest.mark.long
def test_the_same_recording_gives_the_same_picture() -> None:
    """Byte for byte, over time and over the angle; a trigger changes it."""
    t_s = np.arange(N) / 20000 - 0.005
    picture = time_picture(t_s, COLUMNS, {4: "cutting"}, "estop")
    assert picture == time_picture(t_s, COLUMNS, {4: "cutting"}, "estop")
    assert picture != time_picture(t_s, COLUMNS, {4: "cutting"})
    assert angle_picture(COLUMNS) == angle_picture(COLUMNS)
    one = {name: values[:1] for name, values in COLUMNS.items()}  # nothing is too short
    assert time_picture(np.zeros(1), one, {4: "cutting"})[1:4] == b"PNG"
    assert time_picture(np.zeros(1), {"inputs": np.zeros(1)}, {})[1:4] == b"PNG"
    assert angle_picture(one)[1:4] == b"PNG"


def test_bits_have_names() -> None:
    """What is a sum of bits is drawn as a row for each that is ever set; other sums as before."""
    t_s, sums = np.arange(6) / 1000, {"inputs": np.array([2.0, 2, 3, 1, 0, 2])}
    named = time_picture(t_s, sums, {}, bits={"inputs": {0: "estop", 1: "drive_ready"}})
    assert named != time_picture(t_s, sums, {})
    assert named == time_picture(
        t_s, sums, {}, bits={"inputs": {0: "estop", 1: "drive_ready", 9: ""}}
    )
    assert set_spans(sums["inputs"], 1) == [(0, 2), (5, 5)]
    assert set_spans(sums["inputs"], 0) == [(2, 3)]
    nothing = time_picture(t_s, {"faults": np.zeros(6)}, {}, bits={"faults": {0: "estop"}})
    assert nothing[1:4] == b"PNG"


def test_bits_are_those_of_the_controller() -> None:
    """The names are those of hal.h, at their places."""
    header = (ROOT / "hal" / "include" / "hal" / "hal.h").read_text()
    for names, prefix in ((INPUTS, "in"), (OUTPUTS, "out")):
        found = re.findall(rf"hal_{prefix}_(\w+) = (?:1u << (\d+)|(0x\d+)u),", header)
        places = {
            name: int(bit) if bit else int(sum_, 16).bit_length() - 1 for name, bit, sum_ in found
        }
        assert len(places) >= 3
        assert all(names[bit] == name for name, bit in places.items())
        assert set(names.values()) == set(places)
