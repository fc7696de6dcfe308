// SPDX-License-Identifier: Apache-2.0
#include "cam_bounds.h"
#include "cam_fix.h" // cam_abs_i64

/// Raise a bound to the magnitude of a value.
static void widen(int64_t *bound, int64_t value)
{
    const int64_t magnitude = cam_abs_i64(value);
    *bound = magnitude > *bound ? magnitude : *bound;
}

/// Coefficients c3, c4 and c5 of a quintic: TABLE_FORMAT.md, "Knots".
typedef struct {
    int64_t c3, c4, c5;
} rest_t;

/// D, V and A of the format are dp, dv and da here.
static rest_t rest_of(const cam_wide_knot_t *k0, const cam_wide_knot_t *k1)
{
    const int64_t dp = k1->p - k0->p - k0->v - k0->a;
    const int64_t dv = k1->v - k0->v - 2 * k0->a;
    const int64_t da = k1->a - k0->a;
    return (rest_t){
        .c3 = 10 * dp - 4 * dv + da, .c4 = -15 * dp + 7 * dv - 2 * da, .c5 = 6 * dp - 3 * dv + da};
}

// The last coefficient of a segment is the first one of the next segment, which adds it.
void cam_bounds_add(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1)
{
    const int64_t from = 10 * k0->p;
    const int64_t to = 10 * k1->p;
    widen(&b->tenfold, from);
    widen(&b->tenfold, from + 2 * k0->v);
    widen(&b->tenfold, from + 4 * k0->v + k0->a);
    widen(&b->tenfold, to - 4 * k1->v + k1->a);
    widen(&b->tenfold, to - 2 * k1->v);
    widen(&b->twice, 2 * k0->v);
    widen(&b->twice, 2 * k0->v + k0->a);
    widen(&b->twice, 2 * k0->v + 2 * k0->a + rest_of(k0, k1).c3);
    widen(&b->twice, 2 * k1->v - k1->a);
}

// f(t) = 2 a + 6 c3 t + 12 c4 t^2 + 20 c5 t^3, evaluated at t = k / 32. In between it deviates from
// the chord by at most d^2 / 8 |f''| = |f''| / 8192 with d = 1/32; f'' is linear in t and therefore
// largest at an end of the interval.
void cam_bounds_add_second(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1)
{
    const rest_t c = rest_of(k0, k1);
    int64_t most = 0;
    for (int64_t k = 0; k <= 32; k++) {
        widen(&most, 16384 * k0->a + 1536 * c.c3 * k + 96 * c.c4 * k * k + 5 * c.c5 * k * k * k);
    }
    int64_t bend = 0;
    widen(&bend, 24 * c.c4);
    widen(&bend, 24 * c.c4 + 120 * c.c5);
    widen(&b->second_8192, most + bend);
}

void cam_bounds_add_third(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1)
{
    const rest_t c = rest_of(k0, k1);
    widen(&b->third, 6 * c.c3);
    widen(&b->third, 6 * c.c3 + 12 * c.c4);
    widen(&b->third, 6 * c.c3 + 24 * c.c4 + 60 * c.c5);
}

uint32_t cam_bounds_next(const cam_channel_t *ch, uint32_t i)
{
    const uint32_t in_slice = i & ((UINT32_C(1) << ch->log2_knots) - 1u);
    return i - in_slice + ((in_slice + 1u) & ((UINT32_C(1) << ch->log2_knots) - 1u));
}
