# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a record is said before anything is fitted."""

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.identify.multisine import Grid, multisine
from camtools.identify.recording import record_of

GRID = Grid.of(20_000.0)
WAVE = np.tile(multisine(GRID, 25_000.0, 1e5).u_nm, 5).astype(float)
TICKS = np.arange(WAVE.size)


def test_whole_periods_at_the_end_are_taken() -> None:
    """What comes before is left out; means are taken away."""
    record = record_of(GRID, TICKS[100:], WAVE[100:] + 7, WAVE[100:] + 9, 10.0)
    assert record.u_nm.shape == (4, GRID.n_ticks)
    assert record.settled[0].shape == (3, GRID.n_ticks)
    assert abs(record.period_nm.mean()) < 1e-6


@pytest.mark.parametrize(
    ("ticks", "u", "y", "says"),
    [
        (np.append(TICKS[:-1], TICKS[-1] + 3), WAVE, WAVE, "1 gap, the first after tick 19998"),
        (TICKS[:9000], WAVE[:9000], WAVE[:9000], "9000 ticks are 2 periods, a fit needs 3"),
        (TICKS, WAVE * (1 + 1e-6 * TICKS), WAVE, "the set-points of two periods differ by"),
        (TICKS, 0 * WAVE, WAVE, "U was not excited"),
        (TICKS, WAVE, 0 * WAVE, "U did not move"),
    ],
)
def test_bad_records_are_refused(
    ticks: np.ndarray, u: np.ndarray, y: np.ndarray, says: str
) -> None:
    """One line each, with a remedy."""
    with pytest.raises(CamtoolsError) as error:
        record_of(GRID, ticks, u, y, 10.0)
    assert len(error.value.lines) == 1
    assert says in error.value.lines[0]
    assert "; " in error.value.lines[0]
