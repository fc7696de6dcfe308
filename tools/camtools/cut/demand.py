"""What a cut demands of every axis: the controller's rule, number for number.

This is firmware/feasible/cam_demand.c, cam_z_coupling.c and cam_feasible.c in Python's integers, with
the same roundings, so that the generator refuses what the controller would refuse, and nothing
else. The equations are MATHS.md (61) .. (64), (42), (44) and (80).

>>> peak_mrpm(1000, 1310720)
1250
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import isqrt
from typing import NamedTuple

from camtools.cut.demand_gap import AxisPeaks, GapSums
from camtools.part.common import MachineLimits, SwingLimits
from camtools.table.channel import RATIO_ONE
from camtools.table.facts import SliceChange, TableFacts

_MAX_KNOTS_PER_TICK, _MIN_TICKS_PER_TURN = 8, 8
_MAX_Z_UM_PER_S = 6_553_400
_MOST_STOCK_NM = 100_000_000  # no part has more stock on its radius
_INT32, _INT64 = (1 << 31) - 1, (1 << 63) - 1
_SPEED_BITS, _FEED_BITS = 26, 24
_PLAN_PERIOD_US = 400
_WHOLE_PPM = 1_000_000
_LEAST_FEED_NM, _LEAST_RAMP_Q32 = 4, 1 << 24
_MOST_TURNS = 1 << 22
_ONE_MM_PER_S2 = 360_000_000_000
# e, 1.03 2 e' / 2 pi and 1.03 e'' / (2 pi)^2 of the smooth step, MATHS.md (62), in 1e-6
_ENGAGING = (
    *((500000, 614736, 0), (611425, 597160, 46287), (716510, 545958, 88515)),
    *((809474, 465722, 122629), (885658, 364099, 144569), (925567, 289630, 150430)),
    *((956293, 214280, 147876), (978000, 142581, 135703), (991441, 79670, 112710)),
    *((996921, 41685, 87642), (999150, 18166, 61219), (999850, 5844, 36250)),
    *((999984, 1383, 18115), (999999, 244, 7711)),
)


class Demand(NamedTuple):
    """One limit and what a cut needs of it, in the unit of the controller."""

    name: str  # of the controller's error
    limit: int
    needed: int


class Parameters(NamedTuple):
    """Parameters of the controller by which it judges; defaults are those of cam_param.h."""

    tick_hz: int = 20_000
    u_stroke_nm: int = 1_200_000
    u_speed_um_per_s: int = 400_000
    u_acceleration_mm_per_s2: int = 250_000
    x_speed_um_per_s: int = 100_000
    x_acceleration_mm_per_s2: int = 2000
    z_speed_um_per_s: int = 200_000
    z_acceleration_mm_per_s2: int = 2000
    spindle_limit_mrpm: int = 3_000_000
    spindle_lag_us: int = 0
    spindle_acceleration_mrad_per_s2: int = 500_000
    swing_speed_mdeg_per_s: int = 0
    swing_acceleration_deg_per_s2: int = 100_000
    swing_range_mdeg: int = 30_000
    x_clearance_nm: int = 1_000_000
    engage_turns: int = 10
    disengage_turns: int = 10
    feed_ramp_turns: int = 2
    amplitude_ppm: int = _WHOLE_PPM


def parameters_of(limits: MachineLimits) -> Parameters:
    """Return the controller's parameters on the machine that is simulated with these limits."""

    def whole(value: float, low: float, high: float) -> int:
        return int(min(max(value, low), high) + 0.5)

    found = Parameters(
        tick_hz=limits.tick_hz,
        u_stroke_nm=whole(limits.u_stroke_mm * 1e6, 0, 1e9),
        u_speed_um_per_s=whole(limits.u_speed_mm_s * 1e3, 100, 1e7),
        u_acceleration_mm_per_s2=whole(limits.u_acceleration_mm_s2, 10, 1e7),
        z_speed_um_per_s=whole(limits.z_speed_mm_s * 1e3, 100, 1e7),
        z_acceleration_mm_per_s2=whole(limits.z_acceleration_mm_s2, 10, 1e6),
        spindle_limit_mrpm=whole(limits.spindle_rpm * 1e3, 1000, 6e7),
        spindle_lag_us=whole(1e6 / limits.spindle_bandwidth_rad_s, 0, 1e6),
        spindle_acceleration_mrad_per_s2=whole(limits.alpha_rad_s2 * 1e3, 1e3, 2e9),
        swing_speed_mdeg_per_s=1_000_000,
    )
    if not isinstance(limits, SwingLimits):
        return found
    return found._replace(
        swing_speed_mdeg_per_s=whole(limits.swing_speed_deg_s * 1e3, 0, 1e8),
        swing_acceleration_deg_per_s2=whole(limits.swing_acceleration_deg_s2, 10, 1e8),
        swing_range_mdeg=whole(limits.swing_deg * 1e3, 100, 90_000),
    )


def divided_up(a: int, b: int) -> int:
    """Return a / b, rounded up."""
    return -(-a // b)


def peak_mrpm(mean_mrpm: int, ratio_max_q20: int) -> int:
    """Return the highest speed within a turn."""
    return min(divided_up(mean_mrpm * ratio_max_q20, RATIO_ONE), (1 << 32) - 1)


def _omega_mrad_per_s(mrpm: int) -> int:
    return divided_up(mrpm * 104_719_756, 1_000_000_000)


class _Drift(NamedTuple):
    speed: int
    speed_per_rad: int
    acceleration: int


class JudgedCut(NamedTuple):
    """A cut at a mean speed of the spindle: cam_cut_t."""

    facts: TableFacts
    p: Parameters
    mean_mrpm: int
    feed_nm: int

    @property
    def peak_mrpm(self) -> int:
        """Return the highest speed within a turn."""
        return peak_mrpm(self.mean_mrpm, self.facts.ratio_max_q20)

    def at_amplitude(self, peak: int) -> int:
        """Return a peak of U or of the swing at the amplitude in force."""
        return divided_up(peak * self.p.amplitude_ppm, _WHOLE_PPM)

    @property
    def turns(self) -> int:
        """Return the turns of the shorter of the two ramps of the depth."""
        return min(self.p.engage_turns, self.p.disengage_turns)


def _feed_speed2(cut: JudgedCut) -> int:
    return max(cut.feed_nm, _LEAST_FEED_NM) * divided_up(cut.peak_mrpm**2, 10_000)


def _ring_ramp_q32(cut: JudgedCut) -> int:
    part, whole = _feed_speed2(cut), _ONE_MM_PER_S2 * cut.p.z_acceleration_mm_per_s2
    while whole >> 31:
        whole >>= 1
        part = (part + 1) >> 1
    if 4 * part >= whole:
        return 1 << 31
    inner_q32 = ((whole - max(4 * part, 1)) << 32) // whole
    return max(((1 << 32) - isqrt(inner_q32 << 32) + 1) // 2, _LEAST_RAMP_Q32)


def _plain_um_per_s(cut: JudgedCut) -> int:
    return divided_up(cut.feed_nm * cut.peak_mrpm, 60_000_000)


def _way_mm_per_s2(cut: JudgedCut) -> int:
    if cut.facts.table.way is None:
        return 0
    v_tenth = min(_plain_um_per_s(cut), _MAX_Z_UM_PER_S) // 100 + 1
    return v_tenth * v_tenth * cut.facts.way_bend_ppm_per_m // 100_000_000_000 + 1


def _z_um_per_s(cut: JudgedCut) -> int:
    if not cut.facts.table.is_ring_helix:
        return divided_up(_plain_um_per_s(cut) * cut.facts.way_slope_ppm, _WHOLE_PPM)
    mean_nm_per_s = (max(cut.feed_nm, _LEAST_FEED_NM) * cut.peak_mrpm + 59_999) // 60_000
    rest_q24 = ((1 << 32) - _ring_ramp_q32(cut)) >> 8
    return ((mean_nm_per_s << 24) // rest_q24 + 1000) // 1000


def _z_mm_per_s2(cut: JudgedCut) -> int:
    if cut.facts.table.is_ring_helix:
        return divided_up(_feed_speed2(cut), _ONE_MM_PER_S2 // 4)
    ramp = _ramp_mm_per_s2(cut)
    return divided_up(ramp * cut.facts.way_slope_ppm, _WHOLE_PPM) + _way_mm_per_s2(cut)


def _ramp_mm_per_s2(cut: JudgedCut) -> int:
    turns, rpm, span_nm = cut.p.feed_ramp_turns, divided_up(cut.peak_mrpm, 1000), cut.facts.span_nm
    is_short = turns * cut.feed_nm <= span_nm
    per = 3_600_000_000 * turns if is_short else 3_600_000_000 * span_nm // cut.feed_nm
    return divided_up(cut.feed_nm * rpm * rpm, per)


def _z_feeding_mm_per_s2(cut: JudgedCut) -> int:
    if cut.facts.table.is_ring_helix:
        return cut.p.z_acceleration_mm_per_s2
    return _z_mm_per_s2(cut)


def _drift(cut: JudgedCut, spacing_nm: int, change: SliceChange, set_point_hz: int) -> _Drift:
    v_um_per_s = min(_z_um_per_s(cut), _MAX_Z_UM_PER_S)
    a_mm_per_s2 = min(_z_feeding_mm_per_s2(cut), 1_000_000)
    rate_uhz = divided_up(v_um_per_s * 1_000_000_000, spacing_nm)
    rise = divided_up(a_mm_per_s2 * 1_000_000_000, spacing_nm)
    jump = divided_up(change.kink * rate_uhz, 1_000_000) * set_point_hz
    return _Drift(
        divided_up(change.most * rate_uhz, 1_000_000_000),
        divided_up(change.per_rad * divided_up(rate_uhz, 1000), 1_000_000),
        divided_up(jump + divided_up(change.most * rise, 1000), 1000),
    )


def _drift_acceleration(cut: JudgedCut, drift: _Drift) -> int:
    omega_crad_per_s = divided_up(_omega_mrad_per_s(cut.peak_mrpm), 10)
    return divided_up(2 * drift.speed_per_rad * omega_crad_per_s, 100) + drift.acceleration


def _engaging(cut: JudgedCut, peaks: AxisPeaks, n_set_points: int) -> int:
    """Return the largest second derivative while the amplitude rises, MATHS.md (62).

    The first of a plan's set-points takes what the slope of the envelope changes in a plan.
    """
    value, first, second = peaks
    ratio_q10 = divided_up(cut.facts.ratio_max_q20, 1024)
    alpha = divided_up(value * cut.facts.table.bounds.spindle_peak_ppm_per_rad, 2_000_000)
    risen = divided_up(first * ratio_q10, 1024) + alpha
    far = divided_up(divided_up(value * ratio_q10, 1024) * ratio_q10, 1024) * n_set_points
    turns = cut.turns
    sums = (
        second * e + risen * e1 // turns + far * e2 // (turns * turns) for e, e1, e2 in _ENGAGING
    )
    return max(second, *(divided_up(one, _WHOLE_PPM) for one in sums))


def _gap(cut: JudgedCut) -> GapSums:
    facts = cut.facts
    change = facts.least_change_nm // 2 if facts.is_modulated else facts.least_change_nm
    return GapSums(change, facts.ratio_max_q20, facts.table.bounds.spindle_peak_ppm_per_rad)


def _plan_ticks(cut: JudgedCut) -> int:
    return max(1, (cut.p.tick_hz * _PLAN_PERIOD_US + 500_000) // 1_000_000)


def _scaled_up(a: int, b: int, c: int) -> int:
    return divided_up(a * b, c) if a == 0 or b < _INT64 // a else _INT64


def _u_demands(cut: JudgedCut) -> Iterator[Demand]:
    bounds, limits, facts = cut.facts.table.bounds, cut.facts.table.limits, cut.facts
    half_nm = min(cut.p.u_stroke_nm, limits.u_stroke_nm) // 2
    sides = (cut.at_amplitude(max(0, one)) for one in (bounds.u_max_nm, -bounds.u_min_nm))
    yield Demand("u_stroke", half_nm, max(sides))
    drift = _drift(cut, facts.u_spacing_nm, facts.u_change, cut.p.tick_hz)
    omega = _omega_mrad_per_s(cut.mean_mrpm)
    value = max(abs(bounds.u_min_nm), abs(bounds.u_max_nm))
    u = AxisPeaks(value, bounds.u1_peak_nm_per_rad, bounds.u2_peak_nm_per_rad2)
    first = _gap(cut).first(u, cut.feed_nm)
    turning = divided_up(cut.at_amplitude(first) * omega, 1_000_000)
    limit = min(cut.p.u_speed_um_per_s, limits.u_speed_um_per_s)
    yield Demand("u_speed", limit, turning + cut.at_amplitude(drift.speed))
    per_plan = _plan_ticks(cut)
    most = max(_engaging(cut, u, per_plan), _gap(cut).second(u, cut.feed_nm, per_plan))
    omega2 = divided_up(omega * omega, 10_000)
    turning = _scaled_up(cut.at_amplitude(most), omega2, 100_000_000)
    feeding = divided_up(_drift_acceleration(cut, drift), 1000)
    limit = min(cut.p.u_acceleration_mm_per_s2, limits.u_acceleration_mm_per_s2)
    yield Demand("u_acceleration", limit, turning + cut.at_amplitude(feeding))


def _mdeg_of(thousands: int) -> int:
    return divided_up(thousands * 43, 8)


def _swing_demands(cut: JudgedCut) -> Iterator[Demand]:
    p, facts = cut.p, cut.facts
    if not facts.is_swung:
        return
    ratio, swing = facts.ratio_max_q20, facts.swing
    yield Demand("swing_range", p.swing_range_mdeg, cut.at_amplitude(swing.most_mdeg))
    set_point_hz = p.tick_hz // _plan_ticks(cut) + 1
    drift = _drift(cut, facts.angle_spacing_nm, facts.swing_change, set_point_hz)
    first = ((swing.first_mdeg_per_rad * ratio) >> 20) + 1
    bend = (((swing.second_mdeg_per_rad2 * ratio) >> 20) * ratio) >> 20
    peak = facts.table.bounds.spindle_peak_ppm_per_rad
    second = bend + swing.first_mdeg_per_rad * peak // _WHOLE_PPM + 1
    peaks = AxisPeaks(swing.most_mdeg, first, second)
    omega = _omega_mrad_per_s(cut.mean_mrpm)
    first = cut.at_amplitude(_gap(cut).first(peaks, cut.feed_nm))
    feeding = cut.at_amplitude(_mdeg_of(drift.speed))
    speed = divided_up(first * omega, 1000) + feeding
    yield Demand("swing_speed", p.swing_speed_mdeg_per_s, speed)
    second = max(_engaging(cut, peaks, 1), _gap(cut).second(peaks, cut.feed_nm, 1))
    omega2 = divided_up(omega * omega, 1000)
    turning = _scaled_up(cut.at_amplitude(second), omega2, 1_000_000)
    feeding = divided_up(_mdeg_of(_drift_acceleration(cut, drift)), 1000)
    needed = turning + cut.at_amplitude(feeding)
    yield Demand("swing_acceleration", p.swing_acceleration_deg_per_s2, needed)


def _z_demands(cut: JudgedCut) -> Iterator[Demand]:
    yield Demand("feed", cut.facts.span_nm, cut.feed_nm)
    yield Demand("z_speed", cut.p.z_speed_um_per_s, _z_um_per_s(cut))
    yield Demand("z_acceleration", cut.p.z_acceleration_mm_per_s2, _z_mm_per_s2(cut))


def _spindle_demands(cut: JudgedCut) -> Iterator[Demand]:
    p, facts = cut.p, cut.facts
    by_knots = p.tick_hz * _MAX_KNOTS_PER_TICK * 60_000 // (1 << facts.log2_knots)
    by_turn = p.tick_hz * 60_000 // _MIN_TICKS_PER_TURN
    yield Demand("tick_rate", min(by_knots, by_turn), cut.peak_mrpm)
    omega = _omega_mrad_per_s(cut.mean_mrpm)
    peak = facts.table.bounds.spindle_peak_ppm_per_rad
    alpha = divided_up(divided_up(omega * omega, 1000) * peak, _WHOLE_PPM)
    yield Demand("spindle_acceleration", p.spindle_acceleration_mrad_per_s2, alpha)
    bandwidth = 1_000_000_000 // p.spindle_lag_us if p.spindle_lag_us > 0 else _INT64
    fall = divided_up(omega * facts.pace.fall_ppm_per_rad, _WHOLE_PPM)
    yield Demand("spindle_loop", bandwidth, fall)
    told = 0
    if facts.is_modulated:
        c_q16 = divided_up(omega * p.spindle_lag_us * 4096, 62_500_000)
        told = divided_up(facts.pace.set_at_q20(c_q16) * cut.mean_mrpm, RATIO_ONE)
    yield Demand("spindle_set_point", p.spindle_limit_mrpm, told)


def _x_along(cut: JudgedCut) -> tuple[int, int]:
    """Return speed and acceleration along the profile of X: with stations that of the helix."""
    if cut.facts.table.has_stations:
        return _plain_um_per_s(cut), _ramp_mm_per_s2(cut)
    return _z_um_per_s(cut), _z_feeding_mm_per_s2(cut)


def _x_demands(cut: JudgedCut) -> Iterator[Demand]:
    p, facts, turns, peak = cut.p, cut.facts, cut.turns, cut.peak_mrpm
    stock_nm = min(facts.table.depth_nm, _MOST_STOCK_NM)
    clearance_nm = max(p.x_clearance_nm, stock_nm) + facts.rise_nm
    clearing = (clearance_nm * 15 // 8 + 1) * peak // (turns * 60_000_000) + 1
    v_um_per_s, a_mm_per_s2 = _x_along(cut)
    barrel = v_um_per_s * facts.x_slope_ppm // _WHOLE_PPM + 1
    yield Demand("x_speed", p.x_speed_um_per_s, max(barrel, clearing))
    rpm = divided_up(peak, 1000)
    step = (clearance_nm + 1) * rpm * rpm
    clearing = (step // (3600 * turns * turns) + 1) // 173_180 + 1
    v_tenth = min(v_um_per_s, _MAX_Z_UM_PER_S) // 100 + 1
    bend = v_tenth * v_tenth * facts.x_bend_ppm_per_m // 100_000_000_000
    along = a_mm_per_s2 * facts.x_slope_ppm // _WHOLE_PPM
    yield Demand("x_acceleration", p.x_acceleration_mm_per_s2, max(bend + along + 1, clearing))


def _turns_demand(cut: JudgedCut) -> Demand:
    """Return the turns of feed, which alone fall with the feed: no search goes by them."""
    per_feed = 2 if cut.facts.table.is_ring_helix else 1
    fed = per_feed * divided_up(cut.facts.span_nm, cut.feed_nm)
    return Demand("turns", _MOST_TURNS, fed + cut.p.feed_ramp_turns)


def _demands_of_axes(cut: JudgedCut) -> Iterator[Demand]:
    facts, p = cut.facts, cut.p
    yield Demand("cam_amplitude", p.amplitude_ppm, _WHOLE_PPM if facts.is_lobe else 0)
    yield Demand("swing_axis", 0, int(facts.is_swung and p.swing_speed_mdeg_per_s == 0))
    yield from _swing_demands(cut)
    highest = min(p.spindle_limit_mrpm, facts.table.limits.spindle_mrpm)
    yield Demand("spindle_speed", highest, cut.peak_mrpm)
    yield from _u_demands(cut)
    yield from _z_demands(cut)
    yield from _spindle_demands(cut)
    yield from _x_demands(cut)


def demands_of(cut: JudgedCut) -> Iterator[Demand]:
    """Return every limit and what the cut needs of it, in the order in which they are reported."""
    yield from _demands_of_axes(cut)
    yield _turns_demand(cut)


def exceeded(cut: JudgedCut) -> list[Demand]:
    """Return the limits that a cut exceeds."""
    return [one for one in demands_of(cut) if one.needed > one.limit]


def _is_feasible(cut: JudgedCut) -> bool:
    return all(one.needed <= one.limit for one in _demands_of_axes(cut))


def _highest(n_bits: int, is_taken: Callable[[int], bool]) -> int:
    """Return the highest number that is taken, 0 when there is none, bit by bit."""
    found = 0
    for bit in reversed(range(n_bits)):
        trial = found + (1 << bit)
        found = trial if is_taken(trial) else found
    return found


def highest_mrpm(cut: JudgedCut) -> int:
    """Return the highest feasible mean speed, 0 when there is none."""
    return _highest(_SPEED_BITS, lambda mrpm: _is_feasible(cut._replace(mean_mrpm=mrpm)))


def largest_feed_nm(cut: JudgedCut) -> int:
    """Return the largest feasible feed at the cut's speed, 0 when there is none."""
    return _highest(_FEED_BITS, lambda feed_nm: _is_feasible(cut._replace(feed_nm=feed_nm)))
