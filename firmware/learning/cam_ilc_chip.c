// SPDX-License-Identifier: Apache-2.0
#include "cam_learning_inner.h"
#include "cam_doubles.h" // cam_limit, cam_nearest
#include "cam_fix.h"     // cam_abs_i64, cam_sat_i32

enum {
    least_feed_nm = 1500, ///< below it the force of the chip is small
    change_part = 128,    ///< smallest change of the feed that is followed
    change_nm = 500,
};

bool cam_ilc_chip_is_cut(const cam_ilc_t *t)
{
    return t->phase == cam_ilc_cutting && t->correction.is_probed && !t->is_feed_falling &&
           cam_abs_i64(t->feed_nm) >= least_feed_nm;
}

/// @return a coefficient after a step, whose change is found at the feed of the turn. What is
///         played at that feed stays within its limit.
static int32_t stepped(cam_ilc_t *t, int32_t value_q32, double change_q32, int32_t gain_q16)
{
    const double per_feed = cam_ilc_chip_feed_nm / (double)cam_abs_i64(t->feed_nm);
    const double step_q32 = cam_limit(change_q32, 0x1p30) * gain_q16 * 0x1p-16;
    const double next_q32 = value_q32 + step_q32 * per_feed;
    const double within_q32 = cam_limit(cam_limit(next_q32, t->chip_most_q32 * per_feed), 0x1p31);
    t->is_limited = t->is_limited || next_q32 != within_q32;
    return cam_nearest(within_q32);
}

/// @return the coefficient of the mean: of the same sense as that of the set-point, and no larger
static int32_t mean_q32(const cam_ilc_t *t)
{
    const int32_t a_q32 = t->drive.chip_q32;
    return cam_clamp_i32(t->chip_mean_q32, a_q32 < 0 ? a_q32 : 0, a_q32 > 0 ? a_q32 : 0);
}

void cam_ilc_chip_step(cam_ilc_t *t, int32_t share_q32, int32_t gain_q16)
{
    t->drive.chip_q32 = stepped(t, t->drive.chip_q32, share_q32, gain_q16);
}

void cam_ilc_chip_step_mean(cam_ilc_t *t, int32_t error_q6, int32_t depth_nm, int32_t gain_q16)
{
    const int32_t response_q12 = t->correction.gain[0].re;
    const int32_t mean_nm = depth_nm + t->mean_nm;
    if (response_q12 > cam_gain_one_q12 / 4 && mean_nm > 0) {
        const double share_q32 = error_q6 * 0x1p26 / mean_nm * cam_gain_one_q12 / response_q12;
        t->chip_mean_q32 = stepped(t, mean_q32(t), share_q32, gain_q16);
    }
}

void cam_ilc_chip_follow_gap(cam_ilc_t *t)
{
    const uint64_t floor_q6 = cam_ilc_update_guarded_q6(t);
    const bool is_new = t->phase == cam_ilc_cutting && t->square / 4u > t->last_square &&
                        t->square > floor_q6 * floor_q6;
    if (is_new) {
        t->calm_square = t->is_paused ? t->calm_square : 4u * t->last_square;
        t->best_square = UINT64_MAX;
        t->n_steps = 0; // layer 2 learns with the larger gain
    }
    t->is_paused = (is_new || t->is_paused) && t->square > floor_q6 * floor_q6 + t->calm_square;
    t->last_square = t->square;
}

void cam_ilc_chip_follow(cam_ilc_t *t, cam_state_t state, const cam_turn_bins_t *bins)
{
    const int64_t vel_q10 = atomic_load_explicit(&bins->z_vel_q10, memory_order_relaxed);
    const bool is_fed = state == cam_state_cutting && t->turn_speed_q32 > 0;
    t->feed_now_nm = is_fed ? cam_sat_i32(cam_abs_i64(vel_q10) * (1 << 22) / t->turn_speed_q32) : 0;
}

bool cam_ilc_chip_is_due(const cam_ilc_t *t)
{
    const int64_t change = cam_abs_i64((int64_t)t->feed_now_nm - t->chip_feed_nm);
    const bool is_other = change > t->feed_now_nm / change_part + change_nm;
    return is_other && (t->drive.chip_q32 != 0 || t->chip_mean_q32 != 0);
}

static double at_feed(cam_ilc_t *t, int32_t value_q32)
{
    const double share_q32 = (double)value_q32 * t->feed_now_nm / cam_ilc_chip_feed_nm;
    const double within_q32 = cam_limit(share_q32, t->chip_most_q32);
    t->is_limited = t->is_limited || share_q32 != within_q32;
    return within_q32;
}

bool cam_ilc_chip_blend(cam_ilc_t *t, int32_t depth_nm, int32_t most_nm, cam_learned_t *in)
{
    const double share_q32 = at_feed(t, t->drive.chip_q32);
    const double depth = (double)depth_nm + t->mean_nm;
    const double mean_q6 = (at_feed(t, mean_q32(t)) * depth - share_q32 * t->mean_nm) * 0x1p-26;
    const int64_t most_q32 = ((int64_t)most_nm << 32) / ((int64_t)t->largest / 64 + 1);
    const bool is_share = cam_ilc_slew(&in->chip_q32, cam_nearest(share_q32), most_q32);
    const bool is_mean = cam_ilc_slew(&in->chip_q6, cam_nearest(mean_q6), INT64_C(64) * most_nm);
    t->chip_feed_nm = is_share && is_mean ? t->feed_now_nm : t->chip_feed_nm;
    return is_share && is_mean;
}
