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
from camtools.polygon.outline import TURN_RAD, Outline
from camtools.skirt.poly_surface import N_ANGLE, N_HEIGHT, PolySurface
from camtools.table.image import MAX_LOG2_REPEAT
from camtools.table.quintics import segment_coefficients

_FIT_MM = 1e-10  # a ten-thousandth of a nanometre
_COUNTS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512)
_BETWEEN = np.array([0.2, 0.5, 0.8])
_LEAST_RAD = 1e-12


def _fitted(outline: Outline, first_rad: float, last_rad: float) -> tuple[Floats, Floats]:
    """Return breaks [rad] and quintics (n, 6) of the radius between two neighbouring joints."""
    for count in _COUNTS:
        breaks = np.linspace(first_rad, last_rad, count + 1)
        h = (last_rad - first_rad) / count
        ends = np.stack([breaks[:-1], breaks[1:]], axis=-1)
        # the ends belong to the curve between them, not to its neighbours
        curve = outline.curve_at((first_rad + last_rad) / 2)
        at = curve.polar(ends.ravel())
        knots = np.stack([at.r, h * at.d1, h**2 / 2 * at.d2], axis=-1).reshape(count, 2, 3)
        quintics = segment_coefficients(knots, periodic=False)[:, 0]
        between = (breaks[:-1, None] + h * _BETWEEN).ravel()
        exact = curve.polar(between).r.reshape(count, -1)
        got = quintics @ _BETWEEN ** np.arange(N_ANGLE)[:, None]
        if np.abs(got - exact).max() <= _FIT_MM:
            return breaks, np.asarray(quintics, dtype=np.float64)
    problem = f"is too small: at {np.degrees(first_rad):.4g} degrees the outline bends too sharply"
    raise GeometryError("polygon.blend_um", problem, "allow more deviation")


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
    breaks = np.concatenate([*(one[0][:-1] for one in found), [TURN_RAD]]) / TURN_RAD
    quintics = -np.concatenate([one[1] for one in found])
    quintics[:, 0] += largest_mm
    coefficients = np.zeros((1, quintics.shape[0], N_ANGLE, N_HEIGHT))
    coefficients[0, ..., 0] = factors[0] * quintics
    coefficients[0, ..., 1] = (factors[1] - factors[0]) * quintics
    log2 = min(MAX_LOG2_REPEAT, (outline.repeat & -outline.repeat).bit_length() - 1)
    heights = np.asarray(heights_mm, dtype=np.float64)
    return PolySurface(breaks, heights, coefficients, log2_alike=log2)
