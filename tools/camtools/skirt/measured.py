"""Measured sections as the part file has them: read, and checked between their heights.

>>> flat = Scan(np.arange(0.0, 360, 15), np.arange(5.0), np.zeros((5, 24)))
>>> check_scan(flat, SectionShape(shape="table", csv="flat.csv"))
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.errors import GeometryError
from camtools.skirt.part_section import SectionShape
from camtools.skirt.profile import rounded_up
from camtools.skirt.scan import Scan, joined_by, reductions
from camtools.skirt.scan_text import Sections, read_scan_text
from camtools.skirt.section_surface import overshoot_between

_UM_PER_MM = 1000.0


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
    if scan.z_mm.size > 1 and (scan.z_mm[0] > ends_mm[0] or scan.z_mm[-1] < ends_mm[1]):
        problem = f"heights {scan.z_mm[0]:g} .. {scan.z_mm[-1]:g} mm do not cover the profile's"
        remedy = f"measure {ends_mm[0]:g} .. {ends_mm[1]:g} mm, or one height that serves all"
        raise GeometryError("piston.section.csv", problem, remedy)
    return reductions(scan, lambda z: np.asarray(radius(z), dtype=np.float64))


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
            f"{rounded_up(worst.beyond)}"
        )
        raise GeometryError("piston.section.interpolation", problem, remedy)
