"""Surfaces of any shape: piecewise polynomials over angle and height, exact by definition.

The reduction of the radius is, on each piece of angle i and height j, MATHS.md (19),

    delta = sum over k = 0 .. 5, l = 0 .. 7 of c[j, i, k, l] t^k w^l,   t, w = 0 .. 1

A refitted or measured skirt is defined by these numbers; the gauge of the simulator reads the
same ones. The angle coordinate s is the turn (0 .. 1), or counts from the joint of a two-fold
section: 0 at the long axis, 1 at the joint, 2 at the short axis, whatever the joint's angle.

>>> flat = PolySurface(np.array([0.0, 1.0]), np.array([0.0, 10.0]), np.full((1, 1, 6, 8), 0.0))
>>> flat.delta(np.array([0.1, 0.2]), 5.0).delta.tolist()
[0.0, 0.0]
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.quantities import Floats, FloatsLike, Ints, SectionValues
from camtools.base.solvers import unsolved
from camtools.skirt.geometry.sections import SkirtSurface, fold

N_ANGLE, N_HEIGHT = 6, 8  # coefficients of a piece
TURN_RAD = 2 * np.pi
_QUARTER_TURN = 0.25
_FACTORS = np.array(
    [[1, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20], [0, 0, 0, 6, 24, 60]]
)
_CHUNK = 20_000
_NODES = (1 - np.cos(np.pi * np.arange(N_HEIGHT) / (N_HEIGHT - 1))) / 2
_TO_POWERS = np.linalg.inv(np.vander(_NODES, N_HEIGHT, increasing=True))
_BETWEEN = (_NODES[1:] + _NODES[:-1]) / 2
_FIT_MM = 1e-10  # a ten-thousandth of a nanometre
_MAX_HALVINGS = 8

Pieces = Callable[[float], Floats]
"""Coefficients of all angle pieces at a height [mm], shape (n, 6)."""


class Knots(NamedTuple):
    """Sections as values and two derivatives by the turn at breaks [mm, mm/turn, mm/turn^2]."""

    values: Floats  # (m + 1, n, 3), at the heights; the last break is the first again
    slopes: Floats | None  # the same of the slope over the height; None: straight between heights


@dataclass(frozen=True, eq=False)
class PolySurface(SkirtSurface):
    """A surface of polynomial pieces."""

    breaks: Floats  # shape (n + 1,); angle coordinate, rising; 0 .. 1, or 0 .. 2 with a joint
    breaks_mm: Floats  # shape (m + 1,); heights, rising; beyond them it stays as at the end
    coefficients: Floats  # shape (m, n, 6, 8); c[j, i, k, l] [mm]
    joint_turn: PPoly | None = None  # joint [turn] over height
    log2_alike: int = 0  # without a joint: the pieces repeat 2^log2_alike times per turn
    knots: Knots | None = None  # what the coefficients follow from: a shorter document

    @property
    def log2_repeat(self) -> int:
        """Return 1 with a joint; without one what the pieces were made to repeat."""
        return self.log2_alike if self.joint_turn is None else 1

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """Return radius reduction and angle derivatives; shapes as broadcast.

        Fast when all angles of a row share their height: z_mm a scalar or of shape (n, 1).
        """
        phi, z = np.asarray(phi_rad, dtype=np.float64), np.asarray(z_mm, dtype=np.float64)
        shape = np.broadcast_shapes(phi.shape, z.shape)
        if phi.ndim <= 1 and (z.ndim == 0 or z.shape[-1] == 1):
            return SectionValues(*self._rows(np.atleast_1d(phi), z.ravel()).reshape(4, *shape))
        flat_phi, flat_z = (np.broadcast_to(values, shape).ravel() for values in (phi, z))
        parts = [
            self._points(flat_phi[i : i + _CHUNK], flat_z[i : i + _CHUNK])
            for i in range(0, max(1, flat_phi.size), _CHUNK)
        ]
        return SectionValues(*np.concatenate(parts, axis=1).reshape(4, *shape))

    def _place(self, phi: Floats, z: FloatsLike) -> tuple[Ints, Floats, Floats]:
        """Return piece, place in it and its slope dt/dphi [1/rad] for angles."""
        if self.joint_turn is None:
            shape = np.broadcast_shapes(phi.shape, np.shape(z))
            s = np.broadcast_to(np.mod(phi / TURN_RAD, 1.0), shape)
            slope = np.full(shape, 1 / TURN_RAD)
        else:
            folded, sign = fold(phi)
            q, th = folded / TURN_RAD, self.joint_turn(z)
            is_near = q < th
            rest = _QUARTER_TURN - th
            s = np.where(is_near, q / th, 1 + (q - th) / rest)
            slope = sign * np.where(is_near, 1 / th, 1 / rest) / TURN_RAD
        i = np.clip(np.searchsorted(self.breaks, s, side="right") - 1, 0, self.breaks.size - 2)
        width = np.diff(self.breaks)[i]
        return i, (s - self.breaks[i]) / width, slope / width

    def _height(self, z: FloatsLike) -> tuple[Ints, Floats]:
        clamped = np.clip(z, self.breaks_mm[0], self.breaks_mm[-1])
        last = self.breaks_mm.size - 2
        j = np.clip(np.searchsorted(self.breaks_mm, clamped, side="right") - 1, 0, last)
        return j, (clamped - self.breaks_mm[j]) / np.diff(self.breaks_mm)[j]

    def _rows(self, phi: Floats, z: Floats) -> Floats:
        """Return value and derivatives, shape (4, z.size, phi.size), some heights at a time."""
        found = np.empty((4, z.size, phi.size))
        n = max(1, _CHUNK // phi.size)
        # Without a joint a place is the same at every height.
        alike = self._place(phi, 0.0) if self.joint_turn is None else None
        for first in range(0, z.size, n):
            some = slice(first, first + n)
            j, w = self._height(z[some])
            powers = w[:, None] ** np.arange(N_HEIGHT)
            i, t, slope = alike or self._place(phi, z[some, None])
            pieces = np.broadcast_to(i, (j.size, phi.size))
            c = np.empty((N_ANGLE, j.size, phi.size))
            for row in range(j.size):
                of_height = (self.coefficients[j[row]] @ powers[row]).T
                c[:, row] = of_height.take(pieces[row], axis=1)
            found[:, some] = _horner(c, t, slope)
        return found

    def _points(self, phi: Floats, z: Floats) -> Floats:
        j, w = self._height(z)
        i, t, slope = self._place(phi, z)
        powers = w[:, None] ** np.arange(N_HEIGHT)
        return _horner(np.einsum("pkl,pl->pk", self.coefficients[j, i], powers).T, t, slope)

    def document(self) -> dict[str, Any]:
        """Return what a gauge needs as JSON values (layout: host_sim/part/sim_design.h)."""
        kind: dict[str, Any] = {"angle": "turn"}
        if self.joint_turn is not None:
            kind = {"angle": "joint", "joint_turn": piecewise(self.joint_turn)}
        kind |= {"breaks": self.breaks.tolist(), "breaks_mm": self.breaks_mm.tolist()}
        if self.knots is None:
            return kind | {"coefficients": self.coefficients.ravel().tolist()}
        kind["knots"] = _rounded(self.knots.values, self.breaks)
        if self.knots.slopes is not None:
            kind["slopes"] = _rounded(self.knots.slopes, self.breaks)
        return kind


def piecewise(curve: PPoly) -> dict[str, Any]:
    """Return a curve over height as a gauge reads it."""
    return {"breaks_mm": curve.x.tolist(), "coefficients": curve.c.T.tolist()}


def _rounded(knots: Floats, breaks: Floats) -> list[float]:
    """Return knots as numbers that err by less than 1e-6 nm on any piece."""
    decimals = 13 + np.floor(np.log10(float(np.diff(breaks).max()))).astype(int) * np.arange(3)
    columns = [np.round(knots[..., k], int(decimals[k])) for k in range(3)]
    return [float(number) for number in np.stack(columns, axis=-1).ravel()]


def _horner(c: Floats, t: Floats, slope: Floats) -> Floats:
    """Return value and three derivatives by angle, shape (4, ..), of coefficients (6, ..)."""
    found = np.empty((4, *c.shape[1:]))
    for n in range(4):
        value = found[n]
        np.multiply(_FACTORS[n, -1], c[-1], out=value)
        for k in range(N_ANGLE - 2, n - 1, -1):
            value *= t
            value += _FACTORS[n, k] * c[k]
        if n:
            value *= slope**n
    return found


def angle_pieces(curve: PPoly, breaks_rad: Floats) -> Floats:
    """Return a curve's coefficients in t = 0 .. 1 of each stretch between breaks, (n, 6).

    Every break of the curve must be among breaks_rad.
    """
    left, width = breaks_rad[:-1], np.diff(breaks_rad)
    found = np.zeros((left.size, N_ANGLE))
    piece = np.searchsorted(curve.x, (left + breaks_rad[1:]) / 2, side="right") - 1
    piece = np.clip(piece, 0, curve.x.size - 2)
    start, factorial = left - curve.x[piece], 1.0
    for k in range(curve.c.shape[0]):
        factorial *= max(1, k)
        nth = curve.derivative(k).c if k else curve.c
        value = np.zeros(left.size)
        for row in nth[:, piece]:
            value = value * start + row
        found[:, k] = value / factorial * width**k
    return found


def over_height(pieces: Pieces, breaks_mm: Floats) -> tuple[Floats, Floats]:
    """Return heights and coefficients (m, n, 6, 8) that follow `pieces` to 1e-4 nm.

    Stretches between the heights given are halved until their polynomials fit.
    """
    heights, found = [float(breaks_mm[0])], []
    todo = [(float(a), float(b), 0) for a, b in pairwise(breaks_mm)]
    todo.reverse()
    while todo:
        low, high, n_halved = todo.pop()
        nodes = np.stack([pieces(low + (high - low) * w) for w in _NODES], axis=-1)
        c = nodes @ _TO_POWERS.T
        if _misfit_mm(pieces, c, low, high) > _FIT_MM:
            if n_halved == _MAX_HALVINGS:
                raise unsolved(f"piston.section: sections at {low:.6g} mm of height")
            middle = (low + high) / 2
            todo += [(middle, high, n_halved + 1), (low, middle, n_halved + 1)]
            continue
        heights.append(high)
        found.append(c)
    return np.array(heights), np.stack(found)


def _misfit_mm(pieces: Pieces, c: Floats, low: float, high: float) -> float:
    """Return a bound of the error of delta between the nodes: |t| is at most 1."""
    worst = 0.0
    for w in _BETWEEN[:: N_HEIGHT // 3]:
        off = pieces(low + (high - low) * float(w)) - c @ float(w) ** np.arange(N_HEIGHT)
        worst = max(worst, float(np.abs(off).sum(axis=-1).max()))
    return worst
