// SPDX-License-Identifier: Apache-2.0
#include "cam_feed_motion.h"
#include "cam_angle.h" // CAM_TURN_Q32, cam_angle_next_turn
#include "cam_feed.h"  // cam_feed_height_nm_isr, cam_feed_ring_end_q32
#include "cam_fix.h"   // cam_clamp_i64

/// Times that a rate is halved to fit what is left of the part: down to a 128th.
enum { most_halvings = 7 };

/// Positions and lengths lie far from the ends of 64 bits. Sums of them are computed modulo 2^64
/// nevertheless: it costs nothing, and no state, not even one that was changed from outside, is
/// undefined.
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
    const int64_t low = a & ((INT64_C(1) << n) - 1);
    return plus(cam_wrap_times_i64(a >> n, b), cam_wrap_times_i64(low, b) >> n);
}

/// @return [turn] fed while the rate rises from 0 for a number of turns, x^2 / 2r
static int64_t risen_q32(const cam_play_config_t *cfg, int64_t turns_q32)
{
    const int64_t turns_q24 = turns_q32 >> 8;
    const int64_t share_q31 = cam_wrap_times_i64(turns_q24, cfg->per_ramp_q31) >> 24;
    return cam_wrap_times_i64(share_q31, turns_q24) >> 24;
}

/// @return [turn] over which the rate changes by so much
static int64_t ramp_q32(const cam_play_config_t *cfg, int32_t by_q30)
{
    return times(cfg->ramp_q32, by_q30, 30);
}

/// @return [turn] fed at a position that lies before the brake
static int64_t fed_before_brake_q32(const cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                    int64_t pos_q32)
{
    if (pos_q32 >= c->to_q32) {
        return plus(c->fed_to_q32, times(minus(pos_q32, c->to_q32), c->to_rate_q30, 30));
    }
    const int64_t done_q32 = minus(pos_q32, c->from_q32);
    if (c->rate_q30 <= c->to_rate_q30 || done_q32 <= 0) {
        const int64_t more_q32 = done_q32 > 0 ? risen_q32(cfg, done_q32) : 0;
        return plus(plus(c->fed_q32, times(done_q32, c->rate_q30, 30)), more_q32);
    }
    const int64_t left_q32 = minus(c->to_q32, pos_q32);
    const int64_t less_q32 = plus(times(left_q32, c->to_rate_q30, 30), risen_q32(cfg, left_q32));
    return minus(c->fed_to_q32, less_q32);
}

int32_t cam_feed_motion_fed_nm_isr(const cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                   int64_t pos_q32)
{
    const int64_t left_q32 = minus(c->end_q32, pos_q32);
    if (cfg->rings.is_on) {
        const int64_t until_q32 = left_q32 > 0 ? pos_q32 : c->end_q32;
        const int64_t done_q32 = minus(later(until_q32, c->to_q32), c->from_q32);
        return cam_feed_height_nm_isr(&cfg->rings, done_q32,
                                      cam_feed_risen_q30_isr(&cfg->rings, done_q32));
    }
    const int64_t fed_q32 = pos_q32 < c->brake_q32
                                ? fed_before_brake_q32(c, cfg, pos_q32)
                                : minus(c->fed_end_q32, risen_q32(cfg, later(left_q32, 0)));
    return (int32_t)(plus(cam_wrap_times_i64(fed_q32, cfg->feed_nm), INT64_C(1) << 31) >> 32);
}

/// Lay the end of the part behind a change of the rate.
/// @param left_q32  [turn] to be fed behind the change and before the brake, not negative; what the
///                  reciprocal of the rate leaves out of it is added in a second step
/// @param halvings  the rate is that of the configuration, halved so often
static void lay_brake(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t left_q32,
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
    c->is_held = false;
}

/// Lay a change to the rate of the configuration, and behind it the end of the part.
/// @param from_q32  [turn] master position where it begins
/// @param fed_q32   [turn] fed there
/// @param rate_q30  [1] rate up to there
/// @return          false, and nothing is changed, where the part has no room for it and the brake
static bool lay_change(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t from_q32,
                       int64_t fed_q32, int32_t rate_q30, int32_t halvings)
{
    const int32_t to_rate_q30 = cfg->feed_rate_q30 >> halvings;
    const bool is_rising = to_rate_q30 > rate_q30;
    const int32_t by_q30 = is_rising ? to_rate_q30 - rate_q30 : rate_q30 - to_rate_q30;
    const int32_t slower_q30 = is_rising ? rate_q30 : to_rate_q30;
    const int64_t turns_q32 = ramp_q32(cfg, by_q30);
    const int64_t more_q32 =
        plus(times(turns_q32, slower_q30, 30), times(turns_q32, by_q30, 30) / 2);
    const int64_t braked_q32 = times(ramp_q32(cfg, to_rate_q30), to_rate_q30, 30) / 2;
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
    lay_brake(c, cfg, left_q32, halvings);
    return true;
}

/// Begin to feed from rest, with a lower rate where the part is not long enough for that asked for.
static void lay_begin(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t from_q32,
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
    if (!lay_change(c, cfg, from_q32, fed_q32, 0, halvings)) {
        c->end_q32 = from_q32; // what is left is below a micrometre
        c->is_held = false;
    }
}

/// Let the feed rest from a position on.
static void lay_rest(cam_feed_motion_t *c, int64_t at_q32, int64_t fed_q32)
{
    c->brake_q32 = at_q32;
    c->end_q32 = at_q32;
    c->fed_end_q32 = fed_q32;
}

void cam_feed_motion_begin_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t at_q32)
{
    c->from_q32 = at_q32;
    c->to_q32 = at_q32;
    c->fed_q32 = 0;
    c->fed_to_q32 = 0;
    c->rate_q30 = 0;
    c->to_rate_q30 = 0;
    c->requested_q30 = cfg->feed_rate_q30;
    c->is_held = false;
    lay_rest(c, at_q32, 0);
    if (cfg->feed_rate_q30 == 0) {
        c->is_held = true;
    } else if (cfg->rings.is_on) {
        c->end_q32 = plus(at_q32, cfg->feed_q32);
    } else {
        lay_begin(c, cfg, at_q32, 0);
    }
}

/// Bring the brake forward, so that the feed rests on a whole turn. @return whether that is before
/// the end of the part
static bool brake_early(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t next_q32)
{
    if (next_q32 <= c->from_q32 && c->rate_q30 == 0) {
        lay_rest(c, next_q32, c->fed_q32);
        return true;
    }
    const int64_t braked_q32 = ramp_q32(cfg, c->to_rate_q30);
    const int64_t end_q32 = cam_angle_next_turn(plus(later(next_q32, c->to_q32), braked_q32));
    if (end_q32 >= c->end_q32) {
        return false;
    }
    c->brake_q32 = minus(end_q32, braked_q32);
    c->end_q32 = end_q32;
    const int64_t even_q32 = times(minus(c->brake_q32, c->to_q32), c->to_rate_q30, 30);
    const int64_t last_q32 = times(braked_q32, c->to_rate_q30, 30) / 2;
    c->fed_end_q32 = plus(plus(c->fed_to_q32, even_q32), last_q32);
    return true;
}

/// @return [turn] where a ring-helix rests at the earliest: where a ring begins for a hold, where
/// one ends for a stop
static int64_t ring_q32(const cam_feed_motion_t *c, int64_t next_q32, bool is_end)
{
    const int64_t done_q32 = minus(next_q32, c->from_q32);
    if (done_q32 <= 0) {
        return next_q32;
    }
    const int64_t odd_q32 = done_q32 & CAM_TURN_Q32;
    const int64_t whole_q32 = is_end ? cam_feed_ring_end_q32(done_q32) : plus(done_q32, odd_q32);
    return plus(c->from_q32, whole_q32);
}

/// @return whether a ring-helix rests before its end
static bool rest_rings(cam_feed_motion_t *c, int64_t end_q32)
{
    const bool is_early = end_q32 < c->end_q32;
    c->end_q32 = is_early ? end_q32 : c->end_q32;
    return is_early;
}

/// Go on from rest.
static void feed_on(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t next_q32)
{
    if (cfg->rings.is_on) {
        const int64_t done_q32 = later(minus(c->end_q32, c->from_q32), 0);
        c->from_q32 = later(c->from_q32, minus(next_q32, done_q32));
        c->to_q32 = plus(c->from_q32, done_q32); // until then Z stays where it rests
        c->end_q32 = plus(c->from_q32, cfg->feed_q32);
        c->is_held = false;
    } else {
        lay_begin(c, cfg, later(c->from_q32, next_q32), c->fed_end_q32);
    }
}

/// Change the rate of a feed in motion, or of one that has not begun.
/// @return false while a ramp runs
static bool change_rate(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t now_q32,
                        int64_t next_q32)
{
    if (cfg->rings.is_on) {
        return true; // it knows no other rate
    }
    if (next_q32 <= c->from_q32 && c->rate_q30 == 0) {
        lay_begin(c, cfg, c->from_q32, c->fed_q32);
        return true;
    }
    if (now_q32 < c->to_q32) {
        return false;
    }
    if (next_q32 < c->brake_q32) {
        const int64_t fed_q32 = fed_before_brake_q32(c, cfg, next_q32);
        if (lay_change(c, cfg, next_q32, fed_q32, c->to_rate_q30, 0)) {
            return true;
        }
    }
    return true; // so near to its end the feed stays as it is
}

void cam_feed_motion_request_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t now_q32, int64_t next_q32)
{
    const int32_t rate_q30 = cfg->feed_rate_q30;
    if (rate_q30 == c->requested_q30) {
        return;
    }
    bool is_done = true;
    if (rate_q30 == 0) {
        c->is_held = cfg->rings.is_on ? rest_rings(c, ring_q32(c, next_q32, false))
                                      : brake_early(c, cfg, next_q32);
    } else if (c->is_held) {
        is_done = now_q32 >= c->end_q32;
        if (is_done) {
            feed_on(c, cfg, next_q32);
        }
    } else {
        is_done = change_rate(c, cfg, now_q32, next_q32);
    }
    c->requested_q30 = is_done ? rate_q30 : c->requested_q30;
}

int64_t cam_feed_motion_stop_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t next_q32)
{
    if (c->is_held) {
        c->is_held = false;
        return later(c->end_q32, next_q32);
    }
    if (cfg->rings.is_on) {
        (void)rest_rings(c, ring_q32(c, next_q32, true));
    } else {
        (void)brake_early(c, cfg, next_q32);
    }
    return later(c->end_q32, next_q32); // a second stop behind a hold finds Z at rest long since
}
