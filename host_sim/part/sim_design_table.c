// SPDX-License-Identifier: Apache-2.0
#include "sim_design.h"
#include "cam_eval.h"  // cam_lobes_find
#include "sim_units.h" // SIM_NM_PER_MM, sim_clamp, sim_floor, sim_fraction
#include <math.h>      // ldexp
#include <stdbool.h>   // bool
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

/// Position for a look-up in a channel over angle.
typedef struct {
    double turn;
    size_t slice; ///< the slice below, or the pattern itself
    double w;     ///< weight of the slice above
} place_t;

/// Shares of lift and speed ratio at a height of a shaft with lobes.
typedef struct {
    double lift, ratio;
} share_t;

static double smooth_step(double s)
{
    const double t = sim_clamp(s, 0.0, 1.0);
    return t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
}

/// @return the lobe of a shaft at a height
static uint32_t lobe_at(const cam_table_t *t, double z_mm)
{
    const double z_nm = sim_clamp(z_mm * SIM_NM_PER_MM, t->z_first_nm, t->z_last_nm);
    return cam_lobes_find(t, (int32_t)sim_floor(z_nm + 0.5));
}

/// @return progress of the change to the next lobe, or from the previous one; 1 in the middle
static double change_at(const cam_table_t *t, uint32_t i, double z_mm)
{
    const cam_lobe_t *lobe = &t->lobes[i];
    const double above_nm = z_mm * SIM_NM_PER_MM - lobe->z_last_nm;
    const double below_nm = lobe->z_first_nm - z_mm * SIM_NM_PER_MM;
    const bool is_above = above_nm > below_nm;
    if (is_above ? i + 1u >= t->n_lobes : i == 0u) {
        return 0.0;
    }
    const cam_lobe_t *low = is_above ? lobe : lobe - 1;
    const double gap_nm = (double)low[1].z_first_nm - low->z_last_nm;
    const double off_nm = (is_above ? above_nm : below_nm) - cam_lobes_kept_off_nm;
    return off_nm / (gap_nm / 2.0 - cam_lobes_kept_off_nm);
}

/// With a speed channel the lift uses the first half of a change, the ratio the second.
static share_t share_at(const cam_table_t *t, double z_mm)
{
    if (t->n_lobes == 0u) {
        return (share_t){1.0, 1.0};
    }
    const double s = change_at(t, lobe_at(t, z_mm), z_mm);
    const double stretch = t->speed.knots != NULL ? 2.0 : 1.0;
    return (share_t){1.0 - smooth_step(stretch * s), 1.0 - smooth_step(2.0 * s - 1.0)};
}

static place_t place_at(const cam_table_t *t, const cam_channel_t *ch, double turn, double z_mm)
{
    place_t at = {.turn = turn};
    if (t->n_lobes > 0u) {
        const cam_lobe_t *lobe = &t->lobes[lobe_at(t, z_mm)];
        const bool is_last = lobe->pattern + 1u == ch->n_slices;
        at.turn = turn - ldexp(lobe->phase_q32, -32);
        at.slice = lobe->pattern - (is_last ? 1u : 0u);
        at.w = is_last ? 1.0 : 0.0;
    } else {
        at.slice = slice_below(ch, z_mm, &at.w);
    }
    return at;
}

/// Evaluate a channel over angle and height. @return the value in the channel's unit
static double value_at(const cam_table_t *t, const cam_channel_t *ch, double turn, double z_mm)
{
    const place_t at = place_at(t, ch, turn, z_mm);
    const double w = at.w;
    const size_t n_knots = (size_t)1 << ch->log2_knots;
    const cam_knot_t *low = ch->knots + (at.slice << ch->log2_knots);
    const cam_knot_t *high = low + n_knots;
    const double pattern = sim_fraction(at.turn * (double)(1u << ch->log2_repeat));
    const double place = pattern * (double)n_knots;
    const size_t i = (size_t)place % n_knots;
    const size_t next = (i + 1u) % n_knots;
    const double lsb = quintic(blended(low + i, high + i, w), blended(low + next, high + next, w),
                               place - (double)(size_t)place);
    return scaled(ch, lsb);
}

/// @return [turn] a drawing's angle in the sense of cutting, as in tables
static double in_sense(const cam_table_t *t, double turn)
{
    return t->direction < 0 ? -turn : turn;
}

double sim_design_table_radius_mm(const cam_table_t *t, double turn, double z_mm)
{
    const double lift_nm = value_at(t, &t->u, in_sense(t, turn), z_mm);
    return sim_design_table_long_mm(t, z_mm) - share_at(t, z_mm).lift * lift_nm / SIM_NM_PER_MM;
}

double sim_design_table_ratio(const cam_table_t *t, double turn, double z_mm)
{
    if (t->speed.knots == NULL) {
        return 1.0;
    }
    const double ratio = value_at(t, &t->speed, in_sense(t, turn), z_mm) / CAM_TABLE_RATIO_ONE;
    return 1.0 + share_at(t, z_mm).ratio * (ratio - 1.0);
}
