"""Curves over the height of a part: long half axis, ovality, and points that are smoothed.

>>> from camtools.skirt.part.part_file import example_part
>>> f"{profile_spline(example_part().piston.profile)(5.0):.9f}"
'45.983096898'
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.errors import GeometryError
from camtools.base.quantities import UM_PER_MM, Floats, rounded_up
from camtools.base.text import Json
from camtools.part.areas import ZonedTolerances
from camtools.part.common import SectionTolerances
from camtools.part.smoothing import (
    PeakChange,
    band_words,
    bands_um,
    check_share,
    differences,
    first_enough,
    noise_text,
    residuals,
    smoothed,
    smoothed_texts,
)
from camtools.skirt.part.curves import (
    Overshoot,
    PeakOvality,
    Piece,
    PowerProfile,
    curve_of,
    overshoot,
    through,
)
from camtools.skirt.part.keys import USUAL_OVERSHOOT_UM, Ovality, Profile, joined
from camtools.skirt.part.part_file import Piston, SkirtPart


def listed_mm(drawn: Profile | Ovality) -> Floats:
    """Return the listed diameters or ovalities."""
    return np.asarray(getattr(drawn, drawn.VALUE), dtype=np.float64)


def smoothed_mm(drawn: Profile | Ovality, band_um: float | None) -> Floats:
    """Return the diameters or ovalities of the points, smoothed where there is a band."""
    if band_um is None:
        return listed_mm(drawn)
    z_mm = np.asarray(drawn.height_mm, dtype=np.float64)
    return smoothed(z_mm, listed_mm(drawn), band_um / UM_PER_MM)


def _pointed(piston: Piston) -> dict[str, Profile | Ovality]:
    """Return the curves over the height that are given by points, by name."""
    drawn = {"profile": piston.profile, "ovality": piston.ovality}
    return {
        name: curve
        for name, curve in drawn.items()
        if isinstance(curve, Profile | Ovality) and not curve.segment
    }


def smoothed_curves(piston: Piston) -> dict[str, Profile | Ovality]:
    """Return the curves over the height whose points are smoothed, by name."""
    return {name: curve for name, curve in _pointed(piston).items() if curve.smooth_um is not None}


def _facts(drawn: Profile | Ovality, band_um: float) -> Json:
    z_mm = np.asarray(drawn.height_mm, dtype=np.float64)
    before, after = listed_mm(drawn), smoothed_mm(drawn, band_um)
    off_um = (after - before) * UM_PER_MM
    matrix = differences(z_mm, 2)
    bends = (float(np.abs(matrix @ values).max(initial=0.0)) for values in (before, after))
    return residuals(band_um, off_um, z_mm, "largest_at_mm") | {
        "height_mm": z_mm.tolist(),
        "off_um": off_um.tolist(),
        "bend_per_mm": dict(zip(("before", "after"), bends, strict=True)),
    }


def smoothing_facts(piston: Piston) -> Json:
    """Return residuals and largest second derivatives of smoothed points, nothing of others.

    Diameters and ovalities, not radii; the second derivative is that of three neighbours.
    """
    curves = _pointed(piston).items()
    return {name: _facts(curve, curve.smooth_um) for name, curve in curves if curve.smooth_um}


def noise_facts(piston: Piston) -> Json:
    """Return the same of points that are not smoothed and should be, within the band they need."""

    def peaks(facts: Json) -> tuple[float, float]:
        return facts["bend_per_mm"]["before"], facts["bend_per_mm"]["after"]

    found: Json = {}
    for name, drawn in _pointed(piston).items():
        if drawn.smooth_um is None:
            bands = bands_um(np.asarray(drawn.height_mm, dtype=np.float64), listed_mm(drawn))
            found[name] = first_enough(bands, partial(_facts, drawn), peaks)
    return {name: needed for name, needed in found.items() if needed is not None}


def smoothing_texts(found: Json, noise: Json, form_error_um: float) -> list[str]:
    """Return what `smoothing_facts` and `noise_facts` found as lines for people."""
    lines = []
    for name, facts in found.items():
        place = f"height {facts['largest_at_mm']:g} mm"
        lines += smoothed_texts(name, facts, place, [_change(facts)])
    for name, facts in noise.items():
        words = band_words(facts["smooth_um"], facts["largest_um"] / 2, form_error_um)
        lines.append(noise_text(name, f"piston.{name}.{words}", [_change(facts)]))
    return lines


def _change(facts: Json) -> PeakChange:
    bend = facts["bend_per_mm"]
    return PeakChange("second derivative", bend["before"], bend["after"], "per mm")


def _taken_by_curve_um(part: SkirtPart) -> dict[str, float]:
    """Return how far smoothing of each curve moves the radius at most."""
    magnify, found = part.magnify, smoothing_facts(part.piston)
    factors = {"profile": magnify.profile_factor, "ovality": magnify.factor} if magnify else {}
    return {name: factors.get(name, 1.0) * facts["largest_um"] / 2 for name, facts in found.items()}


def smoothing_takes_um(part: SkirtPart) -> float:
    """Return how far smoothing moves the radius at most, 0 without smoothing."""
    return sum(_taken_by_curve_um(part).values(), 0.0)


def tolerances_left(part: SkirtPart) -> ZonedTolerances:
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

    def less(of: SectionTolerances) -> dict[str, float]:
        given = {name: getattr(of, name, None) for name in takes}  # a zone has no taper
        return {name: max(0.0, um - takes[name]) for name, um in given.items() if um is not None}

    taken_um = smoothing_takes_um(part)
    zones = [zone.model_copy(update=less(zone)).narrowed(taken_um) for zone in stated.zones]
    return stated.model_copy(update=less(stated) | {"zones": zones})


def _taper_um(part: SkirtPart) -> float:
    """Return by how much smoothing changes the taper of the diameter at most."""
    found = smoothing_facts(part.piston).values()
    slopes = [abs(np.polyfit(facts["height_mm"], facts["off_um"], 1)[0]) for facts in found]
    spans_mm = [facts["height_mm"][-1] - facts["height_mm"][0] for facts in found]
    factor = part.magnify.factor if part.magnify else 1.0
    return factor * float(np.dot(slopes, spans_mm))


def check_smoothing(part: SkirtPart) -> None:
    """Refuse smoothing that leaves nothing of the form error."""
    found = _taken_by_curve_um(part)
    if found:
        worst = max(found, key=lambda name: found[name])
        field = f"piston.{worst}.smooth_um"
        check_share(field, sum(found.values()), part.tightest_um)


def profile_spline(profile: Profile | PowerProfile) -> PPoly:
    """Return the long half axis a(z) [mm] as cubics, MATHS.md (6), (70) .. (72), (98)."""
    if isinstance(profile, PowerProfile):
        return profile.curve()
    if profile.segment:
        return curve_of(pieces_of(profile))
    ends: object = profile.spline
    if profile.end_slopes is not None:
        ends = ((1, profile.end_slopes[0]), (1, profile.end_slopes[1]))
    radius_mm = smoothed_mm(profile, profile.smooth_um) / 2
    return through(profile.height_mm, radius_mm, profile.interpolation, ends)


def pieces_of(drawn: Profile | Ovality) -> tuple[Piece, ...]:
    """Return the segments of a profile, their values being radii, or of an ovality; or none."""
    start = drawn.height_mm[0], float(listed_mm(drawn)[0])
    return joined(*start, drawn.segment, drawn.SCALE) if drawn.segment else ()


def constant_spline(value: float, first_mm: float, last_mm: float) -> PPoly:
    """Return one value for all heights."""
    return PPoly(np.array([[0.0], [0.0], [0.0], [value]]), np.array([first_mm, last_mm]))


def ovality_spline(ovality: Ovality | PeakOvality) -> PPoly:
    """Return G(z) [mm] as cubics, MATHS.md (6), (70) .. (72)."""
    if isinstance(ovality, PeakOvality):
        return through(ovality.height_mm, ovality.ovality_mm, ovality.interpolation)
    if ovality.segment:
        return curve_of(pieces_of(ovality))
    values_mm = smoothed_mm(ovality, ovality.smooth_um)
    return through(ovality.height_mm, values_mm, ovality.interpolation)


def over_ovality(value: list[float] | float, ovality: Ovality | PeakOvality) -> PPoly:
    """Return a number, or a list over the ovality's heights, as cubics; a polygon of segments."""
    if isinstance(value, list):
        kind = "linear" if ovality.interpolation == "segments" else ovality.interpolation
        return through(ovality.height_mm, value, kind)
    return constant_spline(value, ovality.height_mm[0], ovality.height_mm[-1])


class Allowance(NamedTuple):
    """How far a curve may leave the values of its points."""

    what: str  # the curve's name in messages
    scale: float  # from the curve's unit to that of the limit
    unit: str
    limit: float
    key: str | None  # of the part file, that allows more


def in_um(limit_um: float, what: str, scale: float = 1.0) -> Allowance:
    """Return an allowance in um for a curve in mm, or in a share of it."""
    return Allowance(what, scale * UM_PER_MM, "um", limit_um, "overshoot_um")


def check_overshoot(field: str, curve: PPoly, allowed: Allowance, points_mm: Floats) -> None:
    """Refuse a curve that leaves the values of two neighbouring points too far, MATHS.md (73).

    `field` is the dotted path of the key "interpolation".
    """
    worst = overshoot(curve, points_mm)
    beyond = worst.beyond * allowed.scale
    if beyond <= allowed.limit:
        return
    remedy = 'set interpolation = "pchip", or give more points there'
    if allowed.key is not None:
        remedy += f", or allow it: {allowed.key} = {rounded_up(beyond):g}"
    raise GeometryError(field, _overshoot_text(worst, allowed), remedy)


def _overshoot_text(worst: Overshoot, allowed: Allowance) -> str:
    size = f"{worst.beyond * allowed.scale:.4g} {allowed.unit}".rstrip()
    return (
        f"between the points at {worst.low_mm:g} and {worst.high_mm:g} mm {allowed.what} goes "
        f"{size} beyond both, at height {worst.z_mm:.6g} mm"
    )


def notable_overshoots(piston: Piston) -> list[str]:
    """Return where curves leave their points by more than usual, since overshoot_um allows it."""
    found = []
    for drawn in _pointed(piston).values():
        curve = profile_spline(drawn) if isinstance(drawn, Profile) else ovality_spline(drawn)
        allowed = _allowance(drawn)
        worst = overshoot(curve, np.asarray(drawn.height_mm, dtype=np.float64))
        if worst.beyond * allowed.scale > USUAL_OVERSHOOT_UM:
            found.append(_overshoot_text(worst, allowed))
    return found


def _allowance(drawn: Profile | Ovality) -> Allowance:
    what = "the diameter" if isinstance(drawn, Profile) else "the ovality"
    return in_um(drawn.overshoot_um, what, drawn.SCALE)


def check_drawn(drawn: Profile | PowerProfile | Ovality | PeakOvality, curve: PPoly) -> None:
    """Refuse a profile or an ovality whose curve leaves its points by more than overshoot_um."""
    if isinstance(drawn, PowerProfile | PeakOvality):
        return
    table = "piston.profile" if isinstance(drawn, Profile) else "piston.ovality"
    if drawn.segment:
        _check_derived(_allowance(drawn), pieces_of(drawn), curve, table)
    else:
        check_points(f"{table}.interpolation", curve, _allowance(drawn), drawn)


def check_points(
    field: str, curve: PPoly, allowed: Allowance, drawn: Profile | Ovality | PeakOvality
) -> None:
    """Refuse a curve that leaves the points of a profile or an ovality; formulas have none."""
    if not isinstance(drawn, PeakOvality):
        check_overshoot(field, curve, allowed, np.asarray(drawn.height_mm, dtype=np.float64))


def _check_derived(allowed: Allowance, pieces: tuple[Piece, ...], curve: PPoly, table: str) -> None:
    """Check the arcs whose radius is derived: one that is given is meant as it is."""
    for i, piece in enumerate(pieces):
        if not piece.is_derived:
            continue
        worst = overshoot(curve, np.array([piece.from_mm, piece.to_mm]))
        beyond = worst.beyond * allowed.scale
        if beyond > allowed.limit:
            problem = (
                f"{allowed.what} of the tangent arc of radius {piece.radius_mm:.6g} mm goes "
                f"{beyond:.4g} um beyond both its ends, at height {worst.z_mm:.6g} mm"
            )
            remedy = "give its radius_mm if it is meant, or allow it: overshoot_um = "
            remedy += f"{rounded_up(beyond):g}"
            raise GeometryError(f"{table}.segment.{i}.tangent", problem, remedy)


def magnified(spline: PPoly, factor: float, fixed_mm: float) -> PPoly:
    """Return fixed - factor (fixed - spline), the papers' demonstration, MATHS.md (7)."""
    coefficients = np.array(spline.c * factor)
    coefficients[-1] += fixed_mm * (1 - factor)
    return PPoly(coefficients, spline.x)
