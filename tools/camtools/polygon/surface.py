"""From an outline to the surface that gauge and table are judged against: polynomial pieces.

All sections are similar: the radius at a height is that of the first height times a factor that
grows linearly, 1 without a taper, MATHS.md (118).

>>> from camtools.polygon.shapes import p4c
>>> prism = prism_of(p4c(35.0, 30.0, 5.0, 0.0), 17.5, (0.0, 10.0), (1.0, 1.0))
>>> prism.log2_repeat, f"{float(prism.delta(np.pi / 4, 5.0).delta):.9f}"
(2, '2.500000000')
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.polygon.curves import Curve
from camtools.polygon.outline import TURN_RAD, Outline
from camtools.skirt.geometry.poly_surface import N_ANGLE, N_HEIGHT, PolySurface
from camtools.table.channel import MAX_LOG2_REPEAT
from camtools.table.quintics import segment_coefficients

_FIT_MM = 1e-10  # a ten-thousandth of a nanometre
_MAX_HALVINGS = 16
_BETWEEN = np.array([0.2, 0.5, 0.8])
_LEAST_RAD = 1e-12


def _quintics(curve: Curve, first: Floats, last: Floats) -> tuple[Floats, Floats]:
    """Return quintics (n, 6) through the ends of stretches of a curve, and how far each is off."""
    h = last - first
    at = curve.polar(np.concatenate([first, last]))
    r, d1, d2 = (one.reshape(2, -1) for one in (at.r, at.d1, at.d2))
    knots = np.stack([r, h * d1, h**2 / 2 * d2], axis=-1).transpose(1, 0, 2)
    quintics = np.asarray(segment_coefficients(knots, periodic=False)[:, 0], dtype=np.float64)
    exact = curve.polar((first[:, None] + h[:, None] * _BETWEEN).ravel()).r
    off = quintics @ _BETWEEN ** np.arange(N_ANGLE)[:, None] - exact.reshape(first.size, -1)
    return quintics, np.asarray(np.abs(off).max(axis=1), dtype=np.float64)


def _fitted(outline: Outline, first_rad: float, last_rad: float) -> tuple[Floats, Floats]:
    """Return left ends [rad] and quintics (n, 6) of the radius between two neighbouring joints.

    Stretches are halved until their quintics fit.
    """
    curve = outline.curve_at((first_rad + last_rad) / 2)
    first, last = np.array([first_rad]), np.array([last_rad])
    starts, found = [], []
    for _ in range(_MAX_HALVINGS):
        quintics, off = _quintics(curve, first, last)
        is_close = off <= _FIT_MM
        starts.append(first[is_close])
        found.append(quintics[is_close])
        low, high = first[~is_close], last[~is_close]
        if not low.size:
            break
        middle = (low + high) / 2
        first, last = np.concatenate([low, middle]), np.concatenate([middle, high])
    else:
        where = f"at {np.degrees(float(low[0])):.4g} degrees"
        problem = f"is too small: {where} the outline bends too sharply"
        raise GeometryError("polygon.blend_um", problem, "allow more deviation")
    left = np.concatenate(starts)
    order = np.argsort(left)
    return left[order], np.concatenate(found)[order]


def prism_of(
    outline: Outline,
    largest_mm: float,
    heights_mm: tuple[float, float],
    factors: tuple[float, float],
) -> PolySurface:
    """Return the surface of an outline.

    Parameters
    ----------
    largest_mm : float
        Radius from which the reduction counts.
    factors : tuple of float
        Size of the sections at both heights over that of the outline.
    """
    joints = np.mod(np.array(outline.starts_rad), TURN_RAD)
    borders = np.unique(np.concatenate([[0.0, TURN_RAD], joints]))
    keep = np.append(np.diff(borders) > _LEAST_RAD, True)
    borders = borders[keep]
    borders[0], borders[-1] = 0.0, TURN_RAD
    found = [_fitted(outline, a, b) for a, b in pairwise(borders)]
    breaks = np.concatenate([*(one[0] for one in found), [TURN_RAD]]) / TURN_RAD
    quintics = -np.concatenate([one[1] for one in found])
    quintics[:, 0] += largest_mm
    coefficients = np.zeros((1, quintics.shape[0], N_ANGLE, N_HEIGHT))
    coefficients[0, ..., 0] = factors[0] * quintics
    coefficients[0, ..., 1] = (factors[1] - factors[0]) * quintics
    log2 = min(MAX_LOG2_REPEAT, (outline.repeat & -outline.repeat).bit_length() - 1)
    heights = np.asarray(heights_mm, dtype=np.float64)
    return PolySurface(breaks, heights, coefficients, log2_alike=log2)
