"""Curves over the height of a part: long half axis, ovality, and what else varies with it.

>>> from camtools.skirt.part.part_file import example_part
>>> f"{profile_spline(example_part().piston.profile)(5.0):.9f}"
'45.983096898'
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats, rounded_up
from camtools.skirt.geometry.smooth_points import smoothed_mm
from camtools.skirt.part.curves import Overshoot, overshoot, through
from camtools.skirt.part.part_file import Piston
from camtools.skirt.part.power_law import PeakOvality, PowerProfile
from camtools.skirt.part.profile_keys import USUAL_OVERSHOOT_UM, Ovality, Profile, joined
from camtools.skirt.part.segments import Piece, curve_of

_UM_PER_MM = 1000.0


def profile_spline(profile: Profile | PowerProfile) -> PPoly:
    """Return the long half axis a(z) [mm] as cubics, MATHS.md (6), (70) .. (72), (98)."""
    if isinstance(profile, PowerProfile):
        return profile.curve()
    if profile.segment:
        return curve_of(profile_pieces(profile))
    ends: object = profile.spline
    if profile.end_slopes is not None:
        ends = ((1, profile.end_slopes[0]), (1, profile.end_slopes[1]))
    radius_mm = smoothed_mm(profile) / 2
    return through(profile.height_mm, radius_mm, profile.interpolation, ends)


def profile_pieces(profile: Profile) -> tuple[Piece, ...]:
    """Return the segments of a profile, their values being radii; none without segments."""
    start = profile.height_mm[0], profile.diameter_mm[0]
    return joined(*start, profile.segment, 2) if profile.segment else ()


def polygon_or_spline(z_mm: Sequence[float] | Floats, values: Floats, interpolation: str) -> PPoly:
    """Return values over height as cubics, see `curves.through`."""
    return through(z_mm, values, interpolation)


def constant_spline(value: float, first_mm: float, last_mm: float) -> PPoly:
    """Return one value for all heights."""
    return PPoly(np.array([[0.0], [0.0], [0.0], [value]]), np.array([first_mm, last_mm]))


def ovality_spline(ovality: Ovality | PeakOvality) -> PPoly:
    """Return G(z) [mm] as cubics, MATHS.md (6), (70) .. (72)."""
    if isinstance(ovality, Ovality) and ovality.segment:
        return curve_of(ovality_pieces(ovality))
    values_mm = smoothed_mm(ovality) if isinstance(ovality, Ovality) else ovality.ovality_mm
    return through(ovality.height_mm, values_mm, ovality.interpolation)


def ovality_pieces(ovality: Ovality) -> tuple[Piece, ...]:
    """Return the segments of an ovality; none without segments."""
    start = ovality.height_mm[0], ovality.ovality_mm[0]
    return joined(*start, ovality.segment, 1) if ovality.segment else ()


class Allowance(NamedTuple):
    """How far a curve may leave the values of its points."""

    what: str  # the curve's name in messages
    scale: float  # from the curve's unit to that of the limit
    unit: str
    limit: float
    key: str | None  # of the part file, that allows more


def in_um(limit_um: float, what: str, scale: float = 1.0) -> Allowance:
    """Return an allowance in um for a curve in mm, or in a share of it."""
    return Allowance(what, scale * _UM_PER_MM, "um", limit_um, "overshoot_um")


def check_overshoot(field: str, curve: PPoly, allowed: Allowance, points_mm: Floats) -> None:
    """Refuse a curve that leaves the values of two neighbouring points too far, MATHS.md (73).

    Parameters
    ----------
    field : str
        Dotted path of the key "interpolation".

    Raises
    ------
    GeometryError
        With place, size and remedy.
    """
    worst = overshoot(curve, points_mm)
    beyond = worst.beyond * allowed.scale
    if beyond <= allowed.limit:
        return
    problem = _overshoot_text(worst, allowed)
    remedy = 'set interpolation = "pchip", or give more points there'
    if allowed.key is not None:
        remedy += f", or allow it: {allowed.key} = {rounded_up(beyond):g}"
    raise GeometryError(field, problem, remedy)


def _overshoot_text(worst: Overshoot, allowed: Allowance) -> str:
    size = f"{worst.beyond * allowed.scale:.4g} {allowed.unit}".rstrip()
    return (
        f"between the points at {worst.low_mm:g} and {worst.high_mm:g} mm {allowed.what} goes "
        f"{size} beyond both, at height {worst.z_mm:.6g} mm"
    )


def notable_overshoots(piston: Piston) -> list[str]:
    """Return where curves leave their points by more than usual, since overshoot_um allows it."""
    drawn = [
        (one, curve, scale)
        for one, curve, scale in (
            (piston.profile, profile_spline(piston.profile), 2),
            (piston.ovality, ovality_spline(piston.ovality) if piston.ovality else None, 1),
        )
        if isinstance(one, Profile | Ovality) and not one.segment and curve is not None
    ]
    found = []
    for one, curve, scale in drawn:
        allowed = _allowance(one, scale)
        worst = overshoot(curve, np.asarray(one.height_mm, dtype=np.float64))
        if worst.beyond * allowed.scale > USUAL_OVERSHOOT_UM:
            found.append(_overshoot_text(worst, allowed))
    return found


def check_profile(profile: Profile | PowerProfile, curve: PPoly) -> None:
    """Refuse a profile that leaves its points' diameters by more than overshoot_um."""
    if isinstance(profile, Profile):
        _check(profile, profile_pieces(profile), curve, 2, "piston.profile")


def check_ovality(ovality: Ovality | PeakOvality, curve: PPoly) -> None:
    """Refuse an ovality that leaves its points' values by more than overshoot_um."""
    if isinstance(ovality, Ovality):
        _check(ovality, ovality_pieces(ovality), curve, 1, "piston.ovality")


def _allowance(drawn: Profile | Ovality, scale: int) -> Allowance:
    what = "the diameter" if isinstance(drawn, Profile) else "the ovality"
    return in_um(drawn.overshoot_um, what, scale)


def _check(
    drawn: Profile | Ovality, pieces: tuple[Piece, ...], curve: PPoly, scale: int, table: str
) -> None:
    allowed = _allowance(drawn, scale)
    if pieces:
        _check_derived(allowed, pieces, curve, table)
        return
    points_mm = np.asarray(drawn.height_mm, dtype=np.float64)
    check_overshoot(f"{table}.interpolation", curve, allowed, points_mm)


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
