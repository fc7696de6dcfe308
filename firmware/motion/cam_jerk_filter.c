// SPDX-License-Identifier: Apache-2.0
#include "cam_motion.h"
#include "cam_fix.h" // cam_clamp_i32, cam_sat_i32

/// Sums over m = 0 .. n - 1 of m and of m^2, by log2 n.
static const struct {
    int32_t first, second;
} sums[cam_jerk_filter_most_log2 + 1] = {{0, 0},      {1, 1},       {6, 14},      {28, 140},
                                         {120, 1240}, {496, 10416}, {2016, 85344}};

/// `lag` is the sum over the window of the newest position minus each position of the line.
void cam_jerk_filter_begin_isr(cam_jerk_filter_t *g, const cam_axis_motion_t *m,
                               uint32_t log2_window)
{
    const int32_t n = INT32_C(1) << log2_window;
    const int64_t last = (int64_t)n - 1;
    const int32_t most_q10 = cam_jerk_filter_most_q10(log2_window);
    const int32_t slope_q10 = cam_clamp_i32(m->acc_q10, -most_q10, most_q10);
    const int32_t oldest_q10 = cam_sat_i32(m->vel_q10 - slope_q10 * last / 2);
    const int64_t lag = (int64_t)oldest_q10 * sums[log2_window].first +
                        (int64_t)slope_q10 * sums[log2_window].second;
    g->raw.pos_q10 = cam_wrap_add_i64(m->pos_q10, lag >> log2_window);
    g->raw.vel_q10 = cam_sat_i32(oldest_q10 + slope_q10 * last);
    g->sum_pos_q10 = cam_wrap_sub_i64(cam_wrap_times_i64(g->raw.pos_q10, n), lag);
    g->sum_vel_q10 = (int64_t)oldest_q10 * n + (int64_t)slope_q10 * sums[log2_window].first;
    g->line_q10 = oldest_q10;
    g->slope_q10 = slope_q10;
    g->n_line = (uint32_t)n;
    g->n_still = m->vel_q10 == 0 && m->acc_q10 == 0 ? (uint32_t)n : 0u;
    g->log2_window = log2_window;
}

/// Change the window at rest.
static void fit(cam_jerk_filter_t *g, const cam_axis_motion_t *m, const cam_motion_limits_t *limits)
{
    if (g->log2_window != limits->log2_window && g->n_still >> g->log2_window != 0u) {
        const cam_axis_motion_t resting = {.pos_q10 = m->pos_q10};
        cam_jerk_filter_begin_isr(g, &resting, limits->log2_window);
    }
}

/// Move the newest speed of raw into the window, and the oldest one out.
/// @return whether all of the window is at rest
static bool carry(cam_jerk_filter_t *g, cam_axis_motion_t *m, bool is_still)
{
    const uint32_t n = UINT32_C(1) << g->log2_window;
    int32_t *slot_q10 = &g->past_q10[g->at & (n - 1u)];
    int32_t leaving_q10 = *slot_q10;
    if (g->n_line > 0u) {
        leaving_q10 = g->line_q10;
        g->line_q10 = cam_sat_add(g->line_q10, g->slope_q10);
        g->n_line--;
    }
    *slot_q10 = g->raw.vel_q10;
    g->at++;
    const int64_t change_q10 = (int64_t)g->raw.vel_q10 - leaving_q10;
    g->sum_vel_q10 = cam_wrap_add_i64(g->sum_vel_q10, change_q10);
    g->sum_pos_q10 = cam_wrap_add_i64(g->sum_pos_q10, g->sum_vel_q10);
    const int64_t pos_q10 = g->sum_pos_q10 >> g->log2_window;
    m->vel_q10 = (int32_t)cam_wrap_sub_i64(pos_q10, m->pos_q10);
    m->acc_q10 = (int32_t)(change_q10 >> g->log2_window);
    m->pos_q10 = pos_q10;
    const uint32_t n_still = is_still ? g->n_still + 1u : 0u;
    g->n_still = n_still < n ? n_still : n;
    return g->n_still == n;
}

bool cam_jerk_filter_to_isr(cam_jerk_filter_t *g, cam_axis_motion_t *m,
                            const cam_motion_limits_t *limits, int64_t target_q10)
{
    fit(g, m, limits);
    const bool is_still = cam_move_profile_to_isr(&g->raw, limits, target_q10);
    return carry(g, m, is_still);
}

bool cam_jerk_filter_stop_isr(cam_jerk_filter_t *g, cam_axis_motion_t *m,
                              const cam_motion_limits_t *limits)
{
    fit(g, m, limits);
    const bool is_still = cam_move_profile_stop_isr(&g->raw, limits);
    return carry(g, m, is_still);
}

void cam_jerk_filter_shift_isr(cam_jerk_filter_t *g, int64_t by_q10)
{
    const int64_t sum_q10 = cam_wrap_times_i64(by_q10, INT64_C(1) << g->log2_window);
    g->raw.pos_q10 = cam_wrap_add_i64(g->raw.pos_q10, by_q10);
    g->sum_pos_q10 = cam_wrap_add_i64(g->sum_pos_q10, sum_q10);
}
