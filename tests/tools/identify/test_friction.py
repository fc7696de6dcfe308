# SPDX-License-Identifier: Apache-2.0
"""Friction as played: sticking, slipping, and its balance of forces."""

import numpy as np

from camtools.identify.friction import friction_of

TICK_S = 5e-5
DRIVE = np.array([7e-4, 3e-7, 3000.0, 1e-4])  # friction of 10 m/s2


def test_slide_that_is_pushed_too_little_holds_its_place() -> None:
    """Friction is then the push itself: the command as a share of the friction's length."""
    shares = friction_of(DRIVE, np.full(400, 1500.0), TICK_S)
    assert abs(shares[-1] - 0.5) < 1e-6


def test_slide_that_moves_has_all_of_it() -> None:
    """A ramp drags with the whole friction, in the direction of motion."""
    ramp = 500.0 * np.arange(2000.0)
    assert np.allclose(friction_of(DRIVE, ramp, TICK_S)[1000:], 1.0)
    assert np.allclose(friction_of(DRIVE, -ramp, TICK_S)[1000:], -1.0)


def test_dead_time_moves_it() -> None:
    """A dead time longer by one tick gives the same, one tick later."""
    t = np.arange(4000) * TICK_S
    u_nm = 200_000 * np.sin(2 * np.pi * 40 * t)
    now = friction_of(DRIVE, u_nm, TICK_S)
    later = friction_of(DRIVE + np.array([0, 0, 0, TICK_S]), u_nm, TICK_S)
    assert np.max(np.abs(now[:-1] - later[1:])) < 1e-9
