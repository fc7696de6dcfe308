// SPDX-License-Identifier: Apache-2.0
#include "cam_tick_inner.h"
#include "cam_fix.h" // cam_angle_of_pos, cam_clamp_i32

/// Counts in the direction of cutting: ~c = -c - 1 mirrors the half-open interval of a count, so
/// adding half a count centres it in both directions.
static uint32_t sensed_counts(const cam_spindle_config_t *cfg, uint32_t counts)
{
    return counts ^ cfg->sign_mask;
}

/// Requires |moved| below a turn: at most half a turn, the highest speed that can be represented,
/// plus the jump window of a quarter turn.
static void move_in_turn(cam_spindle_t *s, const cam_spindle_config_t *cfg, int32_t moved)
{
    const int32_t turn = cfg->counts_per_turn;
    int32_t in_turn = cam_wrap_add(s->in_turn, moved);
    if ((uint32_t)in_turn >= (uint32_t)turn) {
        in_turn += in_turn < 0 ? turn : -turn;
    }
    s->in_turn = in_turn;
}

/// Multiplies whole part and fraction of the reciprocal separately: error below 2^-32 turn.
static uint32_t measured_q32(const cam_spindle_t *s, const cam_spindle_config_t *cfg)
{
    const uint32_t in_turn = (uint32_t)s->in_turn;
    return in_turn * cfg->turn_per_count_q32 +
           cam_mulhi_u32(in_turn, cfg->turn_per_count_fraction) + cfg->centre_q32;
}

static void start(cam_spindle_t *s, const cam_spindle_config_t *cfg, const cam_sense_t *in,
                  cam_angle_t *angle)
{
    s->is_started = true;
    s->clock = in->clock;
    s->max_period = cfg->tick_clocks;
    s->counts = sensed_counts(cfg, in->encoder.counts);
    s->n_index = in->encoder.n_index;
    s->pos_q32 = (int64_t)measured_q32(s, cfg);
    *angle = (cam_angle_t){.pos_q32 = s->pos_q32};
}

/// First index edge: the angle becomes known; the observer keeps its speed and its lag. Its turns
/// jump forwards, so that none counts as the one after the last.
static void sync(cam_spindle_t *s, const cam_spindle_config_t *cfg)
{
    const uint32_t before_q32 = measured_q32(s, cfg);
    const int32_t lag_q32 = cam_wrap_diff(cam_angle_of_pos(s->pos_q32), before_q32);
    s->in_turn = 0;
    s->index_error = 0;
    move_in_turn(s, cfg, cam_wrap_diff(s->counts, s->index_counts));
    const int64_t turns_q32 = cam_angle_next_turn(s->pos_q32) & ((INT64_C(1) << 56) - 1);
    s->pos_q32 = turns_q32 + 2 * CAM_TURN_Q32 + measured_q32(s, cfg) + lag_q32;
    s->is_synced = true;
}

/// Note a tick off its time.
/// @return [ticks / 2^27] by which its period differs from a tick
static int32_t note_off_time(cam_spindle_t *s, const cam_spindle_config_t *cfg, uint32_t period)
{
    s->is_off_time = true;
    s->is_plan_off_time = true;
    s->n_late += period > cfg->late_clocks ? 1u : 0u;
    s->max_period = period > s->max_period ? period : s->max_period;
    const uint32_t counted = period < cfg->most_clocks ? period : cfg->most_clocks;
    return (int32_t)(counted * cfg->ticks_per_clock_q27 - (UINT32_C(1) << 27));
}

/// A travel beyond half a turn wraps; its counts are a jump anyway.
/// @return [turn / 2^32] travel in a period that differs from a tick
static int32_t travel_off_time(int32_t travel_q32, int32_t off_q27)
{
    return cam_wrap_add(travel_q32, (int32_t)((uint32_t)cam_mulhi(travel_q32, off_q27) << 5));
}

/// @param moved      [counts] in this tick
/// @param going_q32  [turn / 2^32] travel of this tick at the speed of the last advance
/// @return whether the encoder should have advanced by now, once in each stop
static bool has_stopped(cam_spindle_t *s, const cam_spindle_config_t *cfg, int32_t moved,
                        int32_t going_q32)
{
    const int32_t ahead = cam_sat_add(moved, s->behind);
    if (ahead > 0) {
        s->behind = 0;
        s->still_q32 = 0;
        s->going_q32 = (int32_t)(s->speed_q64 >> 32);
        return false;
    }
    s->behind = ahead > -cfg->still_counts ? ahead : -cfg->still_counts;
    const bool was_still = s->still_q32 > cfg->still_q32;
    s->still_q32 = cam_sat_add(s->still_q32, going_q32);
    return !was_still && s->still_q32 > cfg->still_q32;
}

/// Take the counts of this tick. If they differ too far from the predicted travel they are a fault
/// and are limited to a quarter turn; the rest is lost. @return encoder_jump or none
static uint32_t take_counts(cam_spindle_t *s, const cam_spindle_config_t *cfg, uint32_t counts,
                            int32_t travel_q32)
{
    const int32_t expected = cam_mulhi(travel_q32, cfg->counts_per_turn);
    int32_t moved = cam_wrap_diff(counts, s->counts);
    uint32_t faults = 0;
    if (!cam_is_within(cam_sat_sub(moved, expected), cfg->jump_window)) {
        faults = CAM_FAULT_BIT(encoder_jump);
        const int32_t taken = cam_clamp_i32(moved, -cfg->max_counts, cfg->max_counts);
        s->index_error = cam_sat_sub(s->index_error, cam_sat_sub(moved, taken));
        moved = taken;
    }
    s->counts = counts;
    move_in_turn(s, cfg, moved);
    return faults;
}

/// Measured angle. With a time stamp of the last edge: position of that edge plus the travel since
/// then, at most a count, MATHS.md (138). Without one, or while edges are rare: the middle of the
/// count. A speed that contradicts the edge moves the result by at most a count and a half.
static uint32_t observed_q32(const cam_spindle_t *s, const cam_spindle_config_t *cfg,
                             const cam_sense_t *in)
{
    const uint32_t centred_q32 = measured_q32(s, cfg);
    if (cfg->stamp_clocks == 0u) {
        return centred_q32;
    }
    const uint32_t age = in->clock - in->encoder.edge_clock;
    if (age + cfg->tick_clocks >= cfg->stamp_clocks) {
        return centred_q32;
    }
    const int32_t speed_q32 = (int32_t)(s->speed_q64 >> 32);
    const int32_t half_q32 = (int32_t)(cfg->turn_per_count_q32 >> 1);
    const int32_t age_q27 = (int32_t)(age * cfg->ticks_per_clock_q27);
    const int32_t since_q32 = (int32_t)((uint32_t)cam_mulhi(speed_q32, age_q27) << 5);
    const int32_t behind_q32 =
        speed_q32 < 0 ? cam_sat_add(since_q32, half_q32) : cam_sat_sub(since_q32, half_q32);
    return centred_q32 + (uint32_t)cam_clamp_i32(behind_q32, -3 * half_q32, 3 * half_q32);
}

/// Tracking loop on the wrapped angle error: a speed beyond half a turn per tick wraps.
static void track(cam_spindle_t *s, const cam_spindle_config_t *cfg, uint32_t smooth_q32,
                  int32_t travel_q32, int32_t alpha_q40)
{
    const uint32_t predicted = cam_angle_of_pos(s->pos_q32) + (uint32_t)travel_q32;
    const int32_t error_q32 = cam_wrap_diff(smooth_q32, predicted);
    const int64_t more_q32 = (int64_t)travel_q32 + INT64_C(2) * cam_mulhi(error_q32, cfg->kp_q31);
    s->pos_q32 = cam_wrap_add_i64(s->pos_q32, more_q32);
    s->speed_q64 = cam_wrap_add_i64(s->speed_q64, (int64_t)error_q32 * cfg->ki_q32);
    s->speed_q64 = cam_wrap_add_i64(s->speed_q64, alpha_q40 * (INT64_C(1) << 24));
}

/// Time stamps count only in a tick visibly off its time, so that a coarse clock adds no jitter.
void cam_spindle_step_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg, const cam_sense_t *in,
                          int32_t alpha_q40, cam_angle_t *angle)
{
    if (!s->is_started) {
        start(s, cfg, in, angle);
        return;
    }
    const uint32_t period = in->clock - s->clock;
    int32_t travel_q32 = cam_wrap_add((int32_t)(s->speed_q64 >> 32), alpha_q40 >> 9);
    int32_t going_q32 = s->going_q32;
    const uint32_t before = s->counts;
    uint32_t faults = 0;
    s->clock = in->clock;
    angle->is_off_time = s->is_off_time;
    s->is_off_time = false;
    if (period - cfg->early_clocks >= cfg->on_time_clocks) {
        angle->is_off_time = true;
        faults = period > cfg->late_clocks ? CAM_FAULT_BIT(late_tick) : 0u;
        const int32_t off_q27 = note_off_time(s, cfg, period);
        travel_q32 = travel_off_time(travel_q32, off_q27);
        going_q32 = travel_off_time(going_q32, off_q27);
    }
    faults |= take_counts(s, cfg, sensed_counts(cfg, in->encoder.counts), travel_q32);
    angle->has_stopped = has_stopped(s, cfg, cam_wrap_diff(s->counts, before), going_q32);
    const uint32_t raw_q32 = observed_q32(s, cfg, in);
    const uint32_t learned_q32 = cam_learned_turn_q32(cfg->dm, cam_learned_place(raw_q32));
    track(s, cfg, raw_q32 - learned_q32, travel_q32, alpha_q40);
    angle->faults = faults;
    angle->measured_q32 = raw_q32;
    angle->pos_q32 = s->pos_q32;
    angle->speed_q32 = (int32_t)(s->speed_q64 >> 32);
    angle->is_synced = s->is_synced;
}

/// Take an index edge. The first one makes the angle known, unless the spindle cannot have come
/// from its latched position; then the edge stays overdue. Two edges are 0 (reversal) or one turn
/// apart; the remainder is lost counts.
/// @return fault lost_counts or none
static uint32_t take_edge(cam_spindle_t *s, const cam_spindle_config_t *cfg, uint32_t edge)
{
    const int32_t distance = cam_wrap_diff(edge, s->index_counts);
    s->index_counts = edge;
    s->edge_distance = s->is_synced ? distance : 0;
    if (!s->is_synced) {
        if (cam_is_within(cam_wrap_diff(s->counts, edge), cfg->counts_per_turn)) {
            sync(s, cfg);
        }
        return 0;
    }
    const int32_t turn = distance < 0 ? -cfg->counts_per_turn : cfg->counts_per_turn;
    const int32_t lost =
        cam_is_within(distance, cfg->max_counts) ? distance : cam_wrap_sub(distance, turn);
    s->index_error = cam_sat_add(s->index_error, lost);
    return cam_is_within(s->index_error, cfg->index_tolerance) ? 0u : CAM_FAULT_BIT(lost_counts);
}

uint32_t cam_spindle_check_index_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                     const hal_encoder_t *encoder)
{
    if (encoder->n_index != s->n_index) {
        s->n_index = encoder->n_index;
        // An edge lies on the boundary of a count: its mirror image is -c.
        return take_edge(s, cfg, sensed_counts(cfg, encoder->index_counts) - cfg->sign_mask);
    }
    const int32_t since = cam_wrap_diff(s->counts, s->index_counts);
    return cam_is_within(since, cfg->index_overdue) ? 0u : CAM_FAULT_BIT(index_missing);
}

uint32_t cam_spindle_check_inertia_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                       bool is_playing)
{
    const uint32_t angle_q32 = cam_angle_of_pos(s->pos_q32);
    const int32_t moved_q32 = cam_wrap_diff(angle_q32, s->plan_q32);
    const bool is_off_time = s->is_plan_off_time;
    s->plan_q32 = angle_q32;
    s->is_plan_off_time = false;
    if (!is_playing) {
        s->inert_q32 = moved_q32;
        s->off_q32 = 0;
        s->n_left_out = 0;
        return 0;
    }
    if (is_off_time) { // its travel is that of another time
        s->n_left_out += s->n_left_out < 15 ? 1 : 0;
        return 0;
    }
    const int32_t faster_q32 = cam_sat_sub(moved_q32, s->inert_q32);
    s->off_q32 = cam_sat_add(s->off_q32, faster_q32);
    const int32_t ripple_q32 = cam_mulhi(s->inert_q32, s->inert_q32) >> 3; // 0.02 w^2
    const int32_t most_q32 = cam_clamp_i32(cfg->inertia_q32 + ripple_q32, 0, cam_most_inertia_q32);
    const int32_t room_q32 = most_q32 * (1 + s->n_left_out);
    const int32_t wanted_q32 = (faster_q32 >> 1) + (s->off_q32 >> 4);
    s->inert_q32 = cam_sat_add(s->inert_q32, cam_clamp_i32(wanted_q32, -room_q32, room_q32));
    s->n_left_out = 0;
    return cam_is_within(s->off_q32, cfg->inertia_window_q32 + 16 * most_q32)
               ? 0u
               : CAM_FAULT_BIT(encoder_jump);
}

void cam_spindle_forget_isr(cam_spindle_t *s, const hal_encoder_t *encoder)
{
    s->is_synced = false;
    s->index_error = 0;
    s->index_counts = s->counts;
    s->n_index = encoder->n_index;
}
