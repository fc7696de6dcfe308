// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_spindle.h"
#include "cam/cam_angle.h" // cam_angle_diff_q32
#include "cam/cam_fix.h"   // cam_clamp_i32

/// One tick in elapsed time.
#define TICK_Q16 (INT64_C(1) << 16)

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
    s->in_turn += moved;
    if (s->in_turn >= cfg->counts_per_turn) {
        s->in_turn -= cfg->counts_per_turn;
    } else if (s->in_turn < 0) {
        s->in_turn += cfg->counts_per_turn;
    }
}

/// Product below 2^56, the truncated reciprocal costs less than 2^-32 turn.
static uint32_t measured_q32(const cam_spindle_t *s, const cam_spindle_config_t *cfg)
{
    const uint64_t turn_q56 = (uint64_t)(uint32_t)s->in_turn * cfg->turn_per_count_q56;
    const uint64_t half_q56 = cfg->turn_per_count_q56 >> 1;
    return (uint32_t)((turn_q56 + half_q56) >> 24) + cfg->offset_q32;
}

static void start(cam_spindle_t *s, const cam_spindle_config_t *cfg, const cam_sense_t *in)
{
    s->is_started = true;
    s->clock = in->clock;
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
static uint32_t compare_edges(cam_spindle_t *s, const cam_spindle_config_t *cfg, uint32_t edge)
{
    const int32_t turn = cfg->counts_per_turn;
    const int32_t distance =
        cam_clamp_i32(cam_wrap_diff(edge, s->index_counts), -2 * turn, 2 * turn);
    const int32_t whole = distance > turn / 2 ? turn : distance < -turn / 2 ? -turn : 0;
    s->index_error = cam_clamp_i32(s->index_error + distance - whole, -turn, turn);
    const bool is_off =
        s->index_error > cfg->index_tolerance || s->index_error < -cfg->index_tolerance;
    return is_off ? CAM_FAULT_BIT(lost_counts) : 0u;
}

static uint32_t take_index(cam_spindle_t *s, const cam_spindle_config_t *cfg, const cam_sense_t *in)
{
    if (in->encoder.n_index == s->n_index) {
        const bool is_overdue =
            s->since_index > cfg->index_overdue || s->since_index < -cfg->index_overdue;
        return is_overdue ? CAM_FAULT_BIT(index_missing) : 0u;
    }
    const uint32_t edge = sensed_edge(cfg, in->encoder.index_counts);
    const uint32_t faults = s->is_synced ? compare_edges(s, cfg, edge) : 0u;
    s->n_index = in->encoder.n_index;
    s->index_counts = edge;
    s->since_index = cam_wrap_diff(s->counts, edge);
    if (!s->is_synced) {
        sync(s, cfg);
    }
    return faults;
}

/// Way that the observer expects since the last tick. The time stamp counts only when the tick came
/// visibly off its time: a coarse clock must not shake the angle of a steady tick.
static int64_t predicted_q32(cam_spindle_t *s, const cam_spindle_config_t *cfg, uint32_t clock)
{
    const uint64_t period_q32 = (uint64_t)(clock - s->clock) * cfg->ticks_per_clock_q32;
    const int64_t elapsed_q16 = cam_clamp_i64((int64_t)(period_q32 >> 16), 0, 4 * TICK_Q16);
    const bool is_on_time = cam_abs_i64(elapsed_q16 - TICK_Q16) < TICK_Q16 / 16;
    s->clock = clock;
    return ((s->speed_q48 >> 16) * (is_on_time ? TICK_Q16 : elapsed_q16)) >> 16;
}

static uint32_t take_counts(cam_spindle_t *s, const cam_spindle_config_t *cfg, uint32_t counts,
                            int64_t way_q32)
{
    const int32_t moved = cam_wrap_diff(counts, s->counts);
    const int64_t off = moved - ((way_q32 * cfg->counts_per_turn) >> 32);
    const int32_t limited = cam_clamp_i32(moved, -cfg->max_counts, cfg->max_counts);
    const bool is_jump = cam_abs_i64(off) > cfg->jump_window || limited != moved;
    const int32_t overdue = cfg->index_overdue + 1;
    s->counts = counts;
    s->since_index = cam_clamp_i32(s->since_index + limited, -overdue, overdue);
    move_in_turn(s, cfg, limited);
    return is_jump ? CAM_FAULT_BIT(encoder_jump) : 0u;
}

/// Tracking loop: the error is taken the short way round, so turns are counted by the position
/// itself.
static void track(cam_spindle_t *s, const cam_spindle_config_t *cfg, int64_t way_q32)
{
    s->pos_q32 += way_q32;
    const int32_t error_q32 =
        cam_angle_diff_q32(measured_q32(s, cfg), cam_angle_of_pos(s->pos_q32));
    s->pos_q32 += ((int64_t)error_q32 * cfg->kp_q31) >> 31;
    s->speed_q48 += ((int64_t)error_q32 * cfg->ki_q31) >> 15;
}

cam_angle_t cam_spindle_step_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                 const cam_sense_t *in, int64_t alpha_q48)
{
    uint32_t faults = 0;
    if (s->is_started) {
        const int64_t way_q32 = predicted_q32(s, cfg, in->clock) + (alpha_q48 >> 17);
        s->speed_q48 += alpha_q48;
        faults = take_counts(s, cfg, sensed_counts(cfg, in->encoder.counts), way_q32);
        track(s, cfg, way_q32);
        faults |= take_index(s, cfg, in);
    } else {
        start(s, cfg, in);
    }
    return (cam_angle_t){
        .pos_q32 = s->pos_q32,
        .speed_q32 = cam_sat_i32(s->speed_q48 >> 16),
        .is_synced = s->is_synced,
        .faults = faults,
    };
}

void cam_spindle_forget_isr(cam_spindle_t *s)
{
    s->is_synced = false;
    s->index_error = 0;
    s->since_index = 0;
}
