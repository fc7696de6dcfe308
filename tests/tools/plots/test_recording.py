# SPDX-License-Identifier: Apache-2.0
"""Pictures of recordings: what is drawn over what, and that every recording can be drawn."""

import re

import numpy as np
import pytest

from camtools.link.signals import INPUTS, OUTPUTS
from camtools.plots.recording import angle_picture, set_spans, time_picture, turns_of
from tests.tools.cases.part_cases import ROOT

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


def test_the_same_recording_gives_the_same_picture() -> None:
    """Byte for byte, over time and over the angle; a trigger changes it."""
    t_s = np.arange(N) / 20000 - 0.005
    picture = time_picture(t_s, COLUMNS, {4: "cutting"}, "estop")
    assert picture == time_picture(t_s, COLUMNS, {4: "cutting"}, "estop")
    assert picture != time_picture(t_s, COLUMNS, {4: "cutting"})
    assert angle_picture(COLUMNS) == angle_picture(COLUMNS)


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
        assert len(places) >= 4
        assert all(names[bit] == name for name, bit in places.items())
        assert set(names.values()) - set(places) <= {f"switch_{i}" for i in range(2, 9)}


def test_recordings_of_one_row_or_one_signal_are_drawn() -> None:
    """Nothing is too short to be seen."""
    one = {name: values[:1] for name, values in COLUMNS.items()}
    assert time_picture(np.zeros(1), one, {4: "cutting"})[1:4] == b"PNG"
    assert time_picture(np.zeros(1), {"inputs": np.zeros(1)}, {})[1:4] == b"PNG"
    assert angle_picture(one)[1:4] == b"PNG"
