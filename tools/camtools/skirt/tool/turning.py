"""The motion that cuts a skirt: its axes, where U stands, and the way of Z.

The heel, MATHS.md (111): where a section falls in the sense of cutting, the work after the edge
stands higher than the edge. The steepest place decides, however long the flank is: seen from the
edge, no place of the work appears under a larger angle than the section has somewhere between the
two.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> motion = turning_at(make_geometry(example_part()), 600.0, 20.0, np.array([0.0, 0.25]))
>>> motion.u_mm.round(6).tolist()
[0.0, 0.1]
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from math import ceil
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import NM_PER_MM, Floats, FloatsLike, omega_rad_s
from camtools.base.solvers import inverted, neighbours
from camtools.cut.feasibility import HighestSpeed
from camtools.cut.path import ToolPath, ramp_of, step_of
from camtools.cut.verdict import check_table
from camtools.part.common import FeedLaw, MachineLimits, SectionProcess, Tool
from camtools.skirt.geometry.sections import ALL_AROUND_RAD
from camtools.skirt.geometry.skirt_geometry import Geometry, dense_heights_mm
from camtools.skirt.part.part_file import SkirtPart
from camtools.table.channel import (
    KIND_WAY,
    LEAST_FEED,
    MAX_SLICES,
    MAX_SPACING_NM,
    MIN_SPACING_NM,
    Channel,
)
from camtools.table.evaluate import evaluate_x
from camtools.table.header import TooLargeError, quantise, slice_heights_mm, with_bounds
from camtools.table.image import Table


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
    """Return the axes at turns from the long axis, at constant speed, MATHS.md (8), (9).

    Velocity, acceleration and jerk of U are those at fixed height; the feed adds dU/dz feed n/60.
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

    A step is made for the highest speed of a modulated spindle, its mean times speed_ratio.
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


_PER_PIECE = 8  # heights between the breaks of the shape


def middle_nm(geometry: Geometry, u_zero: str) -> int:
    """Return the reduction of the radius that X takes over from U [nm], MATHS.md (101).

    Of "long-axis" it is 0, of "mean" the middle between the least and the largest reduction of the
    whole table, so that U swings equally far to both sides.
    """
    if u_zero == "long-axis":
        return 0
    z_mm = dense_heights_mm(geometry, _PER_PIECE)
    sections = [geometry.delta(ALL_AROUND_RAD, float(z)).delta for z in z_mm]
    low = min(float(section.min()) for section in sections)
    high = max(float(section.max()) for section in sections)
    return round((low + high) / 2 * NM_PER_MM)


def moved(channel: Channel, by_nm: int) -> Channel:
    """Return a channel whose values are smaller by a length; its knots stay."""
    return replace(channel, value_offset=channel.value_offset - by_nm)


def judged(
    process: SectionProcess, limits: MachineLimits, table: Table, gentler: Callable[[], list[str]]
) -> HighestSpeed:
    """Return the highest speed of a table, or refuse what the controller would refuse.

    The refusal of a stroke says what it would be about the mean, that of an acceleration of U is
    followed by what `gentler` advises.
    """
    try:
        return check_table(table, limits)
    except CamtoolsError as error:
        lines = error.lines
        if process.u_zero != "mean":
            travel_mm = (table.bounds.u_max_nm - table.bounds.u_min_nm) / NM_PER_MM
            hint = f'; or set process.u_zero = "mean", which needs {travel_mm:.9g} mm'
            lines = [line + hint if ".u_stroke_mm" in line else line for line in lines]
        if any("u_acceleration" in line for line in lines):
            lines = lines + gentler()
        raise CamtoolsError(lines) from error


TOLERANCE_NM = 50.0  # of Z: its drive is a thousand times coarser
_TURNS_ERROR = 1e-12  # of all turns
_DENSE = 4001
_GROWTH = 1.15


def _turned(law: FeedLaw, ends_mm: tuple[float, float]) -> tuple[Floats, Floats]:
    dense = np.linspace(*ends_mm, _DENSE)
    return dense, law.turns(ends_mm[0], dense)


def height_at_mm(
    law: FeedLaw,
    ends_mm: tuple[float, float],
    helix_mm: Floats,
    turned: tuple[Floats, Floats] | None = None,
) -> Floats:
    """Return Z where the plain helix with the mean feed is at some heights, MATHS.md (103)."""
    first, last = ends_mm
    dense, turns = turned or _turned(law, ends_mm)
    mean = (last - first) / turns[-1]
    wanted = (np.clip(helix_mm, first, last) - first) / mean

    def turns_to(z_mm: Floats) -> Floats:
        rising, place = np.unique(z_mm, return_inverse=True)
        return law.turns(first, rising)[place]

    within, bounds = _TURNS_ERROR * turns[-1], neighbours(dense, turns, wanted)
    z_mm = inverted(turns_to, wanted, bounds, within, "process.feed_law")
    return np.asarray(np.where(helix_mm <= first, first, np.where(helix_mm >= last, last, z_mm)))


def way_channel(law: FeedLaw, range_nm: tuple[int, int]) -> Channel:
    """Return the smallest way of a law over the heights of a table.

    Raises CamtoolsError: the feed falls too far below its mean, or Z runs further ahead than the
    format holds.
    """
    span_nm = range_nm[1] - range_nm[0]
    ends = range_nm[0] / NM_PER_MM, range_nm[1] / NM_PER_MM
    mean, least = law.mean_mm(*ends), min(law.feed_mm)
    if least < 2 * LEAST_FEED * mean:
        problem = f"feed_mm = {least:g} is less than {2 * LEAST_FEED:.0%} of the mean, {mean:.6g}"
        raise CamtoolsError([f"process.feed_law.feed_mm: {problem}; give feeds nearer together"])
    turned = _turned(law, ends)  # once for all sizes that are tried

    def at_mm(helix_mm: Floats) -> Floats:
        return height_at_mm(law, ends, helix_mm, turned)

    def channel_of(n_knots: int) -> Channel:
        z = slice_heights_mm(range_nm, n_knots)
        at, mean, h_mm = at_mm(z), law.mean_mm(z[0], z[-1]), (z[-1] - z[0]) / (n_knots - 1)
        feed, slope = law.at_mm(at), law.at_mm(at, 1)
        triple = [at - z, h_mm * (feed / mean - 1), h_mm**2 / 2 * slope * feed / mean**2]
        return quantise(KIND_WAY, np.stack(triple, axis=-1)[:, None] * NM_PER_MM, 0, range_nm)

    n, most = max(2, ceil(span_nm / MAX_SPACING_NM) + 1), span_nm // MIN_SPACING_NM + 1
    while n <= min(most, MAX_SLICES):
        with suppress(TooLargeError):
            found = channel_of(n)
            z_nm = np.linspace(found.z_first_nm, found.z_last_nm, 16 * found.n_slices + 1)
            exact = at_mm(z_nm / NM_PER_MM) * NM_PER_MM - z_nm
            if float(np.abs(evaluate_x(found, z_nm).value - exact).max()) <= TOLERANCE_NM:
                return with_bounds(found)
        n = max(n + 1, int(n * _GROWTH))
    problem = "Z would run too far ahead of a plain helix, or change its feed too suddenly"
    remedy = "give feeds nearer together, or points of the law further apart"
    raise CamtoolsError([f"process.feed_law.feed_mm: {problem}; {remedy}"])


def largest_share(channel: Channel | None) -> float:
    """Return the largest feed of a way over its mean; 1 without one."""
    if channel is None:
        return 1.0
    slopes = evaluate_x(channel, np.linspace(channel.z_first_nm, channel.z_last_nm, _DENSE)).d1
    return float(np.abs(1.0 + slopes).max())


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
