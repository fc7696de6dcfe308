# SPDX-License-Identifier: Apache-2.0
"""Waves fitted to surfaces by formula: with noise, wrong points, and heights that are missing."""

import numpy as np
import pytest
from numpy.typing import NDArray

from camtools.base.errors import CamtoolsError
from camtools.measured.points import GaugedPoints
from camtools.measured.surface import fit_surface
from tests.tools.cases.gauged_cases import ENDS, error_um, gauged, helix, traces

Floats = NDArray[np.float64]
GRID = traces(np.linspace(*ENDS, 125), 180)


def left_um(points: GaugedPoints, order: int | None = None) -> Floats:
    """Return what a correction with gain 1 leaves of `error_um`, all over the part."""
    turn, z_mm = GRID
    whole = fit_surface(points, ENDS, order).correction(ENDS, 1.0)
    taken = whole.delta(2 * np.pi * turn, z_mm)[0] + whole.mean(z_mm)
    return np.asarray(error_um(turn, z_mm) - 1000 * taken)


@pytest.mark.parametrize(
    ("place", "most_um"),
    [(traces(np.linspace(*ENDS, 13)), 0.02), (helix(), 0.01), (traces(np.linspace(3, 59, 5)), 0.3)],
)
def test_formula_is_found(place: tuple[Floats, Floats], most_um: float) -> None:
    """Without noise all of 3.5 um is found, but for what lies beyond the outermost heights."""
    assert np.abs(left_um(gauged(place))).max() < most_um


@pytest.mark.parametrize("seed", range(2))
def test_noise_is_not_copied(seed: int) -> None:
    """With 0.2 um of noise per point no more than an eighth of it is left, rms."""
    off = left_um(gauged(traces(np.linspace(*ENDS, 32)), 0.2, seed))
    assert np.sqrt((off**2).mean()) < 0.025
    off = left_um(gauged(helix(), 0.2, seed))
    assert np.sqrt((off**2).mean()) < 0.015


@pytest.mark.parametrize("seed", range(8))
def test_nothing_but_noise_is_left_alone(seed: int) -> None:
    """A perfect part with 0.2 um of noise: what is corrected stays below a twentieth of it."""
    turn, z_mm = traces(np.linspace(*ENDS, 24), 120)
    noise = np.random.default_rng(seed).normal(0, 0.2, turn.size)
    step = fit_surface(GaugedPoints(turn, z_mm, noise), ENDS).correction(ENDS, 0.7)
    waves = step.delta(2 * np.pi * GRID[0], GRID[1])[0] + step.mean(GRID[1])
    assert 1000 * np.sqrt((waves**2).mean()) < 0.01


def test_noise_between_heights_is_seen() -> None:
    """Traces that differ at random as a whole, as after clamping anew, are smoothed."""
    rng = np.random.default_rng(7)
    z = np.linspace(*ENDS, 40)
    turn, z_mm = traces(z, 90)
    wild = np.repeat(rng.normal(0, 0.3, z.size), 90) * np.cos(6 * np.pi * turn)
    off = left_um(GaugedPoints(turn, z_mm, error_um(turn, z_mm) + wild))
    assert np.sqrt((off**2).mean()) < 0.3 / np.sqrt(2) / 2


def test_wrong_points_do_not_count() -> None:
    """One point of fifty is 30 um off to the same side."""
    place = traces(np.linspace(*ENDS, 13))
    points = gauged(place, 0.05)
    wrong = np.random.default_rng(2).random(place[0].size) < 0.02
    bent = points._replace(deviation_um=points.deviation_um + 30 * wrong)
    off = left_um(bent)
    assert np.abs(off).max() < 0.1
    fit = fit_surface(bent, ENDS)
    assert fit.n_far == pytest.approx(wrong.sum(), abs=5)
    assert not fit.counts[wrong].any()


def test_wrong_height_does_not_count() -> None:
    """A trace with dirt under the probe is unlike both its neighbours."""
    turn, z_mm = traces(np.linspace(*ENDS, 21))
    points = gauged((turn, z_mm), 0.05)
    dirt = np.where(np.isclose(z_mm, 31.0), 8 * np.cos(4 * np.pi * turn), 0.0)
    bent = points._replace(deviation_um=points.deviation_um + dirt)
    assert fit_surface(bent, ENDS).alone_mm == [31.0]
    assert np.abs(left_um(bent)).max() < 0.1


def test_missing_heights() -> None:
    """A third of the heights is missing: what lies between the others is bridged smoothly."""
    z = np.linspace(*ENDS, 31)
    some = np.delete(z, np.r_[8:18])
    assert np.abs(left_um(gauged(traces(some), 0.05))).max() < 0.15


def test_step_over_the_height_does_not_ring() -> None:
    """A wave that steps by 2 um leaves its two values by less than a fifth of the step."""
    turn, z_mm = traces(np.linspace(*ENDS, 32))
    noise = np.random.default_rng(5).normal(0, 0.1, turn.size)
    step = np.where(z_mm > 31, 3.0, 1.0) * np.cos(4 * np.pi * turn)
    found = fit_surface(GaugedPoints(turn, z_mm, step + noise), ENDS)
    wave = next(one for one in found.waves if one.order == 2).kept.real
    assert wave.max() < 3.4
    assert wave.min() > 0.6


def test_orders_are_asked_for() -> None:
    """Waves above the highest order are left on the part; without mean and centre both stay."""
    place = traces(np.linspace(*ENDS, 13))
    few = fit_surface(gauged(place), ENDS, most_order=2)
    assert [one.order for one in few.waves if one.is_kept] == [0, 1, 2]
    centred = fit_surface(gauged(place), ENDS, first=2)
    assert [one.order for one in centred.waves if one.is_kept] == [2, 5]


@pytest.mark.parametrize(
    ("place", "order", "message"),
    [
        (traces(np.array([10.0, 50.0])), None, "2 of 2 heights have enough points all round"),
        (traces(np.linspace(0, 62, 5), 30), 16, "need 50 points and no gap above 11.2 degrees"),
        (traces(np.linspace(0, 40, 5)), None, "heights 0 .. 40 mm leave more than 20 % of"),
        (traces(np.array([0, 10, 50, 62.0])), None, "no height between 10 and 50 mm"),
    ],
)
def test_too_little_is_refused(
    place: tuple[Floats, Floats], order: int | None, message: str
) -> None:
    """Numbers and limits are in the message."""
    with pytest.raises(CamtoolsError) as caught:
        fit_surface(gauged(place), ENDS, order)
    assert message in str(caught.value)
    assert len(caught.value.lines) == 1


def test_half_a_trace_is_left_out() -> None:
    """A height where the probe saw half a turn does not count."""
    turn, z_mm = traces(np.linspace(*ENDS, 13))
    keep = (np.abs(z_mm - 31) > 1) | (turn < 0.5)
    points = gauged((turn[keep], z_mm[keep]))
    assert fit_surface(points, ENDS).heights.n_left_out == 1
    assert np.abs(left_um(points)).max() < 0.05
