"""How much of a deviation a round takes off: what two parts agree on, whole; the rest by the gain.

A gain below 1 keeps a machine that answers otherwise than expected, or a part that is not like the
next one, from being corrected too much. What the round before left on purpose, and the next part
shows again, is neither.

>>> shown = Correction((0.0, 60.0), {2: np.full(N_NODES, 0.001 + 0j)})
>>> first = take(shown, {}, 0.7)
>>> second = take(Correction((0.0, 60.0), first.left_mm), first.left_mm, 0.7)
>>> [f"{1000 * abs(one.taken.waves_mm[2][0]):.2f}" for one in (first, second)]
['0.70', '0.30']
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from camtools.cut.correction import N_NODES, Complexes, Correction


class RoundStep(NamedTuple):
    """What a round takes off, and what it leaves of what it was shown."""

    taken: Correction
    left_mm: dict[int, Complexes]


def take(shown: Correction, expected_mm: Mapping[int, Complexes], gain: float) -> RoundStep:
    """Return the step of a round, MATHS.md (160).

    Parameters
    ----------
    shown : Correction
        What the gauged part shows above the noise, all of it.
    expected_mm : mapping
        What the round before left of the part before.
    """
    taken, left = {}, {}
    for order, values in shown.waves_mm.items():
        expected = expected_mm.get(order, np.zeros(N_NODES, dtype=np.complex128))
        # The part of what was expected that is shown, no more than all of it.
        energy = np.abs(expected) ** 2
        along = (values * expected.conj()).real
        share = np.divide(along, energy, out=np.zeros(energy.size), where=energy > 0)
        agreed = np.clip(share, 0.0, 1.0) * expected
        step = gain * values + (1 - gain) * agreed
        taken[order], left[order] = step, values - step
    return RoundStep(Correction(shown.heights_mm, taken), left)
