# SPDX-License-Identifier: Apache-2.0
"""Points of profile and ovality that are smoothed, or should be, and what that costs.

>>> from camtools.skirt.part.part_file import example_part
>>> smoothing_facts(example_part().piston), smoothing_takes_um(example_part())
({}, 0.0)
"""

from __future__ import annotations

import numpy as np

from camtools.base.json_text import Json
from camtools.base.quantities import Floats
from camtools.part.smoothing import bands_um, differences, first_enough, smoothed
from camtools.part.smoothing_text import (
    PeakChange,
    band_words,
    check_share,
    noise_text,
    residuals,
    smoothed_texts,
)
from camtools.part.tolerances import Tolerances
from camtools.skirt.part.part_file import Piston, SkirtPart
from camtools.skirt.part.profile_keys import Ovality, Profile

_UM_PER_MM = 1000.0


def listed_mm(drawn: Profile | Ovality) -> Floats:
    """Return the listed diameters or ovalities."""
    values_mm = drawn.diameter_mm if isinstance(drawn, Profile) else drawn.ovality_mm
    return np.asarray(values_mm, dtype=np.float64)


def smoothed_mm(drawn: Profile | Ovality) -> Floats:
    """Return the diameters or ovalities of the points, smoothed where that is asked for."""
    if drawn.smooth_um is None:
        return listed_mm(drawn)
    return _within(drawn, drawn.smooth_um)


def _within(drawn: Profile | Ovality, band_um: float) -> Floats:
    z_mm = np.asarray(drawn.height_mm, dtype=np.float64)
    return smoothed(z_mm, listed_mm(drawn), band_um / _UM_PER_MM)


def _pointed(piston: Piston) -> dict[str, Profile | Ovality]:
    """Return the curves over the height that are given by points, by name."""
    drawn = {"profile": piston.profile, "ovality": piston.ovality}
    return {
        name: one
        for name, one in drawn.items()
        if isinstance(one, Profile | Ovality) and not one.segment
    }


def smoothed_curves(piston: Piston) -> dict[str, Profile | Ovality]:
    """Return the curves over the height whose points are smoothed, by name."""
    return {name: one for name, one in _pointed(piston).items() if one.smooth_um is not None}


def _facts(drawn: Profile | Ovality, band_um: float) -> Json:
    z_mm = np.asarray(drawn.height_mm, dtype=np.float64)
    before, after = listed_mm(drawn), _within(drawn, band_um)
    off_um = (after - before) * _UM_PER_MM
    matrix = differences(z_mm, 2)
    bends = (float(np.abs(matrix @ one).max(initial=0.0)) for one in (before, after))
    return residuals(band_um, off_um, z_mm, "largest_at_mm") | {
        "height_mm": z_mm.tolist(),
        "off_um": off_um.tolist(),
        "bend_per_mm": dict(zip(("before", "after"), bends, strict=True)),
    }


def smoothing_facts(piston: Piston) -> Json:
    """Return residuals and largest second derivatives of smoothed points, nothing of others.

    Diameters and ovalities, not radii; the second derivative is that of three neighbours.
    """
    curves = smoothed_curves(piston)
    return {name: _facts(one, one.smooth_um) for name, one in curves.items() if one.smooth_um}


def noise_facts(piston: Piston) -> Json:
    """Return the same of points that are not smoothed and should be, within the band they need."""
    found: Json = {}
    for name, one in _pointed(piston).items():
        if one.smooth_um is None and (needed := _needed(one)) is not None:
            found[name] = needed
    return found


def _needed(drawn: Profile | Ovality) -> Json | None:
    def peaks(facts: Json) -> tuple[float, float]:
        return facts["bend_per_mm"]["before"], facts["bend_per_mm"]["after"]

    bands = bands_um(np.asarray(drawn.height_mm, dtype=np.float64), listed_mm(drawn))
    return first_enough(bands, lambda band_um: _facts(drawn, band_um), peaks)


def smoothing_texts(found: Json, noise: Json, form_error_um: float) -> list[str]:
    """Return what `smoothing_facts` and `noise_facts` found as lines for people."""
    lines = []
    for name, one in found.items():
        place = f"height {one['largest_at_mm']:g} mm"
        lines += smoothed_texts(name, one, place, [_change(one)])
    for name, one in noise.items():
        words = band_words(one["smooth_um"], one["largest_um"] / 2, form_error_um)
        lines.append(noise_text(name, f"piston.{name}.{words}", [_change(one)]))
    return lines


def _change(facts: Json) -> PeakChange:
    bend = facts["bend_per_mm"]
    return PeakChange("second derivative", bend["before"], bend["after"], "per mm")


def _taken_by_curve_um(part: SkirtPart) -> dict[str, float]:
    """Return how far smoothing of each curve moves the radius at most."""
    magnify, found = part.magnify, smoothing_facts(part.piston)
    factors = {"profile": magnify.profile_factor, "ovality": magnify.factor} if magnify else {}
    return {name: factors.get(name, 1.0) * one["largest_um"] / 2 for name, one in found.items()}


def smoothing_takes_um(part: SkirtPart) -> float:
    """Return how far smoothing moves the radius at most, 0 without smoothing."""
    return sum(_taken_by_curve_um(part).values(), 0.0)


def tolerances_left(part: SkirtPart) -> Tolerances:
    """Return the tolerances of the sheets less what smoothing may take of each."""
    stated, taken = part.tolerances, _taken_by_curve_um(part)
    if not taken:
        return stated
    oval_um, radius_um = taken.get("ovality", 0.0), sum(taken.values())
    takes = {
        "diameter_um": 2 * radius_um,
        "ovality_um": 2 * oval_um,
        "roundness_um": oval_um,
        "straightness_um": 2 * radius_um,
        "taper_um": _taper_um(part),
    }
    left = {
        name: max(0.0, getattr(stated, name) - um)
        for name, um in takes.items()
        if getattr(stated, name) is not None
    }
    return stated.model_copy(update=left)


def _taper_um(part: SkirtPart) -> float:
    """Return by how much smoothing changes the taper of the diameter at most."""
    found = smoothing_facts(part.piston).values()
    slopes = [abs(np.polyfit(one["height_mm"], one["off_um"], 1)[0]) for one in found]
    spans_mm = [one["height_mm"][-1] - one["height_mm"][0] for one in found]
    factor = part.magnify.factor if part.magnify else 1.0
    return factor * float(np.dot(slopes, spans_mm))


def check_smoothing(part: SkirtPart) -> None:
    """Refuse smoothing that leaves nothing of the form error.

    Raises
    ------
    GeometryError
        With the numbers and the remedy.
    """
    found = _taken_by_curve_um(part)
    if found:
        worst = max(found, key=lambda name: found[name])
        field = f"piston.{worst}.smooth_um"
        check_share(field, sum(found.values()), part.process.form_error_um)
