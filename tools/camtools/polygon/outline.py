"""The outline of a section: curves one after the other round the axis, and where they meet.

>>> from camtools.polygon.curves import CornerArc
>>> circle = Outline((0.0,), (CornerArc(0.0, 0.0, 5.0),), 1)
>>> circle.polar(np.array([0.1, 3.0])).r.tolist()
[5.0, 5.0]
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats, Ints
from camtools.polygon.curves import Curve, Polar

TURN_RAD = 2 * np.pi
_MEASURED = 20_160  # angles; a multiple of all numbers of sides up to 10
_SAME_MM, _SAME_BEND_MM = 1e-9, 1e-6  # slopes and bends that differ by less are the same


class OutlineJoint(NamedTuple):
    """Where two curves of an outline meet."""

    i: int  # of the curve behind
    angle_rad: float
    before: Curve
    behind: Curve
    slope_mm: float  # jump of r' [mm/rad]
    bend_mm: float  # jump of r'' [mm/rad^2]
    room_rad: float  # to the nearer end of both curves


@dataclass(frozen=True, eq=False)
class Outline:
    """A closed outline.

    Attributes
    ----------
    starts_rad : tuple of float
        Where each curve begins, rising, within one turn; the last one ends where the first begins.
    """

    starts_rad: tuple[float, ...]
    curves: tuple[Curve, ...]  # as many
    repeat: int  # how many times the outline repeats per turn

    def ends_rad(self) -> tuple[float, ...]:
        """Return where each curve ends."""
        return (*self.starts_rad[1:], self.starts_rad[0] + TURN_RAD)

    def _piece(self, phi: Floats) -> Ints:
        first = self.starts_rad[0]
        place = np.mod(phi - first, TURN_RAD) + first
        found = np.searchsorted(self.starts_rad, place, side="right") - 1
        return np.clip(found, 0, len(self.curves) - 1)

    def polar(self, phi_rad: Floats) -> Polar:
        """Return radius and derivatives at angles [rad] of any size, shape (n,)."""
        found, piece = np.empty((4, phi_rad.size)), self._piece(phi_rad)
        for i in np.unique(piece):
            here = piece == i
            found[:, here] = np.stack(self.curves[i].polar(phi_rad[here]))
        return Polar(*found)

    def curve_at(self, angle_rad: float) -> Curve:
        """Return the curve at an angle."""
        return self.curves[int(self._piece(np.array([angle_rad]))[0])]

    def joints(self) -> Iterator[OutlineJoint]:
        """Yield where curves meet; a curve that goes on smoothly all around has no joint."""
        ends = self.ends_rad()
        widths = [end - start for start, end in zip(self.starts_rad, ends, strict=True)]
        for i, start in enumerate(self.starts_rad):
            before, behind = self.curves[i - 1], self.curves[i]
            if before is behind:
                continue
            here = np.array([start])
            low, high = before.polar(here), behind.polar(here)
            slope, bend = (float((getattr(high, d) - getattr(low, d))[0]) for d in ("d1", "d2"))
            room = min(widths[i - 1], widths[i])
            yield OutlineJoint(i, start, before, behind, slope, bend, room)


def extremes_of(outline: Outline) -> tuple[float, float]:
    """Return the least and the largest radius [mm]; between samples Newton finds the place."""
    phi = all_around(outline)
    r = outline.polar(phi).r
    places = phi[[int(r.argmin()), int(r.argmax())]]
    for _ in range(3):
        at = outline.polar(places)
        step = np.where(np.abs(at.d2) > 0, at.d1 / np.where(at.d2 == 0, 1.0, at.d2), 0.0)
        places = places - np.where(np.abs(step) < TURN_RAD / _MEASURED, step, 0.0)
    there = outline.polar(places).r
    return min(float(r.min()), float(there[0])), max(float(r.max()), float(there[1]))


class Measures(NamedTuple):
    """What a drawing and an inspector say of a section [mm]."""

    inner_circle_mm: float  # diameter of the largest circle round the axis inside
    outer_circle_mm: float  # diameter of the smallest one outside
    least_width_mm: float  # between two parallel planes, as a calliper measures
    largest_width_mm: float
    area_mm2: float


def all_around(outline: Outline) -> Floats:
    """Return angles all around, the joints among them."""
    grid = TURN_RAD * np.arange(_MEASURED) / _MEASURED
    return np.union1d(grid, np.mod(outline.starts_rad, TURN_RAD))


def measures_of(outline: Outline) -> Measures:
    """Return the measures of a section; widths of 362 directions."""
    phi = all_around(outline)
    r = outline.polar(phi).r
    grid = TURN_RAD * np.arange(360) / 720
    normals = np.concatenate([grid, phi[[int(r.argmax()), int(r.argmin())]]])
    x, y = r * np.cos(phi), r * np.sin(phi)
    width = np.array([float(np.ptp(x * np.cos(a) + y * np.sin(a))) for a in normals])
    closed = np.append(phi, phi[0] + TURN_RAD)
    area = float(np.trapezoid(np.append(r, r[0]) ** 2, closed)) / 2
    least, largest = extremes_of(outline)
    circles = 2 * least, 2 * largest
    return Measures(*circles, float(width.min()), float(width.max()), area)


def is_smooth(joint: OutlineJoint) -> bool:
    """Return whether nothing jumps at a joint but rounding."""
    return abs(joint.slope_mm) < _SAME_MM and abs(joint.bend_mm) < _SAME_BEND_MM
