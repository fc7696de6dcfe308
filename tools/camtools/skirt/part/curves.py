"""Curves over height: through points, or by formula, MATHS.md (98), (99).

linear   a polygon
pchip    monotone between any two points, continuous slope, MATHS.md (72)
akima    close to the polygon, continuous slope, little overshoot
spline   cubic, continuous curvature, not-a-knot unless told otherwise, MATHS.md (6)

>>> round(overshoot(through([0, 2, 10, 20], [91, 91.95, 91.985, 92], "spline")).beyond, 3)
0.776
>>> overshoot(through([0, 2, 10, 20], [91, 91.95, 91.985, 92], "pchip")).beyond
0.0

>>> law = PowerProfile(
...     law="power", range_mm=[0, 62], peak_height_mm=20, peak_diameter_mm=92,
...     coefficient=7.4546e-05, exponent=2,
... )
>>> law.height_mm, [f"{mm:.3f}" for mm in law.diameter_mm]
([0.0, 20.0, 62.0], ['91.940', '92.000', '91.737'])
>>> f"{float(law.curve()(5.0)):.9f}"
'45.983227150'
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import Discriminator, Field, field_validator, model_validator
from scipy.interpolate import (
    Akima1DInterpolator,
    CubicHermiteSpline,
    CubicSpline,
    PchipInterpolator,
    PPoly,
)

from camtools.base.quantities import Floats
from camtools.part.model import MIN_STEP_MM, HeightMm, TomlTable, rising, wrong

Interpolation = Literal["linear", "pchip", "akima", "spline"]


class Overshoot(NamedTuple):
    """Where a curve leaves the values of its two neighbouring points most."""

    beyond: float  # unit of the curve; 0: nowhere
    z_mm: float
    low_mm: float  # the two points
    high_mm: float


def through(
    z_mm: Sequence[float] | Floats,
    values: Sequence[float] | Floats,
    interpolation: str,
    ends: object = "not-a-knot",
) -> PPoly:
    """Return the curve through points as cubics over height; ends as `CubicSpline` takes them."""
    z, v = np.asarray(z_mm, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if interpolation == "spline":
        return CubicSpline(z, v, bc_type=ends)
    if interpolation == "linear" or z.size == 2:
        zero = np.zeros(z.size - 1)
        return PPoly(np.array([zero, zero, np.diff(v) / np.diff(z), v[:-1]]), z)
    curve = {"pchip": PchipInterpolator, "akima": Akima1DInterpolator}[interpolation](z, v)
    return PPoly(curve.c, curve.x)


def overshoot(curve: PPoly, points_mm: Floats | None = None) -> Overshoot:
    """Return where a curve leaves the values of two neighbouring points most, MATHS.md (73).

    The heights of the points rise; by default they are the ends of the curve's pieces.
    """
    z = np.asarray(curve.x if points_mm is None else points_mm, dtype=np.float64)
    turning = curve.derivative().roots(extrapolate=False)
    places = turning[np.isfinite(turning) & (turning > z[0]) & (turning < z[-1])]
    if not places.size:
        return Overshoot(0.0, float(z[0]), float(z[0]), float(z[-1]))
    i = np.clip(np.searchsorted(z, places, side="right") - 1, 0, z.size - 2)
    at_points, there = curve(z), curve(places)
    above = there - np.maximum(at_points[i], at_points[i + 1])
    below = np.minimum(at_points[i], at_points[i + 1]) - there
    beyond = np.maximum(above, below)
    worst = int(np.argmax(beyond))
    around = float(z[i[worst]]), float(z[i[worst] + 1])
    return Overshoot(max(0.0, float(beyond[worst])), float(places[worst]), *around)


LAW_ERROR_MM = 1e-9  # of the cubic pieces from the formula: a thousandth of a nanometre
_HERMITE = 384.0  # a cubic through values and slopes errs by h^4 max|f''''| / 384
_LEAST_STEP_MM = 1e-3
_MAX_DROP = 0.5  # of the peak's half axis: beyond it the formula is no skirt


def _law_or_points(value: object) -> str:
    has_law = "law" in value if isinstance(value, dict) else hasattr(value, "law")
    return "(law)" if has_law else "(points)"


LAW_OR_POINTS = Discriminator(_law_or_points)  # members have these tags: findings leave them out


class _Law(TomlTable):
    """What both formulas have: the range in which they hold and the height of the peak."""

    range_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=2)] = Field(
        description="heights between which the formula holds"
    )
    peak_height_mm: HeightMm = Field(description="h0")

    _check_range = field_validator("range_mm")(rising)

    @property
    def height_mm(self) -> list[float]:
        """Return the ends of the range, and the peak where it lies inside, rising."""
        first, last = (float(one) for one in self.range_mm)
        is_inside = first + MIN_STEP_MM <= self.peak_height_mm <= last - MIN_STEP_MM
        return [first, float(self.peak_height_mm), last] if is_inside else [first, last]

    def _from_peak_mm(self) -> Floats:
        return np.abs(np.array(self.height_mm) - self.peak_height_mm)


class PowerProfile(_Law):
    """[piston.profile]: by formula, a(h) = a0 - K |h - h0|^m, MATHS.md (98)."""

    law: Literal["power"]
    peak_diameter_mm: float = Field(ge=1, le=4000, description="2 a0")
    coefficient: float = Field(ge=0, le=1, description="K, mm of the radius per mm^m")
    exponent: float = Field(2.0, ge=2, le=8, description="m")  # below 2 X would jump

    @model_validator(mode="after")
    def _check_drop(self) -> Self:
        peak_mm = self.peak_diameter_mm / 2
        drop_mm = self.coefficient * float(self._from_peak_mm().max()) ** self.exponent
        if drop_mm > _MAX_DROP * peak_mm:
            problem = f"makes the half axis {drop_mm:.6g} of {peak_mm:g} mm smaller at an end"
            context = {"field": "coefficient", "value": self.coefficient}
            raise wrong("drop", problem, "give mm of radius per mm of height^exponent", **context)
        return self

    @property
    def diameter_mm(self) -> list[float]:
        """Return the diameters at `height_mm`."""
        drop = self.coefficient * self._from_peak_mm() ** self.exponent
        return [float(one) for one in self.peak_diameter_mm - 2 * drop]

    def curve(self) -> PPoly:
        """Return a(h) [mm] in cubic pieces: exact for exponents 2 and 3, else to LAW_ERROR_MM."""
        first, last = (float(one) for one in self.range_mm)
        below = self._breaks(max(0.0, self.peak_height_mm - last), self.peak_height_mm - first)
        above = self._breaks(max(0.0, first - self.peak_height_mm), last - self.peak_height_mm)
        z_mm = np.concatenate([self.peak_height_mm - below[::-1], self.peak_height_mm + above])
        z_mm = np.unique(np.clip(z_mm, first, last))
        return self._hermite(z_mm[np.append(True, np.diff(z_mm) > _LEAST_STEP_MM / 2)])

    def _breaks(self, near_mm: float, far_mm: float) -> Floats:
        """Return distances from the peak between which a cubic keeps the error, rising."""
        if far_mm <= near_mm:
            return np.array([])
        k, m = self.coefficient, self.exponent
        fourth = k * m * (m - 1) * (m - 2) * abs(m - 3)
        if fourth == 0:
            return np.array([near_mm, far_mm])
        places = [far_mm]
        while places[-1] > near_mm:
            here = places[-1]
            step = here / 8  # where the fourth derivative grows inwards, it is that of here - step
            for _ in range(3):
                steepest = max(here ** (m - 4), max(here - step, _LEAST_STEP_MM) ** (m - 4))
                step = min(here / 2, (_HERMITE * LAW_ERROR_MM / (fourth * steepest)) ** 0.25)
            places.append(max(near_mm, here - step) if here > _LEAST_STEP_MM else near_mm)
        return np.array(places[::-1])

    def _hermite(self, z_mm: Floats) -> PPoly:
        """Return the cubics through values and slopes of the formula at rising heights."""
        off = z_mm - self.peak_height_mm
        k, m = self.coefficient, self.exponent
        a = self.peak_diameter_mm / 2 - k * np.abs(off) ** m
        slope = -k * m * np.sign(off) * np.abs(off) ** (m - 1)
        return CubicHermiteSpline(z_mm, a, slope)


class PeakOvality(_Law):
    """[piston.ovality]: by formula, G(h) = p (G0 - kG |h - h0|), MATHS.md (99)."""

    law: Literal["peak"]
    peak_ovality_mm: float = Field(ge=0, le=4000, description="G0")
    fall_mm_per_mm: float = Field(ge=-100, le=100, description="kG; below 0 the peak is the least")
    is_oval: bool = Field(True, description="p; false makes a round skirt")
    interpolation: Literal["linear"] = Field("linear", description="of lists of the section")

    @model_validator(mode="after")
    def _check_least(self) -> Self:
        least = min(self.ovality_mm)
        if least < 0:
            problem = f"makes the ovality fall to {least:.6g} mm at an end"
            context = {"field": "fall_mm_per_mm", "value": self.fall_mm_per_mm}
            raise wrong("least", problem, "give less of it, or more peak_ovality_mm", **context)
        return self

    @property
    def ovality_mm(self) -> list[float]:
        """Return the ovalities at `height_mm`."""
        g = self.peak_ovality_mm - self.fall_mm_per_mm * self._from_peak_mm()
        return [float(one) for one in (g if self.is_oval else 0.0 * g)]
