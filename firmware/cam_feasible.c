// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_feasible.h"
#include "cam/cam_feed.h" // cam_feed_ramp_q32
#include "cam/cam_fix.h"  // cam_root_u64
#include <stdbool.h>      // bool

/// The ISR's arithmetic holds up to 16 knots per tick; half of that leaves room for overspeed.
enum { max_knots_per_tick = 8 };
/// A quarter turn per tick is the observer's limit; an eighth leaves room.
enum { min_ticks_per_turn = 8 };

/// Both sides of a limit at a speed, scaled alike.
typedef struct {
    cam_err_t err;
    int64_t limit;
    int64_t needed;
    uint32_t highest_mrpm;
} demand_t;

static int64_t smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/// [urad/s] of [r/min / 1000]: 2 pi / 60 * 1000, rounded up.
static uint64_t angular_urad_s(uint64_t mrpm)
{
    return (mrpm * 104719756u + 999999u) / 1000000u;
}

/// A speed that was told as the highest must pass when it is asked for: 1/2048 below the bound.
static uint32_t told_speed(uint64_t mrpm)
{
    const uint64_t told = mrpm - mrpm / 2048u;
    return told < UINT32_MAX ? (uint32_t)told : UINT32_MAX;
}

/// [r/min / 1000] of [urad/s], rounded down; saturates far beyond any spindle.
static uint64_t mrpm_of(uint64_t omega_urad_s)
{
    const uint64_t most = UINT64_C(10000000000000);
    return (omega_urad_s < most ? omega_urad_s : most) * 954929u / 100000000u;
}

uint32_t cam_feasible_peak(const cam_table_t *table, uint32_t mean_mrpm)
{
    const uint64_t peak = ((uint64_t)mean_mrpm * table->ratio_max_q20 + CAM_TABLE_RATIO_ONE - 1u) /
                          (uint32_t)CAM_TABLE_RATIO_ONE;
    return peak < UINT32_MAX ? (uint32_t)peak : UINT32_MAX;
}

/// @return a demand that was judged at the peak speed, told as mean speed
static demand_t as_mean(const cam_table_t *t, demand_t d)
{
    const uint64_t mean = (uint64_t)d.highest_mrpm * (uint32_t)CAM_TABLE_RATIO_ONE;
    const bool is_any = d.highest_mrpm == UINT32_MAX;
    d.highest_mrpm = is_any ? UINT32_MAX : (uint32_t)(mean / t->ratio_max_q20);
    return d;
}

static demand_t spindle_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const int64_t limit = smaller(p->spindle_limit_mrpm, t->limit_spindle_mrpm);
    return (demand_t){cam_err_spindle_speed, limit, mrpm, (uint32_t)limit};
}

/// A cam's retract begins at its highest point.
static demand_t stroke_demand(const cam_table_t *t, const cam_params_t *p)
{
    const int64_t half_nm = smaller(p->u_stroke_nm, t->limit_u_stroke_nm) / 2;
    const int64_t high_nm = ((int64_t)t->u_max_nm * p->amplitude_ppm + 999999) / 1000000;
    const int64_t least_nm = (int64_t)t->u_min_nm * p->amplitude_ppm / 1000000;
    const int64_t low_nm = t->angle.knots != NULL ? -(smaller(least_nm, 0) + p->u_retract_nm)
                                                  : -smaller(least_nm, p->u_retract_nm);
    const int64_t needed = low_nm > high_nm ? low_nm : high_nm;
    return (demand_t){cam_err_u_stroke, half_nm, needed, needed <= half_nm ? UINT32_MAX : 0u};
}

/// f'' with what the envelope adds while engaging, whose smooth step e rises over t turns: the
/// largest of e f'' + 2 e' f' + e'' f at 0.7, 0.8 and 0.9 of it (between them it is 1 % more at
/// most), or f'' itself, which is more from about three turns on.
/// @param f, f1, f2  largest magnitudes of f, f', f''; f' and f'' below 2^33
static uint64_t engaging(const cam_params_t *p, uint64_t f, uint64_t f1, uint64_t f2)
{
    static const struct {
        uint32_t e_ppm, e1_ppm, e2_ppm; // e, 2 e' / 2 pi, e'' / (2 pi)^2
    } at[] = {{836920, 421124, 127665}, {942080, 244462, 145903}, {991440, 77349, 109427}};
    const uint64_t turns = (uint64_t)smaller(p->engage_turns, p->disengage_turns);
    uint64_t most = f2;
    for (size_t i = 0; i < sizeof at / sizeof at[0]; i++) {
        const uint64_t sum =
            (f2 * at[i].e_ppm + f1 * at[i].e1_ppm / turns + f * at[i].e2_ppm / (turns * turns)) /
            990000u;
        most = sum > most && turns < 3u ? sum : most;
    }
    return most;
}

/// u' omega in um/s; u' at amplitude, at least 1 nm/rad so that the highest speed is finite.
static demand_t u_speed_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const uint64_t u1 =
        ((uint64_t)t->u1_peak_nm_per_rad * (uint32_t)p->amplitude_ppm + 999999u) / 1000000u + 1u;
    const int64_t limit = smaller(p->u_speed_um_per_s, t->limit_u_speed_um_s);
    const uint64_t omega_mrad_s = (angular_urad_s(mrpm) + 999u) / 1000u;
    const uint64_t needed = (u1 * omega_mrad_s + 999999u) / 1000000u;
    const uint64_t omega_max_urad_s = (uint64_t)limit * 1000000u / u1 * 1000u;
    return (demand_t){cam_err_u_speed, limit, (int64_t)needed,
                      told_speed(mrpm_of(omega_max_urad_s))};
}

/// u'' omega^2 in mm/s2.
static demand_t u_acceleration_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const int64_t low_nm = -(int64_t)t->u_min_nm;
    const uint64_t u = (uint64_t)(low_nm > t->u_max_nm ? low_nm : t->u_max_nm);
    const uint64_t most = engaging(p, u, t->u1_peak_nm_per_rad, t->u2_peak_nm_per_rad2);
    const uint64_t u2 = (most * (uint32_t)p->amplitude_ppm + 999999u) / 1000000u + 1u;
    const int64_t limit = smaller(p->u_acceleration_mm_per_s2, t->limit_u_acceleration_mm_s2);
    const uint64_t omega_mrad_s = (angular_urad_s(mrpm) + 999u) / 1000u;
    const uint64_t omega2_q = (omega_mrad_s * omega_mrad_s + 9999u) / 10000u; // 0.01 rad2/s2
    const uint64_t needed = (u2 * omega2_q + 99999999u) / 100000000u;
    const uint64_t omega_max_mrad_s = cam_root_u64((uint64_t)limit * 1000000000u / u2 * 1000u);
    return (demand_t){cam_err_u_acceleration, limit, (int64_t)needed,
                      told_speed(mrpm_of(omega_max_mrad_s * 1000u))};
}

static uint64_t feed_of(const cam_table_t *t, const cam_params_t *p)
{
    return p->feed_nm > 0 ? (uint64_t)p->feed_nm : t->feed_nm;
}

/// Of a ring-helix that Z is geared along.
static bool has_rings(const cam_table_t *t, const cam_params_t *p)
{
    return t->is_ring_helix && p->z_is_measured == 0;
}

static uint32_t highest_with_rings(const cam_table_t *t, const cam_params_t *p)
{
    return cam_feed_highest_mrpm((uint32_t)feed_of(t, p), (uint32_t)p->z_speed_um_per_s,
                                 (uint32_t)p->z_acceleration_mm_per_s2);
}

/// Speed between the ramps.
static demand_t ring_speed_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const uint32_t feed_nm = (uint32_t)feed_of(t, p);
    const uint32_t ramp_q32 =
        cam_feed_ramp_q32(feed_nm, mrpm, (uint32_t)p->z_acceleration_mm_per_s2);
    return (demand_t){cam_err_z_speed, p->z_speed_um_per_s,
                      (int64_t)cam_feed_speed_um_per_s(feed_nm, mrpm, ramp_q32),
                      highest_with_rings(t, p)};
}

/// The least that any ramp needs: ramps are as short as the limit allows.
static demand_t ring_acceleration_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    return (demand_t){cam_err_z_acceleration, p->z_acceleration_mm_per_s2,
                      (int64_t)cam_feed_least_acceleration((uint32_t)feed_of(t, p), mrpm),
                      highest_with_rings(t, p)};
}

static demand_t z_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const uint64_t feed_nm = feed_of(t, p);
    if (has_rings(t, p)) {
        return ring_speed_demand(t, p, mrpm);
    }
    const uint64_t limit = p->z_is_measured != 0 ? INT32_MAX : (uint64_t)p->z_speed_um_per_s;
    const uint64_t needed = (feed_nm * mrpm + 59999999u) / 60000000u;
    return (demand_t){cam_err_z_speed, (int64_t)limit, (int64_t)needed,
                      told_speed(limit * 60000000u / feed_nm)};
}

/// feed * (turns per second)^2 / ramp in mm/s2, in whole r/min. A ramp is not longer than the feed.
static demand_t z_acceleration_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    if (p->z_is_measured != 0) {
        return (demand_t){cam_err_z_acceleration, INT32_MAX, 0, UINT32_MAX};
    }
    if (has_rings(t, p)) {
        return ring_acceleration_demand(t, p, mrpm);
    }
    const uint64_t feed_nm = feed_of(t, p);
    const uint64_t turns = (uint64_t)p->feed_ramp_turns;
    const uint64_t span_nm = (uint64_t)((int64_t)t->z_last_nm - t->z_first_nm);
    const uint64_t limit = (uint64_t)p->z_acceleration_mm_per_s2;
    const uint64_t rpm = ((uint64_t)mrpm + 999u) / 1000u;
    const uint64_t per = turns * feed_nm <= span_nm ? UINT64_C(3600000000) * turns
                                                    : UINT64_C(3600000000) * span_nm / feed_nm;
    const uint64_t needed = (feed_nm * rpm * rpm + per - 1u) / per;
    return (demand_t){cam_err_z_acceleration, (int64_t)limit, (int64_t)needed,
                      told_speed(cam_root_u64(limit * per / feed_nm) * 1000u)};
}

static uint64_t clearance_nm(const cam_table_t *t, const cam_params_t *p)
{
    return (uint64_t)p->x_clearance_nm + (uint64_t)cam_table_rise_nm(t);
}

/// X leaves its clearance c by the smooth step over t turns: 15/8 c n / t at n turns per second.
static uint64_t x_clear_um_per_s(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const uint64_t turns = (uint64_t)smaller(p->engage_turns, p->disengage_turns);
    return (clearance_nm(t, p) * 15u / 8u + 1u) * mrpm / (turns * 60000000u) + 1u;
}

/// ... and 5.774 c (n / t)^2, in whole r/min.
static uint64_t x_clear_mm_per_s2(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const uint64_t turns = (uint64_t)smaller(p->engage_turns, p->disengage_turns);
    const uint64_t rpm = ((uint64_t)mrpm + 999u) / 1000u;
    const uint64_t way = (clearance_nm(t, p) + 1u) * rpm * rpm;
    return (way / (3600u * turns * turns) + 1u) / 173180u + 1u;
}

/// Z stands while X does that, then X follows the barrel: its slope times the speed of Z.
static uint64_t x_um_per_s(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const uint64_t z_um_per_s = (uint64_t)z_demand(t, p, mrpm).needed;
    const uint64_t barrel = z_um_per_s * t->x_slope_ppm / 1000000u + 1u;
    const uint64_t clear = x_clear_um_per_s(t, p, mrpm);
    return barrel > clear ? barrel : clear;
}

/// Its bend times the square of Z's speed, and its slope times Z's acceleration.
static uint64_t x_mm_per_s2(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const uint64_t z_um_per_s = (uint64_t)z_demand(t, p, mrpm).needed;
    const uint64_t z_tenth_mm = (uint64_t)smaller((int64_t)z_um_per_s / 100 + 1, 65535); // 6.5 m/s
    const uint64_t z_mm_per_s2 = has_rings(t, p)
                                     ? (uint64_t)p->z_acceleration_mm_per_s2
                                     : (uint64_t)z_acceleration_demand(t, p, mrpm).needed;
    const uint64_t bend = z_tenth_mm * z_tenth_mm * t->x_bend_ppm_per_m / 100000000000u;
    const uint64_t barrel = bend + z_mm_per_s2 * t->x_slope_ppm / 1000000u + 1u;
    const uint64_t clear = x_clear_mm_per_s2(t, p, mrpm);
    return barrel > clear ? barrel : clear;
}

/// What an axis needs at a speed; it grows with the speed.
typedef uint64_t need_fn(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm);

/// @return the highest speed up to 134 000 r/min at which no more is needed
static uint32_t highest(need_fn *need, const cam_table_t *t, const cam_params_t *p, int64_t limit)
{
    uint32_t mrpm = 0;
    for (uint32_t bit = UINT32_C(1) << 26; bit != 0u; bit >>= 1) {
        mrpm += need(t, p, mrpm + bit) <= (uint64_t)limit ? bit : 0u;
    }
    return mrpm;
}

static demand_t x_speed_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const int64_t limit = p->x_speed_um_per_s;
    return (demand_t){cam_err_x_speed, limit, (int64_t)x_um_per_s(t, p, mrpm),
                      highest(x_um_per_s, t, p, limit)};
}

static demand_t x_acceleration_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const int64_t limit = p->x_acceleration_mm_per_s2;
    return (demand_t){cam_err_x_acceleration, limit, (int64_t)x_mm_per_s2(t, p, mrpm),
                      highest(x_mm_per_s2, t, p, limit)};
}

/// r r' omega^2 in mrad/s2; without modulation nothing is needed.
static demand_t spindle_acceleration_demand(const cam_table_t *t, const cam_params_t *p,
                                            uint32_t mrpm)
{
    const int64_t limit = p->spindle_acceleration_mrad_per_s2;
    if (t->spindle_peak_ppm == 0u) {
        return (demand_t){cam_err_spindle_acceleration, limit, 0, UINT32_MAX};
    }
    const uint64_t omega_mrad_s = (angular_urad_s(mrpm) + 999u) / 1000u;
    const uint64_t omega2 = (omega_mrad_s * omega_mrad_s + 999u) / 1000u;
    const uint64_t needed = (omega2 * t->spindle_peak_ppm + 999999u) / 1000000u;
    const uint64_t omega_max_mrad_s =
        cam_root_u64((uint64_t)limit * 1000000000u / t->spindle_peak_ppm);
    return (demand_t){cam_err_spindle_acceleration, limit, (int64_t)needed,
                      told_speed(mrpm_of(omega_max_mrad_s * 1000u))};
}

static demand_t feed_demand(const cam_table_t *t, const cam_params_t *p)
{
    const int64_t span_nm = (int64_t)t->z_last_nm - t->z_first_nm;
    const int64_t feed_nm = p->z_is_measured != 0 ? 0 : (int64_t)feed_of(t, p);
    return (demand_t){cam_err_feed, span_nm, feed_nm, feed_nm <= span_nm ? UINT32_MAX : 0u};
}

/// A tool that has to swing and does not would leave another cam: no speed helps.
static demand_t swing_demand(const cam_table_t *t, const cam_params_t *p)
{
    const bool is_missing = t->is_swung && p->swing_speed_mdeg_per_s == 0;
    return (demand_t){cam_err_swing_axis, 0, is_missing ? 1 : 0, is_missing ? 0u : UINT32_MAX};
}

/// @return a peak at the amplitude, rounded up
static uint64_t at_amplitude(const cam_params_t *p, uint64_t peak)
{
    return (peak * (uint32_t)p->amplitude_ppm + 999999u) / 1000000u;
}

static demand_t swing_range_demand(const cam_table_t *t, const cam_params_t *p)
{
    const int64_t needed = (int64_t)at_amplitude(p, t->swing.most_mdeg);
    const int64_t limit = p->swing_range_mdeg;
    return (demand_t){cam_err_swing_range, limit, needed, needed <= limit ? UINT32_MAX : 0u};
}

/// @return [degrees / 1000 / rad] bound of swing' r
static uint64_t swing_first(const cam_table_t *t)
{
    const uint64_t ratio_q20 = t->ratio_max_q20;
    return ((t->swing.first_mdeg_per_rad * ratio_q20) >> 20) + 1u;
}

/// @return [degrees / 1000 / rad2] bound of swing'' r^2 + swing' r r'
static uint64_t swing_second(const cam_table_t *t)
{
    const uint64_t ratio_q20 = t->ratio_max_q20;
    const uint64_t bend = (((t->swing.second_mdeg_per_rad2 * ratio_q20) >> 20) * ratio_q20) >> 20;
    return bend + (uint64_t)t->swing.first_mdeg_per_rad * t->spindle_peak_ppm / 1000000u + 1u;
}

/// swing' omega in degrees / 1000 per second.
static demand_t swing_speed_demand(const cam_table_t *t, const cam_params_t *p, uint32_t mrpm)
{
    const int64_t limit = p->swing_speed_mdeg_per_s;
    if (!t->is_swung) {
        return (demand_t){cam_err_swing_speed, limit, 0, UINT32_MAX};
    }
    const uint64_t first = at_amplitude(p, swing_first(t));
    const uint64_t omega_mrad_s = (angular_urad_s(mrpm) + 999u) / 1000u;
    const uint64_t needed = (first * omega_mrad_s + 999u) / 1000u;
    const uint64_t omega_max_urad_s = (uint64_t)limit * 1000000u / first;
    return (demand_t){cam_err_swing_speed, limit, (int64_t)needed,
                      told_speed(mrpm_of(omega_max_urad_s))};
}

/// swing'' omega^2 in degrees per second squared.
static demand_t swing_acceleration_demand(const cam_table_t *t, const cam_params_t *p,
                                          uint32_t mrpm)
{
    const int64_t limit = p->swing_acceleration_deg_per_s2;
    if (!t->is_swung) {
        return (demand_t){cam_err_swing_acceleration, limit, 0, UINT32_MAX};
    }
    const uint64_t second =
        at_amplitude(p, engaging(p, t->swing.most_mdeg, swing_first(t), swing_second(t)));
    const uint64_t omega_mrad_s = (angular_urad_s(mrpm) + 999u) / 1000u;
    const uint64_t omega2 = (omega_mrad_s * omega_mrad_s + 999u) / 1000u; // 0.001 rad2/s2
    const bool is_any = omega2 < (uint64_t)INT64_MAX / second; // else the product means nothing
    const uint64_t product = (second * omega2 + 999999u) / 1000000u;
    const int64_t needed = is_any ? (int64_t)product : INT64_MAX;
    const uint64_t omega_max_mrad_s = cam_root_u64((uint64_t)limit * 1000000u / second * 1000u);
    return (demand_t){cam_err_swing_acceleration, limit, needed,
                      told_speed(mrpm_of(omega_max_mrad_s * 1000u))};
}

static demand_t tick_demand(const cam_table_t *t, uint32_t mrpm, uint32_t tick_hz)
{
    const uint64_t knots = UINT64_C(1) << (t->u.log2_knots + t->u.log2_repeat);
    const uint64_t by_knots = (uint64_t)tick_hz * max_knots_per_tick * 60000u / knots;
    const uint64_t by_turn = (uint64_t)tick_hz * 60000u / min_ticks_per_turn;
    const uint64_t most = by_knots < by_turn ? by_knots : by_turn;
    return (demand_t){cam_err_tick_rate, (int64_t)most, mrpm, told_speed(most)};
}

cam_feasibility_t cam_feasible(const cam_table_t *table, const cam_params_t *params,
                               uint32_t speed_mrpm, uint32_t tick_hz)
{
    const uint32_t peak_mrpm = cam_feasible_peak(table, speed_mrpm);
    const demand_t demands[] = {
        swing_demand(table, params),
        swing_range_demand(table, params),
        swing_speed_demand(table, params, speed_mrpm),
        swing_acceleration_demand(table, params, speed_mrpm),
        as_mean(table, spindle_demand(table, params, peak_mrpm)),
        stroke_demand(table, params),
        u_speed_demand(table, params, speed_mrpm),
        u_acceleration_demand(table, params, speed_mrpm),
        feed_demand(table, params),
        as_mean(table, z_demand(table, params, peak_mrpm)),
        as_mean(table, z_acceleration_demand(table, params, peak_mrpm)),
        as_mean(table, tick_demand(table, peak_mrpm, tick_hz)),
        spindle_acceleration_demand(table, params, speed_mrpm),
        as_mean(table, x_speed_demand(table, params, peak_mrpm)),
        as_mean(table, x_acceleration_demand(table, params, peak_mrpm)),
    };
    cam_feasibility_t result = {.speed_mrpm = speed_mrpm, .highest_mrpm = UINT32_MAX};
    for (size_t i = 0; i < sizeof demands / sizeof demands[0]; i++) {
        const demand_t *d = &demands[i];
        result.highest_mrpm =
            d->highest_mrpm < result.highest_mrpm ? d->highest_mrpm : result.highest_mrpm;
        if (result.err == cam_ok && d->needed > d->limit) {
            result.err = d->err;
            result.needed = d->needed;
            result.limit = d->limit;
        }
    }
    return result;
}
