// SPDX-License-Identifier: Apache-2.0
#include "sim_config.h"
#include "sim_design.h" // sim_design_table_ratio
#include "sim_units.h"  // SIM_NM_PER_MM
#include <math.h>       // ceil, floor, fmax, fmin
#include <stdio.h>      // snprintf

enum { n_angles = 1440, heights_per_slice = 4 };

static double stopped_rpm(const cam_params_t *p)
{
    return p->stopped_mrpm * 1e-3;
}

/// @return number of heights to check: one on each lobe of a shaft; one without modulation
static uint32_t n_heights(const cam_table_t *t)
{
    if (t->n_lobes > 0u && t->speed.knots != NULL) {
        return t->n_lobes;
    }
    return t->speed.knots != NULL ? heights_per_slice * (t->speed.n_slices - 1u) + 1u : 1u;
}

static double height_mm(const cam_table_t *t, uint32_t i)
{
    if (t->n_lobes > i) {
        return ((double)t->lobes[i].z_first_nm + t->lobes[i].z_last_nm) / 2.0 / SIM_NM_PER_MM;
    }
    const uint32_t last = n_heights(t) - 1u;
    const double share = last > 0u ? (double)i / last : 0.0;
    return (t->z_first_nm + share * ((double)t->z_last_nm - t->z_first_nm)) / SIM_NM_PER_MM;
}

/// @return the longest slow time at a height, over two turns because the slow part may cross the
///         start of the turn
static double longest_at_s(const cam_table_t *t, double z_mm, double mean_rpm, double slow_rpm)
{
    double run_s = 0.0;
    double longest_s = 0.0;
    for (int i = 0; i < 2 * n_angles; i++) {
        const double turn = (double)(i % n_angles) / n_angles;
        const double rpm = mean_rpm * sim_design_table_ratio(t, turn, z_mm);
        run_s = rpm < slow_rpm ? run_s + 60.0 / (rpm * n_angles) : 0.0;
        longest_s = fmax(longest_s, run_s);
    }
    return longest_s;
}

static double least_ratio(const cam_table_t *t)
{
    double least = 1.0;
    for (uint32_t k = 0; k < n_heights(t); k++) {
        for (int i = 0; i < n_angles; i++) {
            least = fmin(least, sim_design_table_ratio(t, (double)i / n_angles, height_mm(t, k)));
        }
    }
    return least;
}

double sim_slow_longest_s(const cam_table_t *table, const cam_params_t *params, double mean_rpm)
{
    double longest_s = 0.0;
    for (uint32_t k = 0; k < n_heights(table); k++) {
        const double z_mm = height_mm(table, k);
        longest_s = fmax(longest_s, longest_at_s(table, z_mm, mean_rpm, stopped_rpm(params)));
    }
    return longest_s;
}

bool sim_slow_is_turning(const cam_table_t *table, const cam_params_t *params, double mean_rpm)
{
    return mean_rpm >= stopped_rpm(params) &&
           sim_slow_longest_s(table, params, mean_rpm) * 1e3 <= params->stopped_ms;
}

/// A spindle that is never slower than stopped_mrpm has no problem with lag and ripple either.
/// @return the remedy
static common_error_t remedy(const cam_table_t *t, const cam_params_t *p, const cam_refusal_t *f)
{
    const double ratio = least_ratio(t);
    const double least_rpm = ceil(stopped_rpm(p) / ratio * 10.0) / 10.0;
    const double slowest_mrpm = fmax(floor(f->speed_mrpm * ratio), 1.0);
    char speed[60] = "make the table for a faster spindle";
    if (least_rpm * 1e3 <= f->highest_mrpm) {
        (void)snprintf(speed, sizeof speed, "give at least --rpm %.1f", least_rpm);
    }
    common_error_t text;
    (void)common_error(&text, "%s, or --set stopped_mrpm=%.0f", speed, slowest_mrpm);
    return text;
}

bool sim_slow_check(const cam_table_t *table, const cam_params_t *params,
                    const cam_refusal_t *feasibility, common_error_t *e)
{
    const double mean_rpm = feasibility->speed_mrpm * 1e-3;
    if (sim_slow_is_turning(table, params, mean_rpm)) {
        return true;
    }
    const common_error_t what = remedy(table, params, feasibility);
    if (mean_rpm < stopped_rpm(params)) {
        return common_error(
            e, "--rpm %.12g: below %.12g (stopped_mrpm) the spindle counts as stopped; %s",
            mean_rpm, stopped_rpm(params), what.text);
    }
    return common_error(e,
                        "--rpm %.12g: in a turn it falls to %.4g, and for %.0f ms below %.12g "
                        "(stopped_mrpm), which is a fault after %d ms (stopped_ms); %s",
                        mean_rpm, mean_rpm * least_ratio(table),
                        sim_slow_longest_s(table, params, mean_rpm) * 1e3, stopped_rpm(params),
                        (int)params->stopped_ms, what.text);
}
