"""What a round of correcting came to, in lines for people.

>>> wave = {"order": 2, "gauged_um": 3.0, "noise_um": 0.01, "from_mm": 0, "to_mm": 62, "left_um": 1}
>>> print(wave_text(wave))
    harmonic  2: 3 um at most, noise 0.01 um, corrected at 0 .. 62 mm, 1 um left
"""

from __future__ import annotations

from camtools.base.json_text import Json
from camtools.measured.round_summary import best_round, best_text, judged_um, pair_text


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
        places = ", ".join(f"{one:.4g}" for one in about["heights_alone_mm"])
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
    lines = "".join(f"{wave_text(one)}\n" for one in about["waves"])
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
    """Return how the new table is cut otherwise than the gauged part was, a line each.

    Parameters
    ----------
    report : dict
        NAME.json of the table that cut the gauged part.
    """
    then, found = report.get("process", {}), []
    for key, unit in (("spindle_rpm", "r/min"), ("feed_mm", "mm"), ("direction", "")):
        old, new = then.get(key), getattr(process, key, None)
        if old is not None and new is not None and old != new:
            found.append(f"process.{key}: {old:g} {unit}".rstrip() + f" then, {new:g} now")
    old, new = report.get("tool", {}).get("nose_radius_mm"), getattr(tool, "nose_radius_mm", None)
    if old is not None and new is not None and old != new:
        found.append(f"tool.nose_radius_mm: {old:g} mm then, {new:g} now")
    return [f"  caution: the measured part was cut with other settings: {one}" for one in found]
