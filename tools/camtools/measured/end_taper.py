# SPDX-License-Identifier: Apache-2.0
"""A step that is smaller at the ends of a part, where its waves do not describe the error.

Where the tool enters the metal or leaves it, the error changes within a turn, and a smooth
correction that suits the next turns would add as much there. MATHS.md (160).

>>> z_mm, turn = np.repeat(np.linspace(0, 10, 1001), 8), np.tile(np.arange(8) / 8, 1001)
>>> entering = GaugedPoints(turn, z_mm, np.where(z_mm < 0.03, 0.0, 1.0))
>>> whole = Correction((0.0, 10.0), {0: np.full(N_NODES, 0.001 + 0j)})
>>> smaller = taper(whole, entering)
>>> largest_um(off_um(whole, entering)), 0.4 < largest_um(off_um(smaller, entering)) < 0.6
(1.0, True)
"""

from __future__ import annotations

import numpy as np

from camtools.base.quantities import Bools, Floats
from camtools.cut.correction import N_NODES, Correction, nodes_of
from camtools.measured.points import GaugedPoints
from camtools.measured.surface import SurfaceFit, taken_um

_REACH = 3  # values from the end within which the outer one is felt
_SHARES = np.linspace(1.0, -1.0, 41)  # below 0 the round before took too much
_RELUCTANCE = 0.05  # by so much no correction at the end must be better than a whole one


def judged(fit: SurfaceFit, points: GaugedPoints, ends_mm: tuple[float, float]) -> GaugedPoints:
    """Return the points by which a step is judged.

    Grains of dust and damaged heights are left out, but nothing at the ends, where the entry of
    the tool looks like them.
    """
    nodes_mm = nodes_of(ends_mm)
    is_judged = fit.counts | (points.z_mm <= nodes_mm[1]) | (points.z_mm >= nodes_mm[-2])
    return _chosen(points, is_judged)


def _chosen(points: GaugedPoints, is_chosen: Bools) -> GaugedPoints:
    turn, z_mm, deviation_um = (one[is_chosen] for one in points[:3])
    return GaugedPoints(turn, z_mm, deviation_um)


def off_um(step: Correction, points: GaugedPoints) -> Floats:
    """Return the deviations of the next part, if the machine repeats its errors [um]."""
    return np.asarray(points.deviation_um - taken_um(step, points), dtype=np.float64)


def largest_um(deviations_um: Floats) -> float:
    """Return the largest magnitude of deviations [um], 0 of none."""
    return float(np.abs(deviations_um).max(initial=0.0))


def taper(step: Correction, points: GaugedPoints) -> Correction:
    """Return a step whose outer values are scaled for the least largest error at either end.

    Parameters
    ----------
    step : Correction
        What a round would take off.
    points : GaugedPoints
        Of the part that shows it.
    """
    waves_mm = {order: values.copy() for order, values in step.waves_mm.items()}
    nodes_mm = step.nodes_mm
    for outer, reached in ((0, _REACH), (N_NODES - 1, N_NODES - 1 - _REACH)):
        reach_mm = abs(nodes_mm[reached] - nodes_mm[outer])
        near = _chosen(points, np.abs(points.z_mm - nodes_mm[outer]) <= reach_mm)
        share = _share(step, outer, near)
        for values in waves_mm.values():
            values[outer] *= share
    return Correction(step.heights_mm, waves_mm)


def _share(step: Correction, outer: int, near: GaugedPoints) -> float:
    """Return the share of an outer value that leaves the points near it the least error."""
    is_outer = np.arange(N_NODES) == outer
    alone = {order: values * is_outer for order, values in step.waves_mm.items()}
    added_um = taken_um(Correction(step.heights_mm, alone), near)
    left_um = off_um(step, near)
    costs = [
        largest_um(left_um + (1 - share) * added_um) * (1 + _RELUCTANCE * (1 - share))
        for share in _SHARES
    ]
    return float(_SHARES[int(np.argmin(costs))])
