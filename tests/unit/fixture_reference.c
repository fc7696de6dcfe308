// SPDX-License-Identifier: Apache-2.0
#include "fixture_reference.h"

typedef struct {
    long double p, v, a;
} exact_knot_t;

static exact_knot_t blend(const cam_knot_t *low, const cam_knot_t *high, long double w)
{
    return (exact_knot_t){
        .p = low->p + ((long double)high->p - low->p) * w,
        .v = low->v + ((long double)high->v - low->v) * w,
        .a = low->a + ((long double)high->a - low->a) * w,
    };
}

static fixture_value_t quintic(exact_knot_t k0, exact_knot_t k1, long double t)
{
    const long double dp = k1.p - k0.p - k0.v - k0.a;
    const long double dv = k1.v - k0.v - 2 * k0.a;
    const long double da = k1.a - k0.a;
    const long double c3 = 10 * dp - 4 * dv + da;
    const long double c4 = -15 * dp + 7 * dv - 2 * da;
    const long double c5 = 6 * dp - 3 * dv + da;
    return (fixture_value_t){
        .y = k0.p + t * (k0.v + t * (k0.a + t * (c3 + t * (c4 + t * c5)))),
        .d1 = k0.v + t * (2 * k0.a + t * (3 * c3 + t * (4 * c4 + t * 5 * c5))),
        .d2 = 2 * k0.a + t * (6 * c3 + t * (12 * c4 + t * 20 * c5)),
    };
}

fixture_value_t fixture_reference_surface(const cam_channel_t *ch, uint32_t theta_q32, uint32_t i,
                                          long double weight)
{
    const uint32_t n = 1u << ch->log2_knots;
    const uint64_t scaled = (uint64_t)theta_q32 << (ch->log2_knots + ch->log2_repeat);
    const uint32_t k = (uint32_t)(scaled >> 32) % n;
    const long double t = (long double)(scaled & 0xFFFFFFFFu) / 4294967296.0L;
    const cam_knot_t *low = ch->knots + (size_t)i * n;
    const cam_knot_t *high = low + n;
    return quintic(blend(&low[k], &high[k], weight),
                   blend(&low[(k + 1u) % n], &high[(k + 1u) % n], weight), t);
}

fixture_value_t fixture_reference_surface_at(const cam_channel_t *ch, uint32_t theta_q32,
                                             int32_t z_nm)
{
    const long double above = ((long double)z_nm - ch->z_first_nm) / ch->span_nm;
    const long double in = above < 0 ? 0 : above > 1 ? 1 : above;
    const long double slice = in * (ch->n_slices - 1u);
    const uint32_t i = slice >= ch->n_slices - 1u ? ch->n_slices - 2u : (uint32_t)slice;
    return fixture_reference_surface(ch, theta_q32, i, slice - i);
}

fixture_value_t fixture_reference_profile(const cam_channel_t *ch, uint32_t i, long double t)
{
    const cam_knot_t *k = ch->knots + i;
    return quintic(blend(&k[0], &k[0], 0), blend(&k[1], &k[1], 0), t);
}
