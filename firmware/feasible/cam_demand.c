// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible_inner.h"
#include "cam_table.h" // cam_peaks_set_point_q20
#include "cam_plan.h"  // cam_plan_ticks
#include <stdbool.h>   // bool
#include <stddef.h>    // size_t

/// The interrupt's arithmetic holds 16 knots per tick; half of them leaves room for overspeed.
enum { max_knots_per_tick = 8 };
/// [nm] No part has more stock on its radius.
enum { most_stock_nm = 100000000 };
/// The angle observer follows up to a quarter turn per tick; an eighth leaves room.
enum { min_ticks_per_turn = 8 };

/// The spindle accelerates with r r' omega^2, in mrad/s2. At uniform speed nothing is needed.
static cam_demand_t spindle_acceleration_demand(const cam_cut_t *c)
{
    const double omega = cam_cut_omega(c->mean_mrpm);
    return (cam_demand_t){cam_err_spindle_acceleration, c->p->spindle_acceleration_mrad_per_s2,
                          cam_cut_up(omega * omega * c->t->spindle_peak_ppm_per_rad * 1e-3)};
}

/// A speed loop of bandwidth b with set-point 0 loses at most the share b of its speed per second,
/// so b must reach the rate at which the ratio falls, -r' times the mean speed.
static cam_demand_t spindle_loop_demand(const cam_cut_t *c)
{
    const int64_t lag_us = c->p->spindle_lag_us;
    const double omega = cam_cut_omega(c->mean_mrpm);
    return (cam_demand_t){cam_err_spindle_loop, lag_us > 0 ? 1000000000 / lag_us : INT64_MAX,
                          cam_cut_up(omega * c->t->spindle_demand.fall_ppm_per_rad * 1e-3)};
}

/// The set-point that makes the spindle follow must not exceed its highest speed.
static cam_demand_t spindle_set_point_demand(const cam_cut_t *c)
{
    const double lag = cam_cut_omega(c->mean_mrpm) * c->p->spindle_lag_us * 1e-6; // [rad]
    const uint64_t set_q20 =
        cam_peaks_set_point_q20(&c->t->spindle_demand, cam_cut_up(lag * 0x1p16));
    const double ratio = c->t->speed.knots != NULL ? (double)set_q20 * 0x1p-20 : 0.0;
    return (cam_demand_t){cam_err_spindle_set_point, c->p->spindle_limit_mrpm,
                          cam_cut_up(ratio * c->mean_mrpm)};
}

/// No more knots, and no larger part of a turn, may pass in a tick than the interrupt can follow.
static cam_demand_t tick_demand(const cam_cut_t *c)
{
    const uint64_t knots = UINT64_C(1) << (c->t->u.log2_knots + c->t->u.log2_repeat);
    const uint64_t by_knots = (uint64_t)c->tick_hz * max_knots_per_tick * 60000u / knots;
    const uint64_t by_turn = (uint64_t)c->tick_hz * 60000u / min_ticks_per_turn;
    return (cam_demand_t){cam_err_tick_rate, (int64_t)(by_knots < by_turn ? by_knots : by_turn),
                          c->peak_mrpm};
}

static cam_z_coupling_t u_drift(const cam_cut_t *c)
{
    return cam_z_coupling_of(c, &c->t->u, &c->t->u_change, c->tick_hz);
}

/// @return [nm] how far U travels outwards from the middle of its stroke in the cut
static uint64_t outwards_nm(const cam_cut_t *c)
{
    return cam_cut_up(cam_cut_at_amplitude(c, -(double)c->t->u_min_nm));
}

/// From the middle of its stroke U travels inwards by the largest u and outwards by the least.
static cam_demand_t stroke_demand(const cam_cut_t *c)
{
    const double in_nm = cam_cut_at_amplitude(c, c->t->u_max_nm);
    return (cam_demand_t){cam_err_u_stroke, cam_demand_half_stroke_nm(c->t, c->p),
                          cam_greater_u64(cam_cut_up(in_nm), outwards_nm(c))};
}

/// A retract that was set counts from the outermost position of U in the cut. The default goes as
/// far as the stroke allows, and X moves the tool away from the work in any case.
static cam_demand_t retract_demand(const cam_cut_t *c)
{
    const int32_t retract_nm = c->p->u_retract_nm;
    const bool is_set = retract_nm != cam_param_info(cam_param_u_retract_nm)->def;
    return (cam_demand_t){cam_err_u_retract, cam_demand_half_stroke_nm(c->t, c->p),
                          is_set ? outwards_nm(c) + (uint64_t) - (int64_t)retract_nm : 0u};
}

static double depth_turns(const cam_cut_t *c)
{
    return (double)cam_smaller_i64(c->p->engage_turns, c->p->disengage_turns);
}

/// Bound a sum while the envelope e, a smooth step, rises over so many turns. It is evaluated at
/// twelve points of the second half of the step, with e' and e'' enlarged by 3 %, so that it
/// misses less than a ten-thousandth of the largest value between them, for any number of turns.
/// @return the largest of f e + g e' + h e'' over the step, or f itself
static double most_of_step(double turns, double f, double g, double h)
{
    static const uint16_t permille[] = {500, 560, 620, 680, 740, 780, 820, 860, 900, 930, 955, 975};
    const double per_rad = 1.0 / (2.0 * CAM_PI * turns);
    double most = f;
    for (size_t i = 0; i < sizeof permille / sizeof permille[0]; i++) {
        const cam_cut_step_t at = cam_cut_step(permille[i] * 1e-3);
        const double by = g * at.e1 * per_rad + h * at.e2 * per_rad * per_rad;
        most = cam_cut_most(most, f * at.e + 1.03 * by);
    }
    return most;
}

/// @return largest ratio of the speed of the spindle to its mean
static double ratio_of(const cam_table_t *t)
{
    return t->ratio_max_q20 * 0x1p-20;
}

/// The speed while engaging: the largest of e f' + e' f over the step, or f' itself; from lobe to
/// lobe it may be larger. The spindle may turn faster than its mean speed.
static double most_speed(const cam_cut_t *c, const cam_z_coupling_peaks_t *peaks)
{
    const double engaging = most_of_step(depth_turns(c), peaks->f1, peaks->f * ratio_of(c->t), 0.0);
    return cam_cut_most(engaging, cam_z_coupling_lobes_first(c->t, c->feed_nm, peaks));
}

/// The acceleration while engaging: the largest of e f'' + 2 e' f' + e'' f over the step, or f''
/// itself; from lobe to lobe it may be larger. The spindle may turn faster than its mean speed and
/// accelerate. The slope of the envelope is constant within a plan, so its change over a whole plan
/// acts on the first set-point of the next one.
/// @param n_set_points  of a plan
static double most_acceleration(const cam_cut_t *c, const cam_z_coupling_peaks_t *peaks,
                                uint32_t n_set_points)
{
    const double ratio = ratio_of(c->t);
    const double alpha = peaks->f * c->t->spindle_peak_ppm_per_rad * 1e-6 * n_set_points;
    const double engaging = most_of_step(depth_turns(c), peaks->f2, 2.0 * peaks->f1 * ratio + alpha,
                                         peaks->f * ratio * ratio * n_set_points);
    return cam_cut_most(engaging,
                        cam_z_coupling_lobes_second(c->t, c->feed_nm, peaks, n_set_points));
}

static cam_z_coupling_peaks_t u_peaks(const cam_table_t *t)
{
    return (cam_z_coupling_peaks_t){.f = (double)cam_cut_largest_nm(t),
                                    .f1 = t->u1_peak_nm_per_rad,
                                    .f2 = t->u2_peak_nm_per_rad2};
}

/// U moves with u' omega, in um/s, plus the effect of the feed.
static cam_demand_t u_speed_demand(const cam_cut_t *c)
{
    const int64_t limit = cam_smaller_i64(c->p->u_speed_um_per_s, c->t->limit_u_speed_um_per_s);
    const cam_z_coupling_peaks_t u = u_peaks(c->t);
    const double um_per_s = cam_cut_um_per_s(c, most_speed(c, &u)) + u_drift(c).speed;
    return (cam_demand_t){cam_err_u_speed, limit, cam_cut_up(cam_cut_at_amplitude(c, um_per_s))};
}

/// U accelerates with u'' omega^2, in mm/s2, plus the effect of the feed.
static cam_demand_t u_acceleration_demand(const cam_cut_t *c)
{
    const cam_table_t *t = c->t;
    const int64_t limit =
        cam_smaller_i64(c->p->u_acceleration_mm_per_s2, t->limit_u_acceleration_mm_per_s2);
    const cam_z_coupling_peaks_t u = u_peaks(t);
    const uint32_t plan_ticks = (uint32_t)cam_plan_ticks(c->tick_hz);
    const double most = most_acceleration(c, &u, plan_ticks);
    const cam_z_coupling_t d = u_drift(c);
    const double mm_per_s2 = cam_cut_mm_per_s2(c, most) + cam_z_coupling_acceleration(c, &d) * 1e-3;
    return (cam_demand_t){cam_err_u_acceleration, limit,
                          cam_cut_up(cam_cut_at_amplitude(c, mm_per_s2))};
}

/// The force over a turn, rms in mN: mass times acceleration, drag at the peak speed, and friction.
/// It must not exceed the continuous force of the motor. The cutting force is not known.
static cam_demand_t u_force_demand(const cam_cut_t *c)
{
    const cam_params_t *p = c->p;
    if (p->servo_crossover_hz == 0) {
        return (cam_demand_t){cam_err_servo_continuous, 0, 0u};
    }
    const double share = cam_cut_at_amplitude(c, 1.0);
    const double u2 =
        c->t->speed.knots != NULL ? c->t->u2_peak_nm_per_rad2 : c->t->u2_rms_nm_per_rad2;
    const double by_mass = share * cam_cut_mm_per_s2(c, u2) * p->servo_mass_g * 1e-3;
    const double by_drag =
        share * cam_cut_um_per_s(c, c->t->u1_peak_nm_per_rad) * p->servo_drag_mn_s_per_m * 1e-6;
    const double by_friction = p->servo_friction_mn;
    return (cam_demand_t){
        cam_err_servo_continuous, cam_smaller_i64(p->servo_continuous_mn, p->servo_force_limit_mn),
        cam_cut_up(cam_root(by_mass * by_mass + by_drag * by_drag + by_friction * by_friction))};
}

/// [degrees / 1000] in thousands of 2^-26 turn
#define MDEG (360e6 * 0x1p-26)

/// The swing gets a set-point from every plan.
static cam_z_coupling_t swing_drift(const cam_cut_t *c)
{
    const uint32_t set_point_hz = c->tick_hz / (uint32_t)cam_plan_ticks(c->tick_hz) + 1u;
    return cam_z_coupling_of(c, &c->t->angle, &c->t->swing_change, set_point_hz);
}

/// @return peaks of the swing over the angle, in degrees / 1000; its acceleration is proportional
///         to swing'' r^2 + swing' r r'
static cam_z_coupling_peaks_t swing_peaks(const cam_table_t *t)
{
    const double ratio = ratio_of(t);
    const double slope = t->swing.first_mdeg_per_rad;
    return (cam_z_coupling_peaks_t){
        .f = t->swing.most_mdeg,
        .f1 = slope * ratio,
        .f2 = t->swing.second_mdeg_per_rad2 * ratio * ratio +
              slope * t->spindle_peak_ppm_per_rad * 1e-6,
    };
}

/// The swing moves with swing' omega, in degrees / 1000 per second, plus the effect of the feed.
static uint64_t swing_speed(const cam_cut_t *c)
{
    const cam_z_coupling_peaks_t swing = swing_peaks(c->t);
    const double turning = most_speed(c, &swing) * cam_cut_omega(c->mean_mrpm);
    return cam_cut_up(cam_cut_at_amplitude(c, turning + MDEG * swing_drift(c).speed));
}

/// The swing accelerates, in degrees per second squared, over the angle and by the feed.
static uint64_t swing_acceleration(const cam_cut_t *c)
{
    const cam_z_coupling_peaks_t swing = swing_peaks(c->t);
    const double second = most_acceleration(c, &swing, 1u);
    const double omega = cam_cut_omega(c->mean_mrpm);
    const cam_z_coupling_t d = swing_drift(c);
    const double mdeg_per_s2 = second * omega * omega + MDEG * cam_z_coupling_acceleration(c, &d);
    return cam_cut_up(cam_cut_at_amplitude(c, mdeg_per_s2 * 1e-3));
}

int32_t cam_demand_clearance_nm(const cam_table_t *t, const cam_params_t *p)
{
    if (t == NULL) {
        return p->x_clearance_nm;
    }
    const int64_t stock_nm = cam_smaller_i64(t->depth_nm, most_stock_nm);
    const int64_t clear_nm = p->x_clearance_nm > stock_nm ? p->x_clearance_nm : stock_nm;
    return (int32_t)clear_nm + cam_table_rise_nm(t);
}

/// X first leaves its clearance c by a smooth step over t turns while Z stands, which at n turns
/// per second needs the speed 15/8 c n / t. Afterwards it follows the barrel with slope times the
/// speed of Z. The two do not coincide, so the larger one counts.
static cam_demand_t x_speed_demand(const cam_cut_t *c)
{
    const double clearing =
        15.0 / 8.0 * cam_demand_clearance_nm(c->t, c->p) * c->peak_mrpm / (depth_turns(c) * 6e7);
    const double barrel = cam_z_coupling_along_um_per_s(c) * c->t->x_slope_ppm * 1e-6;
    return (cam_demand_t){cam_err_x_speed, c->p->x_speed_um_per_s,
                          cam_cut_up(cam_cut_most(barrel, clearing))};
}

/// The smooth step needs the acceleration 5.774 c (n / t)^2. The barrel needs its bend times the
/// square of Z's speed, and its slope times Z's acceleration.
static cam_demand_t x_acceleration_demand(const cam_cut_t *c)
{
    const double per_s = c->peak_mrpm / (6e4 * depth_turns(c)); // n / t
    const double clearing =
        5.7735027e-6 * cam_demand_clearance_nm(c->t, c->p) * per_s * per_s; // 10 / root of 3
    const double v_um_per_s = cam_z_coupling_along_um_per_s(c);
    const double bend = v_um_per_s * v_um_per_s * c->t->x_bend_ppm_per_mm * 1e-12;
    const double along = cam_z_coupling_along_mm_per_s2(c) * c->t->x_slope_ppm * 1e-6;
    return (cam_demand_t){cam_err_x_acceleration, c->p->x_acceleration_mm_per_s2,
                          cam_cut_up(cam_cut_most(bend + along, clearing))};
}

int32_t cam_demand_half_stroke_nm(const cam_table_t *t, const cam_params_t *p)
{
    const int64_t made_for_nm = t != NULL ? t->limit_u_stroke_nm : INT32_MAX;
    return (int32_t)(cam_smaller_i64(p->u_stroke_nm, made_for_nm) / 2);
}

cam_demands_t cam_demand_all(const cam_cut_t *c)
{
    const cam_table_t *t = c->t;
    const cam_params_t *p = c->p;
    const bool is_led = p->z_is_measured != 0; // another controller moves and limits Z
    const uint32_t whole_ppm = 1000000;
    const bool is_overridden = p->feed_override_ppm != (int32_t)whole_ppm;
    // The ramps of a ring-helix are made for the programmed feed and speed.
    const bool is_beyond_rings = is_overridden || p->spindle_override_ppm > (int32_t)whole_ppm;
    return (cam_demands_t){{
        // A skirt may be trimmed by the amplitude; a lobe with less than its full lift is wrong.
        {cam_err_cam_amplitude, p->amplitude_ppm, t->angle.knots != NULL ? whole_ppm : 0u},
        // Without its swing the tool would cut a wrong lobe at any speed.
        {cam_err_swing_axis, 0, t->is_swung && p->swing_speed_mdeg_per_s == 0 ? 1u : 0u},
        // Stations count the turns of the helix, which a measured Z does not give.
        {cam_err_z_stations, 0, t->has_stations && is_led ? 1u : 0u},
        {cam_err_override_measured, 0, is_led && is_overridden ? 1u : 0u},
        {cam_err_override_rings, 0, t->is_ring_helix && is_beyond_rings ? 1u : 0u},
        {cam_err_swing_range, p->swing_range_mdeg,
         cam_cut_up(cam_cut_at_amplitude(c, t->swing.most_mdeg))},
        {cam_err_swing_speed, p->swing_speed_mdeg_per_s, t->is_swung ? swing_speed(c) : 0u},
        {cam_err_swing_acceleration, p->swing_acceleration_deg_per_s2,
         t->is_swung ? swing_acceleration(c) : 0u},
        {cam_err_spindle_speed, cam_smaller_i64(p->spindle_limit_mrpm, t->limit_spindle_mrpm),
         c->peak_mrpm},
        stroke_demand(c),
        retract_demand(c),
        u_speed_demand(c),
        u_acceleration_demand(c),
        u_force_demand(c),
        cam_command_stroke_demand(c),
        cam_command_speed_demand(c),
        cam_command_acceleration_demand(c),
        {cam_err_feed, (int64_t)cam_cut_span_nm(c), is_led ? 0u : c->programmed_nm},
        {cam_err_z_speed, is_led ? INT32_MAX : p->z_speed_um_per_s,
         cam_cut_up(cam_z_coupling_z_um_per_s(c))},
        {cam_err_z_acceleration, p->z_acceleration_mm_per_s2,
         is_led ? 0u : cam_cut_up(cam_z_coupling_z_mm_per_s2(c))},
        tick_demand(c),
        spindle_acceleration_demand(c),
        spindle_loop_demand(c),
        spindle_set_point_demand(c),
        x_speed_demand(c),
        x_acceleration_demand(c),
    }};
}

cam_demand_t cam_demand_first_exceeded(const cam_cut_t *c)
{
    const cam_demands_t all = cam_demand_all(c);
    for (size_t i = 0; i < (size_t)cam_n_demands; i++) {
        if (all.of[i].needed > (uint64_t)all.of[i].limit) {
            return all.of[i];
        }
    }
    return (cam_demand_t){.err = cam_ok};
}
