"""The motion that cuts a skirt: its axes at constant speed, and the path of Z.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> motion = turning_at(make_geometry(example_part()), 600.0, 20.0, np.array([0.0, 0.25]))
>>> motion.u_mm.round(6).tolist()
[0.0, 0.1]
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats, FloatsLike, omega_rad_s
from camtools.cut.path import ToolPath, ramp_of, step_of
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.part.part_file import SkirtPart


class AxesMotion(NamedTuple):
    """Set-points of uniform turning, all of the shape of the turns asked for."""

    c_rad: Floats
    z_mm: Floats
    x_mm: Floats
    u_mm: Floats
    velocity_mm_s: Floats
    acceleration_mm_s2: Floats
    jerk_mm_s3: Floats


def turning_at(
    geometry: Geometry, spindle_rpm: float, z_mm: FloatsLike, turns: Floats
) -> AxesMotion:
    """Return the axes of turning at constant speed, MATHS.md (8), (9).

    Parameters
    ----------
    spindle_rpm : float
        Speed [r/min].
    z_mm : float or ndarray, shape (n,)
        Height(s) [mm].
    turns : ndarray, shape (n,)
        Spindle angle from the long axis, in turns.

    Returns
    -------
    AxesMotion
        Velocity, acceleration and jerk of U at fixed height; the feed adds dU/dz feed n/60.
    """
    c_rad, omega = 2 * np.pi * turns, omega_rad_s(spindle_rpm)
    u = geometry.delta(c_rad, z_mm)
    z_all_mm = np.broadcast_to(np.asarray(z_mm, dtype=np.float64), c_rad.shape)
    x_mm = geometry.radius_mm(z_all_mm)
    return AxesMotion(
        c_rad, z_all_mm, x_mm, u.delta, u.d1 * omega, u.d2 * omega**2, u.d3 * omega**3
    )


def path_of(
    part: SkirtPart, z_first_mm: float, z_last_mm: float, speed_ratio: float = 1.0
) -> ToolPath:
    """Return the path of a part between two heights, with the shortest ramp or step.

    Parameters
    ----------
    speed_ratio : float
        Highest speed of a modulated spindle over its mean; a step is made for that speed.

    Raises
    ------
    CamtoolsError
        See `ramp_of`, `step_of`.
    """
    process, limits = part.process, part.machine.limits
    ends = z_first_mm, z_last_mm
    if process.path == "stepped":
        step, ramp = step_of(process.feed_mm, process.spindle_rpm * speed_ratio, limits)
        return ToolPath("stepped", *ends, process.feed_mm, ramp, step)
    if process.path == "helix":
        return ToolPath("helix", z_first_mm, z_last_mm, process.feed_mm)
    ramp = ramp_of(process.feed_mm, process.spindle_rpm, limits)
    return ToolPath("ring-helix", z_first_mm, z_last_mm, process.feed_mm, ramp)
