// SPDX-License-Identifier: Apache-2.0
#include "cam_round.h"
#include "cam_fix.h" // cam_clamp_i64

/// Of two lags of 2048 ticks and a plan: products with the acceleration fit 62 bits.
enum { max_lag2 = 1 << 21 };

/// Other tasks from one pass of the swing to the next.
enum { between_uniform = 2, between_modulated = 4 };

enum {
    n_pass = cam_plan_task_aim_swing - cam_plan_task_find_swing + 1,
};
_Static_assert(n_pass == cam_swing_aim_ticks + 1, "as a pass counts");

/// A round that is being laid out.
typedef struct {
    cam_play_config_t *c;
    uint32_t n;       ///< ticks so far
    uint32_t n_since; ///< other tasks since the last pass of the swing
    uint32_t between; ///< of them; 0: the tool does not swing
} layout_t;

static void lay_row(layout_t *l, uint32_t first, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        l->c->schedule[l->n] = (uint8_t)(first + i);
        l->n++;
    }
}

static void lay_pass(layout_t *l)
{
    lay_row(l, cam_plan_task_find_swing, n_pass);
    l->n_since = 0;
}

/// @param first, n  tasks in the order of their list
static void lay_tasks(layout_t *l, uint32_t first, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        lay_row(l, first + i, 1);
        l->n_since++;
        if (l->n_since == l->between) {
            lay_pass(l);
        }
    }
}

static void lay_round(layout_t *l, bool is_modulated)
{
    const uint32_t n_ratio_tasks = is_modulated ? (uint32_t)cam_plan_ratio_tasks : 0u;
    lay_tasks(l, cam_plan_task_positions, cam_plan_task_find_slices - cam_plan_task_positions);
    lay_tasks(l, cam_plan_task_find_slices, n_ratio_tasks);
    lay_tasks(l, cam_plan_task_read_profile,
              cam_plan_task_height_swing - cam_plan_task_read_profile);
    if (l->between > 0u) {
        lay_tasks(l, cam_plan_task_height_swing, 2);
    }
    lay_tasks(l, cam_plan_task_find_slices, n_ratio_tasks);
    if (l->between > 0u && l->n_since > 0u) {
        lay_pass(l);
    }
    l->c->schedule[l->n] = cam_plan_task_positions; // which leads back to the begin
}

/// @return [ticks] from the begin of the round to a task
static int32_t place_of(const cam_play_config_t *c, uint32_t task)
{
    int32_t i = 0;
    while (c->schedule[i] != task) {
        i++;
    }
    return i;
}

/// How far ahead X and Z, U and the speed ratio are planned, seen from the tick of the positions.
static void build_plans(cam_play_config_t *c)
{
    const int32_t aim_z = place_of(c, cam_plan_task_aim_z);
    const int32_t xz_ticks = c->round_ticks + aim_z - 1;
    const int32_t u_ticks = c->round_ticks + place_of(c, cam_plan_task_aim_u) - 1;
    c->x_early_ticks = aim_z - place_of(c, cam_plan_task_aim_x);
    c->xz_plan_q16 = c->xz_lag_q16 + xz_ticks * 65536;
    c->u_plan_q16 = c->lead_q16 + u_ticks * 65536;
    const int32_t furthest_q16 = c->u_plan_q16 > c->xz_plan_q16 ? c->u_plan_q16 : c->xz_plan_q16;
    c->told_q16 = furthest_q16 + (c->round_ticks + cam_plan_put_off) * 65536;
    c->free_q16 = c->told_q16 + (c->round_ticks - place_of(c, cam_plan_task_hold_height)) * 65536;
    // A geared Z is planned for the end of its own way, a measured one for the end of a round.
    const int32_t after_round = (aim_z - 1) * 65536;
    c->u_behind_q16 = (c->is_z_measured ? -after_round : c->xz_lag_q16) - c->lead_q16;
    c->u_height_q16 = (place_of(c, cam_plan_task_aim_height) - aim_z) * 65536 - c->u_behind_q16;
    // At the end of a plan of n ticks with lag l: n^2 / 2 and n l, and (l / 2)^2, which two equal
    // poles lag more while the spindle accelerates.
    const int64_t lag_q8 = c->xz_lag_q16 >> 8;
    const int64_t lag2 =
        ((lag_q8 * lag_q8) >> 18) + ((lag_q8 * xz_ticks) >> 8) + xz_ticks * xz_ticks / 2;
    c->xz_lag2 = (int32_t)cam_clamp_i64(lag2, 0, max_lag2);
}

void cam_round_build(cam_play_config_t *c, bool is_modulated, bool is_swung)
{
    const uint32_t between = is_modulated ? between_modulated : between_uniform;
    layout_t l = {.c = c, .between = is_swung ? between : 0u};
    lay_round(&l, is_modulated);
    c->round_ticks = (int32_t)l.n;
    c->per_round_q32 = (int32_t)((INT64_C(1) << 32) / c->round_ticks);
    c->most_put_off = c->round_ticks + cam_plan_put_off;
    build_plans(c);
    if (is_modulated) { // the ratio is for the middle of the ticks that use it, half a round
        const int32_t to_speed =
            place_of(c, cam_plan_task_speed) - place_of(c, cam_plan_task_find_slices);
        c->ratio_q16 = c->lead_q16 + (2 * to_speed + c->round_ticks / 2 - 1) * 32768;
    }
    const int32_t pass_ticks = (int32_t)(between + n_pass);
    c->swing.is_swung = is_swung;
    c->swing.per_pass_q32 = (int32_t)((INT64_C(1) << 32) / pass_ticks);
    c->swing.ahead_q16 = c->swing.lag_q16 + (pass_ticks + n_pass - 1) * 65536;
}
