"""The fewest bytes that keep the tolerance.

Candidates are ordered by size and sieved by estimates of the error in height and in angle;
the first one whose measured error is small enough wins.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> channel, accuracy = choose_u(make_geometry(example_part()), tolerance_nm=1.0)
>>> channel.n_slices, channel.log2_knots
(32, 3)
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from math import ceil, floor, inf
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Ints
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.table.accuracy import (
    Accuracy,
    height_error,
    height_range_nm,
    measure_u,
    measure_x,
    probe,
    u_channel,
    x_channel,
)
from camtools.table.channel import (
    MAX_CHANNEL_BYTES,
    MAX_LOG2_KNOTS,
    MAX_SLICES,
    MAX_SPACING_NM,
    MIN_LOG2_KNOTS,
    MIN_SPACING_NM,
    Channel,
)
from camtools.table.evaluate import GRID_MARGIN
from camtools.table.quantise import TooLargeError
from camtools.table.records import KNOT_SIZE

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
    """Return whether shares of the derivatives' peaks are small enough."""
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
        one
        for one in candidates
        if one.estimate_nm <= tolerance_nm and one.log2_knots not in coarse
    )
    for one in islice(within, _MAX_PROBES):
        size = one.log2_knots, one.n_slices
        found = probe(geometry, in_height, *size, has_kinks=has_kinks)
        first, second = (GRID_MARGIN * share for share in found.shares)
        is_near = GRID_MARGIN * found.value_nm <= tolerance_nm
        if is_near and _keeps_derivatives(geometry, first, second):
            yield one
    yield from sorted(candidates, key=lambda one: one.estimate_nm)[:1]


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
    smooth = [one for one in others if _keeps_derivatives(geometry, *one[1].shares)]
    best = min(smooth, key=lambda one: one[1].value_nm, default=None)
    if best is None or best[1].value_nm > most_nm:
        best_nm = min((accuracy.value_nm for _, accuracy in others), default=inf)
        raise UnreachableError("u", tolerance_nm, best_nm)
    return best


def _measured(
    geometry: Geometry, sieve: Geometry, tolerance_nm: float, most: int
) -> tuple[tuple[Channel, Accuracy] | None, list[tuple[Channel, Accuracy]]]:
    """Return the first channel of a sieve's sizes that keeps the tolerance, and those that do not.

    The latter are those that were measured before it.
    """
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
    return next(one for one in found if one[1].value_nm <= min(most_nm, _NEAR_BEST * best_nm))
