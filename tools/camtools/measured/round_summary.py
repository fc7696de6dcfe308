"""What a round of correcting came to, for NAME.json.

>>> pair_of(np.array([3.0, -4.0]))
{'max': 4.0, 'rms': 3.535534}
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camtools.base.json_text import Json
from camtools.base.quantities import Floats
from camtools.measured.correction_step import RoundStep
from camtools.measured.end_taper import off_um
from camtools.measured.points import GaugedPoints
from camtools.measured.surface import KeptWave, SurfaceFit

_DIGITS = 6
_UM_PER_MM = 1000.0
_ALIKE = 1.1  # largest errors within this ratio do not decide, the rms does


def _rounded(value: float) -> float:
    return round(float(value), _DIGITS)


def pair_of(values_um: Floats) -> Json:
    """Return the largest magnitude and the rms of deviations [um]."""
    return {
        "max": _rounded(np.abs(values_um).max(initial=0.0)),
        "rms": _rounded(np.sqrt(np.mean(values_um**2))),
    }


def _wave(fit: SurfaceFit, one: KeptWave, step: RoundStep) -> Json:
    """Return what is said of a wave that is kept."""
    heights_mm = fit.z_mm[np.abs(one.kept) > 0]
    return {
        "order": one.order,
        "gauged_um": _rounded(np.abs(one.smooth.values).max()),
        "noise_um": _rounded(np.sqrt(np.mean(one.smooth.errors**2))),
        "from_mm": _rounded(heights_mm[0]),
        "to_mm": _rounded(heights_mm[-1]),
        "left_um": _rounded(_UM_PER_MM * np.abs(step.left_mm[one.order]).max()),
    }


def judged_um(one: Json) -> Json:
    """Return largest error and rms of the part of a round, less dust and damaged heights."""
    return dict(one.get("judged_um") or one["gauged_um"])


def pair_text(form: Json) -> str:
    """Return largest error and rms for people."""
    return f"max {form['max']:.4g} um, rms {form['rms']:.3g} um"


def best_round(rounds: Sequence[Json]) -> int:
    """Return the round of the table with the best part; 0: as drawn.

    The least largest error decides; of parts within a tenth of it, the least rms.
    """
    found = [judged_um(one) for one in rounds]
    most_um = _ALIKE * min(one["max"] for one in found)
    return min(range(len(found)), key=lambda i: (found[i]["max"] > most_um, found[i]["rms"]))


def best_text(rounds: Sequence[Json]) -> str:
    """Return which table was the best, by round and `table_crc32`, and the errors of its part."""
    number = best_round(rounds)
    one = rounds[number]
    table = f"the table of round {number} (table_crc32 {one['table_crc32']})"
    return f"{table}, {pair_text(judged_um(one))}"


def account_of(points: GaugedPoints, fit: SurfaceFit, step: RoundStep, by: GaugedPoints) -> Json:
    """Return what was measured and what is expected of the next part.

    Parameters
    ----------
    by : GaugedPoints
        The points by which the step was judged.
    """
    kept = [one for one in fit.waves if one.is_kept]
    noise2 = sum(float(np.mean(one.smooth.errors**2)) / (2 if one.order else 1) for one in kept)
    return {
        "points": int(points.turn.size),
        "heights": int(fit.z_mm.size),
        "heights_left_out": fit.heights.n_left_out,
        "heights_alone_mm": fit.alone_mm,
        "points_far_off": fit.n_far,
        "most_order": fit.heights.most_order,
        "noise_um": _rounded(fit.sigma_um),
        "noise_corrected_um": _rounded(np.sqrt(noise2)),
        "gauged_um": pair_of(points.deviation_um),
        "judged_um": pair_of(by.deviation_um),
        "expected_um": pair_of(off_um(step.taken, by)),
        "waves": [_wave(fit, one, step) for one in kept],
    }
