"""The waves of a gauged surface that exceed its noise, MATHS.md (157) .. (159).

>>> turn, z_mm = np.tile(np.arange(72) / 72, 9), np.repeat(np.linspace(0, 40, 9), 72)
>>> noise_um = np.random.default_rng(1).normal(0, 0.05, turn.size)
>>> gauged = GaugedPoints(turn, z_mm, 2 * np.cos(6 * np.pi * turn) + noise_um)
>>> found = fit_surface(gauged, (0.0, 40.0))
>>> [one.order for one in found.waves if one.is_kept], f"{found.sigma_um:.2f}"
([3], '0.05')
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Bools, Floats
from camtools.cut.correction import Complexes, Correction, nodes_of
from camtools.measured.heights import MIN_HEIGHTS, Heights, by_height
from camtools.measured.points import GaugedPoints
from camtools.measured.smoothing import Smoothed, Smoother, off_neighbours, scatter, shares_kept
from camtools.measured.waves import fit_waves

_PASSES = 3
_END_SHARE, _GAP_SHARE = 0.2, 0.5  # of the part's height that may lie beyond, or between, heights
_ALONE = 8.0  # times the usual distance from the neighbours
_MOST_ALONE = 0.1  # of all heights
_MOST_WIDE = 3.0  # times the usual number of points; a wider band is not left out
_MOST_DUST = 0.03  # of the points of a height; more of them are the surface itself
_MM_PER_UM = 1e-3
LEAST_UM = 1e-3  # a nanometre, the tolerance of a table


class KeptWave(NamedTuple):
    """One order over the heights, all of shape (n,) [um]."""

    order: int
    smooth: Smoothed
    kept: Complexes

    @property
    def is_kept(self) -> bool:
        """Return whether anything of it stands above its noise."""
        return bool(self.kept.any())


class SurfaceFit(NamedTuple):
    """The waves of a gauged surface over its heights.

    Attributes
    ----------
    alone_mm : list of float
        Heights that do not count because they differ from both their neighbours.
    counts : ndarray
        Of each point, whether it counts: its height is not left out, and it is not far off. Where
        a height has many points that are far off, they are edges of a gap and count everywhere.
    """

    z_mm: Floats  # shape (n,); heights that count
    waves: list[KeptWave]  # from the mean on
    sigma_um: float  # standard deviation of a point about the waves, the median of all heights
    n_far: int  # points that do not count because they are far from the waves of their height
    counts: Bools  # shape (number of points,)
    alone_mm: list[float]
    heights: Heights  # as the points were divided

    def correction(self, ends_mm: tuple[float, float], gain: float) -> Correction:
        """Return what is kept as a correction of this gain."""
        kept = {one.order: gain * one.kept for one in self.waves if one.is_kept}
        return _over_part(self.z_mm, kept, ends_mm)


def _over_part(
    z_mm: Floats, waves_um: dict[int, Complexes], ends_mm: tuple[float, float]
) -> Correction:
    """Return waves at some heights as values at the nodes of a part.

    Beyond the outer heights a wave goes on for half a step, and then keeps its value.
    """
    lowest_mm = z_mm[0] - (z_mm[1] - z_mm[0]) / 2
    highest_mm = z_mm[-1] + (z_mm[-1] - z_mm[-2]) / 2
    at = np.clip(nodes_of(ends_mm), lowest_mm, highest_mm)
    values: dict[int, Complexes] = {}
    for order, wave in waves_um.items():
        curve = CubicSpline(z_mm, _MM_PER_UM * wave, bc_type="natural")
        values[order] = np.asarray(curve(at), dtype=np.complex128)
    return Correction(ends_mm, values)


def check_heights(z_mm: Floats, ends_mm: tuple[float, float]) -> None:
    """Refuse heights that leave too much of a part unknown.

    Raises
    ------
    CamtoolsError
        With the numbers and the limits.
    """
    height_mm = ends_mm[1] - ends_mm[0]
    steps = np.diff(np.concatenate([ends_mm[:1], z_mm, ends_mm[1:]]))
    part = f"the part's {ends_mm[0]:g} .. {ends_mm[1]:g} mm"
    if max(steps[0], steps[-1]) > _END_SHARE * height_mm:
        problem = (
            f"heights {z_mm[0]:.6g} .. {z_mm[-1]:.6g} mm leave more than "
            f"{100 * _END_SHARE:g} % of {part} beyond an end"
        )
        raise CamtoolsError([f"--measured: {problem}; gauge nearer to the ends"])
    worst = int(np.argmax(steps[1:-1]))
    if steps[1 + worst] > _GAP_SHARE * height_mm:
        problem = (
            f"no height between {z_mm[worst]:.6g} and {z_mm[worst + 1]:.6g} mm, more than "
            f"{100 * _GAP_SHARE:g} % of {part}"
        )
        raise CamtoolsError([f"--measured: {problem}; gauge heights between them"])


def _lone(z_mm: Floats, waves: Complexes) -> int | None:
    """Return a height that differs from both its neighbours, while they agree with theirs."""
    if z_mm.size < 2 * MIN_HEIGHTS:
        return None
    off = np.sqrt((np.abs(off_neighbours(z_mm, waves)) ** 2).sum(axis=0))
    worst = int(np.argmax(off))
    others = np.delete(np.arange(z_mm.size), worst + 1)
    without = np.sqrt((np.abs(off_neighbours(z_mm[others], waves[:, others])) ** 2).sum(axis=0))
    near = without[max(0, worst - 1) : worst + 1]
    limit = _ALONE * float(np.median(without))
    return worst + 1 if off[worst] > limit and near.max(initial=0.0) < limit / 2 else None


def _smooth(z_mm: Floats, waves: Complexes, white: Floats) -> list[Smoothed]:
    """Return each order smoothed by its noise, the larger one of both estimates."""
    smoother, found = Smoother(z_mm), []
    for order, values in enumerate(waves):
        rough = scatter(z_mm, values, is_real=order == 0)
        found.append(smoother.smooth(values, max(rough, float(white[order]))))
    return found


def fit_surface(
    points: GaugedPoints,
    ends_mm: tuple[float, float],
    most_order: int | None = None,
    first: int = 0,
) -> SurfaceFit:
    """Return the waves of a gauged surface.

    Each pass fits the waves of every height to what the smooth waves of the pass before leave of
    its points, so that heights which run through within a band do no harm.

    Parameters
    ----------
    ends_mm : tuple of float
        Of the part.
    most_order : int, optional
        See `by_height`.
    first : int
        First order that may be kept.

    Raises
    ------
    CamtoolsError
        Too few heights or angles.
    """
    heights = by_height(points, most_order)
    z_mm = np.array([height.z_mm for height in heights.heights])
    check_heights(z_mm, ends_mm)
    sizes = np.array([height.rows.size for height in heights.heights])
    use = np.arange(z_mm.size)
    off_um, base = points.deviation_um, np.zeros((heights.most_order + 1, z_mm.size), complex)
    alone_mm: list[float] = []
    for _ in range(_PASSES):
        fits = [
            fit_waves(points.turn[height.rows], off_um[height.rows], heights.most_order)
            for height in heights.heights
        ]
        waves = base + np.array([fit.waves for fit in fits]).T
        while len(alone_mm) < _MOST_ALONE * z_mm.size:
            lone = _lone(z_mm[use], waves[:, use])
            if lone is None or sizes[use[lone]] > _MOST_WIDE * np.median(sizes):
                break
            alone_mm.append(float(z_mm[use[lone]]))
            use = np.delete(use, lone)
        white = np.median([fits[i].variances for i in use], axis=0)
        smooth = _smooth(z_mm[use], waves[:, use], white)
        curves = {order: one.values for order, one in enumerate(smooth)}
        model = _over_part(z_mm[use], curves, (float(z_mm[0]), float(z_mm[-1])))
        off_um = points.deviation_um - taken_um(model, points)
        for order in curves:
            base[order] = _at(model, order, z_mm)
    found = [
        KeptWave(order, one, _kept(one) if order >= first else 0 * one.values)
        for order, one in enumerate(smooth)
    ]
    sigma_um = float(np.median([fits[i].sigma for i in use]))
    counts = np.zeros(points.turn.size, dtype=np.bool_)
    has_edges = max(fits[i].is_far.mean() for i in use) > _MOST_DUST
    for i in use:
        counts[heights.heights[i].rows] = ~fits[i].is_far | has_edges
    n_far = sum(int(np.count_nonzero(fits[i].is_far)) for i in use)
    return SurfaceFit(z_mm[use], found, sigma_um, n_far, counts, sorted(alone_mm), heights)


def _kept(one: Smoothed) -> Complexes:
    """Return what is kept of a wave: nothing below what a table resolves."""
    kept = one.values * shares_kept(one)
    return kept if np.abs(kept).max() >= LEAST_UM else 0 * kept


def _at(model: Correction, order: int, z_mm: Floats) -> Complexes:
    """Return a wave of a model at heights [um]."""
    curve = CubicSpline(model.nodes_mm, model.waves_mm[order], bc_type="natural")
    return np.asarray(curve(np.clip(z_mm, *model.heights_mm)) / _MM_PER_UM, dtype=np.complex128)


def taken_um(correction: Correction, points: GaugedPoints) -> Floats:
    """Return what a correction takes off at points [um]."""
    z_mm = np.clip(points.z_mm, *correction.heights_mm)
    waves = correction.delta(2 * np.pi * points.turn, z_mm)[0]
    return np.asarray((waves + correction.mean(z_mm)) / _MM_PER_UM, dtype=np.float64)
