"""From exact geometry to channels of a table, and how far those are from it.

The fewest bytes that keep the tolerance are searched: candidates are ordered by size and sieved by
estimates of the error in height and in angle; the first one whose measured error is small enough
wins.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> u_channel(make_geometry(example_part()), 3, 32).n_slices
32

What is measured here is bounded by MATHS.md (48) .. (50).
"""

from collections.abc import Iterator
from itertools import islice
from math import ceil, floor, inf
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, Floats, Ints
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.table.channel import (
    KIND_U,
    KIND_X,
    KNOT_SIZE,
    MAX_CHANNEL_BYTES,
    MAX_LOG2_KNOTS,
    MAX_SLICES,
    MAX_SPACING_NM,
    MIN_LOG2_KNOTS,
    MIN_SPACING_NM,
    Channel,
    segment_coefficients,
)
from camtools.table.evaluate import (
    GRID_MARGIN,
    PLACES,
    ROUNDING_LSB,
    Values,
    evaluate_grid,
    evaluate_x,
    power_rows,
)
from camtools.table.header import TooLargeError, quantise, slice_heights_mm


def height_range_nm(geometry: Geometry) -> tuple[int, int]:
    """Return the profile's height range in whole nanometres."""
    return round(geometry.z_first_mm * NM_PER_MM), round(geometry.z_last_mm * NM_PER_MM)


def _curvature(geometry: Geometry, phi_rad: Floats, z_mm: Floats, spacing_mm: float) -> Floats:
    """Return d2/dz2 of (delta, d1, d2), shape (3, n, n_phi), inside one piece of the shape."""
    breaks = geometry.breaks_mm()
    piece = np.clip(np.searchsorted(breaks, z_mm, side="right") - 1, 0, breaks.size - 2)
    step = np.minimum(spacing_mm, np.diff(breaks)[piece]) / 4
    middle = np.clip(z_mm, breaks[piece] + step, breaks[piece + 1] - step)
    below, here, above = (
        np.stack(geometry.delta(phi_rad, (middle + k * step)[:, None])[:3]) for k in (-1, 0, 1)
    )
    return np.asarray((below - 2 * here + above) / step[:, None] ** 2, dtype=np.float64)


def balanced(geometry: Geometry, phi_rad: Floats, z_mm: Floats, spacing_mm: float) -> Floats:
    """Return what slices store so that blending errs to both sides alike.

    Chords between points of a curve err to one side by spacing^2 / 8 of its curvature; moved by
    half of that they err by half as much, MATHS.md (50). Returned are the reduction and two angle
    derivatives [mm, mm/rad, mm/rad^2], shape (3, n, n_phi), of n slices spacing_mm apart.
    """
    exact = np.stack(geometry.delta(phi_rad, z_mm[:, None])[:3])
    curvature = _curvature(geometry, phi_rad, z_mm, spacing_mm)
    return np.asarray(exact - curvature * (spacing_mm**2 / 16), dtype=np.float64)


def u_channel(
    geometry: Geometry, log2_knots: int, n_slices: int, *, is_balanced: bool = True
) -> Channel:
    """Return the quantised u channel of this size; unbalanced slices are exact themselves."""
    range_nm, repeat = height_range_nm(geometry), geometry.surface.log2_repeat
    h = 2 * np.pi / (1 << (log2_knots + repeat))
    z_mm = slice_heights_mm(range_nm, n_slices)
    spacing_mm = (range_nm[1] - range_nm[0]) / NM_PER_MM / (n_slices - 1)
    phi_rad = h * np.arange(1 << log2_knots, dtype=np.float64)
    if is_balanced:
        u = balanced(geometry, phi_rad, z_mm, spacing_mm)
    else:
        u = np.stack(geometry.delta(phi_rad, z_mm[:, None])[:3])
    return quantise(KIND_U, _as_stored(u, h) * NM_PER_MM, repeat, range_nm)


def _as_stored(u: Floats, h: float) -> Floats:
    """Return value and derivatives (3, ..) as a table with knots h [rad] apart stores them."""
    return np.stack([u[0], h * u[1], h**2 / 2 * u[2]], axis=-1)


def x_channel(geometry: Geometry, n_knots: int) -> Channel:
    """Return the quantised x channel of this size."""
    range_nm = height_range_nm(geometry)
    z_mm = slice_heights_mm(range_nm, n_knots)
    h_mm = (range_nm[1] - range_nm[0]) / NM_PER_MM / (n_knots - 1)
    triple = [geometry.radius_mm(z_mm, n) * h_mm**n / max(1, n) for n in range(3)]
    knots_nm = np.stack(triple, axis=-1)[:, None] * NM_PER_MM
    return quantise(KIND_X, knots_nm, 0, range_nm)


_W = np.array([0.0, 0.13, 0.27, 0.5, 0.71, 0.91])
_W_X = np.arange(32) / 32


class Accuracy(NamedTuple):
    """Largest errors against exact geometry; derivatives of u by angle, of x by height."""

    value_nm: float  # with the firmware's rounding
    first: float  # nm/rad, or nm/mm for x
    second: float  # nm/rad^2, or nm/mm^2 for x
    first_peak: float  # largest exact magnitude, same units
    second_peak: float
    lsb_nm: float

    @property
    def first_share(self) -> float:
        """Error of the first derivative as a share of its peak."""
        return self.first / self.first_peak if self.first_peak else 0.0

    @property
    def second_share(self) -> float:
        """Error of the second derivative as a share of its peak."""
        return self.second / self.second_peak if self.second_peak else 0.0

    @property
    def shares(self) -> tuple[float, float]:
        """Both."""
        return self.first_share, self.second_share


def _accuracy(channel: Channel, got: Values, exact: Values) -> Accuracy:
    errors = [float(np.abs(a - b).max()) for a, b in zip(got, exact, strict=True)]
    peaks = [float(np.abs(values).max()) for values in exact]
    value_nm, first, second = (GRID_MARGIN * error for error in errors)
    value_nm += ROUNDING_LSB * channel.lsb
    return Accuracy(value_nm, first, second, peaks[1], peaks[2], channel.lsb)


def _between(geometry: Geometry, n_slices: int, weights: Floats) -> Floats:
    """Return heights in every interval, at both ends and at every break of the splines [nm]."""
    range_nm = height_range_nm(geometry)
    slices = slice_heights_mm(range_nm, n_slices) * NM_PER_MM
    inside = slices[:-1, None] + np.diff(slices)[:, None] * weights
    heights = np.concatenate([inside.ravel(), slices[-1:], geometry.breaks_mm() * NM_PER_MM])
    return np.asarray(np.clip(heights, *range_nm), dtype=np.float64)


def measure_u(geometry: Geometry, channel: Channel, z_nm: Floats | None = None) -> Accuracy:
    """Return the error of a u channel at heights, by default a dense grid with all kinks."""
    z_nm = _between(geometry, channel.n_slices, _W) if z_nm is None else z_nm
    n_knots = channel.knots.shape[1]
    pattern = (np.arange(n_knots)[:, None] + PLACES).ravel() / n_knots
    phi_rad = pattern * (2 * np.pi / (1 << channel.log2_repeat))
    u = geometry.delta(phi_rad, z_nm[:, None] / NM_PER_MM)
    exact = Values(u.delta * NM_PER_MM, u.d1 * NM_PER_MM, u.d2 * NM_PER_MM)
    return _accuracy(channel, evaluate_grid(channel, z_nm, PLACES), exact)


def measure_x(geometry: Geometry, channel: Channel) -> Accuracy:
    """Return the error of an x channel on a dense grid with both ends and all breaks."""
    z_nm = _between(geometry, channel.n_slices, _W_X)
    a = [geometry.radius_mm(z_nm / NM_PER_MM, n) * NM_PER_MM for n in range(3)]
    got = evaluate_x(channel, z_nm)
    per_mm = Values(got.value, got.d1 * NM_PER_MM, got.d2 * NM_PER_MM**2)
    return _accuracy(channel, per_mm, Values(*a))


_ANGLES = 33
_PIECES = 24


class HeightError(NamedTuple):
    """What blending does to u between slices, from the exact geometry, MATHS.md (50)."""

    curvatures: Floats  # largest |d2u/dz2| of each piece, nm per nm^2, shape (n + 1,)
    worst_nm: Floats  # where that is, above the first slice, shape (n + 1,)
    kinks_nm: Floats  # heights of the breaks above the first slice, shape (n,)
    bends: Floats  # largest |jump of du/dz| there, shape (n,)
    span_nm: float
    largest_nm: float  # where the second angle derivative peaks, above the first slice
    peaks_mm: tuple[float, float]  # of the first and second angle derivative, mm/rad, mm/rad^2

    def estimate_nm(self, n_slices: Ints) -> Floats:
        """Return the larger of both kinds of error for each number of slices."""
        spacing = self.span_nm / (n_slices - 1)
        worst = self.curvatures.max() * spacing**2 / 16
        for kink_nm, bend in zip(self.kinks_nm, self.bends, strict=True):
            w = np.mod(kink_nm / spacing, 1.0)
            worst = np.maximum(worst, bend * w * (1 - w) * spacing)
        return np.asarray(worst, dtype=np.float64)

    def probes_nm(self, n_slices: int) -> Floats:
        """Return the heights above the first slice where the error should be worst."""
        spacing = self.span_nm / (n_slices - 1)
        i_slice = np.minimum(np.floor(self.worst_nm / spacing), n_slices - 2)
        return np.concatenate([(i_slice + 0.5) * spacing, self.kinks_nm, [self.largest_nm]])


def height_error(geometry: Geometry) -> HeightError:
    """Return curvature and kinks of u over height, the worst over the angle."""
    breaks = geometry.breaks_mm()
    share = np.arange(_PIECES + 1) / _PIECES
    step = np.diff(breaks)[:, None, None] / _PIECES
    along = np.diff(breaks)[:, None] * share
    z = breaks[:-1, None] + along
    pattern_rad = 2 * np.pi / (1 << geometry.surface.log2_repeat)
    u = geometry.delta(np.linspace(0, pattern_rad, _ANGLES), z[..., None])
    peaks = float(np.abs(u.d1).max()), float(np.abs(u.d2).max())
    largest_mm = float(z.ravel()[np.abs(u.d2).max(axis=2).argmax()])
    slopes = np.diff(u.delta, axis=1) / step
    curves = np.diff(slopes, axis=1) / step
    # slopes at the breaks themselves, extrapolated from inside the pieces
    upper = slopes[:, -1] + curves[:, -1] * step[:, 0] / 2
    lower = slopes[:, 0] - curves[:, 0] * step[:, 0] / 2
    bends = np.abs(lower[1:] - upper[:-1]).max(axis=1, initial=0)
    worst = np.abs(curves).max(axis=2)
    place = z[np.arange(worst.shape[0]), 1 + worst.argmax(axis=1)]
    first, last = height_range_nm(geometry)
    above = place * NM_PER_MM - first, breaks[1:-1] * NM_PER_MM - first
    return HeightError(
        worst.max(axis=1) / NM_PER_MM,
        *above,
        bends,
        last - first,
        largest_mm * NM_PER_MM - first,
        peaks,
    )


class Probe(NamedTuple):
    """Error of an unquantised table at its worst heights."""

    value_nm: float
    shares: tuple[float, float]  # errors of the first and second derivative over their peaks


def probe(
    geometry: Geometry,
    estimate: HeightError,
    log2_knots: int,
    n_slices: int,
    *,
    has_kinks: bool = False,
) -> Probe:
    """Return the error of an unquantised table of this size at its worst heights.

    Only the slices around these heights are made, so the cost does not grow with their number. The
    estimate may have missed the peak of a second derivative that has kinks.
    """
    probes_nm = estimate.probes_nm(n_slices)
    spacing, first_nm = estimate.span_nm / (n_slices - 1), height_range_nm(geometry)[0]
    i_slice = np.minimum(np.floor(probes_nm / spacing), n_slices - 2)
    weight = (probes_nm / spacing - i_slice)[:, None, None]
    h = 2 * np.pi / (1 << (log2_knots + geometry.surface.log2_repeat))
    knots = np.arange(1 << log2_knots, dtype=np.float64)
    around_mm = (first_nm + (i_slice + np.array([[0], [1]])) * spacing) / NM_PER_MM
    u = balanced(geometry, h * knots, around_mm.ravel(), spacing / NM_PER_MM)
    stored = _as_stored(u, h)
    below, above = stored.reshape(*around_mm.shape, *stored.shape[1:])
    blended = segment_coefficients((1 - weight) * below + weight * above, periodic=True)
    phi_rad = (h * (knots[:, None] + PLACES)).ravel()
    exact = geometry.delta(phi_rad, (first_nm + probes_nm[:, None]) / NM_PER_MM)
    got = np.einsum("zkc,dct->dzkt", blended, power_rows(PLACES)).reshape(3, *exact.delta.shape)
    errors = [float(np.abs(got[n] / h**n - exact[n]).max()) for n in range(3)]
    peaks = list(estimate.peaks_mm)
    if has_kinks:
        peaks = [max(peak, float(np.abs(exact[n]).max())) for n, peak in enumerate(peaks, 1)]
    first, second = (
        error / peak if peak else 0.0 for error, peak in zip(errors[1:], peaks, strict=True)
    )
    return Probe(errors[0] * NM_PER_MM, (first, second))


DERIVATIVE_SHARE = 1e-3
CUBIC_SHARE = 0.05  # of the second derivative of a cubic refit, which has a kink at every point
_MAX_PROBES, _MAX_MEASURES = 4000, 20
_MAX_SIEVED = 3
_AT_FLOOR_LSB = 2.5
_NEAR_BEST = 1.25


class UnreachableError(CamtoolsError):
    """No table within the format's and the generator's limits keeps the tolerance."""

    def __init__(self, channel: str, tolerance_nm: float, best_nm: float) -> None:
        self.best_nm = best_nm
        best, remedy = "nothing fits the format", "magnify less"
        if best_nm < inf:
            best = f"best achievable is {best_nm:.3g} nm"
            remedy = f"ask for at least {float(f'{best_nm * 1.05:.2g}'):g} nm"
        if channel == "u":
            remedy += ', or put linear ovality nodes on a common grid, or use "spline" ovality'
        super().__init__(
            [f"tolerance_nm = {tolerance_nm:g}: unreachable for {channel}, {best}; {remedy}"]
        )


def slice_counts(geometry: Geometry) -> Ints:
    """Return all numbers of slices whose spacing the format allows, rising."""
    first, last = height_range_nm(geometry)
    fewest = max(2, ceil((last - first) / MAX_SPACING_NM) + 1)
    most = min(MAX_SLICES, floor((last - first) / MIN_SPACING_NM) + 1)
    return np.arange(fewest, most + 1)


def second_share_of(geometry: Geometry) -> float:
    """Return the error of the second derivative that is allowed, as a share of its peak.

    A cubic spline is C2: its second derivative has kinks, which quintics of the table round.
    """
    corner = geometry.corner
    is_cubic = corner is not None and corner.recipe is not None and corner.recipe.spline == "cubic"
    return CUBIC_SHARE if is_cubic else DERIVATIVE_SHARE


def _keeps_derivatives(geometry: Geometry, first: float, second: float) -> bool:
    return first <= DERIVATIVE_SHARE and second <= second_share_of(geometry)


class SizeCandidate(NamedTuple):
    """A size of the u channel and what its error might be."""

    size: int
    log2_knots: int
    n_slices: int
    estimate_nm: float


def u_candidates(geometry: Geometry) -> list[SizeCandidate]:
    """Return all sizes that can satisfy the derivatives, smallest first."""
    counts = slice_counts(geometry)
    n_slices = int(counts[0])
    slices_nm = np.linspace(*height_range_nm(geometry), n_slices)
    in_height = height_error(geometry).estimate_nm(counts)
    found: list[SizeCandidate] = []
    for log2_knots in range(MIN_LOG2_KNOTS, MAX_LOG2_KNOTS + 1):
        fits = (counts << log2_knots) * KNOT_SIZE <= MAX_CHANNEL_BYTES
        if not fits.any():
            break
        try:
            exact = u_channel(geometry, log2_knots, n_slices, is_balanced=False)
            in_angle = measure_u(geometry, exact, slices_nm)  # at slices alone
        except TooLargeError:
            continue
        if not _keeps_derivatives(geometry, *in_angle.shares):
            continue
        estimates = np.maximum(in_height, in_angle.value_nm)[fits]
        sizes = (counts[fits] << log2_knots) * KNOT_SIZE
        found += [
            SizeCandidate(int(size), log2_knots, int(n), float(estimate))
            for size, n, estimate in zip(sizes, counts[fits], estimates, strict=True)
        ]
        is_fine = in_angle.value_nm <= _AT_FLOOR_LSB * in_angle.lsb_nm
        if is_fine and max(in_angle.shares) <= DERIVATIVE_SHARE / 2:
            break  # more knots cannot help any more
    return sorted(found)


def _hopeful(geometry: Geometry, tolerance_nm: float, coarse: set[int]) -> Iterator[SizeCandidate]:
    """Yield the sizes whose estimates are within the tolerance, smallest first.

    The best estimate of all comes last, so that a failed search still measures it. Whoever measures
    adds to `coarse` the knots per turn (log2) of which more slices do not help.
    """
    candidates, in_height = u_candidates(geometry), height_error(geometry)
    has_kinks = second_share_of(geometry) > DERIVATIVE_SHARE
    within = (
        candidate
        for candidate in candidates
        if candidate.estimate_nm <= tolerance_nm and candidate.log2_knots not in coarse
    )
    for candidate in islice(within, _MAX_PROBES):
        size = candidate.log2_knots, candidate.n_slices
        found = probe(geometry, in_height, *size, has_kinks=has_kinks)
        first, second = (GRID_MARGIN * share for share in found.shares)
        is_near = GRID_MARGIN * found.value_nm <= tolerance_nm
        if is_near and _keeps_derivatives(geometry, first, second):
            yield candidate
    yield from sorted(candidates, key=lambda candidate: candidate.estimate_nm)[:1]


def choose_u(
    geometry: Geometry, tolerance_nm: float, sieve: Geometry | None = None, most_nm: float = 0.0
) -> tuple[Channel, Accuracy]:
    """Return the smallest u channel within the tolerance, and its measured error.

    Between slices at equal distances no cubic follows a step of the ovality's curvature within any
    tolerance. Where none keeps it, the best one found is taken if its error is at most most_nm. A
    sieve is nearly the same geometry, evaluated more quickly: the sizes that it needs come first.
    """
    if sieve is not None and sieve is not geometry:
        within, _ = _measured(geometry, sieve, tolerance_nm, _MAX_SIEVED)
        if within is not None:
            return within
    within, others = _measured(geometry, geometry, tolerance_nm, _MAX_MEASURES)
    if within is not None:
        return within
    smooth = [made for made in others if _keeps_derivatives(geometry, *made[1].shares)]
    best = min(smooth, key=lambda made: made[1].value_nm, default=None)
    if best is None or best[1].value_nm > most_nm:
        best_nm = min((accuracy.value_nm for _, accuracy in others), default=inf)
        raise UnreachableError("u", tolerance_nm, best_nm)
    return best


def _measured(
    geometry: Geometry, sieve: Geometry, tolerance_nm: float, most: int
) -> tuple[tuple[Channel, Accuracy] | None, list[tuple[Channel, Accuracy]]]:
    """Return the first channel of a sieve's sizes that keeps the tolerance, and those before it."""
    others: list[tuple[Channel, Accuracy]] = []
    coarse: set[int] = set()
    for candidate in islice(_hopeful(sieve, tolerance_nm, coarse), most):
        channel = u_channel(geometry, candidate.log2_knots, candidate.n_slices)
        accuracy = measure_u(geometry, channel)
        is_within = accuracy.value_nm <= tolerance_nm
        if is_within and _keeps_derivatives(geometry, *accuracy.shares):
            return (channel, accuracy), others
        if is_within:
            coarse.add(candidate.log2_knots)  # a derivative decides, and that by the angle
        others.append((channel, accuracy))
    return None, others


def choose_x(
    geometry: Geometry, tolerance_nm: float, most_nm: float = 0.0
) -> tuple[Channel, Accuracy]:
    """Return the smallest x channel within the tolerance, and its measured error.

    No quintic with knots at equal distances follows a corner of the drawing, or a step of its
    curvature, within any tolerance. Where the best channel misses the tolerance, the smallest one
    that comes near the best is taken instead, as long as its error is at most most_nm.
    """
    found: list[tuple[Channel, Accuracy]] = []
    for n_knots in slice_counts(geometry):
        try:
            channel = x_channel(geometry, int(n_knots))
        except TooLargeError:
            continue
        accuracy = measure_x(geometry, channel)
        if accuracy.value_nm <= tolerance_nm:
            return channel, accuracy
        found.append((channel, accuracy))
    best_nm = min((accuracy.value_nm for _, accuracy in found), default=inf)
    if best_nm > most_nm:
        raise UnreachableError("x", tolerance_nm, best_nm)
    return next(made for made in found if made[1].value_nm <= min(most_nm, _NEAR_BEST * best_nm))
