"""How much of a deviation a round of correcting takes off, and what the round came to.

A gain below 1 keeps a machine that answers otherwise than expected, or a part that is not like the
next one, from being corrected too much. What the round before left on purpose, and the next part
shows again, is neither.

>>> shown = Correction((0.0, 60.0), {2: np.full(N_NODES, 0.001 + 0j)})
>>> first = take(shown, {}, 0.7)
>>> second = take(Correction((0.0, 60.0), first.left_mm), first.left_mm, 0.7)
>>> [f"{1000 * abs(step.taken.waves_mm[2][0]):.2f}" for step in (first, second)]
['0.70', '0.30']

Where the tool enters the metal or leaves it, the error changes within a turn, and a smooth
correction that suits the next turns would add as much there. MATHS.md (160).

>>> z_mm, turn = np.repeat(np.linspace(0, 10, 1001), 8), np.tile(np.arange(8) / 8, 1001)
>>> entering = GaugedPoints(turn, z_mm, np.where(z_mm < 0.03, 0.0, 1.0))
>>> whole = Correction((0.0, 10.0), {0: np.full(N_NODES, 0.001 + 0j)})
>>> smaller = taper(whole, entering)
>>> largest_um(off_um(whole, entering)), 0.4 < largest_um(off_um(smaller, entering)) < 0.6
(1.0, True)

>>> wave = {"order": 2, "gauged_um": 3.0, "noise_um": 0.01, "from_mm": 0, "to_mm": 62, "left_um": 1}
>>> print(wave_text(wave))
    harmonic  2: 3 um at most, noise 0.01 um, corrected at 0 .. 62 mm, 1 um left
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import UM_PER_MM, Floats
from camtools.base.text import Json
from camtools.cut.correction import N_NODES, Complexes, Correction, nodes_of
from camtools.measured.points import GaugedPoints
from camtools.measured.surface import KeptWave, SurfaceFit, taken_um


class RoundStep(NamedTuple):
    """What a round takes off, and what it leaves of what it was shown."""

    taken: Correction
    left_mm: dict[int, Complexes]


def take(shown: Correction, expected_mm: Mapping[int, Complexes], gain: float) -> RoundStep:
    """Return the step of a round, MATHS.md (160).

    Shown is all that the gauged part shows above the noise, expected what the round before left.
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
    return points.pick(is_judged)


def off_um(step: Correction, points: GaugedPoints) -> Floats:
    """Return the deviations of the next part, if the machine repeats its errors [um]."""
    return np.asarray(points.deviation_um - taken_um(step, points), dtype=np.float64)


def largest_um(deviations_um: Floats) -> float:
    """Return the largest magnitude of deviations [um], 0 of none."""
    return float(np.abs(deviations_um).max(initial=0.0))


def taper(step: Correction, points: GaugedPoints) -> Correction:
    """Return a step whose outer values are scaled for the least largest error at either end."""
    waves_mm = {order: values.copy() for order, values in step.waves_mm.items()}
    nodes_mm = step.nodes_mm
    for outer, reached in ((0, _REACH), (N_NODES - 1, N_NODES - 1 - _REACH)):
        reach_mm = abs(nodes_mm[reached] - nodes_mm[outer])
        share = _share(step, outer, points.pick(np.abs(points.z_mm - nodes_mm[outer]) <= reach_mm))
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


_DIGITS = 6
_ALIKE = 1.1  # largest errors within this ratio do not decide, the rms does


def _rounded(value: float) -> float:
    return round(float(value), _DIGITS)


def pair_of(values_um: Floats) -> Json:
    """Return the largest magnitude and the rms of deviations [um]."""
    return {
        "max": _rounded(np.abs(values_um).max(initial=0.0)),
        "rms": _rounded(np.sqrt(np.mean(values_um**2))),
    }


def _wave(fit: SurfaceFit, wave: KeptWave, step: RoundStep) -> Json:
    heights_mm = fit.z_mm[np.abs(wave.kept) > 0]
    return {
        "order": wave.order,
        "gauged_um": _rounded(np.abs(wave.smooth.values).max()),
        "noise_um": _rounded(np.sqrt(np.mean(wave.smooth.errors**2))),
        "from_mm": _rounded(heights_mm[0]),
        "to_mm": _rounded(heights_mm[-1]),
        "left_um": _rounded(UM_PER_MM * np.abs(step.left_mm[wave.order]).max()),
    }


def judged_um(about: Json) -> Json:
    """Return largest error and rms of the part of a round, less dust and damaged heights."""
    return dict(about.get("judged_um") or about["gauged_um"])


def pair_text(form: Json) -> str:
    """Return largest error and rms for people."""
    return f"max {form['max']:.4g} um, rms {form['rms']:.3g} um"


def best_round(rounds: Sequence[Json]) -> int:
    """Return the round of the table with the best part; 0: as drawn.

    The least largest error decides; of parts within a tenth of it, the least rms.
    """
    found = [judged_um(about) for about in rounds]
    most_um = _ALIKE * min(form["max"] for form in found)
    return min(range(len(found)), key=lambda i: (found[i]["max"] > most_um, found[i]["rms"]))


def best_text(rounds: Sequence[Json]) -> str:
    """Return which table was the best, by round and `table_crc32`, and the errors of its part."""
    number = best_round(rounds)
    about = rounds[number]
    table = f"the table of round {number} (table_crc32 {about['table_crc32']})"
    return f"{table}, {pair_text(judged_um(about))}"


def account_of(points: GaugedPoints, fit: SurfaceFit, step: RoundStep, by: GaugedPoints) -> Json:
    """Return what was measured and what is expected of the next part, judged `by` points."""
    kept = [wave for wave in fit.waves if wave.is_kept]
    noise2 = sum(float(np.mean(wave.smooth.errors**2)) / (2 if wave.order else 1) for wave in kept)
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
        "waves": [_wave(fit, wave, step) for wave in kept],
    }


def wave_text(wave: Json) -> str:
    """Return what was done about a wave."""
    name = f"harmonic {wave['order']:2d}" if wave["order"] else "mean       "
    return (
        f"    {name}: {wave['gauged_um']:.3g} um at most, noise {wave['noise_um']:.2g} um, "
        f"corrected at {wave['from_mm']:.4g} .. {wave['to_mm']:.4g} mm, "
        f"{wave['left_um']:.2g} um left"
    )


def _left_out(about: Json) -> str:
    """Return what of a surface does not count, nothing where all of it does."""
    found = []
    if about["heights_left_out"]:
        found.append(f"{about['heights_left_out']} heights have too few points")
    if about["heights_alone_mm"]:
        places = ", ".join(f"{mm:.4g}" for mm in about["heights_alone_mm"])
        found.append(f"heights unlike both neighbours: {places} mm")
    if about["points_far_off"]:
        found.append(f"{about['points_far_off']} points far from the others")
    less = f"; the rest has {pair_text(judged_um(about))}"
    return f"    left out: {'; '.join(found)}{less}\n" if found else ""


def round_text(correction: Json) -> str:
    """Return what the last round of a correction came to."""
    rounds = correction["rounds"]
    about = rounds[-1]
    is_best = best_round(rounds) == len(rounds) - 1
    worse = "" if is_best else f"    caution: the best so far is {best_text(rounds)}\n"
    lines = "".join(f"{wave_text(wave)}\n" for wave in about["waves"])
    return (
        f"  round {len(rounds)} of correcting, gain {about['gain']:g}: {about['points']} points at "
        f"{about['heights']} heights, deviation {pair_text(about['gauged_um'])}\n"
        + _left_out(about)
        + f"    noise of a point {about['noise_um']:.2g} um, of the correction "
        f"{about['noise_corrected_um']:.2g} um; harmonics up to {about['most_order']} checked\n"
        + lines
        + worse
        + f"    expected for the next part: {pair_text(about['expected_um'])}\n"
    )


def cautions(process: object, tool: object, report: Json) -> list[str]:
    """Return how the new table is cut otherwise than the gauged part by its report, a line each."""
    then, found = report.get("process", {}), []
    for key, unit in (("spindle_rpm", "r/min"), ("feed_mm", "mm"), ("direction", "")):
        old, new = then.get(key), getattr(process, key, None)
        if old is not None and new is not None and old != new:
            found.append(f"process.{key}: {old:g} {unit}".rstrip() + f" then, {new:g} now")
    old, new = report.get("tool", {}).get("nose_radius_mm"), getattr(tool, "nose_radius_mm", None)
    if old is not None and new is not None and old != new:
        found.append(f"tool.nose_radius_mm: {old:g} mm then, {new:g} now")
    caution = "  caution: the measured part was cut with other settings"
    return [f"{caution}: {change}" for change in found]
