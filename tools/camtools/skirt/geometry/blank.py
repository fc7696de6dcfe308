"""The blank of a skirt, a cylinder, and the metal between it and one section.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> round(blank_radius_mm(make_geometry(example_part()), 0.1), 9)
46.1
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats, SectionValues
from camtools.cut.removal import QUARTER_RAD, TURN_RAD, SectionCut
from camtools.skirt.geometry.skirt_geometry import Geometry

_SYMMETRIC_MM = 1e-9  # sections that differ by less are mirror images


def blank_radius_mm(geometry: Geometry, depth_mm: float) -> float:
    """Return the radius of the blank, a cylinder: largest long half axis plus cutting depth."""
    z_mm = np.linspace(*geometry.skirt_mm, 4097)
    return float(geometry.radius_mm(z_mm).max()) + depth_mm


def section_cut(geometry: Geometry, depth_mm: float, z_mm: float) -> SectionCut:
    """Return a part's section at a height [mm], out of a cylindrical blank."""

    def shaped(phi_rad: Floats) -> SectionValues:
        flat = geometry.delta(phi_rad.ravel(), z_mm)
        return SectionValues(*(one.reshape(phi_rad.shape) for one in flat))

    phi = np.linspace(0, QUARTER_RAD, 181)
    here = shaped(phi).delta
    mirrored = [shaped(other).delta for other in (np.pi - phi, phi + np.pi, -phi)]
    is_quarter = all(np.abs(one - here).max() < _SYMMETRIC_MM for one in mirrored)
    pattern = QUARTER_RAD if is_quarter else TURN_RAD
    a_mm, blank_mm = float(geometry.radius_mm(z_mm)), blank_radius_mm(geometry, depth_mm)
    return SectionCut(shaped, a_mm, blank_mm, pattern)


class Axes(NamedTuple):
    """Table 5: axis positions at the borders of the parts, from the long axis on."""

    t_s: Floats
    c_rad: Floats  # unwrapped
    z_mm: Floats
    x_mm: Floats
    u_mm: Floats


def axes_at(geometry: Geometry, z_mm: float, feed_mm: float, angles: Floats, t_s: Floats) -> Axes:
    """Return the axes, MATHS.md (8), at unwrapped angles [rad] and their times, Z from a height."""
    z = z_mm + feed_mm * angles / TURN_RAD
    u = geometry.delta(angles, z).delta
    return Axes(t_s, angles, z, geometry.radius_mm(z), u)
