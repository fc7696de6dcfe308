// SPDX-License-Identifier: Apache-2.0
#include "sim_design_table.h"
#include "sim_units.h" // SIM_NM_PER_MM, sim_clamp, sim_floor, sim_fraction
#include <math.h>      // ldexp
#include <stddef.h>    // size_t

typedef struct {
    double p, v, a;
} knot_t;

static knot_t blended(const cam_knot_t *low, const cam_knot_t *high, double w)
{
    return (knot_t){
        .p = low->p + w * ((double)high->p - low->p),
        .v = low->v + w * ((double)high->v - low->v),
        .a = low->a + w * ((double)high->a - low->a),
    };
}

static double quintic(knot_t k0, knot_t k1, double t)
{
    const double d = k1.p - k0.p - k0.v - k0.a;
    const double v = k1.v - k0.v - 2.0 * k0.a;
    const double a = k1.a - k0.a;
    const double c3 = 10.0 * d - 4.0 * v + a;
    const double c4 = -15.0 * d + 7.0 * v - 2.0 * a;
    const double c5 = 6.0 * d - 3.0 * v + a;
    return k0.p + t * (k0.v + t * (k0.a + t * (c3 + t * (c4 + t * c5))));
}

/// Find the slice below a height; *w is the weight of the slice above it.
static size_t slice_below(const cam_channel_t *ch, double z_mm, double *w)
{
    const double n = ch->n_slices - 1.0;
    const double above = (z_mm * SIM_NM_PER_MM - ch->z_first_nm) / ch->span_nm;
    const double place = sim_clamp(above, 0.0, 1.0) * n;
    const double i = sim_clamp((double)sim_floor(place), 0.0, n - 1.0);
    *w = place - i;
    return (size_t)i;
}

static double scaled(const cam_channel_t *ch, double lsb)
{
    return ch->value_offset + ldexp(lsb, -(int)ch->frac_bits);
}

double sim_design_table_long_mm(const cam_table_t *t, double z_mm)
{
    double w;
    const cam_knot_t *k = t->x.knots + slice_below(&t->x, z_mm, &w);
    return scaled(&t->x, quintic(blended(k, k, 0.0), blended(k + 1, k + 1, 0.0), w)) /
           SIM_NM_PER_MM;
}

/// Look up a channel over angle and height. @return the value in the unit of the channel
static double value_at(const cam_channel_t *ch, double turn, double z_mm)
{
    double w;
    const size_t n_knots = (size_t)1 << ch->log2_knots;
    const cam_knot_t *low = ch->knots + (slice_below(ch, z_mm, &w) << ch->log2_knots);
    const cam_knot_t *high = low + n_knots;
    const double pattern = sim_fraction(turn * (double)(1u << ch->log2_repeat));
    const double place = pattern * (double)n_knots;
    const size_t i = (size_t)place % n_knots;
    const size_t next = (i + 1u) % n_knots;
    const double lsb = quintic(blended(low + i, high + i, w), blended(low + next, high + next, w),
                               place - (double)(size_t)place);
    return scaled(ch, lsb);
}

/// @return [turn] a drawing's angle in the sense of cutting, in which tables count
static double in_sense(const cam_table_t *t, double turn)
{
    return t->direction < 0 ? -turn : turn;
}

double sim_design_table_radius_mm(const cam_table_t *t, double turn, double z_mm)
{
    const double u_nm = value_at(&t->u, in_sense(t, turn), z_mm);
    return sim_design_table_long_mm(t, z_mm) - u_nm / SIM_NM_PER_MM;
}

double sim_design_table_ratio(const cam_table_t *t, double turn, double z_mm)
{
    return t->speed.knots != NULL
               ? value_at(&t->speed, in_sense(t, turn), z_mm) / CAM_TABLE_RATIO_ONE
               : 1.0;
}
