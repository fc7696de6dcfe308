"""Where a round nose touches the surface of a skirt, MATHS.md (107) .. (109).

In the plane of the axis and one angle the surface is a curve R(z), and the nose a circle. The
circle touches the curve where their slopes are equal, at the kink of a curve that juts out, or at
an end of it.

>>> class Cone:
...     def values(self, phi: Floats, z: Floats) -> Floats:
...         return np.stack([10 + 0.75 * z, 0 * z, 0 * z, 0 * z])
>>> rays = Rays(Cone(), np.array([0.0, 20.0]))
>>> touch = find_contact(rays, np.array([0.0]), np.array([10.0]), 2.0, 0.0, 20.0)
>>> f"{touch.z_mm[0] - 10:.6f} {touch.above_mm(2.0)[0]:.6f}"
'1.200000 -0.400000'
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from camtools.base.quantities import Floats, Ints

Bools = npt.NDArray[np.bool_]
_STEP_MM = 1e-3  # of differences along the height
ACROSS_MM = 1e-9  # how far beyond a break its other side is looked at
_FOUND_MM = 1e-8
_MAX_STEPS = 100
_WITHIN = 1 - 1e-9  # of the nose's radius: the circle's slope is finite there


class Surface(Protocol):
    """A surface over angle and height, smooth between the breaks of its heights."""

    def values(self, phi: Floats, z: Floats) -> Floats:
        """Return the radius and three derivatives by the angle, shape (4, n)."""


class Along(NamedTuple):
    """Derivatives along the height, of the radius and of its angle derivatives, shape (4, n)."""

    first: Floats
    second: Floats


@dataclass(frozen=True, eq=False)
class Rays:
    """A surface with derivatives along the height, taken from inside one piece of it.

    Attributes
    ----------
    surface : Surface
        With exact values.
    breaks_mm : ndarray, shape (m + 1,)
        Heights between which it is smooth, rising, both ends included.
    """

    surface: Surface
    breaks_mm: Floats

    def piece(self, z: Floats) -> Ints:
        """Return the index of the piece above each height, of the last one at the end."""
        found = np.searchsorted(self.breaks_mm, z, side="right") - 1
        return np.asarray(np.clip(found, 0, self.breaks_mm.size - 2), dtype=np.int64)

    def along(self, phi: Floats, z: Floats) -> Along:
        """Return the derivatives at heights of a parabola inside the piece of each."""
        piece = self.piece(z)
        low, high = self.breaks_mm[piece], self.breaks_mm[piece + 1]
        step = np.minimum(_STEP_MM, (high - low) / 4)
        middle = np.clip(z, low + step, high - step)
        below, here, above = (self.surface.values(phi, middle + k * step) for k in (-1, 0, 1))
        second = (below - 2 * here + above) / step**2
        return Along((above - below) / (2 * step) + second * (z - middle), second)


class NoseContact(NamedTuple):
    """Contacts, all of the shape (n,)."""

    z_mm: Floats
    off_mm: Floats  # above the middle of the nose
    is_free: Floats  # 1 where slopes are equal, 0 at a kink or an end

    def above_mm(self, nose_mm: float) -> Floats:
        """Return the lowest place of the nose's centre line less its radius: at most 0."""
        root = np.sqrt(nose_mm**2 - self.off_mm**2)
        return np.asarray(-(self.off_mm**2) / (nose_mm + root), dtype=np.float64)


def find_contact(
    rays: Rays, phi: Floats, centre_mm: Floats, nose_mm: float, low_mm: float, high_mm: float
) -> NoseContact:
    """Return the contact of each nose with the heights low_mm .. high_mm of the surface.

    Newton's method on the difference of the slopes, inside a bracket; a step never crosses a break
    but stops at it and looks at its other side. Errs by less than 1e-8 mm of height.

    Parameters
    ----------
    phi, centre_mm : ndarray, shape (n,)
        Angle [rad] and height of the nose's middle.
    nose_mm : float
        Radius, less than the radius of every hollow between the two heights.
    """
    z = np.clip(centre_mm, low_mm, high_mm)
    is_free, todo = np.ones(z.size), np.arange(z.size)
    search = _Search(rays, nose_mm, centre_mm, low_mm, high_mm)
    for _ in range(_MAX_STEPS):
        z[todo], is_free[todo], is_found = search.step(phi[todo], z[todo], todo)
        todo = todo[~is_found]
        if todo.size == 0:
            break
    return NoseContact(z, z - centre_mm, is_free)


class _Search:
    """Brackets of a search; a bound counts as tested once the slopes there are known."""

    def __init__(
        self, rays: Rays, nose_mm: float, centre_mm: Floats, low_mm: float, high_mm: float
    ) -> None:
        self.rays, self.nose_mm, self.centre_mm = rays, nose_mm, centre_mm
        reach = nose_mm * _WITHIN
        self.low = np.clip(centre_mm - reach, low_mm, high_mm)
        self.high = np.clip(centre_mm + reach, low_mm, high_mm)
        self.is_tested = np.zeros((2, centre_mm.size), dtype=bool)

    def step(self, phi: Floats, z: Floats, todo: Ints) -> tuple[Floats, Floats, Bools]:
        """Return the next heights, whether slopes are equal there, and which are found."""
        along = self.rays.along(phi, z)
        off = np.clip(z - self.centre_mm[todo], -self.nose_mm * _WITHIN, self.nose_mm * _WITHIN)
        root = np.sqrt(self.nose_mm**2 - off**2)
        rise = along.first[0] - off / root
        bend = along.second[0] - self.nose_mm**2 / root**3
        is_up, is_down = rise >= 0, rise <= 0
        self.low[todo] = np.where(is_up, z, self.low[todo])
        self.high[todo] = np.where(is_down, z, self.high[todo])
        self.is_tested[0, todo] |= is_up
        self.is_tested[1, todo] |= is_down
        low, high = self.low[todo], self.high[todo]
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = np.where(bend < 0, z - rise / bend, np.where(is_up, np.inf, -np.inf))
        wish = self._to_break(z, np.clip(newton, low, high))
        is_stale = np.where(is_up, self.is_tested[1, todo] & (wish >= high), False) | np.where(
            is_down, self.is_tested[0, todo] & (wish <= low), False
        )
        new = np.where(is_stale, (low + high) / 2, wish)
        is_free = np.abs(newton - z) < _FOUND_MM
        is_found = is_free | (high - low < _FOUND_MM)
        return np.where(is_found & ~is_free, z, new), np.where(is_free, 1.0, 0.0), is_found

    def _to_break(self, z: Floats, wish: Floats) -> Floats:
        """Return wishes that leave the piece of z cut to just beyond the break between them."""
        breaks, piece = self.rays.breaks_mm, self.rays.piece(z)
        above, below = breaks[piece + 1] + ACROSS_MM, breaks[piece] - ACROSS_MM
        last = breaks.size - 2
        wish = np.where((wish > above) & (piece < last), above, wish)
        return np.asarray(np.where((wish < below) & (piece > 0), below, wish), dtype=np.float64)
