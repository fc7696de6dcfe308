"""Machines drawn from what is known of them: points of a scrambled Sobol sequence.

>>> from camtools.forecast.vary import default_vary
>>> unknowns, _ = default_vary({})
>>> draw(unknowns, 4, seed=1).shape == (4, len(unknowns))
True
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from scipy.stats import qmc

from camtools.base.quantities import Floats
from camtools.forecast.vary import Unknown


def draw(unknowns: Sequence[Unknown], n_runs: int, *, seed: int) -> Floats:
    """Return the numbers of machines, shape (n_runs, unknowns).

    The first points of a longer draw with the same seed are those of a shorter one. MATHS.md (162).
    """
    sobol = qmc.Sobol(len(unknowns), scramble=True, rng=np.random.default_rng(seed))
    with warnings.catch_warnings():  # balance wants powers of two; any number is a fair sample
        warnings.simplefilter("ignore", UserWarning)
        points = sobol.random(n_runs)
    return np.column_stack([one.at(points[:, place]) for place, one in enumerate(unknowns)])
