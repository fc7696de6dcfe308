"""Gauged surfaces by formula, and a judge of surfaces that knows nothing of the correction."""

import numpy as np
from numpy.typing import NDArray

from camtools.measured.points import GaugedPoints

Floats = NDArray[np.float64]
ENDS = (0.0, 62.0)


def traces(heights_mm: Floats, n_angles: int = 360) -> tuple[Floats, Floats]:
    """Return angles and heights of an instrument's traces."""
    turn = np.tile(np.arange(n_angles) / n_angles, heights_mm.size)
    return turn, np.repeat(heights_mm, n_angles)


def helix(turns: int = 310, per_turn: int = 180) -> tuple[Floats, Floats]:
    """Return angles and heights of a surface that is gauged along its cut."""
    along = np.arange(turns * per_turn) / per_turn
    return np.mod(along + 0.3, 1.0), ENDS[1] * along / turns


def error_um(turn: Floats, z_mm: Floats) -> Floats:
    """Return the error of an imagined machine: mean, eccentricity, oval, and a wave of order 5."""
    phi, s = 2 * np.pi * turn, z_mm / ENDS[1]
    oval = (2 + s) * np.cos(2 * phi - 0.5 * s)
    return 1.5 * s + 0.6 * np.cos(phi - 1) + oval + 0.3 * s**2 * np.sin(5 * phi)


def gauged(place: tuple[Floats, Floats], noise_um: float = 0.0, seed: int = 0) -> GaugedPoints:
    """Return `error_um` at places, with normal noise."""
    rng = np.random.default_rng(seed)
    return GaugedPoints(*place, error_um(*place) + rng.normal(0, noise_um, place[0].size))


def amplitudes_um(points: GaugedPoints, order: int, n_bands: int = 8) -> Floats:
    """Return the amplitude of an order in bands of height, by the sums of a Fourier series."""
    bands = np.array_split(np.argsort(points.z_mm, kind="stable"), n_bands)
    factor = np.exp(2j * np.pi * order * points.turn)
    found = [2 * abs((points.deviation_um[rows] * factor[rows]).mean()) for rows in bands]
    return np.array(found)
