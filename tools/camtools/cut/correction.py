"""What a table takes off a drawing because a gauged part showed it, MATHS.md (160).

It is given by waves over the angle whose coefficients change smoothly over the height: natural
cubic splines through values at `nodes_of` a part, whose tangents fade beyond its ends.
The mean of each height is carried by X, all waves by U.

>>> bump = Correction((0.0, 60.0), {2: np.full(N_NODES, 1e-3 + 0j)})
>>> twice = bump.plus(bump, {"gain": 0.7}, {})
>>> [f"{mm:.4f}" for mm in twice.delta(np.radians([0.0, 90.0]), np.array(5.0))[0]]
['0.0020', '-0.0020']
>>> twice.repeats, len(twice.rounds)
(2, 1)
>>> nodes_of((0.0, 30.0))[[0, 1, 2, 32, 33, 64]].round(3).tolist()
[0.0, 0.15, 0.326, 15.0, 15.658, 30.0]
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import gcd
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline, PPoly

from camtools.base.quantities import UM_PER_MM, Floats, FloatsLike
from camtools.base.text import Json
from camtools.part.areas import Area

N_NODES = 65  # heights over the part
FADE_MM = 0.5
_LEAST_STEP_MM = 0.15  # at the ends, where a cut changes fastest; a table's slices are 0.0655 apart
MAX_ORDER = 64  # of the gauge, host_sim/part/sim_surface.h
_DECIMALS = 9  # of a micrometre

Complexes = npt.NDArray[np.complex128]


def nodes_of(ends_mm: tuple[float, float]) -> Floats:
    """Return N_NODES heights of a part, rising, closer at its ends."""
    share = np.arange(N_NODES) / (N_NODES - 1)
    wave = (1 - np.cos(np.pi * share)) / 2
    even, dense = ((ends_mm[1] - ends_mm[0]) * places[1] for places in (share, wave))
    graded = float(np.clip((even - _LEAST_STEP_MM) / (even - dense), 0.0, 1.0))
    within = (1 - graded) * share + graded * wave
    return np.asarray(ends_mm[0] + (ends_mm[1] - ends_mm[0]) * within, dtype=np.float64)


class Drawing(NamedTuple):
    """What a part is judged by, whatever the table plays."""

    ends_mm: tuple[float, float]
    radius_mm: Callable[[Floats, Floats], Floats]  # of turns and heights of the same shape
    swing_mm: float  # largest less least reduction of the radius
    document: Json  # `design` of NAME.json
    windows: tuple[Area, ...] = ()  # without material


@dataclass(frozen=True, eq=False)
class Correction:
    """A reduction of the radius, added to that of the drawing.

    `waves_mm` has of each order, 0 being the mean, N_NODES values c over the height:
    Re(c e^(-j order phi)); `left_mm` as many, which the last round left of the last gauged part for
    the next one on purpose.
    """

    heights_mm: tuple[float, float]  # ends of the part
    waves_mm: Mapping[int, Complexes]
    rounds: tuple[Json, ...] = ()  # what each round of measuring and correcting added
    left_mm: Mapping[int, Complexes] = field(default_factory=dict)

    @property
    def nodes_mm(self) -> Floats:
        """Return the heights of the values."""
        return nodes_of(self.heights_mm)

    @property
    def orders(self) -> list[int]:
        """Return the orders of the waves, rising, without the mean."""
        return sorted(order for order in self.waves_mm if order > 0)

    @property
    def repeats(self) -> int:
        """Return how many times the waves repeat per turn, 0 without a wave."""
        return gcd(*self.orders)

    @property
    def mean(self) -> PPoly:
        """Return the mean over the height [mm]."""
        values = self.waves_mm.get(0, np.zeros(N_NODES, dtype=np.complex128))
        return CubicSpline(self.nodes_mm, values.real, bc_type="natural")

    @cached_property
    def _waves(self) -> CubicSpline:
        values = np.stack([self.waves_mm[order] for order in self.orders], axis=1)
        parts = np.concatenate([values.real, values.imag], axis=1)
        return CubicSpline(self.nodes_mm, parts, bc_type="natural")

    def delta(self, phi_rad: Floats, z_mm: FloatsLike) -> list[Floats]:
        """Return what the waves take off, and three derivatives by the angle [mm, mm/rad^n].

        The drawing's angle and the height are broadcast; it is fast when all angles of a row share
        their height: phi one-dimensional, z a scalar or of shape (.., 1).
        """
        z = np.asarray(z_mm, dtype=np.float64)
        shape = np.broadcast_shapes(phi_rad.shape, z.shape)
        found = [np.zeros(shape) for _ in range(4)]
        if not self.orders:
            return found
        is_grid = phi_rad.ndim == 1 and z.ndim > 0 and z.shape[-1] == 1
        parts = self._parts(z[..., 0] if is_grid else z)
        for i, order in enumerate(self.orders):
            cos, sin = np.cos(order * phi_rad), np.sin(order * phi_rad)
            a, b = parts[..., i], parts[..., len(self.orders) + i]
            if is_grid:
                a, b = a[..., None], b[..., None]
            wave, slope = a * cos + b * sin, order * (b * cos - a * sin)
            found[0] += wave
            found[1] += slope
            found[2] -= order**2 * wave
            found[3] -= order**2 * slope
        return found

    def _parts(self, z_mm: Floats) -> Floats:
        """Return cosines, then sines of all waves at heights [mm], shape (.., 2 orders).

        Beyond an end they go on as their tangent, which fades over FADE_MM: no kink in the air.
        """
        held = np.clip(z_mm, *self.heights_mm)
        beyond = z_mm - held
        run = np.minimum(np.abs(beyond), FADE_MM)
        reach = np.sign(beyond) * (run - run**2 / (2 * FADE_MM))
        found = self._waves(held)
        if beyond.any():
            found = found + reach[..., None] * self._waves(held, 1)
        return np.asarray(found, dtype=np.float64)

    def plus(self, other: Correction, about: Json, left_mm: Mapping[int, Complexes]) -> Correction:
        """Return the sum of two corrections of one part, the other one being a new round."""
        waves = dict(self.waves_mm)
        for order, values in other.waves_mm.items():
            waves[order] = waves[order] + values if order in waves else values
        return Correction(self.heights_mm, waves, (*self.rounds, about), left_mm)

    def document(self) -> Json:
        """Return the values as JSON, from which `correction_of` makes the same correction."""
        return {
            "heights_mm": list(self.heights_mm),
            "rounds": list(self.rounds),
            "waves": _written(self.waves_mm),
            "left": _written(self.left_mm),
        }

    def for_gauge(self) -> list[Json]:
        """Return the waves as a gauge reads them (layout: host_sim/part/sim_surface.h)."""
        if not self.orders:
            return []
        breaks, c, n = self.nodes_mm.tolist(), self._waves.c, len(self.orders)
        return [
            {
                "order": order,
                "cos_mm": {"breaks_mm": breaks, "coefficients": c[:, :, i].T.tolist()},
                "sin_mm": {"breaks_mm": breaks, "coefficients": c[:, :, n + i].T.tolist()},
            }
            for i, order in enumerate(self.orders)
        ]


def _written(waves_mm: Mapping[int, Complexes]) -> list[Json]:
    return [
        {"order": order, "cos_um": _um(values.real), "sin_um": _um(values.imag)}
        for order, values in sorted(waves_mm.items())
    ]


def _um(values_mm: Floats) -> list[float]:
    return [round(float(value) * UM_PER_MM, _DECIMALS) for value in values_mm]


def correction_of(document: Json) -> Correction:
    """Return the correction of a document; KeyError, TypeError or ValueError where it is none."""
    first_mm, last_mm = (float(height) for height in document["heights_mm"])
    waves, left = (_read(document[key]) for key in ("waves", "left"))
    return Correction((first_mm, last_mm), waves, tuple(document["rounds"]), left)


def _read(written: list[Json]) -> dict[int, Complexes]:
    waves: dict[int, Complexes] = {}
    for wave in written:
        parts = np.array([wave["cos_um"], wave["sin_um"]], dtype=np.float64) / UM_PER_MM
        order = int(wave["order"])
        if parts.shape != (2, N_NODES) or not 0 <= order <= MAX_ORDER:
            raise ValueError(order)
        waves[order] = parts[0] + 1j * parts[1]
    return waves
