"""The page that camctl watch draws over and over."""

import pytest

from camtools.link.controller import Status
from camtools.link.status_text import Dashboard

MOVING = {
    "speed": 2999.9,
    "z": -120.5,
    "angle": 359.9,
    "u_set": 0.1212,
    "u_actual": -0.1212,
    "following_error": 1.5e-3,
}


@pytest.mark.parametrize("width", [40, 80, 121])
def test_page_is_no_wider_than_the_terminal(width: int) -> None:
    """No line reaches the margin, where terminals wrap, or erase the last character."""
    status = Status()
    status.signals.update(MOVING)
    board = Dashboard(width)
    for _ in range(2 * width):
        board.add(status)
    lines = board.lines(status)
    assert max(len(line) for line in lines if "[" in line) == width - 1
    assert "r/min" in lines[2]
