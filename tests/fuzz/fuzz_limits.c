// SPDX-License-Identifier: Apache-2.0
#include "fuzz_limits.h"

enum { table_feed_nm = 100000 };   ///< of the tables of fuzz_rig.c
enum { table_stock_nm = 1000000 }; ///< ... no more than this, from which X leaves

static const double nowhere_nm = 1e12; ///< of a travel without an end

static int64_t most(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int64_t least(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/// @return [steps] over which the acceleration of a motion by time turns round: a power of two
static double window_steps(double turn_s, double step_s)
{
    double n = 1.0;
    while (n < (double)fuzz_limits_steps && step_s * n < turn_s * (1.0 - 1e-9)) {
        n *= 2.0;
    }
    return n;
}

/// FAULTS.md, window of a motion by time. @return [s] 2 a / jerk, or what is derived where that is
/// 0
static double turn_s(const cam_params_t *p, uint32_t axis, double tick_s)
{
    const double a_m_per_s2[] = {p->u_acceleration_mm_per_s2 / 1e3,
                                 p->x_acceleration_mm_per_s2 / 1e3,
                                 p->z_acceleration_mm_per_s2 / 1e3};
    const int32_t jerks[] = {p->u_jerk_m_per_s3, p->x_jerk_m_per_s3, p->z_jerk_m_per_s3};
    if (jerks[axis] > 0) {
        return 2.0 * a_m_per_s2[axis] / jerks[axis];
    }
    if (axis != (uint32_t)hal_axis_u) {
        return 6.4e-3;
    }
    const double by_k2_s = 4e-6 * a_m_per_s2[axis] * p->k2_us2 / p->u_speed_um_per_s;
    return fuzz_more(fuzz_more(0.8e-3, 2.0 * tick_s), fuzz_more(p->k1_ns / 1e9, by_k2_s));
}

/// MATHS.md (213): what the feed-forward adds to U's set-point.
static void add_gains(fuzz_limits_t *l, const cam_params_t *p, double hz)
{
    const uint32_t u = (uint32_t)hal_axis_u;
    const double k1 = p->k1_ns * hz / 1e9;
    const double k2 = p->k2_us2 * hz * hz / 1e12;
    const double n = l->window[u];
    const double v_nm = l->speed_nm[u];
    const double a_nm = l->acceleration_nm[u];
    const double jerk_nm = 2.0 * a_nm / n;
    l->commanded_step_nm = v_nm + k1 * a_nm + k2 * jerk_nm;
    l->commanded_change_nm = a_nm + k1 * jerk_nm + 2.0 * k2 * jerk_nm;
    l->gain_rounding_nm = (2.0 * k1 + 4.0 * k2) / 1024.0;
}

/// @return [nm] fastest way of X or Z over a turn: Z by the feed, X also by a smooth step to its
/// clearance, at 15/8 of its mean
static double way_nm(const cam_params_t *p, uint32_t axis)
{
    const double feed_nm = (double)most(p->feed_nm, table_feed_nm);
    const int64_t turns = least(p->engage_turns, p->disengage_turns);
    const double clearing_nm = (double)most(p->x_clearance_nm, table_stock_nm) * 15.0 / 8.0;
    return axis == (uint32_t)hal_axis_x ? feed_nm + clearing_nm / (double)turns : feed_nm;
}

fuzz_limits_t fuzz_limits(const cam_params_t *p, uint32_t tick_hz, uint32_t plan_ticks)
{
    const double hz = tick_hz;
    const int32_t speed_um_per_s[] = {p->u_speed_um_per_s, p->x_speed_um_per_s,
                                      p->z_speed_um_per_s};
    const int32_t acceleration_mm_per_s2[] = {
        p->u_acceleration_mm_per_s2, p->x_acceleration_mm_per_s2, p->z_acceleration_mm_per_s2};
    fuzz_limits_t l = {
        .stroke_nm = p->u_stroke_nm / 2,
        .clearance_nm = p->x_clearance_nm,
        .x_low_nm = p->x_low_nm < p->x_high_nm ? p->x_low_nm : -nowhere_nm,
        .x_high_nm = p->x_low_nm < p->x_high_nm ? p->x_high_nm : nowhere_nm,
        .spindle_mrpm = p->spindle_limit_mrpm,
        .swing_q32 = p->swing_range_mdeg * INT64_C(4294967296) / 360000,
    };
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const double step = i == (uint32_t)hal_axis_u ? 1.0 : (double)plan_ticks;
        l.speed_nm[i] = speed_um_per_s[i] * 1e3 / hz;
        l.acceleration_nm[i] = acceleration_mm_per_s2[i] * 1e6 / hz / hz;
        l.window[i] = window_steps(turn_s(p, i, 1.0 / hz), step / hz);
        l.longest[i] = l.window[i];
        l.way_nm[i] = way_nm(p, i);
        l.leave_nm[i] = l.speed_nm[i];
        // A window carries no more than what fits a word.
        l.brake_nm[i] = fuzz_less(l.acceleration_nm[i], 1048576.0 / l.window[i] / step / step);
    }
    add_gains(&l, p, hz);
    return l;
}

void fuzz_limits_widen(fuzz_limits_t *l, const fuzz_limits_t *now)
{
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        l->speed_nm[i] = fuzz_more(l->speed_nm[i], now->speed_nm[i]);
        l->acceleration_nm[i] = fuzz_more(l->acceleration_nm[i], now->acceleration_nm[i]);
        l->leave_nm[i] = fuzz_less(l->leave_nm[i], now->leave_nm[i]);
        l->brake_nm[i] = fuzz_less(l->brake_nm[i], now->brake_nm[i]);
        l->window[i] = fuzz_less(l->window[i], now->window[i]);
        l->longest[i] = fuzz_more(l->longest[i], now->longest[i]);
        l->way_nm[i] = fuzz_more(l->way_nm[i], now->way_nm[i]);
    }
    l->x_low_nm = fuzz_less(l->x_low_nm, now->x_low_nm);
    l->x_high_nm = fuzz_more(l->x_high_nm, now->x_high_nm);
    l->commanded_step_nm = fuzz_more(l->commanded_step_nm, now->commanded_step_nm);
    l->commanded_change_nm = fuzz_more(l->commanded_change_nm, now->commanded_change_nm);
    l->gain_rounding_nm = fuzz_more(l->gain_rounding_nm, now->gain_rounding_nm);
    l->stroke_nm = most(l->stroke_nm, now->stroke_nm);
    l->clearance_nm = most(l->clearance_nm, now->clearance_nm);
    l->spindle_mrpm = most(l->spindle_mrpm, now->spindle_mrpm);
    l->swing_q32 = most(l->swing_q32, now->swing_q32);
}

/// @return [ticks] that an axis needs at most to brake from its highest speed, go a way and come to
/// rest there: with a ramp at both ends, and a plan for every change of mind
static double ticks_for(double way_nm, double speed_nm, double leave_nm, double brake_nm)
{
    const double brake = speed_nm / brake_nm + 1.0;
    const double ramp = 2.0 * brake; // up and down again, where the way is long enough for it
    const double back_nm = speed_nm * brake;
    return brake + ramp + (way_nm + 2.0 * back_nm) / leave_nm + 1.0;
}

/// FAULTS.md: U by at most its stroke, X by its clearance and what a lobe rises, Z to rest.
double fuzz_limits_patience(const fuzz_limits_t *l, int32_t rise_nm)
{
    const double ways_nm[hal_n_axes] = {(double)(2 * l->stroke_nm + rise_nm),
                                        (double)(l->clearance_nm + rise_nm), 0.0};
    double ticks = 0;
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const double fastest_nm = i == (uint32_t)hal_axis_u ? l->commanded_step_nm : l->speed_nm[i];
        ticks = fuzz_more(ticks, ticks_for(ways_nm[i], fastest_nm, l->leave_nm[i], l->brake_nm[i]));
    }
    return ticks;
}
