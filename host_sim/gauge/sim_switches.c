// SPDX-License-Identifier: Apache-2.0
#include "sim_switches.h"
#include "sim_units.h" // sim_abs
#include <math.h>      // floor, HUGE_VAL

/// Share of the window distance: a change farther away has another cause.
static const double near_share = 0.125;

void sim_switches_init(sim_switches_t *s, const sim_switch_window_t *window)
{
    *s = (sim_switches_t){0};
    for (uint32_t i = 0; i < sim_switches_n; i++) {
        s->each[i].window = window[i];
        s->each[i].low_mm = HUGE_VAL;
        s->each[i].high_mm = -HUGE_VAL;
        s->n_used = window[i].per_turn > 0.0 ? i + 1u : s->n_used;
    }
}

/// The switched device acts.
static void act(sim_switch_t *one, bool is_on, double turn)
{
    const sim_switch_window_t *w = &one->window;
    sim_switch_edges_t *edges = is_on ? &one->on : &one->off;
    // Distance from an end of the nearest window, -1/2 .. 1/2 of the window distance.
    const double windows = (turn - (is_on ? w->on_turn : w->off_turn)) * w->per_turn;
    const double away_turn = (windows - floor(windows + 0.5)) / w->per_turn;
    if (sim_abs(away_turn) * w->per_turn > near_share) {
        edges->n_other++;
        return;
    }
    edges->n++;
    edges->sum_turn += away_turn;
    if (sim_abs(away_turn) > sim_abs(edges->largest_turn)) {
        edges->largest_turn = away_turn;
    }
}

static void see_change(sim_switch_t *one, double t_s, bool is_on)
{
    if (is_on == one->is_on || one->n_pending == sim_switches_pending) {
        return;
    }
    const uint32_t at = (one->first + one->n_pending++) % sim_switches_pending;
    one->pending[at].at_s = t_s + one->window.dead_time_s;
    one->pending[at].is_on = is_on;
    one->is_on = is_on;
}

/// Execute the changes that took effect since the last tick.
static void let_act(const sim_switches_t *s, sim_switch_t *one, double t_s, double turn)
{
    const double period_s = t_s - s->t_s;
    while (one->n_pending > 0u && one->pending[one->first].at_s <= t_s) {
        const double share =
            period_s > 0.0 ? (one->pending[one->first].at_s - s->t_s) / period_s : 1.0;
        act(one, one->pending[one->first].is_on, s->turn + share * (turn - s->turn));
        one->first = (one->first + 1u) % sim_switches_pending;
        one->n_pending--;
    }
}

void sim_switches_tick(sim_switches_t *s, double t_s, double turn, double z_mm, uint32_t bits)
{
    for (uint32_t i = 0; i < s->n_used; i++) {
        sim_switch_t *one = &s->each[i];
        if (one->window.per_turn <= 0.0) {
            continue;
        }
        see_change(one, t_s, (bits >> i & 1u) != 0u);
        let_act(s, one, t_s, turn);
        if (one->is_on) {
            one->low_mm = z_mm < one->low_mm ? z_mm : one->low_mm;
            one->high_mm = z_mm > one->high_mm ? z_mm : one->high_mm;
        }
    }
    s->t_s = t_s;
    s->turn = turn;
}
