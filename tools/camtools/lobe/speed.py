"""The spindle's speed over the angle of a lobe: constant surface speed within its acceleration.

The contact runs along the lobe by ds/dphi; N = n0 r / (ds/dphi) keeps its speed at that of the base
circle, MATHS.md (35). Where that needs more acceleration than the spindle has, the square of the
speed rises and falls along straight lines below it, MATHS.md (36): no slower than needed.

>>> ds_dphi = 20 + 10 * np.sin(np.arange(N_GRID) * 2 * np.pi / N_GRID)
>>> law = surface_speed(ds_dphi, 20.0, 6.0, SpindleLimits(1e6, 1e3))
>>> bool(np.abs(law * ds_dphi / 120 - 1).max() < 1e-4)
True
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats

N_GRID = 1 << 15  # places of a turn
_MARGIN = 0.94  # of the acceleration: the table overshoots where straight lines meet
_TOP_MARGIN = 0.995  # of the highest speed
_SMOOTHED = 8  # places over which those corners are rounded, on either side


class SpindleLimits(NamedTuple):
    """What the spindle can do."""

    alpha_rad_s2: float
    highest_rad_s: float
    bandwidth_rad_s: float = np.inf  # of its speed loop


def surface_speed(
    ds_dphi: Floats, base_mm: float, base_rad_s: float, limits: SpindleLimits
) -> Floats:
    """Return the spindle's speed [rad/s] at N_GRID angles of a turn.

    Parameters
    ----------
    ds_dphi : ndarray, shape (N_GRID,)
        Travel of the contact along the profile [mm/rad], above 0.
    base_mm : float
        Radius of the base circle.
    base_rad_s : float
        Speed of the spindle on the base circle.
    limits : SpindleLimits
        Speed and acceleration are kept everywhere.

    Notes
    -----
    With b = omega^2 the acceleration is b' / 2, so its limit bounds a slope. The largest function
    below a given one with bounded slope is found in one pass in each direction, twice round.
    Averages over a few places keep the bound of slope; where the speed has a corner downwards they
    are up to 2 % above it.
    """
    wanted = np.minimum(base_rad_s * base_mm / ds_dphi, _TOP_MARGIN * limits.highest_rad_s)
    step = 2 * _MARGIN * limits.alpha_rad_s2 * 2 * np.pi / N_GRID
    square = _falling(np.sqrt(_below(wanted**2, step)), limits) ** 2
    kernel = np.ones(2 * _SMOOTHED + 1) / (2 * _SMOOTHED + 1)
    padded = np.concatenate([square[-_SMOOTHED:], square, square[:_SMOOTHED]])
    return np.asarray(np.sqrt(np.convolve(padded, kernel, "valid")), dtype=np.float64)


def _falling(omega_rad_s: Floats, limits: SpindleLimits) -> Floats:
    """Return the largest speed below another that falls as torque and speed loop let it.

    It falls by at most alpha / omega per radian and by the bandwidth of the loop, MATHS.md (80).
    The angle over which it falls from a speed to 0 is a coordinate of a bounded slope.
    """
    alpha, bandwidth = _MARGIN * limits.alpha_rad_s2, _MARGIN * limits.bandwidth_rad_s
    slow = alpha / bandwidth  # below it the loop decides
    angle = np.where(
        omega_rad_s < slow,
        omega_rad_s / bandwidth,
        (omega_rad_s**2 + slow**2) / (2 * alpha),
    )
    angle = _below(angle[::-1], 2 * np.pi / N_GRID)[::-1]
    fast = np.sqrt(np.maximum(2 * alpha * angle - slow**2, 0.0))
    return np.asarray(np.where(angle * bandwidth < slow, angle * min(bandwidth, 1e300), fast))


def _below(square: Floats, step: float) -> Floats:
    """Return the largest cyclic function below another that rises by at most `step` per place."""
    n = square.size
    ramp = step * np.arange(2 * n)
    lowest = np.minimum.accumulate(np.tile(square, 2) - ramp) + ramp
    return np.asarray(lowest[n:], dtype=np.float64)


def acceleration_of(omega_rad_s: Floats) -> Floats:
    """Return the acceleration of the spindle [rad/s2] at N_GRID angles of a turn."""
    square = omega_rad_s**2 / 2
    return (np.roll(square, -1) - np.roll(square, 1)) * (N_GRID / (4 * np.pi))


def mean_of(omega_rad_s: Floats) -> float:
    """Return the mean speed of a turn: one turn over its time."""
    return float(1 / np.mean(1 / omega_rad_s))
