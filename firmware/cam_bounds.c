// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_bounds.h"
#include "cam/cam_fix.h" // cam_abs_i64

static void widen(int64_t *bound, int64_t value)
{
    const int64_t magnitude = cam_abs_i64(value);
    *bound = magnitude > *bound ? magnitude : *bound;
}

/// The second derivative at eighths, and the h^2 / 8 |f''| by which a function leaves the straight
/// line between two of them: 1/512 of its own second derivative, which is largest at an end.
static int64_t second_512(int64_t a0, int64_t c3, int64_t c4, int64_t c5)
{
    int64_t most = 0;
    for (int64_t k = 0; k <= 8; k++) {
        widen(&most, 1024 * a0 + 384 * c3 * k + 96 * c4 * k * k + 20 * c5 * k * k * k);
    }
    int64_t bend = 0;
    widen(&bend, 24 * c4);
    widen(&bend, 24 * c4 + 120 * c5);
    return most + bend;
}

/// The coefficients at the end of a quintic are the next one's first.
void cam_bounds_add(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1)
{
    const int64_t a0 = k0->a;
    const int64_t v0 = k0->v;
    const int64_t dp = k1->p - k0->p - v0 - a0;
    const int64_t dv = k1->v - v0 - 2 * a0;
    const int64_t da = k1->a - a0;
    const int64_t c3 = 10 * dp - 4 * dv + da;
    const int64_t c4 = -15 * dp + 7 * dv - 2 * da;
    const int64_t c5 = 6 * dp - 3 * dv + da;
    const int64_t from = 10 * k0->p;
    const int64_t to = 10 * k1->p;
    widen(&b->tenfold, from);
    widen(&b->tenfold, from + 2 * v0);
    widen(&b->tenfold, from + 4 * v0 + a0);
    widen(&b->tenfold, to - 4 * k1->v + k1->a);
    widen(&b->tenfold, to - 2 * k1->v);
    widen(&b->twice, 2 * v0);
    widen(&b->twice, 2 * v0 + a0);
    widen(&b->twice, 2 * v0 + 2 * a0 + c3);
    widen(&b->twice, 2 * k1->v - k1->a);
    widen(&b->second_512, second_512(a0, c3, c4, c5));
}

uint32_t cam_bounds_next(const cam_channel_t *ch, uint32_t i)
{
    const uint32_t in_slice = i & ((UINT32_C(1) << ch->log2_knots) - 1u);
    return i - in_slice + ((in_slice + 1u) & ((UINT32_C(1) << ch->log2_knots) - 1u));
}
