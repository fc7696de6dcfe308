"""Whether the flank of a swung tool clears the lobe that it turns, MATHS.md (111).

The tool stands along the normal of its contact, so that at the edge the lobe neither rises nor
falls. Behind the edge a lobe that is convex falls away; a hollow rises, the more the longer the
flank is.

>>> from camtools.lobe.motion import example_lobe, make_lobes
>>> part = example_lobe()
>>> nearest_heel(make_lobes(part), 5.0, 1).needed_deg
0.0
"""

from __future__ import annotations

from math import ceil, floor
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.lobe.contact import all_round
from camtools.lobe.motion import ShaftLobe
from camtools.part.common import SwungTool

_PLACES = 3600
_BISECTIONS = 20
_MARGIN = 0.99  # of a length that would do

Complexes = npt.NDArray[np.complexfloating[Any, Any]]


class LobeHeel(NamedTuple):
    """The place where the flank comes nearest to a lobe."""

    needed_deg: float  # least clearance angle that just does
    lobe: int
    angle_deg: float  # direction of the follower in the lobe's own frame


def needed_clearance_deg(
    places_mm: Complexes, outward: Complexes, heel_mm: float, direction: int
) -> Floats:
    """Return the least clearance angle of every place of a closed contour [degrees], at least 0.

    `places_mm`, counter-clockwise round the axis, and `outward`, their normals of length 1 to which
    the tool stands parallel, are complex numbers of shape (n,). Places within the length of the
    flank count. `direction` is 1 where the tool runs counter-clockwise round the work, or -1.
    """
    needed = np.zeros(places_mm.size)
    came_from = -1j * direction * outward
    for k in range(1, places_mm.size // 2):
        behind = np.roll(places_mm, direction * k) - places_mm
        is_near = np.abs(behind) <= heel_mm
        if not is_near.any():
            break
        angle = np.arctan2((behind * outward.conj()).real, (behind * came_from.conj()).real)
        needed = np.where(is_near, np.maximum(needed, angle), needed)
    return np.asarray(np.degrees(needed), dtype=np.float64)


def nearest_heel(lobes: list[ShaftLobe], heel_mm: float, direction: int) -> LobeHeel:
    """Return the largest clearance angle that the lobes of a shaft need, and where."""
    firsts = {lobe.profile: i for i, lobe in reversed(list(enumerate(lobes)))}
    return max(
        (_of_lobe(i, lobes[i], heel_mm, direction) for i in firsts.values()),
        key=lambda one: one.needed_deg,
    )


def _of_lobe(i: int, lobe: ShaftLobe, heel_mm: float, direction: int) -> LobeHeel:
    touch = all_round(lobe.law, lobe.base_mm, lobe.roller_mm, is_flat=lobe.is_flat)
    travel = np.cumsum(touch.ds)
    evenly = np.searchsorted(travel, travel[-1] * (np.arange(_PLACES) + 0.5) / _PLACES)
    places = (touch.radius * np.exp(1j * touch.alpha))[evenly]
    normals = np.exp(1j * (touch.theta - touch.gamma))[evenly]
    needed = needed_clearance_deg(places, normals, heel_mm, direction)
    worst = int(needed.argmax())
    return LobeHeel(float(needed[worst]), i, float(np.degrees(touch.theta[evenly[worst]])))


def check_lobe_heel(lobes: list[ShaftLobe], tool: SwungTool, direction: int) -> LobeHeel:
    """Return where the flank comes nearest to a lobe, or refuse a tool whose heel rubs.

    Raises GeometryError with the place, the least clearance angle and the longest flank that do.
    """
    found = nearest_heel(lobes, tool.heel_mm, direction)
    if found.needed_deg < tool.clearance_deg:
        return found
    low, high = 0.0, tool.heel_mm
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        is_clear = nearest_heel(lobes, middle, direction).needed_deg < tool.clearance_deg
        low, high = (middle, high) if is_clear else (low, middle)
    problem = (
        f"the heel of {tool.clearance_deg:g} degrees rubs on the hollow flank of "
        f"cam.lobe.{found.lobe} at {found.angle_deg:.4g} degrees, which rises after the edge by "
        f"{found.needed_deg:.2f} degrees within {tool.heel_mm:g} mm"
    )
    least_deg = ceil(found.needed_deg * 10 + 0.1) / 10
    remedy = f"give a tool with at least {least_deg:.1f}, or with heel_mm at most "
    raise GeometryError("tool.clearance_deg", problem, f"{remedy}{floor(_MARGIN * low * 10) / 10}")
