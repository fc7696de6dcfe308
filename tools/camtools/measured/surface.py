"""The waves of a gauged surface that exceed its noise, MATHS.md (157) .. (159).

>>> turn = np.arange(360) / 360
>>> values = 0.5 + 2 * np.cos(4 * np.pi * turn - 1)
>>> values[7] += 1000
>>> found = fit_waves(turn, values, 4)
>>> np.abs(found.waves).round(6).tolist(), float(np.angle(found.waves[2]).round(6))
([0.5, 0.0, 2.0, 0.0, 0.0], 1.0)

>>> z = np.linspace(0, 60, 40)
>>> rng = np.random.default_rng(3)
>>> noise = rng.normal(0, 0.1, (2, 40))
>>> noisy = 2 * np.exp(1j * z / 30) + noise[0] + 1j * noise[1]
>>> found = Smoother(z).smooth(noisy, scatter(z, noisy))
>>> bool(np.abs(found.values - 2 * np.exp(1j * z / 30)).max() < 0.12)
True

>>> turn, z_mm = np.tile(np.arange(72) / 72, 9), np.repeat(np.linspace(0, 40, 9), 72)
>>> noise_um = np.random.default_rng(1).normal(0, 0.05, turn.size)
>>> gauged = GaugedPoints(turn, z_mm, 2 * np.cos(6 * np.pi * turn) + noise_um)
>>> found = fit_surface(gauged, (0.0, 40.0))
>>> [wave.order for wave in found.waves if wave.is_kept], f"{found.sigma_um:.2f}"
([3], '0.05')
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Bools, Floats
from camtools.cut.correction import Complexes, Correction, nodes_of
from camtools.measured.points import MIN_HEIGHTS, GaugedPoints, Heights, by_height

_ROUNDS = 8
_HUBER = 2.0  # standard deviations from which on a point counts less
_FAR = 6.0  # .. and from which on it does not count
_TO_SIGMA = 1.4826  # of the median of magnitudes of a normal distribution
_LEAST = 1e-12


class HeightWaves(NamedTuple):
    """The waves of one height."""

    waves: Complexes  # (order + 1,): value = Re sum c_k e^(-j k phi)
    sigma: float  # standard deviation of a point about the waves
    variances: Floats  # (order + 1,) of the waves, real and imaginary part together
    is_far: Bools  # of each point, whether it is beyond six standard deviations and does not count


def fit_waves(turn: Floats, values: Floats, order: int) -> HeightWaves:
    """Return the waves up to an order through the points of a height."""
    phi, n_unknown = 2 * np.pi * turn[:, None] * np.arange(order + 1), 2 * order + 1
    basis = np.hstack([np.cos(phi), np.sin(phi[:, 1:])])  # the mean has no sine
    weight, sigma = np.ones(turn.size), 0.0
    for _ in range(_ROUNDS):
        weighted = weight[:, None] * basis
        found = np.linalg.solve(weighted.T @ basis, weighted.T @ values)
        off = np.abs(values - basis @ found)
        sigma = _TO_SIGMA * float(np.median(off)) * np.sqrt(off.size / (off.size - n_unknown))
        limit = max(sigma, _LEAST)
        weight = np.minimum(1.0, _HUBER * limit / np.maximum(off, _LEAST))
        weight[off > _FAR * limit] = 0.0
        if np.count_nonzero(weight) <= n_unknown:
            weight = np.ones(turn.size)
            break
    variances = np.full(order + 1, 4 * sigma**2 / turn.size)
    variances[0] /= 4
    waves = found[: order + 1] + 1j * np.append(0.0, found[order + 1 :])
    return HeightWaves(waves, sigma, variances, weight == 0)


_MEDIAN_COMPLEX, _MEDIAN_REAL = float(np.log(2)), 0.454936  # of |noise|^2 over its mean
_CAUTION = 1.5  # of each degree of freedom in Mallows' criterion
_GRID = 10.0 ** np.arange(-6, 10, 0.125)
_KEPT_WHOLE = 6.0  # energy over that of the noise from which on a wave is kept at all
_LOCAL = 2.0  # standard errors that are taken off at a height
MIN_FOR_SCATTER = 6


def off_neighbours(z_mm: Floats, values: Complexes) -> Complexes:
    """Return by how much values leave the line through their neighbours, over its noise."""
    below = (z_mm[2:] - z_mm[1:-1]) / (z_mm[2:] - z_mm[:-2])
    above = 1 - below
    off = values[..., 1:-1] - below * values[..., :-2] - above * values[..., 2:]
    return np.asarray(off / np.sqrt(1 + below**2 + above**2), dtype=np.complex128)


def scatter(z_mm: Floats, values: Complexes, *, is_real: bool = False) -> float:
    """Return the variance of values that change smoothly over the height but for noise.

    MATHS.md (158); 0 where there are too few heights.
    """
    if z_mm.size < MIN_FOR_SCATTER:
        return 0.0
    median = _MEDIAN_REAL if is_real else _MEDIAN_COMPLEX
    return float(np.median(np.abs(off_neighbours(z_mm, values)) ** 2)) / median


class Smoothed(NamedTuple):
    """A wave over the height."""

    values: Complexes  # (n,)
    errors: Floats  # (n,) standard errors


class Smoother:
    """Natural cubic smoothing splines over heights, MATHS.md (159)."""

    def __init__(self, z_mm: Floats) -> None:
        n, h = z_mm.size, np.diff(z_mm) / float(np.ptp(z_mm))
        i = np.arange(n - 2)
        q, r = np.zeros((n, n - 2)), np.zeros((n - 2, n - 2))
        q[i, i], q[i + 1, i], q[i + 2, i] = 1 / h[:-1], -1 / h[:-1] - 1 / h[1:], 1 / h[1:]
        r[i, i] = (h[:-1] + h[1:]) / 3
        r[i[:-1], i[1:]] = r[i[1:], i[:-1]] = h[1:-1] / 6
        bends, self._modes = np.linalg.eigh(q @ np.linalg.solve(r, q.T))
        self._bends = np.where(np.arange(n) < 2, 0.0, np.maximum(bends, 0.0))

    def smooth(self, values: Complexes, variance: float) -> Smoothed:
        """Return the curve with the least expected error for a noise of this variance."""
        modes = self._modes.T @ values
        energy = np.abs(modes) ** 2
        kept = 1 / (1 + self._bends / np.median(self._bends[2:]) / _GRID[:, None])
        risk = ((1 - kept) ** 2 @ energy) + 2 * _CAUTION * variance * kept.sum(axis=1)
        share = kept[int(np.argmin(risk))]
        errors = np.sqrt(variance * (self._modes**2 @ share**2))
        return Smoothed(np.asarray(self._modes @ (share * modes), dtype=np.complex128), errors)


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

    A point counts unless its height is left out or it is far off. Where a height has many points
    that are far off, they are edges of a gap and count everywhere.
    """

    z_mm: Floats  # shape (n,); heights that count
    waves: list[KeptWave]  # from the mean on
    sigma_um: float  # standard deviation of a point about the waves, the median of all heights
    n_far: int  # points that do not count because they are far from the waves of their height
    counts: Bools  # shape (number of points,)
    alone_mm: list[float]  # heights left out because they differ from both their neighbours
    heights: Heights  # as the points were divided

    def correction(self, ends_mm: tuple[float, float], gain: float) -> Correction:
        """Return what is kept as a correction of this gain."""
        kept = {wave.order: gain * wave.kept for wave in self.waves if wave.is_kept}
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
    """Refuse heights that leave too much of a part unknown."""
    height_mm = ends_mm[1] - ends_mm[0]
    steps = np.diff(np.concatenate([ends_mm[:1], z_mm, ends_mm[1:]]))
    part = f"the part's {ends_mm[0]:g} .. {ends_mm[1]:g} mm"
    if max(steps[0], steps[-1]) > _END_SHARE * height_mm:
        problem = f"heights {z_mm[0]:.6g} .. {z_mm[-1]:.6g} mm leave more than "
        problem += f"{100 * _END_SHARE:g} % of {part} beyond an end"
        raise CamtoolsError([f"--measured: {problem}; gauge nearer to the ends"])
    worst = int(np.argmax(steps[1:-1]))
    if steps[1 + worst] > _GAP_SHARE * height_mm:
        problem = f"no height between {z_mm[worst]:.6g} and {z_mm[worst + 1]:.6g} mm, more than "
        problem += f"{100 * _GAP_SHARE:g} % of {part}"
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
    smoother = Smoother(z_mm)
    rough = [scatter(z_mm, values, is_real=order == 0) for order, values in enumerate(waves)]
    return [
        smoother.smooth(values, noise)
        for values, noise in zip(waves, np.maximum(rough, white), strict=True)
    ]


def fit_surface(
    points: GaugedPoints,
    ends_mm: tuple[float, float],
    most_order: int | None = None,
    first: int = 0,
) -> SurfaceFit:
    """Return the waves of a gauged surface.

    Each pass fits the waves of every height to what the smooth waves of the pass before leave of
    its points, so that heights which run through within a band do no harm.

    For the highest order see `by_height`; no order below `first` is kept.
    """
    heights = by_height(points, most_order)
    z_mm = heights.z_mm
    check_heights(z_mm, ends_mm)
    sizes = np.array([rows.size for rows in heights.rows])
    use = np.arange(z_mm.size)
    off_um, base = points.deviation_um, np.zeros((heights.most_order + 1, z_mm.size), complex)
    alone_mm: list[float] = []
    for _ in range(_PASSES):
        fits = [
            fit_waves(points.turn[rows], off_um[rows], heights.most_order) for rows in heights.rows
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
        curves = {order: wave.values for order, wave in enumerate(smooth)}
        model = _over_part(z_mm[use], curves, (float(z_mm[0]), float(z_mm[-1])))
        off_um = points.deviation_um - taken_um(model, points)
        for order in curves:
            base[order] = _at(model, order, z_mm)
    found = [
        KeptWave(order, wave, _kept(wave) if order >= first else 0 * wave.values)
        for order, wave in enumerate(smooth)
    ]
    sigma_um = float(np.median([fits[i].sigma for i in use]))
    counts = np.zeros(points.turn.size, dtype=np.bool_)
    has_edges = max(fits[i].is_far.mean() for i in use) > _MOST_DUST
    for i in use:
        counts[heights.rows[i]] = ~fits[i].is_far | has_edges
    n_far = sum(int(np.count_nonzero(fits[i].is_far)) for i in use)
    return SurfaceFit(z_mm[use], found, sigma_um, n_far, counts, sorted(alone_mm), heights)


def _kept(wave: Smoothed) -> Complexes:
    """Return what stands above the noise of a wave: nothing below what a table resolves."""
    energy, noise = np.abs(wave.values) ** 2, wave.errors**2
    least = np.finfo(float).tiny
    share = np.maximum(0.0, 1 - _LOCAL**2 * noise / np.maximum(energy, least))
    kept: Complexes = wave.values * share
    is_whole = energy.sum() > _KEPT_WHOLE * noise.sum() and np.abs(kept).max() >= LEAST_UM
    return kept if is_whole else 0 * kept


def _at(model: Correction, order: int, z_mm: Floats) -> Complexes:
    """Return a wave of a model at heights [um]."""
    curve = CubicSpline(model.nodes_mm, model.waves_mm[order], bc_type="natural")
    return np.asarray(curve(np.clip(z_mm, *model.heights_mm)) / _MM_PER_UM, dtype=np.complex128)


def taken_um(correction: Correction, points: GaugedPoints) -> Floats:
    """Return what a correction takes off at points [um]."""
    z_mm = np.clip(points.z_mm, *correction.heights_mm)
    waves = correction.delta(2 * np.pi * points.turn, z_mm)[0]
    return np.asarray((waves + correction.mean(z_mm)) / _MM_PER_UM, dtype=np.float64)
