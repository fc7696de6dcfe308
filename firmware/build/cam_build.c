// SPDX-License-Identifier: Apache-2.0
#include "cam_build_inner.h"
#include "cam_doubles.h"  // CAM_PI, cam_limit, cam_nearest
#include "cam_fix.h"      // CAM_TURN_Q32, cam_sat_i32
#include "cam_feasible.h" // cam_changes_build, cam_demand_half_stroke_nm
#include "cam_motion.h"   // cam_jerk_filter_most_q10
#include "cam_plan.h"     // cam_plan_ticks
#include "cam_eval.h"     // cam_feed_profile_z_last_nm
#include "hal/hal.h"      // hal_has_edge_time
#include <stddef.h>       // NULL

/// [nm / 1024] Rounding margin of set-point checks, which also allow 1/16 for encoder noise.
#define MARGIN_Q10 3072

enum {
    height_end = 64,       ///< [slices / 2^32] of U's height below the last slice, with rounding
    max_rate_bits = 4,     ///< derivatives hold up to 2^4 knots per tick; start refuses more
    most_speed_shift = 20, ///< one turn in 2^22 ticks is slower than any spindle
    agreeing_part = 512,   ///< two turns of a steady spindle differ by less, MATHS.md (230)
    homing_patience = 100, ///< homing waits so many times longer than the cut for the spindle
    most_periods = 10,     ///< largest late_percent, in periods; a longer pause counts as that long
    still_nm = 1000,       ///< [nm] unnoticed motion of U, should the encoder stand
    stamp_periods = 4,     ///< an older edge is no better than the middle of its count
};

int32_t cam_build_speed_q32(uint32_t speed_mrpm, uint32_t tick_hz)
{
    return cam_sat_i32(cam_units_scale(speed_mrpm, CAM_TURN_Q32 / 4, (int64_t)tick_hz * 15000));
}

/// @param u  limits of the retract, which overshoots by an eighth of its acceleration: it brakes in
///           steps
/// @return [nm / 1024] retracted position of U, whatever was set: within the stroke by that, or by
///         less where U would otherwise stay among the positions of the cut
static int64_t retract_q10(const cam_params_t *p, const cam_table_t *table,
                           const cam_motion_limits_t *u)
{
    const int32_t rise_nm = table != NULL ? cam_table_rise_nm(table) : 0;
    const int32_t room_nm = u->acceleration_q10 / 8192 + 1;
    const int32_t half_nm = cam_demand_half_stroke_nm(table, p);
    const int64_t out_nm = table != NULL ? -(int64_t)table->u_min_nm * p->amplitude_ppm : 0;
    const int32_t least_nm = cam_sat_i32(cam_clamp_i64(out_nm / 1000000, 0, half_nm));
    const int32_t roomy_nm = half_nm > room_nm ? half_nm - room_nm : 0;
    const int32_t most_nm = roomy_nm > least_nm ? roomy_nm : least_nm;
    return (int64_t)cam_clamp_i32(p->u_retract_nm - rise_nm, -most_nm, most_nm) * 1024;
}

/// A tick is on time within a sixteenth of the period, or one unit of a coarse clock.
static void build_clock(cam_spindle_config_t *c, int32_t late_percent, uint32_t tick_hz,
                        uint32_t clock_hz)
{
    c->tick_clocks = (uint32_t)cam_units_scale(clock_hz, 1, tick_hz);
    c->ticks_per_clock_q27 = (uint32_t)cam_units_scale(tick_hz, INT64_C(1) << 27, clock_hz);
    c->most_clocks = most_periods * c->tick_clocks;
    const uint32_t off = 1u + (c->tick_clocks - 1u) / 16u;
    c->late_clocks =
        (uint32_t)cam_units_scale(clock_hz, 100 + late_percent, (int64_t)tick_hz * 100);
    c->early_clocks = c->tick_clocks - off;
    c->on_time_clocks = 2u * off + 1u;
    c->stamp_clocks = hal_has_edge_time() ? (stamp_periods + 1) * c->tick_clocks : 0u;
}

/// How far the spindle may turn without an advance of its encoder: by three uneven counts and the
/// tolerance, and where counts are fine by an angle in which U moves still_nm at most.
static void build_still(cam_spindle_config_t *c, const cam_table_t *table)
{
    const uint32_t u1 = table != NULL ? table->u1_peak_nm_per_rad : 0u;
    const int64_t by_pi = INT64_C(710) * u1; // 2 pi = 710 / 113
    const int64_t slope_q32 = cam_units_scale(CAM_TURN_Q32, INT64_C(113) * still_nm, by_pi + 113);
    c->still_counts = cam_clamp_i32(c->index_tolerance + 3, 3, c->max_counts);
    const int64_t jitter_q32 = (int64_t)c->still_counts * c->turn_per_count_q32;
    c->still_q32 = cam_sat_i32(jitter_q32 > slope_q32 ? jitter_q32 : slope_q32);
}

/// What the spindle's inertia allows, with a quarter to spare, and by how many counts the encoder
/// may contradict it: 2 for its unevenness, and the tolerance.
static void build_inertia(cam_spindle_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const double plan_s = (double)cam_plan_ticks(tick_hz) / (double)tick_hz;
    const double turns = 1.25e-3 * p->spindle_acceleration_mrad_per_s2 / (2.0 * CAM_PI);
    const double counts = 2.0 + p->index_tolerance_counts;
    c->inertia_q32 = cam_nearest(cam_limit(turns * plan_s * plan_s * 0x1p32, cam_most_inertia_q32));
    c->inertia_window_q32 = cam_nearest(cam_limit(counts / p->counts_per_turn * 0x1p32, 0x1p29));
}

static void build_spindle(cam_spindle_config_t *c, const cam_params_t *p, int32_t sense,
                          uint32_t tick_hz, uint32_t clock_hz)
{
    const int32_t turn = p->counts_per_turn;
    const uint64_t count_q32 = (uint64_t)CAM_TURN_Q32 / (uint32_t)turn;
    const uint64_t left = (uint64_t)CAM_TURN_Q32 % (uint32_t)turn;
    c->sign_mask = sense == p->encoder_sign ? 0u : ~0u;
    c->counts_per_turn = turn;
    c->turn_per_count_q32 = (uint32_t)count_q32;
    c->turn_per_count_fraction = (uint32_t)(left * (uint64_t)CAM_TURN_Q32 / (uint32_t)turn);
    c->centre_q32 =
        (uint32_t)cam_units_turn_of_udeg(sense * p->index_offset_udeg) + (uint32_t)(count_q32 / 2u);
    c->index_tolerance = p->index_tolerance_counts;
    c->index_overdue = turn + turn / 8;
    c->max_counts = turn / 4;
    c->jump_window = cam_clamp_i32(cam_derived_limits_jump_counts(p, tick_hz), 0, c->max_counts);
    build_clock(c, p->late_percent, tick_hz, clock_hz);
    build_inertia(c, p, tick_hz);
    // Observer with a double pole at w = 2 pi f: kp = 2 w T, ki = (w T)^2.
    const int64_t wt_q24 =
        cam_units_scale(CAM_TWO_PI_Q24, p->observer_bandwidth_mHz, (int64_t)tick_hz * 1000);
    c->kp_q31 = cam_sat_i32(wt_q24 * 256);
    c->ki_q32 = cam_sat_i32((wt_q24 * wt_q24) >> 16);
}

/// The mean speed is limited to 1/64 turn per tick, beyond any that can be modulated.
static void build_speed(cam_speed_config_t *c, const cam_params_t *p, int32_t direction,
                        int32_t mean_mrpm, uint32_t tick_hz)
{
    const int64_t plan_us_hz = cam_plan_ticks(tick_hz) * INT64_C(1000000);
    const int64_t mean_q32 = cam_build_speed_q32((uint32_t)mean_mrpm, tick_hz);
    c->mean_mrpm = mean_mrpm;
    c->limit_mrpm = p->spindle_limit_mrpm;
    c->sense = direction;
    c->lag_q16 = cam_sat_i32(
        cam_units_scale((int64_t)p->spindle_lag_us * tick_hz, INT64_C(1) << 16, plan_us_hz));
    c->mean_q32 = (int32_t)cam_clamp_i64(mean_q32, 0, INT64_C(1) << 26);
}

/// Turns over which a stop lets the feed fall: while it does, Z and X take half of their
/// accelerations for it, and at least two. The other half is for the form of the part.
/// @param most_mrpm  [r/min / 1000] highest speed of the spindle
/// @return           [turn] at most the ramp of the cut
static int64_t stop_ramp_q32(const cam_play_config_t *c, const cam_params_t *p,
                             const cam_table_t *table, uint32_t most_mrpm)
{
    const uint32_t rpm = most_mrpm / 1000u + 1u;
    const uint64_t even = (uint64_t)c->feed_nm * rpm * rpm / UINT64_C(3600000000) + 1u; // [mm/s2]
    const uint64_t z = cam_scaled_up_u64(even, table->way_slope_ppm, 1000000);
    const uint64_t along = table->has_stations ? even : z; // the heights of the table
    const uint64_t x = cam_scaled_up_u64(along, table->x_slope_ppm, 1000000);
    const uint64_t z_turns = 2u * z / (uint64_t)p->z_acceleration_mm_per_s2 + 1u;
    const uint64_t x_turns = 2u * x / (uint64_t)p->x_acceleration_mm_per_s2 + 1u;
    const uint64_t turns = cam_greater_u64(2u, cam_greater_u64(z_turns, x_turns));
    const uint64_t most = (uint64_t)p->feed_ramp_turns;
    return cam_smaller_i64((int64_t)(turns < most ? turns : most) * CAM_TURN_Q32, c->ramp_q32);
}

static uint32_t reciprocal_q31(int64_t ramp_q32)
{
    return (uint32_t)(((UINT64_C(1) << 63) - 1u) / (uint64_t)ramp_q32);
}

/// The feed in turns is rounded down by less than 2^-32, heights to nearest: the last is reached.
static void build_feed(cam_play_config_t *c, const cam_params_t *p, const cam_table_t *table,
                       uint32_t most_mrpm, uint32_t tick_hz)
{
    const int64_t span_nm = (int64_t)table->z_last_nm - table->z_first_nm;
    c->feed_nm = p->feed_nm > 0 ? p->feed_nm : (int32_t)table->feed_nm;
    const int64_t fed_q32 =
        span_nm / c->feed_nm * CAM_TURN_Q32 + span_nm % c->feed_nm * CAM_TURN_Q32 / c->feed_nm;
    c->ramp_q32 = cam_clamp_i64(fed_q32, CAM_TURN_Q32 / 2, p->feed_ramp_turns * CAM_TURN_Q32);
    c->per_ramp_q31 = reciprocal_q31(c->ramp_q32);
    c->stop_ramp_q32 = stop_ramp_q32(c, p, table, most_mrpm);
    c->per_stop_q31 = reciprocal_q31(c->stop_ramp_q32);
    c->feed_q32 = fed_q32 + c->ramp_q32;
    c->z_margin_nm = p->z_margin_nm;
    c->z_first_nm = table->z_first_nm;
    c->z_low_nm = cam_sat_i32((int64_t)table->z_first_nm - p->z_margin_nm);
    c->z_high_nm = cam_sat_i32((int64_t)cam_feed_profile_z_last_nm(table) + p->z_margin_nm);
    const int64_t wanted_mrpm =
        p->spindle_mrpm > 0 ? p->spindle_mrpm : (int64_t)table->spindle_mrpm;
    const uint32_t speed_mrpm = (uint32_t)cam_clamp_i64(wanted_mrpm, 0, p->spindle_limit_mrpm);
    c->spindle_mrpm = (int32_t)speed_mrpm * table->direction;
    build_speed(&c->speed, p, table->direction, (int32_t)speed_mrpm, tick_hz);
    if (table->is_ring_helix && !c->is_z_measured) { // its ramps are for the commanded speed
        c->rings = cam_feed_rings((uint32_t)c->feed_nm, (int32_t)span_nm, speed_mrpm,
                                  (uint32_t)p->z_acceleration_mm_per_s2);
        c->feed_q32 = cam_feed_turns_q32(&c->rings);
    }
}

/// Shifts that scale products to full words: k bits bring the speed to 2^30, R = knots per
/// tick.
///     y:   nm / 2^(4 + frac), times scale_q30 / 2^32, to nm / 2^6
///     d1:  nm / 2^(4 + frac) per knot, times R scale = rate 2^(log2 knots - k - 30), to nm / 2^10
///     d2:  ... times R^2 scale = rate2 2^(2 log2 knots - 2 k - 30), to nm / 2^10
/// k is limited so that the high word of d1 rate is never shifted down; frac <= 8.
static void build_u_scale(cam_u_scale_t *c, const cam_channel_t *u, int32_t speed_max_q32)
{
    const int32_t knots = (int32_t)(u->log2_knots + u->log2_repeat);
    const int32_t frac = (int32_t)u->frac_bits;
    const int32_t least_k = knots > max_rate_bits + 2 ? knots - max_rate_bits - 2 : 0;
    const int32_t v_bits = 8 + knots - frac;
    int32_t k = cam_clamp_i32(v_bits, least_k, most_speed_shift);
    while (k > least_k && (int64_t)speed_max_q32 << k >= INT64_C(1) << 30) {
        k--;
    }
    const int32_t a_bits = 24 + frac + 2 * k - 2 * knots;
    c->speed_shift = (uint32_t)k;
    c->y_up = (uint32_t)(frac < 4 ? 4 - frac : 0);
    c->scale_down = (uint32_t)(frac > 4 ? frac - 4 : 0);
    c->offset = u->value_offset * (256 >> c->y_up);
    c->v_up = (uint32_t)(v_bits - k);
    c->a_down = (uint32_t)(a_bits > 31 ? a_bits - 31 : 0);
    c->a_shift = (uint32_t)a_bits - c->a_down;
    const int32_t alpha_bits = 40 - 2 * k + knots + (int32_t)c->a_down;
    c->alpha_shift = (uint32_t)cam_clamp_i32(alpha_bits, 1, 62);
}

/// The gain, speed over distance, is such that slowing down stays within the acceleration and a
/// set-point covers at most a quarter of the distance.
static cam_swing_limits_t swing_limits(int64_t speed_mdeg_per_s, int64_t acceleration_deg_per_s2,
                                       uint32_t tick_hz)
{
    const int64_t most = INT64_C(1) << 24;      // a turn in 256 ticks
    const int64_t most_step = INT64_C(1) << 30; // a quarter of a turn per tick, from plan to plan
    const int64_t plan_ticks = cam_plan_ticks(tick_hz);
    const int64_t speed =
        cam_units_scale(speed_mdeg_per_s, CAM_TURN_Q32 / 64, (int64_t)tick_hz * 5625);
    const int64_t per_tick2 = cam_units_scale(acceleration_deg_per_s2 * plan_ticks,
                                              CAM_TURN_Q32 / 8, (int64_t)tick_hz * tick_hz * 45);
    const int64_t speed_q32 = cam_clamp_i64(speed, 1, most);
    const int64_t step_q32 = cam_clamp_i64(per_tick2, 1, most_step);
    const int64_t gain = step_q32 * (CAM_TURN_Q32 / plan_ticks) / speed_q32;
    return (cam_swing_limits_t){
        .speed_q32 = (int32_t)speed_q32,
        .step_q32 = (int32_t)step_q32,
        .gain_q32 = (int32_t)cam_clamp_i64(gain, 1, CAM_TURN_Q32 / (4 * plan_ticks)),
    };
}

/// @return [ticks^2] half the square, at most 2^21: products with it fit 62 bits
static int32_t half_square(int64_t ticks_q16)
{
    const int64_t ticks_q8 = ticks_q16 >> 8;
    return (int32_t)cam_clamp_i64((ticks_q8 * ticks_q8) >> 17, 0, 1 << 21);
}

/// The channel is read in LSB / 16 of 2^-(30 + frac) turn.
static void build_swing(cam_swing_config_t *c, const cam_params_t *p, const cam_channel_t *ch,
                        uint32_t tick_hz)
{
    c->lag_q16 = cam_units_ticks_of_ns(p->swing_lag_ns, tick_hz);
    c->following_q32 = cam_units_turn_of_mdeg(p->swing_following_limit_mdeg);
    c->unit_q30 = cam_sat_i32((INT64_C(1) << 31) >> ch->frac_bits);
    c->offset_q30 = ch->value_offset * 16;
    const int32_t line_q16 = (cam_plan_ticks(tick_hz) + 1) * 65536;
    c->is_swung = true;
    c->ahead_q16 = c->lag_q16 + line_q16;
    c->ahead2 = half_square(c->ahead_q16);
    c->full = swing_limits(p->swing_speed_mdeg_per_s, p->swing_acceleration_deg_per_s2, tick_hz);
    c->gentle =
        swing_limits(p->swing_speed_mdeg_per_s / cam_derived_limits_approach_share,
                     p->swing_acceleration_deg_per_s2 / cam_derived_limits_approach_share, tick_hz);
}

/// X, Z and U are predicted to the next plan and by their lags, the speed ratio to the next plan. U
/// uses the height that a geared Z reaches after its own lag, or that a measured Z has. While the
/// spindle accelerates, two equal poles lag by the square of half their lag more.
static void build_plan(cam_play_config_t *c, uint32_t tick_hz)
{
    const int32_t ticks = cam_plan_ticks(tick_hz);
    const int32_t lag_q16 = c->xz_lag_q16;
    c->plan_ticks = ticks;
    c->per_plan_q30 = (INT32_C(1) << 30) / ticks;
    c->xz_plan_q16 = lag_q16 + ticks * 65536;
    c->u_plan_q16 = c->lead_q16 + ticks * 65536;
    c->commanded_q16 = lag_q16 > c->lead_q16 ? lag_q16 : c->lead_q16;
    // In force from the next tick to the one after the plan, when the spindle has the ratio of that
    // angle: a longer prediction would modulate the removal rate by twice the additional angle
    // times the largest r' / r.
    c->ratio_q16 = (ticks + 1) * 65536;
    c->xz_lag2 = half_square(c->xz_plan_q16) - half_square(lag_q16) / 2;
}

/// @param is_rehearsed  false where the speed is modulated, because nothing is learned then
static void build_play(cam_play_config_t *c, const cam_params_t *p, int32_t sense,
                       bool is_rehearsed, uint32_t tick_hz)
{
    c->lead_q16 = cam_units_ticks_of_ns(p->lead_ns, tick_hz);
    c->xz_lag_q16 = cam_units_ticks_of_ns(p->xz_lag_ns, tick_hz);
    c->phase_q32 = cam_units_turn_of_udeg(sense * p->phase_udeg);
    c->phase_step_q32 =
        (int32_t)(cam_units_turn_of_udeg(p->phase_rate_udeg_per_s) / (int64_t)tick_hz) + 1;
    c->amplitude_q30 = (int32_t)cam_units_scale(p->amplitude_ppm, INT64_C(1) << 30, 1000000);
    c->amplitude_step_q30 = (int32_t)cam_units_scale(p->amplitude_rate_ppm_per_s, INT64_C(1) << 30,
                                                     (int64_t)tick_hz * 1000000) +
                            1;
    c->engage_q32 = p->engage_turns * CAM_TURN_Q32;
    c->disengage_q32 = p->disengage_turns * CAM_TURN_Q32;
    c->per_engage_q31 = (uint32_t)((UINT32_C(1) << 31) / (uint32_t)p->engage_turns);
    c->per_disengage_q31 = (uint32_t)((UINT32_C(1) << 31) / (uint32_t)p->disengage_turns);
    c->settle_q32 = is_rehearsed ? cam_build_settle_turns(p) * CAM_TURN_Q32 : 0;
    c->rehearse_q32 = is_rehearsed ? p->rehearse_turns * CAM_TURN_Q32 : 0;
    c->is_z_measured = p->z_is_measured != 0;
    c->dwell_ticks = (uint32_t)cam_units_scale(p->enable_dwell_ms, tick_hz, 1000) + 1u;
    c->turning_q32 = cam_build_speed_q32((uint32_t)p->stopped_mrpm, tick_hz);
    c->agreeing_q16 = 65536u / (uint32_t)agreeing_part + 65536u / (uint32_t)p->counts_per_turn + 1u;
    build_plan(c, tick_hz);
}

/// [nm / 1024 per tick or plan] limit of speeds and accelerations, so that their sum fits a word
#define MOST_Q10 (INT64_C(1) << 29)

static cam_motion_limits_t within_word(int64_t speed_q10, int64_t acceleration_q10)
{
    return (cam_motion_limits_t){
        .speed_q10 = (int32_t)cam_clamp_i64(speed_q10, 1, MOST_Q10),
        .acceleration_q10 = (int32_t)cam_clamp_i64(acceleration_q10, 1, MOST_Q10),
    };
}

static cam_motion_limits_t per_tick(int32_t speed_um_per_s, int32_t acceleration_mm_per_s2,
                                    uint32_t tick_hz)
{
    return within_word(
        cam_units_scale(speed_um_per_s, 1024000, tick_hz),
        cam_units_scale(acceleration_mm_per_s2, 1024000000, (int64_t)tick_hz * tick_hz));
}

static cam_motion_limits_t per_plan(cam_motion_limits_t limits, int32_t plan_ticks)
{
    return within_word((int64_t)limits.speed_q10 * plan_ticks,
                       (int64_t)limits.acceleration_q10 * plan_ticks * plan_ticks);
}

/// @return limits with their jerk window; its sum of n values limits the acceleration to 2^30 / n
static cam_motion_limits_t windowed(cam_motion_limits_t limits, uint32_t log2_window)
{
    const int32_t most_q10 = cam_jerk_filter_most_q10(log2_window);
    limits.acceleration_q10 =
        limits.acceleration_q10 < most_q10 ? limits.acceleration_q10 : most_q10;
    limits.log2_window = log2_window;
    return limits;
}

/// U moves per tick, X and Z per plan.
static void build_limits(cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const cam_motion_limits_t full[hal_n_axes] = {
        [hal_axis_u] = per_tick(p->u_speed_um_per_s, p->u_acceleration_mm_per_s2, tick_hz),
        [hal_axis_x] = per_tick(p->x_speed_um_per_s, p->x_acceleration_mm_per_s2, tick_hz),
        [hal_axis_z] = per_tick(p->z_speed_um_per_s, p->z_acceleration_mm_per_s2, tick_hz),
    };
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const int32_t ticks = i == (uint32_t)hal_axis_u ? 1 : c->play.plan_ticks;
        const cam_motion_limits_t gentle = {
            .speed_q10 = full[i].speed_q10 / cam_derived_limits_approach_share + 1,
            .acceleration_q10 = full[i].acceleration_q10 / cam_derived_limits_approach_share + 1,
        };
        const uint32_t log2 = cam_gains_log2_window(p, (hal_axis_t)i, tick_hz);
        c->play.approach[i] = windowed(per_plan(gentle, ticks), log2);
        c->play.leave[i] = windowed(per_plan(full[i], ticks), log2);
    }
    c->guard.u = c->play.leave[hal_axis_u];
}

/// @return [counts] change of the predicted position from plan to plan, beyond that of the speed,
///         when the spindle's acceleration reverses: the prediction by the square of the time
static int32_t reversal_counts(const cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int64_t per_mrad_q32 = 683566; // 2^32 / 2000 pi
    const int64_t alpha_q32 = cam_units_scale(p->spindle_acceleration_mrad_per_s2, per_mrad_q32,
                                              (int64_t)tick_hz * tick_hz);
    const int64_t ahead_q1 = (c->play.xz_plan_q16 >> 15) + 1; // rounded up, like the acceleration
    const int64_t turn_q32 =
        cam_smaller_i64(ahead_q1 * ahead_q1 * (alpha_q32 + 1) >> 2, INT64_C(1) << 32);
    return (int32_t)((turn_q32 * c->spindle.counts_per_turn) >> 32) + 1;
}

/// @return [counts] change of the predicted position from plan to plan: the reversal of the
///         spindle's acceleration, and a step of the encoder within the jump window or the
///         observer's response to a count: w T counts per tick times the prediction, of which half
///         is the most seen. At most a quarter of a turn.
static int32_t prediction_counts(const cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int64_t ahead_q47 = (int64_t)c->spindle.kp_q31 * c->play.xz_plan_q16; // kp = 2 w T
    const int32_t observed = 1 + (int32_t)(ahead_q47 >> 49);
    const int32_t seen = observed > c->spindle.jump_window ? observed : c->spindle.jump_window;
    return (int32_t)cam_smaller_i64((int64_t)seen + reversal_counts(c, p, tick_hz),
                                    c->spindle.counts_per_turn / 4);
}

/// Limits of the commands of X and Z from plan to plan: twice the change by their acceleration and
/// by the noise of the spindle's angle times their travel per turn; for the speed once. Z travels
/// by the feed; X also by its clearance, as a smooth step over whole turns at 15/8 of its mean
/// speed. A measured Z is not limited, and X follows its measurement from plan to plan.
static void build_command(cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int32_t ticks = c->play.plan_ticks;
    const int64_t noise = prediction_counts(c, p, tick_hz);
    const int64_t ramp_q32 = cam_smaller_i64(c->play.engage_q32, c->play.disengage_q32);
    const int64_t clearing_nm =
        (int64_t)c->play.x_clearance_nm * 15 / (8 * (ramp_q32 / CAM_TURN_Q32));
    cam_axis_command_config_t *t = &c->command;
    for (uint32_t i = (uint32_t)hal_axis_x; i <= (uint32_t)hal_axis_z; i++) {
        const cam_motion_limits_t *full = &c->play.leave[i]; // per plan
        const int64_t vel_q10 = full->speed_q10 / ticks;
        const int64_t change_q10 = full->acceleration_q10 / ticks;
        const int64_t ticks_counts = (int64_t)c->spindle.counts_per_turn * ticks;
        const int64_t travel_nm =
            c->play.feed_nm + (i == (uint32_t)hal_axis_x ? clearing_nm : 0); // per turn
        const int64_t noise_q10 = travel_nm * noise * 256 / ticks_counts * 4;
        const int64_t most_q10 = vel_q10 + vel_q10 / 16 + noise_q10 + MARGIN_Q10;
        const bool is_measured = c->play.is_z_measured && i == (uint32_t)hal_axis_z;
        const int64_t command_q10 = 2 * (change_q10 + noise_q10) + MARGIN_Q10;
        t->vel_q10[i] = is_measured ? INT32_MAX : cam_sat_i32(most_q10);
        t->change_q10[i] = is_measured
                               ? INT32_MAX
                               : cam_sat_i32(c->play.is_z_measured ? 2 * most_q10 : command_q10);
        t->jump_q10[i] = is_measured ? INT32_MAX : 4 * ticks; // rounding of equal increments
    }
}

/// @return limits of jogging: no faster than an axis can brake within the 2^31 units that
///         cam_move_profile_to_isr() looks ahead, v (v + a) <= 2 a 2^31
static cam_motion_limits_t jog_limits(int32_t jog_um_per_s, int32_t speed_um_per_s,
                                      int64_t acceleration_q10, int32_t plan_ticks,
                                      uint32_t tick_hz)
{
    const int32_t um_per_s = jog_um_per_s < speed_um_per_s ? jog_um_per_s : speed_um_per_s;
    const int64_t a_q10 = cam_clamp_i64(acceleration_q10, 1, MOST_Q10);
    const int64_t root_q10 = (int64_t)cam_root_u64((uint64_t)a_q10 << 32);
    const int64_t most_q10 = cam_clamp_i64(root_q10 - a_q10, 1, MOST_Q10);
    const int64_t speed_q10 = (int64_t)um_per_s * 1024000 * plan_ticks / tick_hz;
    return (cam_motion_limits_t){.speed_q10 = (int32_t)cam_clamp_i64(speed_q10, 1, most_q10),
                                 .acceleration_q10 = (int32_t)a_q10};
}

static void build_jog(cam_config_t *config, const cam_params_t *p, uint32_t tick_hz)
{
    const cam_motion_limits_t *gentle = config->play.approach;
    const int32_t n = config->play.plan_ticks;
    cam_jog_config_t *jog = &config->play.jog;
    // U moves per tick, but its jog speed is per plan as for X and Z.
    const int64_t u_q10 = (int64_t)gentle[hal_axis_u].acceleration_q10 * n * n;
    jog->limits[hal_axis_u] = jog_limits(p->u_jog_um_per_s, p->u_speed_um_per_s, u_q10, n, tick_hz);
    jog->limits[hal_axis_u].acceleration_q10 = gentle[hal_axis_u].acceleration_q10;
    jog->limits[hal_axis_x] = jog_limits(p->x_jog_um_per_s, p->x_speed_um_per_s,
                                         gentle[hal_axis_x].acceleration_q10, n, tick_hz);
    jog->limits[hal_axis_z] = jog_limits(p->z_jog_um_per_s, p->z_speed_um_per_s,
                                         gentle[hal_axis_z].acceleration_q10, n, tick_hz);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        jog->limits[i].log2_window = gentle[i].log2_window;
    }
    // Braking in steps may overshoot by an eighth of the acceleration (cam_motion.h).
    const int64_t over_q10 = jog->limits[hal_axis_u].acceleration_q10 / 8 + 1024;
    const int64_t end_q10 = (int64_t)p->u_stroke_nm * 512 - over_q10;
    jog->u_end_q10 = cam_clamp_i64(end_q10, 0, INT64_MAX) / 1024 * 1024;
}

static void build_guard(cam_guard_config_t *c, const cam_params_t *p, uint32_t speed_limit_mrpm,
                        uint32_t tick_hz)
{
    const cam_motion_limits_t *u = &c->u;
    c->overspeed_q32 = cam_build_speed_q32(speed_limit_mrpm, tick_hz);
    c->stopped_ticks = (uint32_t)cam_units_scale(p->stopped_ms, tick_hz, 1000);
    c->homing_ticks = c->stopped_ticks * homing_patience;
    c->u_vel_q6 = (u->speed_q10 + u->speed_q10 / 16 + MARGIN_Q10) / 16;
    c->u_acc_q6 = (u->acceleration_q10 + u->acceleration_q10 / 16 + MARGIN_Q10) / 16;
    c->u_acc_off_q6 = c->u_acc_q6 + c->u_vel_q6;
    c->range_nm = p->u_stroke_nm / 2;
    const int32_t due_q16 = cam_units_ticks_of_ns(p->lead_ns + p->u_scale_latency_ns, tick_hz);
    c->due_ticks = (uint32_t)due_q16 >> 16;
    c->due_part_q31 = (due_q16 & 0xFFFF) * 32768;
}

/// @return [ticks^2 / 2^16] k2, corrected for half the attenuation by holding a set-point for a
///         tick, MATHS.md (189); the whole would be right at the ticks only. A k2 smaller than that
///         is unchanged.
static int32_t held_k2_q16(int32_t k2_us2, uint32_t tick_hz)
{
    const int32_t hold_q16 = 65536 / 48;
    const int32_t k2_q16 = cam_units_ticks2_of_us2(k2_us2, tick_hz);
    return k2_q16 > hold_q16 ? k2_q16 - hold_q16 : k2_q16;
}

cam_refusal_t cam_build_config(cam_config_t *config, const cam_params_t *params,
                               const cam_table_t *table, uint32_t speed_limit_mrpm,
                               uint32_t tick_hz, uint32_t clock_hz)
{
    cam_force_config_t force;
    cam_refusal_t refusal = cam_derived_limits_check(params, tick_hz);
    if (refusal.err == cam_ok) {
        refusal = cam_build_force(&force, params, tick_hz);
    }
    if (refusal.err != cam_ok) {
        return refusal;
    }
    *config = (cam_config_t){.generation = config->generation, .force = force};
    cam_config_tie(config, table != NULL);
    // Tables and observer use angles in the sense of cutting, parameters those of the drawing.
    const int32_t sense = table != NULL ? table->direction : 1;
    build_spindle(&config->spindle, params, sense, tick_hz, clock_hz);
    build_still(&config->spindle, table);
    const bool is_swung = table != NULL && table->is_swung && params->swing_speed_mdeg_per_s > 0;
    const bool is_rehearsed = table != NULL && table->speed.knots == NULL;
    build_play(&config->play, params, sense, is_rehearsed, tick_hz);
    config->play.rehearse_x_q10 = (int64_t)cam_demand_half_stroke_nm(table, params) * 1024;
    config->play.x_clearance_nm = cam_demand_clearance_nm(table, params);
    if (is_swung) {
        build_swing(&config->play.swing, params, &table->angle, tick_hz);
    }
    if (table != NULL) {
        config->table = *table;
        config->play.x_clear_q10 =
            ((int64_t)table->x_max_nm + params->x_trim_nm + config->play.x_clearance_nm) * 1024;
        config->play.x_offset_q10 = (int64_t)table->x.value_offset * 1024;
        build_feed(&config->play, params, table, speed_limit_mrpm, tick_hz);
        // Scaled for the spindle's limit, not its speed: the scale must not change in the cut.
        const int32_t limit_q32 =
            cam_build_speed_q32((uint32_t)params->spindle_limit_mrpm, tick_hz);
        config->play.height_max_q32 = ((int64_t)table->u.n_slices - 1) * CAM_TURN_Q32 - height_end;
        build_u_scale(&config->play.u, &table->u, cam_sat_i32(INT64_C(5) * limit_q32 / 4));
    }
    config->command.configured =
        (cam_u_gains_t){.k1_q16 = cam_units_ticks_of_ns(params->k1_ns, tick_hz),
                        .k2_q16 = held_k2_q16(params->k2_us2, tick_hz),
                        .friction_q14 = params->u_friction_nm * 16384};
    build_limits(config, params, tick_hz);
    build_command(config, params, tick_hz);
    build_jog(config, params, tick_hz);
    cam_changes_build(&config->play, params, tick_hz);
    build_guard(&config->guard, params, speed_limit_mrpm, tick_hz);
    config->guard.following_nm = cam_derived_limits_following_nm(params, table);
    config->guard.approach_nm = cam_derived_limits_approach_nm(params, table, tick_hz);
    cam_build_force_limits(config, params);
    config->play.u_retract_q10 = retract_q10(params, table, &config->guard.u);
    config->guard.u_retract_q10 = config->play.u_retract_q10;
    return refusal;
}

void cam_build_origin(cam_config_t *config, int32_t x_nm, int32_t z_nm)
{
    cam_play_config_t *c = &config->play;
    c->x_clear_q10 += (int64_t)x_nm * 1024;
    c->x_offset_q10 += (int64_t)x_nm * 1024;
    c->z_origin_nm = z_nm;
    c->z_low_nm = cam_sat_i32((int64_t)c->z_low_nm + z_nm);
    c->z_high_nm = cam_sat_i32((int64_t)c->z_high_nm + z_nm);
}
