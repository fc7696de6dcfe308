"""Where U stands in the middle of its stroke: on the long axis, or about its mean, MATHS.md (101).

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> middle_nm(make_geometry(example_part()), "mean")
75000
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camtools.base.quantities import NM_PER_MM
from camtools.skirt.geometry.skirt_geometry import Geometry, dense_heights_mm
from camtools.table.channel import Bounds, Channel

_PER_PIECE = 8  # heights between the breaks of the shape
_AROUND_RAD = np.radians(np.arange(0, 360, 0.5))


def middle_nm(geometry: Geometry, u_zero: str) -> int:
    """Return the reduction of the radius that X takes over from U [nm], the same everywhere.

    Parameters
    ----------
    u_zero : str
        "long-axis": 0. "mean": the middle between the least and the largest reduction of the whole
        table, so that U swings equally far to both sides.
    """
    if u_zero == "long-axis":
        return 0
    z_mm = dense_heights_mm(geometry, _PER_PIECE)
    ranges = [geometry.delta(_AROUND_RAD, float(z)).delta for z in z_mm]
    low, high = min(float(one.min()) for one in ranges), max(float(one.max()) for one in ranges)
    return round((low + high) / 2 * NM_PER_MM)


def moved(channel: Channel, by_nm: int) -> Channel:
    """Return a channel whose values are smaller by a length; its knots stay."""
    return replace(channel, value_offset=channel.value_offset - by_nm)


def with_mean(lines: list[str], u_zero: str, bounds: Bounds) -> list[str]:
    """Return refusals; that of the stroke with what it would be about the mean."""
    if u_zero == "mean":
        return lines
    travel_mm = (bounds.u_max_nm - bounds.u_min_nm) / NM_PER_MM
    hint = f'; or set process.u_zero = "mean", which needs {travel_mm:.9g} mm'
    return [line + hint if ".u_stroke_mm" in line else line for line in lines]
