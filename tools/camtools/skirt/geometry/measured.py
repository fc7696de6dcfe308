"""Measured sections as the part file has them: read, and checked between their heights.

>>> flat = Scan(np.arange(0.0, 360, 15), np.arange(5.0), np.zeros((5, 24)))
>>> check_scan(flat, SectionShape(shape="table", csv="flat.csv"))
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.errors import GeometryError
from camtools.base.json_text import Json
from camtools.base.quantities import Floats, rounded_up
from camtools.skirt.geometry.scan import Periodic, Scan, joined_by, reductions
from camtools.skirt.geometry.scan_text import Sections, read_scan_text
from camtools.skirt.geometry.section_surface import overshoot_between
from camtools.skirt.part.section_keys import SectionShape

_UM_PER_MM = 1000.0
_GAP_STEPS = 4.0  # a gap: so many mean steps without a point ..
_GAP_DEG = (10.0, 45.0)  # .. but not less than the first and not more than the second
_PER_GAP = 256  # places at which a gap is looked at


def measured_sections(
    section: SectionShape, ends_mm: tuple[float, float], radius: PPoly
) -> Sections:
    """Return the sections of a part's file as reductions of its profile.

    Raises
    ------
    CamtoolsError
        The file is no good, or its heights do not cover the profile's.
    """
    assert section.csv is not None
    scan = read_scan_text(Path(section.csv))
    check_heights(scan.z_mm, ends_mm, is_single=section.single_height is True)
    found = reductions(scan, lambda z: np.asarray(radius(z), dtype=np.float64))
    check_gaps(found, section.overshoot_um)
    return found


def check_heights(z_mm: Floats, ends_mm: tuple[float, float], *, is_single: bool) -> None:
    """Refuse heights that do not cover the profile; one height must be asked for.

    Raises
    ------
    GeometryError
        A file that was cut short has fewer heights than were measured, too.
    """
    place = "piston.section.single_height"
    if z_mm.size == 1 and not is_single:
        problem = f"the file has one height only, {z_mm[0]:g} mm"
        remedy = "measure more, or set single_height = true if it is to serve all heights"
        raise GeometryError(place, problem, remedy)
    if z_mm.size > 1 and is_single:
        problem = f"is true, but the file has {z_mm.size} heights"
        raise GeometryError(place, problem, "leave it out, or keep one of them")
    if z_mm.size > 1 and (z_mm[0] > ends_mm[0] or z_mm[-1] < ends_mm[1]):
        problem = f"heights {z_mm[0]:g} .. {z_mm[-1]:g} mm do not cover the profile's"
        remedy = (
            f"measure {ends_mm[0]:g} .. {ends_mm[1]:g} mm, or one height with single_height = true"
        )
        raise GeometryError("piston.section.csv", problem, remedy)


class Gap(NamedTuple):
    """An angle without points, and how far the curve leaves the points at its ends."""

    beyond_um: float
    z_mm: float
    from_deg: float
    to_deg: float


def check_gaps(sections: Sections, overshoot_um: float) -> None:
    """Refuse sections whose curves leave the two points at the ends of a gap in the angle too far.

    Where many points are missing the spline tells nothing of the part: it swings.
    """
    worst = max(all_gaps(sections), default=Gap(0, 0, 0, 0))
    if worst.beyond_um > overshoot_um:
        problem = (
            f"height {worst.z_mm:g} mm: no points from {worst.from_deg:g} to {worst.to_deg:g} "
            f"degrees, where the curve goes {worst.beyond_um:.4g} um beyond both"
        )
        remedy = f"measure there, or allow it: overshoot_um = {rounded_up(worst.beyond_um):g}"
        raise GeometryError("piston.section.csv", problem, remedy)


def all_gaps(sections: Sections) -> list[Gap]:
    """Return the gaps of all heights."""
    return [
        gap
        for z_mm, angle, values in zip(*sections[:3], strict=True)
        for gap in gaps_of(float(z_mm), angle, values)
    ]


def coverage(sections: Sections) -> Json:
    """Return what was measured, and the gaps in the angle that the curves bridge."""
    return {
        "heights_mm": sections.z_mm.tolist(),
        "points": sum(angle.size for angle in sections.angles_deg),
        "gaps": [gap._asdict() for gap in all_gaps(sections)],
    }


def gaps_of(z_mm: float, angle_deg: Floats, values_mm: Floats) -> Iterator[Gap]:
    """Find the gaps of a section, and how far its curve leaves the points at their ends."""
    steps = np.diff(angle_deg, append=angle_deg[0] + 360)
    wide = steps > np.clip(_GAP_STEPS * 360 / angle_deg.size, *_GAP_DEG)
    curve, after = Periodic(angle_deg, values_mm), np.roll(values_mm, -1)
    for i in np.flatnonzero(wide):
        at = angle_deg[i] + steps[i] * (np.arange(_PER_GAP) + 0.5) / _PER_GAP
        between, ends = curve(at), (values_mm[i], after[i])
        beyond = max(between.max() - max(ends), min(ends) - between.min(), 0.0)
        to_deg = float(np.mod(angle_deg[i] + steps[i], 360))
        yield Gap(_UM_PER_MM * float(beyond), z_mm, float(angle_deg[i]), to_deg)


def check_scan(scan: Scan, section: SectionShape) -> None:
    """Refuse sections whose curves over the height leave the points of two heights too far."""
    values_um = scan.reduction_mm * _UM_PER_MM
    kind = joined_by(scan, section.interpolation)
    worst, i = overshoot_between(scan.z_mm, values_um, kind)
    if worst.beyond > section.overshoot_um:
        problem = (
            f"between the heights {worst.low_mm:g} and {worst.high_mm:g} mm the section at "
            f"{scan.angle_deg[i]:g} degrees goes {worst.beyond:.4g} um beyond both, at height "
            f"{worst.z_mm:.6g} mm"
        )
        remedy = (
            'set interpolation = "pchip", measure more heights, or allow it: overshoot_um = '
            f"{rounded_up(worst.beyond):g}"
        )
        raise GeometryError("piston.section.interpolation", problem, remedy)
