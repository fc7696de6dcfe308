// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_spindle.h"
#include "cam/cam_angle.h" // cam_angle_diff_q32
#include "cam/cam_fix.h"   // cam_clamp_i32

/// Counts in the sense of cutting: ~c = -c - 1 mirrors the half-open interval of a count, so that
/// adding half a count centres it for both senses.
static uint32_t sensed_counts(const cam_spindle_config_t *cfg, uint32_t counts)
{
    return counts ^ cfg->sign_mask;
}

/// An index edge lies on the boundary of a count: its mirror image is -c.
static uint32_t sensed_edge(const cam_spindle_config_t *cfg, uint32_t counts)
{
    return (counts ^ cfg->sign_mask) - cfg->sign_mask;
}

/// in_turn stays within one turn because a tick moves at most a quarter.
static void move_in_turn(cam_spindle_t *s, const cam_spindle_config_t *cfg, int32_t moved)
{
    const int32_t in_turn = s->in_turn + moved;
    const int32_t turn = cfg->counts_per_turn;
    s->in_turn = in_turn >= turn ? in_turn - turn : in_turn < 0 ? in_turn + turn : in_turn;
}

/// Whole and fraction of the reciprocal apart: the truncated fraction costs less than 2^-32 turn.
static uint32_t measured_q32(const cam_spindle_t *s, const cam_spindle_config_t *cfg)
{
    const uint32_t in_turn = (uint32_t)s->in_turn;
    return in_turn * cfg->turn_per_count_q32 +
           cam_mulhi_u32(in_turn, cfg->turn_per_count_fraction) + cfg->centre_q32;
}

CAM_STAGE static void start(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                            const cam_sense_t *in)
{
    s->is_started = true;
    s->clock = in->clock;
    s->max_period = cfg->tick_clocks;
    s->counts = sensed_counts(cfg, in->encoder.counts);
    s->n_index = in->encoder.n_index;
    s->pos_q32 = (int64_t)measured_q32(s, cfg);
}

/// First edge: the angle becomes known; the observer keeps its speed and its small error.
static void sync(cam_spindle_t *s, const cam_spindle_config_t *cfg)
{
    const uint32_t before_q32 = measured_q32(s, cfg);
    const int32_t lag_q32 = cam_angle_diff_q32(cam_angle_of_pos(s->pos_q32), before_q32);
    s->in_turn = 0;
    move_in_turn(s, cfg, cam_wrap_diff(s->counts, s->index_counts));
    s->pos_q32 = (int64_t)measured_q32(s, cfg) + lag_q32;
    s->is_synced = true;
}

/// Distance of two edges is 0 (the spindle turned back) or a turn; what is left is lost counts.
/// Their sum wraps only after it has been a fault all the way.
static uint32_t compare_edges(cam_spindle_t *s, const cam_spindle_config_t *cfg)
{
    const int32_t turn = cfg->counts_per_turn;
    const int32_t distance = s->edge_distance;
    const int32_t whole = distance > cfg->max_counts    ? turn
                          : distance < -cfg->max_counts ? -turn
                                                        : 0;
    s->index_error = cam_wrap_add(s->index_error, cam_wrap_sub(distance, whole));
    s->edge_distance = 0;
    return cam_is_within(s->index_error, cfg->index_tolerance) ? 0u : CAM_FAULT_BIT(lost_counts);
}

/// An index edge tells the angle, or how far it is from the last one: judged in the next tick.
CAM_STAGE static void take_index(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                 const cam_sense_t *in)
{
    const uint32_t edge = sensed_edge(cfg, in->encoder.index_counts);
    const int32_t distance = cam_wrap_diff(edge, s->index_counts);
    s->edge_distance = s->is_synced ? cam_wrap_add(s->edge_distance, distance) : 0;
    s->n_index = in->encoder.n_index;
    s->index_counts = edge;
    s->since_index = cam_wrap_diff(s->counts, edge);
    if (!s->is_synced) {
        sync(s, cfg);
    }
}

/// Most ticks see neither an edge nor too long a way without one.
static uint32_t watch_index(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                            const cam_sense_t *in)
{
    if (in->encoder.n_index != s->n_index) {
        take_index(s, cfg, in);
        return 0;
    }
    if (s->edge_distance != 0) {
        return compare_edges(s, cfg);
    }
    const int32_t overdue = cfg->index_overdue;
    if (cam_is_within(s->since_index, overdue)) {
        return 0;
    }
    s->since_index = cam_clamp_i32(s->since_index, -overdue - 1, overdue + 1);
    return CAM_FAULT_BIT(index_missing);
}

/// A tick that came off its time: what it is blamed for, and its way at its time stamp; half a turn
/// at most.
CAM_STAGE static int32_t take_off_time(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                       uint32_t period, cam_angle_t *angle, int32_t way_q32)
{
    const uint32_t most = 10u * cfg->tick_clocks; // as late as a parameter can bear
    const uint32_t limited = period < most ? period : most;
    const uint64_t elapsed_q32 = (uint64_t)limited * cfg->ticks_per_clock_q32;
    const bool is_late = period > cfg->late_clocks;
    s->is_off_time = true;
    s->n_late += is_late ? 1u : 0u;
    s->max_period = period > s->max_period ? period : s->max_period;
    angle->is_off_time = true;
    angle->faults = is_late ? CAM_FAULT_BIT(late_tick) : 0u;
    return cam_sat_i32(((int64_t)way_q32 * (int32_t)(elapsed_q32 >> 16)) >> 16);
}

/// Way that the observer expects since the last tick. The time stamp counts only when the tick came
/// visibly off its time: a coarse clock must not shake the angle of a steady tick.
static int32_t take_clock(cam_spindle_t *s, const cam_spindle_config_t *cfg, uint32_t clock,
                          int32_t alpha_q40, cam_angle_t *angle)
{
    const int32_t way_q32 = cam_wrap_add((int32_t)(s->speed_q64 >> 32), alpha_q40 >> 9);
    const uint32_t period = clock - s->clock;
    s->clock = clock;
    angle->is_off_time = s->is_off_time;
    angle->faults = 0;
    s->is_off_time = false;
    const bool is_on_time = period - cfg->early_clocks < cfg->on_time_clocks;
    return is_on_time ? way_q32 : take_off_time(s, cfg, period, angle, way_q32);
}

/// Counts of this tick, limited to a quarter turn.
static uint32_t take_counts(cam_spindle_t *s, const cam_spindle_config_t *cfg, uint32_t counts,
                            int32_t way_q32)
{
    const int32_t moved = cam_wrap_diff(counts, s->counts);
    const int32_t most = cfg->max_counts;
    const int32_t expected = cam_mulhi(way_q32, cfg->counts_per_turn);
    const bool is_possible = cam_is_within(moved, most);
    const int32_t limited = is_possible ? moved : moved < 0 ? -most : most;
    const bool is_likely = is_possible && cam_is_within(moved - expected, cfg->jump_window);
    s->counts = counts;
    s->since_index += limited;
    move_in_turn(s, cfg, limited);
    return is_likely ? 0u : CAM_FAULT_BIT(encoder_jump);
}

static int64_t wrap_add_i64(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a + (uint64_t)b);
}

/// Tracking loop: the error is taken the short way round, so turns are counted by the position
/// itself. A speed beyond half a turn per tick is the same as one below zero: it wraps.
static void track(cam_spindle_t *s, const cam_spindle_config_t *cfg, int32_t way_q32,
                  int32_t alpha_q40)
{
    const uint32_t predicted = cam_angle_of_pos(s->pos_q32) + (uint32_t)way_q32;
    const int32_t error_q32 = cam_angle_diff_q32(measured_q32(s, cfg), predicted);
    s->pos_q32 += (int64_t)way_q32 + INT64_C(2) * cam_mulhi(error_q32, cfg->kp_q31);
    s->speed_q64 = wrap_add_i64(s->speed_q64, (int64_t)error_q32 * cfg->ki_q32);
    s->speed_q64 = wrap_add_i64(s->speed_q64, alpha_q40 * (INT64_C(1) << 24));
}

void cam_spindle_step_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg, const cam_sense_t *in,
                          int32_t alpha_q40, cam_angle_t *angle)
{
    if (s->is_started) {
        const int32_t way_q32 = take_clock(s, cfg, in->clock, alpha_q40, angle);
        angle->faults |= take_counts(s, cfg, sensed_counts(cfg, in->encoder.counts), way_q32);
        track(s, cfg, way_q32, alpha_q40);
        angle->faults |= watch_index(s, cfg, in);
    } else {
        start(s, cfg, in);
        *angle = (cam_angle_t){0};
    }
    angle->pos_q32 = s->pos_q32;
    angle->speed_q32 = (int32_t)(s->speed_q64 >> 32);
    angle->is_synced = s->is_synced;
}

void cam_spindle_forget_isr(cam_spindle_t *s)
{
    s->is_synced = false;
    s->index_error = 0;
    s->edge_distance = 0;
    s->since_index = 0;
}
