// SPDX-License-Identifier: Apache-2.0
#include "sim_removal.h"
#include "sim_units.h" // SIM_PI, sim_floor
#include <math.h>      // acos, pow

void sim_spread_add(sim_spread_t *s, double value)
{
    s->min = s->n == 0u || value < s->min ? value : s->min;
    s->max = s->n == 0u || value > s->max ? value : s->max;
    s->sum += value;
    s->n++;
}

double sim_spread_mean(const sim_spread_t *s)
{
    return s->n > 0u ? s->sum / (double)s->n : 0.0;
}

static double ripple_of(const sim_spread_t *s)
{
    const double mean = sim_spread_mean(s);
    return mean > 0.0 ? (s->max - s->min) / mean : 0.0;
}

void sim_removal_init(sim_removal_t *r, const sim_removal_config_t *config)
{
    *r = (sim_removal_t){.config = *config};
}

static void begin_slice(sim_removal_t *r, double t_s, double turn)
{
    r->begin_s = t_s;
    r->begin_turn = turn;
    r->volume_mm3 = 0.0;
    r->work_nmm = 0.0;
    r->force_sum_n = 0.0;
    r->n = 0;
    r->is_clean = true;
}

/// A turn is whole when its first slice follows a slice of the previous turn.
static void begin_turn(sim_removal_t *r, double whole, bool is_whole)
{
    r->turn = whole;
    r->is_whole = is_whole;
    r->turn_rate = (sim_spread_t){0};
    r->turn_force = (sim_spread_t){0};
}

/// Finish the slice and evaluate it.
static void end_slice(sim_removal_t *r, double t_s, double turn, double z_mm)
{
    const double dt_s = t_s - r->begin_s;
    r->slice = (sim_slice_t){
        .t_s = r->begin_s + 0.5 * dt_s,
        .turn = 0.5 * (r->begin_turn + turn),
        .z_mm = z_mm,
        .volume_mm3 = r->volume_mm3,
        .rate_mm3_s = r->volume_mm3 / dt_s,
        .power_w = r->work_nmm / dt_s * 1e-3,
        .rate_force_n = r->work_nmm / r->config.feed_mm,
        .chip_force_n = r->force_sum_n / (double)r->n,
    };
    const sim_slice_t *s = &r->slice;
    const double whole = (double)sim_floor(s->turn);
    if (whole != r->turn) {
        if (r->is_whole && r->turn_rate.n > 0u) {
            sim_spread_add(&r->rate_ripple, ripple_of(&r->turn_rate));
            sim_spread_add(&r->force_ripple, ripple_of(&r->turn_force));
        }
        begin_turn(r, whole, whole == r->turn + 1.0);
    }
    r->is_whole = r->is_whole && r->is_clean;
    if (r->is_clean) {
        sim_spread_add(&r->rate, s->rate_mm3_s);
        sim_spread_add(&r->power, s->power_w);
        sim_spread_add(&r->rate_force, s->rate_force_n);
        sim_spread_add(&r->chip_force, s->chip_force_n);
        sim_spread_add(&r->turn_rate, s->rate_mm3_s);
        sim_spread_add(&r->turn_force, s->chip_force_n);
    }
}

/// Specific cutting force of a chip, MATHS.md (86): the thinner the chip, the larger the force per
/// area. Without a nose the edge is square to the feed; a nose cuts along its arc.
/// @return [N/mm2]
static double kc_of(const sim_removal_config_t *c, double depth_mm, double thick_mm)
{
    if (c->size_exponent == 0.0 || depth_mm <= 0.0 || thick_mm <= 0.0) {
        return c->kc_n_mm2;
    }
    double chip_mm = thick_mm;
    if (c->nose_mm > 0.0) {
        const double below_mm = depth_mm < c->nose_mm ? depth_mm : c->nose_mm;
        const double edge_mm =
            c->nose_mm * acos(1.0 - below_mm / c->nose_mm) + (depth_mm - below_mm);
        chip_mm = depth_mm * thick_mm / edge_mm;
    }
    return c->kc_n_mm2 * pow(chip_mm, -c->size_exponent);
}

/// Add the metal removed between the last sample and this one, by the trapezium rule.
static void remove_metal(sim_removal_t *r, double turn, double z_mm, double radius_mm)
{
    const double thick_mm = sim_pass_touch(&r->pass, turn, z_mm);
    const double depth_mm = r->config.blank_mm - radius_mm;
    const double cut_mm3 = SIM_PI * depth_mm * (r->config.blank_mm + radius_mm) * thick_mm;
    const double volume_mm3 = 0.5 * (r->last_cut_mm3 + cut_mm3) * (turn - r->last_turn);
    const double kc_n_mm2 = kc_of(&r->config, depth_mm, thick_mm);
    r->last_turn = turn;
    r->last_cut_mm3 = cut_mm3;
    r->removed_mm3 += volume_mm3;
    r->volume_mm3 += volume_mm3;
    r->work_nmm += kc_n_mm2 * volume_mm3;
    r->force_sum_n += kc_n_mm2 * depth_mm * thick_mm;
    r->n++;
}

bool sim_removal_touch(sim_removal_t *r, double t_s, double turn, double z_mm, double radius_mm,
                       bool is_judged)
{
    if (!r->is_running) {
        r->is_running = true;
        r->due_s = t_s + r->config.slice_s;
        r->last_turn = turn;
        (void)sim_pass_touch(&r->pass, turn, z_mm);
        begin_turn(r, (double)sim_floor(turn), false);
        begin_slice(r, t_s, turn);
        return false;
    }
    remove_metal(r, turn, z_mm, radius_mm);
    r->is_clean = r->is_clean && is_judged;
    if (t_s < r->due_s) {
        return false;
    }
    const double next_s = r->due_s + r->config.slice_s;
    r->due_s = next_s > t_s ? next_s : t_s + r->config.slice_s;
    end_slice(r, t_s, turn, z_mm);
    begin_slice(r, t_s, turn);
    return true;
}
