// SPDX-License-Identifier: Apache-2.0
#include "sim_work.h"
#include "sim_units.h" // sim_abs, sim_floor
#include <math.h>      // HUGE_VAL

/// U counts as moving from a fiftieth of the drawing's travel on.
static const double moving_share = 0.02;

void sim_turns_init(sim_turns_t *t, double rise_turns, double kept_turns, double fall_turns)
{
    *t =
        (sim_turns_t){.rise_turns = rise_turns, .kept_turns = kept_turns, .fall_turns = fall_turns};
}

static double lesser(double a, double b)
{
    return b < a ? b : a;
}

static double larger(double a, double b)
{
    return b > a ? b : a;
}

static void begin_turn(sim_turns_t *t)
{
    t->least_um = t->least_u_um = t->least_drawn_um = HUGE_VAL;
    t->most_um = t->most_u_um = t->most_drawn_um = -HUGE_VAL;
}

/// Merge every two neighbours of the same kind.
static void merge(sim_turns_t *t)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < t->n; i++) {
        const bool is_pair = i + 1u < t->n && t->entry[i].kind == t->entry[i + 1u].kind;
        sim_turn_t one = t->entry[i];
        t->run_from = i == t->run_from ? n : t->run_from;
        if (is_pair && i + 1u != t->run_from) {
            one.um = larger(one.um, t->entry[++i].um);
        }
        t->entry[n++] = one;
    }
    t->n = n;
}

static void keep(sim_turns_t *t, double um)
{
    if (t->n == (uint32_t)sim_turns_most) {
        merge(t);
    }
    const double turn = sim_abs(t->begin_turn - t->zero_turn) + t->n_whole;
    t->entry[t->n++] = (sim_turn_t){.turn = turn, .um = um, .kind = t->kind};
}

/// Finish a whole turn.
static void end_turn(sim_turns_t *t)
{
    if (t->kind == sim_turns_cut) {
        keep(t, larger(t->most_um, -t->least_um));
        return;
    }
    const double drawn_um = t->most_drawn_um - t->least_drawn_um;
    if (t->full_turn < 0.0 && t->most_u_um - t->least_u_um > moving_share * drawn_um) {
        t->full_turn = sim_abs(t->begin_turn - t->zero_turn) + t->n_whole + t->rise_turns;
    }
    keep(t, 0.5 * (t->most_um - t->least_um));
}

/// Advance to an angle, finishing a turn if it is complete.
static void go_to(sim_turns_t *t, sim_turns_kind_t kind, double turn)
{
    if (!t->has_begun) {
        t->has_begun = true;
        t->zero_turn = turn;
    }
    if (!t->is_running) {
        t->is_running = true;
        t->kind = kind;
        t->begin_turn = turn;
        t->full_turn = -1.0;
        t->run_from = t->n;
        t->n_whole = 0.0;
        begin_turn(t);
    }
    const double turned = sim_abs(turn - t->begin_turn);
    if (turned >= t->n_whole + 1.0) {
        end_turn(t);
        begin_turn(t);
        t->n_whole = (double)sim_floor(turned);
    }
}

static void take(sim_turns_t *t, double error_um)
{
    t->least_um = lesser(t->least_um, error_um);
    t->most_um = larger(t->most_um, error_um);
}

/// Keep only the turns of the rehearsal at full amplitude.
static void drop_ramps(sim_turns_t *t, double end_turn_of, bool is_whole)
{
    const double first = is_whole ? end_turn_of - t->fall_turns - t->kept_turns : t->full_turn;
    const double last = is_whole ? end_turn_of - t->fall_turns : end_turn_of;
    uint32_t n = t->run_from;
    for (uint32_t i = t->run_from; i < t->n; i++) {
        const sim_turn_t one = t->entry[i];
        if (t->full_turn >= 0.0 && one.turn >= first - 1e-6 && one.turn + 1.0 <= last + 1e-6) {
            t->entry[n++] = one;
        }
    }
    t->n = n;
}

static void end_run(sim_turns_t *t, double turn, bool is_engaging)
{
    if (t->kind == sim_turns_rehearsed) {
        drop_ramps(t, sim_abs(turn - t->zero_turn), is_engaging);
    } else if (t->most_um > -HUGE_VAL) { // an incomplete turn
        end_turn(t);
    }
    t->is_running = false;
}

void sim_turns_rest(sim_turns_t *t, double turn, bool is_engaging)
{
    if (t->is_running) {
        end_run(t, turn, is_engaging);
    }
}

void sim_turns_rehearse(sim_turns_t *t, double turn, double u_um, double drawn_um)
{
    if (t->is_running && t->kind != sim_turns_rehearsed) {
        end_run(t, turn, false);
    }
    go_to(t, sim_turns_rehearsed, turn);
    take(t, -u_um - drawn_um);
    t->least_u_um = lesser(t->least_u_um, u_um);
    t->most_u_um = larger(t->most_u_um, u_um);
    t->least_drawn_um = lesser(t->least_drawn_um, drawn_um);
    t->most_drawn_um = larger(t->most_drawn_um, drawn_um);
}

void sim_turns_touch(sim_turns_t *t, double turn, double error_um)
{
    if (t->is_running && t->kind != sim_turns_cut) {
        end_run(t, turn, true);
    }
    go_to(t, sim_turns_cut, turn);
    take(t, error_um);
}
