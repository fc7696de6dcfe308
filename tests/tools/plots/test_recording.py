# SPDX-License-Identifier: Apache-2.0
"""Pictures of recordings: what is drawn over what, and that every recording can be drawn."""

from __future__ import annotations

import numpy as np
import pytest

from camtools.plots.recording import angle_picture, time_picture, turns_of

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


def test_recordings_of_one_row_or_one_signal_are_drawn() -> None:
    """Nothing is too short to be seen."""
    one = {name: values[:1] for name, values in COLUMNS.items()}
    assert time_picture(np.zeros(1), one, {4: "cutting"})[1:4] == b"PNG"
    assert time_picture(np.zeros(1), {"inputs": np.zeros(1)}, {})[1:4] == b"PNG"
    assert angle_picture(one)[1:4] == b"PNG"
