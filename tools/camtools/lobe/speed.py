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

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats

N_GRID = 1 << 15  # places of a turn
_MARGIN = 0.94  # of the acceleration: the table overshoots where straight lines meet
_TOP_MARGIN = 0.985  # of the highest speed
_TOLD_MARGIN = 0.992  # of the same as set-point
_COORDINATES = 1 << 15
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
    base_rad_s : float
        Speed of the spindle on the base circle.
    limits : SpindleLimits
        Speed and acceleration are kept everywhere.

    Notes
    -----
    The spindle accelerates by its torque, and by what its speed loop makes of a set-point between 0
    and its highest speed, MATHS.md (80). The largest function below a given one with bounded slope
    is found in one pass in each direction, twice round. Averages over a few places keep the bound
    of slope; where the speed has a corner downwards they are up to 2 % above it.
    """
    wanted = np.minimum(base_rad_s * base_mm / ds_dphi, _TOP_MARGIN * limits.highest_rad_s)
    alpha, loop = _MARGIN * limits.alpha_rad_s2, _MARGIN * limits.bandwidth_rad_s
    told = _TOLD_MARGIN * limits.highest_rad_s

    def rising(omega: Floats) -> Floats:
        return np.minimum(alpha, np.maximum(loop * (told - omega), 1e-9))

    def falling(omega: Floats) -> Floats:
        return np.minimum(alpha, loop * np.maximum(omega, 1e-9))

    risen = _bounded(wanted, told, rising)
    square = _bounded(risen[::-1], told, falling)[::-1] ** 2
    kernel = np.ones(2 * _SMOOTHED + 1) / (2 * _SMOOTHED + 1)
    padded = np.concatenate([square[-_SMOOTHED:], square, square[:_SMOOTHED]])
    return np.asarray(np.sqrt(np.convolve(padded, kernel, "valid")), dtype=np.float64)


def _bounded(omega_rad_s: Floats, top_rad_s: float, alpha_of: Callable[[Floats], Floats]) -> Floats:
    """Return the largest speed below another that rises as its acceleration lets it.

    The angle over which the speed rises from 0 is a coordinate in which that is a bounded slope.
    """
    omega = top_rad_s * np.arange(_COORDINATES) / _COORDINATES
    per_rad = omega / alpha_of(omega)
    angle = np.append(0.0, np.cumsum((per_rad[1:] + per_rad[:-1]) / 2)) * omega[1]
    # The largest cyclic function below the wanted angles that rises by no more than the turn does.
    wanted = np.interp(omega_rad_s, omega, angle)
    ramp = (2 * np.pi / N_GRID) * np.arange(2 * wanted.size)
    risen = (np.minimum.accumulate(np.tile(wanted, 2) - ramp) + ramp)[wanted.size :]
    return np.asarray(np.interp(risen, angle, omega), dtype=np.float64)


def acceleration_of(omega_rad_s: Floats) -> Floats:
    """Return the acceleration of the spindle [rad/s2] at N_GRID angles of a turn."""
    square = omega_rad_s**2 / 2
    return (np.roll(square, -1) - np.roll(square, 1)) * (N_GRID / (4 * np.pi))


def mean_of(omega_rad_s: Floats) -> float:
    """Return the mean speed of a turn: one turn over its time."""
    return float(1 / np.mean(1 / omega_rad_s))
