"""Solvers of scipy that raise where they have not converged.

>>> [f"{x:.6f}" for x in inverted(np.exp, np.array([1.0, 2.0]), (-1.0, 1.0), 1e-12, "x")]
['0.000000', '0.693147']
>>> inverted(np.exp, np.array([3.0]), (-1.0, 1.0), 1e-12, "x")
Traceback (most recent call last):
...
camtools.base.errors.CamtoolsError: x: no solution was found; report it with the input file
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import OptimizeResult
from scipy.optimize.elementwise import find_root

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, FloatsLike

OF_FILE = "report it with the input file"
OF_RECORD = "record for longer, or excite more"


def unsolved(subject: str, remedy: str = OF_FILE) -> CamtoolsError:
    """Return the error of a solver that has not converged; the subject is a key or a file."""
    return CamtoolsError([f"{subject}: no solution was found; {remedy}"])


def inverted(
    function: Callable[[Floats], Floats],
    values: Floats,
    bounds: tuple[FloatsLike, FloatsLike],
    within: float,
    subject: str,
) -> Floats:
    """Return where a rising function has given values, by Chandrupatla's bracketing method.

    `function` works element by element on any part of the places; `values` are within those at the
    two `bounds`, which broadcast with them. The function at the places returned is `within` its
    values, or the places are exact to rounding. Raises CamtoolsError, which names the `subject`,
    where it is not.
    """

    def off(x: Floats, value: Floats) -> Floats:
        return function(x) - value

    found = find_root(off, bounds, args=(values,), tolerances={"fatol": within})
    if not np.all(found.success):
        raise unsolved(subject)
    return np.asarray(found.x, dtype=np.float64)


def neighbours(grid: Floats, on_grid: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return neighbours of a rising grid between which a rising function has given values.

    `on_grid` is the function on the grid; values beyond its ends count as between the last two.
    """
    i = np.clip(np.searchsorted(on_grid, values), 1, grid.size - 1)
    return grid[i - 1], grid[i]


def converged(found: OptimizeResult, subject: str, remedy: str = OF_FILE) -> OptimizeResult:
    """Return what an optimiser of scipy found; raise CamtoolsError where it has not converged."""
    if not np.all(found.success):
        raise unsolved(subject, remedy)
    return found
