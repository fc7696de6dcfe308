"""Whether the flank of the tool clears every section of a skirt, MATHS.md (111).

Where a section falls in the sense of cutting, the work behind the edge stands higher than the edge.
The steepest place decides, however long the flank is: seen from the edge, no place of the work
appears under a larger angle than the section has somewhere between the two.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> found = steepest_heel(make_geometry(example_part()), 1)
>>> f"{found.needed_deg:.3f} degrees needed at {found.angle_deg:g}, height {found.z_mm:g} mm"
'0.188 degrees needed at 44.9, height 62 mm'
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from camtools.base.errors import GeometryError
from camtools.part.common import Tool
from camtools.skirt.geometry.skirt_geometry import Geometry

_ANGLES, _HEIGHTS = 3600, 17
_MAX_BREAKS = 64


class Heel(NamedTuple):
    """The place where the flank comes nearest to the work."""

    needed_deg: float  # least clearance angle that just does
    angle_deg: float  # of the drawing, where the edge stands
    z_mm: float


def steepest_heel(geometry: Geometry, direction: int) -> Heel:
    """Return the largest clearance angle of all sections; 1: the tool runs to rising angles."""
    breaks = geometry.breaks_mm()
    inner = breaks[:: max(1, breaks.size // _MAX_BREAKS)]
    z_mm = np.union1d(inner, np.linspace(breaks[0], breaks[-1], _HEIGHTS))
    phi = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
    u = geometry.delta(phi, z_mm[:, None])
    needed = np.arctan2(direction * u.d1, geometry.radius_mm(z_mm)[:, None] - u.delta)
    i, k = np.unravel_index(int(needed.argmax()), needed.shape)
    return Heel(float(np.degrees(needed[i, k])), float(k) * 360 / _ANGLES, float(z_mm[i]))


def check_heel(geometry: Geometry, tool: Tool, direction: int) -> Heel:
    """Return where the flank comes nearest to the work, or refuse a tool whose heel rubs."""
    found = steepest_heel(geometry, direction)
    if found.needed_deg < tool.clearance_deg:
        return found
    problem = (
        f"the heel of {tool.clearance_deg:g} degrees rubs: at {found.angle_deg:g} degrees, height "
        f"{found.z_mm:g} mm the work after the edge rises by {found.needed_deg:.2f} degrees"
    )
    least_deg = ceil(found.needed_deg * 10 + 0.1) / 10
    remedy = f"give a tool with at least {least_deg:.1f}, or a section that is less steep"
    raise GeometryError("tool.clearance_deg", problem, remedy)
