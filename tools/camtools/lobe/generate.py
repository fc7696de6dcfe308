"""From the part file of a camshaft to its table, checked against the machine's limits.

The heel, MATHS.md (111): the tool stands along the normal of its contact, so that at the edge the
lobe neither rises nor falls. After the edge a lobe that is convex falls away; a hollow rises, the
more the longer the flank is.

>>> from camtools.lobe.motion import example_lobe
>>> result = generate_lobes(example_lobe())
>>> result.lift.error <= 10.0, result.angle.error <= 1e-4
(True, True)
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, floor, pi
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from camtools.base.cache import recall
from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import NM_PER_MM, Floats, omega_rad_s
from camtools.cut.feasibility import HighestSpeed, Peaks, given_of, needed_of, peaks_of
from camtools.cut.verdict import check_table, needs_of_peaks
from camtools.judge.binding import TablePeaks
from camtools.lobe.channels import (
    N_GRID,
    MadeChannel,
    SpindleLimits,
    acceleration_of,
    centre_channel,
    choose_angle,
    choose_lift,
    mean_of,
    patterns_of,
    places_of,
    speed_channel,
    surface_speed,
)
from camtools.lobe.contact import Follower, all_round
from camtools.lobe.lift import LiftLaw
from camtools.lobe.motion import ShaftLobe, channels_key, lobes_of, noise_hint
from camtools.lobe.part import LobePart
from camtools.lobe.plunge import Plan, plan_of, stations_of, way_channel, x_channel
from camtools.part.common import SwungTool, check_feed
from camtools.table.channel import DEG_PER_UNIT, RATIO_ONE, Channel, change_nm
from camtools.table.evaluate import knot_interval, moving_bounds, peaks_together, raw_bounds
from camtools.table.header import check_tolerance, table_of, u_bounds
from camtools.table.image import Table

_PLACES = 3600
_HEEL_BISECTIONS = 20
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
        key=lambda heel: heel.needed_deg,
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
    for _ in range(_HEEL_BISECTIONS):
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


DEFAULT_TOLERANCE_NM = 10.0
_BISECTIONS = 40
# what engaging in ten turns adds, MATHS.md (62), and the controller's rounding of gaps
_ENGAGED = {"swing_acceleration_deg_s2": 1.055, "u_acceleration_mm_s2": 1.03}
_SEARCH_MARGIN = 0.99  # of every limit: the table's own bounds are a little above its samples
_MAX_SPINDLE_RAD2 = 8.5  # |r r'|: a table promises at most 10, of a mean that limits make slower


@dataclass(frozen=True, eq=False)
class GeneratedLobes:
    """A table of a camshaft and everything that is known about it."""

    part: LobePart
    lobes: list[ShaftLobe]  # exact geometry
    tolerance_nm: float
    table: Table
    lift: MadeChannel  # channel of u, error in nm
    angle: MadeChannel  # channel of swing or contact, error in degrees
    speed: MadeChannel | None  # channel of the speed ratio, error of the ratio
    mean_rpm: float  # mean speed of a turn
    peaks: Peaks  # what the axes need
    highest_speed: HighestSpeed
    heel: LobeHeel | None  # where the flank of a tool comes nearest to the lobes; None of a wheel
    plunge: Plan | None = None  # the turns of a plunge cut

    @property
    def laws(self) -> list[LiftLaw]:
        """Return the law of each lobe."""
        return [lobe.law for lobe in self.lobes]


def generate_lobes(part: LobePart, tolerance_nm: float | None = None) -> GeneratedLobes:
    """Return the smallest table of a camshaft whose lift keeps a tolerance, 10 nm by default.

    Angles are within 1e-4 degrees. Raises CamtoolsError: the shape is impossible, the tolerance is
    out of reach, or the machine is too weak.
    """
    tolerance_nm = DEFAULT_TOLERANCE_NM if tolerance_nm is None else tolerance_nm
    check_tolerance(tolerance_nm)
    lobes = lobes_of(part)
    try:
        return _generated(part, lobes, tolerance_nm)
    except CamtoolsError as error:
        hint = noise_hint([lobe.law for lobe in lobes], part.process.form_error_um)
        raise CamtoolsError([line + hint for line in error.lines]) from error


def _generated(part: LobePart, lobes: list[ShaftLobe], tolerance_nm: float) -> GeneratedLobes:
    plunge = plan_of(part, lobes) if part.process.is_plunge else None
    if plunge is None:
        check_feed(part)
    placed = lobes  # where the table finds them: on the shaft, or on the station
    if plunge is not None:
        ends = [(a / NM_PER_MM, b / NM_PER_MM) for a, b in stations_of(plunge, lobes)]
        placed = [replace(lobe, z_mm=z_mm) for lobe, z_mm in zip(lobes, ends, strict=True)]
    is_swung = part.process.operation == "turning"
    heel = check_lobe_heel(lobes, part.tool, part.process.direction) if is_swung else None
    key = channels_key(part, tolerance_nm)
    lift = recall(("lobe lift", key), lambda: choose_lift(placed, tolerance_nm))
    angle = recall(("lobe angle", key), lambda: choose_angle(placed, is_swung=is_swung))
    speed, mean_rpm = _modulation(part, lobes)
    bounds = u_bounds(lift.channel, lift.error)
    centre = x_channel(plunge, part, lobes) if plunge else centre_channel(lobes)
    channels = [lift.channel, centre, angle.channel]
    together = peaks_together(lift.channel, speed.channel) if speed else None
    if speed is not None and together is not None:
        bounds = moving_bounds(bounds, together)
        channels.append(speed.channel)
    table = table_of(part, mean_rpm, bounds, tuple(channels))
    table = replace(table, lobes=places_of(placed, part.process.direction))
    if plunge is not None:
        table = _plunged(table, plunge, part, lobes)
    ratio = together.ratio if together else 1.0
    peaks = peaks_of(bounds, ratio)
    if is_swung:
        peaks = _with_swing(peaks, angle.channel, speed.channel if speed else None)
    fed = _feeding(table)
    peaks = peaks._replace(feed_mm=fed.feed_mm, change_mm=fed.change_mm)
    best, asked_rpm = None, None
    if part.process.speed != "uniform":
        best, asked_rpm = _highest_surface_speed(part, _paths(lobes), fed), part.process.spindle_rpm
    best = check_table(table, part.machine.limits, best, asked_rpm)
    return GeneratedLobes(
        *(part, lobes, tolerance_nm, table, lift, angle, speed, mean_rpm, peaks, best, heel), plunge
    )


def _plunged(table: Table, plunge: Plan, part: LobePart, lobes: list[ShaftLobe]) -> Table:
    """Return the table with the feed of the station and the way of Z."""
    assert part.process.stock_um is not None
    return replace(
        table,
        feed_nm=plunge.feed_nm,
        depth_nm=round(part.process.stock_um * 1000),
        channels=(*table.channels, way_channel(plunge, lobes)),
        has_stations=True,
    )


def _paths(lobes: list[ShaftLobe]) -> list[Follower]:
    """Return all patterns at the angles at which the spindle's speed is planned."""
    phi = 2 * np.pi * np.arange(N_GRID, dtype=np.float64) / N_GRID
    return [lobe.at(phi) for lobe in patterns_of(lobes)]


def _laws(part: LobePart, paths: list[Follower], rpm: float) -> list[Floats]:
    """Return the spindle's speed over the angle of each pattern [rad/s]."""
    limits, base_rad_s = part.machine.limits, omega_rad_s(rpm)
    base_mm = part.cam.base_radius_mm
    slowest = min(mean_of(base_rad_s * base_mm / path.ds_dphi) for path in paths)
    alpha = min(limits.alpha_rad_s2, _MAX_SPINDLE_RAD2 * slowest**2)
    spindle = SpindleLimits(alpha, omega_rad_s(limits.spindle_rpm), limits.spindle_bandwidth_rad_s)
    return [surface_speed(path.ds_dphi, base_mm, base_rad_s, spindle) for path in paths]


def _peak(values: Floats) -> float:
    return float(np.abs(values).max())


def _modulation(part: LobePart, lobes: list[ShaftLobe]) -> tuple[MadeChannel | None, float]:
    """Return the speed channel, where there is one, and the mean speed of all lobes [r/min]."""
    rpm = part.process.spindle_rpm
    if part.process.speed == "uniform":
        return None, rpm
    laws = _laws(part, _paths(lobes), rpm)
    mean_rad_s = float(np.mean([mean_of(laws[lobe.profile]) for lobe in lobes]))
    return speed_channel(lobes, laws, mean_rad_s), mean_rad_s * 60 / (2 * np.pi)


def _with_swing(peaks: Peaks, angle: Channel, speed: Channel | None) -> Peaks:
    raw, h = raw_bounds(angle), knot_interval(angle)
    unit = angle.lsb * DEG_PER_UNIT
    extremes = (angle.value_offset + value * angle.lsb for value in (raw.low, raw.high))
    largest = max(abs(value) for value in extremes) * DEG_PER_UNIT
    first, second = raw.first * unit / h, raw.second * unit / h**2
    if speed is not None:
        moved = peaks_together(angle, speed)
        first, second = moved.first * DEG_PER_UNIT, moved.second * DEG_PER_UNIT
    return peaks._replace(swing_deg=largest, swing1_deg=first, swing2_deg=second)


def _feeding(table: Table) -> Peaks:
    """Return what the feed decides: the speed of Z, and the shortest change between two lobes."""
    least_nm = min((change_nm(*pair) for pair in pairwise(table.lobes)), default=0)
    # with a speed channel the lift has half of a change
    change_mm = (least_nm if table.speed is None else least_nm // 2) / NM_PER_MM
    return Peaks(0.0, 0.0, 0.0, feed_mm=table.feed_nm / NM_PER_MM, change_mm=change_mm)


def _needs(part: LobePart, paths: list[Follower], fed: Peaks, rpm: float) -> dict[str, float]:
    """Return needed over limit of every axis at a speed on the base circle, by limit."""
    limits = part.machine.limits
    given, shares = given_of(limits), {"spindle_rpm": rpm / limits.spindle_rpm}
    laws = _laws(part, paths, rpm)
    mean = float(np.mean([mean_of(law) for law in laws]))
    alone = [_peaks(part, path, law / mean, fed) for path, law in zip(paths, laws, strict=True)]
    numbers = ("u_stroke_mm", "u1_mm", "u2_mm", "ratio", "spindle_rad2")
    swung = ("swing_deg", "swing1_deg", "swing2_deg")
    most = {name: max(getattr(peaks, name) for peaks in alone) for name in (*numbers, *swung)}
    for name, needed in needed_of(fed._replace(**most), limits, mean).items():
        if name in given and name != "spindle_rpm":
            shares[name] = needed * _ENGAGED.get(name, 1.0) / given[name]
    judged = needs_of_peaks(_before_table(fed._replace(**most)), limits, round(mean * 30_000 / pi))
    for name in shares.keys() & judged.keys():
        shares[name] = max(shares[name], _SEARCH_MARGIN * judged[name])
    return shares


def _before_table(peaks: Peaks) -> TablePeaks:
    """Return what the controller will know of a table, with room for the table's own bounds."""
    ratio, room = max(peaks.ratio, 1.0), 2 - _SEARCH_MARGIN

    def whole(value: float) -> int:
        return min(ceil(value * room), (1 << 31) - 1)

    slope_deg = peaks.swing1_deg / ratio
    bend_deg = max(0.0, peaks.swing2_deg - slope_deg * peaks.spindle_rad2) / ratio**2
    return TablePeaks(
        span_nm=1 << 24,
        feed_nm=round(peaks.feed_mm * NM_PER_MM),
        change_nm=round(peaks.change_mm * NM_PER_MM) * (2 if ratio > 1 else 1),
        u_nm=round(peaks.u_stroke_mm / 2 * NM_PER_MM),
        u1_peak_nm_per_rad=whole(peaks.u1_mm * NM_PER_MM),
        u2_peak_nm_per_rad2=whole(peaks.u2_mm * NM_PER_MM),
        spindle_peak_ppm_per_rad=whole(peaks.spindle_rad2 * 1e6),
        ratio_max_q20=ceil(ratio * RATIO_ONE),
        swing_mdeg=ceil(peaks.swing_deg * 1e3),
        swing1_mdeg_per_rad=whole(slope_deg * 1e3),
        swing2_mdeg_per_rad2=whole(bend_deg * 1e3),
    )


def peaks_along(path: Follower, ratio: Floats) -> Peaks:
    """Return the peaks of U and of the spindle on a path, over the mean speed of its turn."""
    alpha = acceleration_of(ratio)
    u2_mm = _peak(path.d2 * ratio**2 + path.d1 * alpha)
    return Peaks(2 * _peak(path.lift), _peak(path.d1 * ratio), u2_mm, _peak(ratio), _peak(alpha))


def _peaks(part: LobePart, path: Follower, ratio: Floats, fed: Peaks) -> Peaks:
    """Return the peaks of a pattern over the mean speed of its own turn."""
    peaks = peaks_along(path, ratio)._replace(feed_mm=fed.feed_mm, change_mm=fed.change_mm)
    if part.process.operation != "turning":
        return peaks
    # the controller knows the peaks of the swing and of the speed, not what they do together
    first, second = _peak(np.degrees(path.angle1)), _peak(np.degrees(path.angle2))
    return peaks._replace(
        swing_deg=_peak(np.degrees(path.angle)),
        swing1_deg=first * peaks.ratio,
        swing2_deg=second * peaks.ratio**2 + first * peaks.spindle_rad2,
    )


def _highest_surface_speed(part: LobePart, paths: list[Follower], fed: Peaks) -> HighestSpeed:
    """Return the highest speed on the base circle, its law planned anew for every speed."""
    low, high, decides = 0.0, part.machine.limits.spindle_rpm, "spindle_rpm"
    for _ in range(_BISECTIONS):
        middle = high if low == 0.0 and decides == "spindle_rpm" else (low + high) / 2
        shares = _needs(part, paths, fed, middle)
        name = max(shares, key=lambda limit: shares[limit])
        is_kept = shares[name] <= (1.0 if name == "spindle_rpm" else _SEARCH_MARGIN)
        if is_kept and middle == high:
            return HighestSpeed(high, decides)
        low, high = (middle, high) if is_kept else (low, middle)
        decides = decides if is_kept else name
    return HighestSpeed(low, decides)
