"""Radii of polygons by other methods than camtools': tangents, circles, distances from a core.

Nothing here uses the curves, roots or pieces of camtools.polygon.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_COARSE, _FINE = 4001, 60


def envelope_mm(
    phi: Floats, mean_mm: float, eccentricity_mm: float, n: int, reach_rad: float
) -> Floats:
    """Return how far a ray goes until the first tangent stops it.

    A convex contour is what all of its tangents leave: r = min p(a) / cos(phi - a), over the
    directions a of the normals, here within `reach_rad` of the ray. Golden sections find the least.
    """

    def stop(a: Floats, at: Floats) -> Floats:
        return np.asarray((mean_mm - eccentricity_mm * np.cos(n * a)) / np.cos(at - a))

    grid = np.linspace(-reach_rad, reach_rad, _COARSE)
    best = np.array([stop(one + grid, one).argmin() for one in phi])
    low, high = phi + grid[np.maximum(0, best - 1)], phi + grid[np.minimum(_COARSE - 1, best + 1)]
    ratio = (np.sqrt(5) - 1) / 2
    for _ in range(_FINE):
        a, b = high - ratio * (high - low), low + ratio * (high - low)
        is_left = stop(a, phi) < stop(b, phi)
        low, high = np.where(is_left, low, a), np.where(is_left, b, high)
    return stop((low + high) / 2, phi)


def p3g_mm(phi: Floats, mean_diameter_mm: float, eccentricity_mm: float) -> Floats:
    """Return the radius of DIN 32711, a corner at angle 0: the tangent there is farthest."""
    # a corner at 0: p(a) = dm / 2 + e cos 3a = dm / 2 - e cos 3 (a - 60 degrees)
    return envelope_mm(phi - np.pi / 3, mean_diameter_mm / 2, eccentricity_mm, 3, 1.0)


def p4c_mm(phi: Floats, outer_mm: float, inner_mm: float, eccentricity_mm: float) -> Floats:
    """Return the radius of DIN 32712, a corner at angle 0: flank or circle, what comes first."""
    from_flank = np.mod(phi, np.pi / 2) - np.pi / 4
    mean = inner_mm / 2 + eccentricity_mm
    # tangents near the middle of the flank only: beyond its loops it has others
    last = (
        float(np.arccos(-mean / (15 * eccentricity_mm))) / 4 if mean < 15 * eccentricity_mm else 0.7
    )
    normals = np.linspace(-last, last, 200_001)
    p = mean - eccentricity_mm * np.cos(4 * normals)
    p1 = 4 * eccentricity_mm * np.sin(4 * normals)
    x, y = p * np.cos(normals) - p1 * np.sin(normals), p * np.sin(normals) + p1 * np.cos(normals)
    inside = np.hypot(x, y) < 0.75 * outer_mm
    x, y = x[inside], y[inside]
    # the chord that the ray meets, then the same between two points of the contour, finely
    angle = np.arctan2(y, x)
    i = np.clip(np.searchsorted(angle, from_flank), 1, angle.size - 1)
    ux, uy = np.cos(from_flank), np.sin(from_flank)
    dx, dy = x[i] - x[i - 1], y[i] - y[i - 1]
    chord = (x[i] * dy - y[i] * dx) / (ux * dy - uy * dx)
    return np.asarray(np.minimum(chord, outer_mm / 2), dtype=np.float64)


def rounded_mm(phi: Floats, corners: Floats, radius_mm: float) -> Floats:
    """Return the radius of a convex polygon with rounded corners: all points near its core.

    The core is the polygon moved inwards by the radius; the outline is where the distance from
    the core is the radius. A bisection on the ray finds it.
    """
    core = _inset(corners, radius_mm)
    low, high = np.zeros(phi.size), np.full(phi.size, 2 * float(np.abs(corners).max()) + 1)
    ray = np.stack([np.cos(phi), np.sin(phi)], axis=-1)
    for _ in range(60):
        middle = (low + high) / 2
        is_in = _distance(middle[:, None] * ray, core) <= radius_mm
        low, high = np.where(is_in, middle, low), np.where(is_in, high, middle)
    return np.asarray((low + high) / 2, dtype=np.float64)


def _inset(corners: Floats, by_mm: float) -> Floats:
    """Return the corners of a convex polygon whose sides are moved inwards."""
    side = np.roll(corners, -1, axis=0) - corners
    normal = np.stack([side[:, 1], -side[:, 0]], axis=-1) / np.hypot(*side.T)[:, None]
    reach = (corners * normal).sum(axis=1) - by_mm
    found = [
        np.linalg.solve(np.stack([normal[i - 1], normal[i]]), [reach[i - 1], reach[i]])
        for i in range(reach.size)
    ]
    return np.array(found)


def _distance(points: Floats, core: Floats) -> Floats:
    """Return the distance of points from a convex polygon, 0 inside."""
    best = np.full(points.shape[0], np.inf)
    is_inside = np.ones(points.shape[0], dtype=bool)
    for a, b in zip(core, np.roll(core, -1, axis=0), strict=True):
        along = b - a
        off = points - a
        share = np.clip(off @ along / (along @ along), 0, 1)
        best = np.minimum(best, np.hypot(*(off - share[:, None] * along).T))
        is_inside &= along[0] * off[:, 1] - along[1] * off[:, 0] >= 0
    return np.where(is_inside, 0.0, best)


def regular_corners(n: int, across_mm: float) -> Floats:
    """Return the corners of a regular polygon, one at angle 0."""
    out = across_mm / 2 / np.cos(np.pi / n)
    angle = 2 * np.pi * np.arange(n) / n
    corners = out * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return np.asarray(corners, dtype=np.float64)
