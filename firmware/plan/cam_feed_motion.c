// SPDX-License-Identifier: Apache-2.0
#include "cam_plan_inner.h"
#include "cam_fix.h"    // CAM_TURN_Q32, cam_angle_next_turn, cam_clamp_i32, cam_wrap_add_i64, ..
#include "cam_motion.h" // cam_feed_height_nm_isr, cam_feed_ring_end_q32

/// Most halvings of a rate that is too high for the remaining part: down to 1/128.
enum { most_halvings = 7 };

/// Master positions are counters: their sums and differences wrap.
static int64_t plus(int64_t a, int64_t b)
{
    return cam_wrap_add_i64(a, b);
}

static int64_t minus(int64_t a, int64_t b)
{
    return cam_wrap_sub_i64(a, b);
}

static int64_t later(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

/// @return a * b / 2^n rounded down, for a quotient below 2^63; exact where b is 2^n
static int64_t times(int64_t a, int32_t b, uint32_t n)
{
    const int32_t low = (int32_t)(a & ((INT64_C(1) << n) - 1));
    return plus(cam_wrap_times_i64(a >> n, b), ((int64_t)low * b) >> n);
}

/// @return [turn] length of a ramp
static int64_t ramp_q32(const cam_play_config_t *cfg, int32_t by_q30)
{
    return times(cfg->ramp_q32, by_q30, 30);
}

/// @param per_q31    [1/turn] change of the rate per turn of a ramp
/// @param turns_q32  [turn] of that ramp, 0 .. 150
/// @return           [1] change of the rate over them
static int32_t change_q30(uint32_t per_q31, int64_t turns_q32)
{
    return (int32_t)(((uint64_t)(uint32_t)(turns_q32 >> 8) * per_q31) >> 25);
}

/// @return [turn] feed over some turns in which the rate changes evenly from a to b
static int64_t fed_over_q32(int64_t turns_q32, int32_t a_q30, int32_t b_q30)
{
    return times(turns_q32, (a_q30 >> 1) + (b_q30 >> 1), 30);
}

/// @return [1] rate at a position before the end of the change
static int32_t rate_at_q30(const cam_feed_motion_t *c, const cam_play_config_t *cfg,
                           int64_t pos_q32)
{
    const int64_t done_q32 = minus(pos_q32, c->from_q32);
    const int32_t by_q30 = done_q32 > 0 ? change_q30(cfg->per_ramp_q31, done_q32) : 0;
    return c->to_rate_q30 > c->rate_q30
               ? cam_clamp_i32(cam_wrap_add(c->rate_q30, by_q30), c->rate_q30, c->to_rate_q30)
               : cam_clamp_i32(cam_wrap_sub(c->rate_q30, by_q30), c->to_rate_q30, c->rate_q30);
}

/// @return [turn] feed at a position before the brake
static int64_t fed_before_brake_q32(const cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                    int64_t pos_q32)
{
    if (pos_q32 >= c->to_q32) {
        return plus(c->fed_to_q32, times(minus(pos_q32, c->to_q32), c->to_rate_q30, 30));
    }
    const int32_t rate_q30 = rate_at_q30(c, cfg, pos_q32);
    return plus(c->fed_q32, fed_over_q32(minus(pos_q32, c->from_q32), c->rate_q30, rate_q30));
}

int32_t cam_feed_motion_fed_nm_isr(const cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                   int64_t pos_q32)
{
    const int64_t left_q32 = minus(c->end_q32, pos_q32);
    if (cfg->rings.is_on) {
        const int64_t until_q32 = left_q32 > 0 ? pos_q32 : c->end_q32;
        const int64_t done_q32 = minus(later(until_q32, c->to_q32), c->from_q32);
        return cam_feed_height_nm_isr(&cfg->rings, done_q32);
    }
    int64_t fed_q32 = c->fed_end_q32;
    if (pos_q32 < c->brake_q32) {
        fed_q32 = fed_before_brake_q32(c, cfg, pos_q32);
    } else if (left_q32 > 0) {
        const int32_t rate_q30 = change_q30(c->per_brake_q31, left_q32);
        fed_q32 = minus(fed_q32, fed_over_q32(left_q32, rate_q30, 0));
    } else { // at rest
    }
    return (int32_t)(plus(cam_wrap_times_i64(fed_q32, cfg->feed_nm), INT64_C(1) << 31) >> 32);
}

/// Schedule the end of the part after a change of rate.
/// @param left_q32  [turn] feed between change and brake, not negative; a second step removes the
///                  error of the rate's reciprocal
/// @param halvings  of the rate of the configuration
static void schedule_brake(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t left_q32,
                           int32_t halvings)
{
    const int32_t per_q24 = cfg->per_feed_rate_q24;
    const int64_t scale = INT64_C(1) << halvings;
    const int64_t near_q32 = cam_wrap_times_i64(times(left_q32, per_q24, 24), scale);
    const int64_t rest_q32 = minus(left_q32, times(near_q32, c->to_rate_q30, 30));
    const int64_t more_q32 = cam_wrap_times_i64(times(rest_q32, per_q24, 24), scale);
    c->brake_q32 = plus(plus(c->to_q32, near_q32), more_q32);
    c->end_q32 = plus(c->brake_q32, ramp_q32(cfg, c->to_rate_q30));
    c->fed_end_q32 = cfg->feed_q32 - cfg->ramp_q32;
    c->per_brake_q31 = cfg->per_ramp_q31;
    c->is_held = false;
}

/// Schedule a change to the rate of the configuration, and then the end of the part.
/// @param from_q32  [turn] master position at which it begins
/// @param fed_q32   [turn] feed there
/// @param rate_q30  [1] rate up to there
/// @return          false, without any change, if the part is too short for change and brake
static bool schedule_change(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t from_q32,
                            int64_t fed_q32, int32_t rate_q30, int32_t halvings)
{
    const int32_t to_rate_q30 = cfg->feed_rate_q30 >> halvings;
    const int32_t by_q30 = to_rate_q30 > rate_q30 ? to_rate_q30 - rate_q30 : rate_q30 - to_rate_q30;
    const int64_t turns_q32 = ramp_q32(cfg, by_q30);
    const int64_t more_q32 = fed_over_q32(turns_q32, rate_q30, to_rate_q30);
    const int64_t braked_q32 = fed_over_q32(ramp_q32(cfg, to_rate_q30), to_rate_q30, 0);
    const int64_t left_q32 =
        minus(minus(cfg->feed_q32 - cfg->ramp_q32, plus(more_q32, braked_q32)), fed_q32);
    if (left_q32 < 0) {
        return false;
    }
    c->from_q32 = from_q32;
    c->fed_q32 = fed_q32;
    c->rate_q30 = rate_q30;
    c->to_rate_q30 = to_rate_q30;
    c->to_q32 = plus(from_q32, turns_q32);
    c->fed_to_q32 = plus(fed_q32, more_q32);
    schedule_brake(c, cfg, left_q32, halvings);
    return true;
}

/// Begin to feed from rest, at a lower rate if the part is too short for the requested one.
static void schedule_begin(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t from_q32,
                           int64_t fed_q32)
{
    const int32_t rate_q30 = cfg->feed_rate_q30;
    const int64_t left_q32 = minus(cfg->feed_q32 - cfg->ramp_q32, fed_q32);
    int64_t needed_q32 = times(ramp_q32(cfg, rate_q30), rate_q30, 30);
    int32_t halvings = 0;
    while (needed_q32 > left_q32 && halvings < most_halvings) {
        needed_q32 >>= 2;
        halvings++;
    }
    if (!schedule_change(c, cfg, from_q32, fed_q32, 0, halvings)) {
        c->end_q32 = from_q32; // the remainder is below a micrometre
        c->is_held = false;
    }
}

/// Begin or continue from rest.
static void resume(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t next_q32)
{
    if (cfg->rings.is_on) {
        const int64_t done_q32 = later(minus(c->end_q32, c->from_q32), 0);
        c->from_q32 = later(c->from_q32, minus(next_q32, done_q32));
        c->to_q32 = plus(c->from_q32, done_q32); // Z rests until then
        c->end_q32 = plus(c->from_q32, cfg->feed_q32);
        c->is_held = false;
    } else {
        schedule_begin(c, cfg, later(c->from_q32, next_q32), c->fed_end_q32);
    }
}

void cam_feed_motion_begin_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t at_q32)
{
    c->from_q32 = at_q32; // assigned one by one: an initialiser of the whole would call memset
    c->to_q32 = at_q32;
    c->brake_q32 = at_q32;
    c->end_q32 = at_q32;
    c->fed_q32 = 0;
    c->fed_to_q32 = 0;
    c->fed_end_q32 = 0;
    c->rate_q30 = 0;
    c->to_rate_q30 = 0;
    c->per_brake_q31 = cfg->per_ramp_q31;
    c->requested_q30 = cfg->feed_rate_q30;
    c->is_held = cfg->feed_rate_q30 == 0;
    if (!c->is_held) {
        resume(c, cfg, at_q32);
    }
}

/// Bring the brake forward, so that the feed rests at a whole turn. A stop ends a change of the
/// rate and brakes more steeply. @return whether that is before the end of the part
static bool brake_early(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t next_q32,
                        bool is_stop)
{
    if (next_q32 <= c->from_q32 && c->rate_q30 == 0) {
        c->brake_q32 = next_q32;
        c->end_q32 = next_q32;
        c->fed_end_q32 = c->fed_q32;
        return true;
    }
    const bool is_cut = is_stop && next_q32 < c->to_q32;
    const int32_t rate_q30 = is_cut ? rate_at_q30(c, cfg, next_q32) : c->to_rate_q30;
    const int64_t to_q32 = is_cut ? next_q32 : c->to_q32;
    const int64_t braked_q32 = times(is_stop ? cfg->stop_ramp_q32 : cfg->ramp_q32, rate_q30, 30);
    const int64_t end_q32 = cam_angle_next_turn(plus(later(next_q32, to_q32), braked_q32));
    if (end_q32 >= c->end_q32) {
        return false;
    }
    c->fed_to_q32 = is_cut ? fed_before_brake_q32(c, cfg, next_q32) : c->fed_to_q32;
    c->to_q32 = to_q32;
    c->to_rate_q30 = rate_q30;
    c->brake_q32 = minus(end_q32, braked_q32);
    c->end_q32 = end_q32;
    c->per_brake_q31 = is_stop ? cfg->per_stop_q31 : cfg->per_ramp_q31;
    const int64_t even_q32 = plus(minus(c->brake_q32, to_q32), braked_q32 >> 1);
    c->fed_end_q32 = plus(c->fed_to_q32, times(even_q32, rate_q30, 30));
    return true;
}

/// Let a ring-helix rest as early as possible: at the begin of a ring for a hold, at the end of one
/// for a stop. @return whether that is before its end
static bool rest_rings(cam_feed_motion_t *c, int64_t next_q32, bool is_stop)
{
    const int64_t done_q32 = minus(next_q32, c->from_q32);
    int64_t rest_q32 = next_q32;
    if (done_q32 > 0) {
        const int64_t begin_q32 = plus(done_q32, done_q32 & CAM_TURN_Q32);
        rest_q32 = plus(c->from_q32, is_stop ? cam_feed_ring_end_q32(done_q32) : begin_q32);
    }
    const bool is_early = rest_q32 < c->end_q32;
    c->end_q32 = is_early ? rest_q32 : c->end_q32;
    return is_early;
}

/// Change the rate of a moving feed, or of one that has not begun.
/// @return false while a ramp is in progress
static bool change_rate(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t now_q32,
                        int64_t next_q32)
{
    if (cfg->rings.is_on) {
        return true; // has no other rate
    }
    if (next_q32 <= c->from_q32 && c->rate_q30 == 0) {
        schedule_begin(c, cfg, c->from_q32, c->fed_q32);
        return true;
    }
    if (now_q32 < c->to_q32) {
        return false;
    }
    if (next_q32 < c->brake_q32) { // near its end the feed stays as it is
        const int64_t fed_q32 = fed_before_brake_q32(c, cfg, next_q32);
        (void)schedule_change(c, cfg, next_q32, fed_q32, c->to_rate_q30, 0);
    }
    return true;
}

void cam_feed_motion_request_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t now_q32, int64_t next_q32)
{
    const int32_t rate_q30 = cfg->feed_rate_q30;
    bool is_done = true;
    if (rate_q30 == 0) {
        c->is_held = cfg->rings.is_on ? rest_rings(c, next_q32, false)
                                      : brake_early(c, cfg, next_q32, false);
    } else if (c->is_held) {
        is_done = now_q32 >= c->end_q32;
        if (is_done) {
            resume(c, cfg, next_q32);
        }
    } else {
        is_done = change_rate(c, cfg, now_q32, next_q32);
    }
    c->requested_q30 = is_done ? rate_q30 : c->requested_q30;
}

int64_t cam_feed_motion_stop_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t next_q32)
{
    const bool was_held = c->is_held;
    c->is_held = false;
    if (cfg->rings.is_on && !was_held) {
        (void)rest_rings(c, next_q32, true);
    } else if (!cfg->rings.is_on && next_q32 <= c->brake_q32) {
        (void)brake_early(c, cfg, next_q32, true);
    } else {
        // it brakes or rests already
    }
    return later(c->end_q32, next_q32); // Z may rest already, after a hold
}
