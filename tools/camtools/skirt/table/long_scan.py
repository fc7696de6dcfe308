"""The remedy for measured parts whose points are too many for a table: tried, then named.

A table through every point of a long scan plays the instrument's noise and needs several knots per
point; the format has 4096 per turn and the generator makes no channel above a mebibyte.

>>> WAVES[:3]
(120, 60, 30)
"""

from __future__ import annotations

from collections.abc import Callable

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.skirt.geometry.skirt_geometry import Geometry, keeping
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.search import UnreachableError, choose_u

WAVES = (120, 60, 30, 15, 8, 4)  # numbers of harmonics that are tried


def refuse_scan(
    part: SkirtPart,
    geometry: Geometry,
    followed: Callable[[Geometry], Geometry],
    tolerance_nm: float,
    error: UnreachableError,
) -> None:
    """Refuse a measured part that has no table, with the most waves that make one.

    Does nothing for other parts.

    Parameters
    ----------
    followed : callable
        From the skirt's geometry to what the tool's tip follows.

    Raises
    ------
    GeometryError
        With the number of harmonics that was tried and works, and how far it is off the points.
    """
    section = part.piston.section
    if geometry.measured is None:
        return
    scan = geometry.measured[1]
    factor = part.magnify.factor if part.magnify else 1.0
    most = min(section.harmonics or scan.angle_deg.size, (scan.angle_deg.size - 1) // 2 + 1)
    n_points = f"{scan.angle_deg.size} points a turn at {scan.z_mm.size} heights"
    kept = "all points" if section.harmonics is None else f"{section.harmonics} waves per turn"
    problem = f"no table through {kept} of the scan ({n_points}) keeps {tolerance_nm:g} nm"
    for waves in (one for one in WAVES if one < most):
        try:
            fewer = keeping(geometry, waves, factor, section.interpolation)
            channel, _ = choose_u(followed(fewer), tolerance_nm)
        except CamtoolsError:
            continue
        remedy = (
            f"set harmonics = {waves}: its surface is within {fewer.off_points_um:.3g} um of the "
            f"points and takes {channel.size} bytes"
        )
        raise GeometryError("piston.section.harmonics", problem, remedy) from error
