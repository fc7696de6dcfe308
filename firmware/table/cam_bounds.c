// SPDX-License-Identifier: Apache-2.0
#include "cam_table_inner.h"
#include "cam_fix.h" // cam_abs_i64, cam_is_between

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

cam_wide_knot_t cam_bounds_wide(const cam_knot_t *knot, int64_t offset)
{
    return (cam_wide_knot_t){knot->p + offset, knot->v, knot->a};
}

void cam_bounds_tenfold(const cam_wide_knot_t *k0, const cam_wide_knot_t *k1, int64_t c[6])
{
    c[0] = 10 * k0->p;
    c[1] = c[0] + 2 * k0->v;
    c[2] = c[0] + 4 * k0->v + k0->a;
    c[5] = 10 * k1->p;
    c[4] = c[5] - 2 * k1->v;
    c[3] = c[5] - 4 * k1->v + k1->a;
}

// The last coefficient of a segment is the first one of the next segment, which adds it.
void cam_bounds_add(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1)
{
    int64_t tenfold[6];
    cam_bounds_tenfold(k0, k1, tenfold);
    for (uint32_t i = 0; i < 5u; i++) {
        widen(&b->tenfold, tenfold[i]);
    }
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
    const uint32_t in_slice = (UINT32_C(1) << ch->log2_knots) - 1u;
    return (i & ~in_slice) | ((i + 1u) & in_slice);
}

/// Factor that keeps all numbers whole: ten for the Bernstein coefficients of a quintic, 2^5 for
/// each of three halvings. Tenfold coefficients are below 2^29 LSB, so these are below 2^44; ends
/// of a range are below 2^59.
#define SCALE (INT64_C(10) << 15)

/// Bernstein coefficients of a quintic, in LSB / SCALE.
typedef struct {
    int64_t c[6];
} hull_t;

static hull_t hull_of(const cam_knot_t *k0, const cam_knot_t *k1)
{
    const cam_wide_knot_t from = cam_bounds_wide(k0, 0);
    const cam_wide_knot_t to = cam_bounds_wide(k1, 0);
    hull_t hull;
    cam_bounds_tenfold(&from, &to, hull.c);
    for (uint32_t i = 0; i < 6u; i++) {
        hull.c[i] *= SCALE / 10;
    }
    return hull;
}

/// Halve an interval by de Casteljau's means, which are whole (SCALE). After r rounds the first
/// mean is coefficient r of the lower half, the last one coefficient 5 - r of the upper half.
static void halve(hull_t mean, hull_t *lower, hull_t *upper)
{
    for (int32_t r = 0; r < 6; r++) {
        lower->c[r] = mean.c[0];
        upper->c[5 - r] = mean.c[5 - r];
        for (int32_t i = 0; i + r < 5; i++) {
            mean.c[i] = (mean.c[i] + mean.c[i + 1]) >> 1;
        }
    }
}

static bool is_covered(const cam_extent_t *range, const hull_t *hull)
{
    bool is_inside = true;
    for (int32_t i = 0; i < 6; i++) {
        is_inside = is_inside && cam_is_between(hull->c[i], range->low, range->high);
    }
    return is_inside;
}

/// Widen a range in LSB / SCALE by the eighths of an interval, unless it covers the interval.
static void widen_by_segment(cam_extent_t *range, const cam_knot_t *k0, const cam_knot_t *k1)
{
    hull_t part[8];
    part[0] = hull_of(k0, k1);
    if (is_covered(range, &part[0])) { // most segments
        return;
    }
    for (uint32_t n = 1; n < 8u; n *= 2u) {
        for (uint32_t i = n; i > 0u; i--) { // from the last part, so that none is overwritten
            halve(part[i - 1u], &part[2u * i - 2u], &part[2u * i - 1u]);
        }
    }
    for (uint32_t i = 0; i < 48u; i++) {
        const int64_t c = part[i / 6u].c[i % 6u];
        range->low = c < range->low ? c : range->low;
        range->high = c > range->high ? c : range->high;
    }
}

cam_extent_t cam_extent_of_knots(const cam_channel_t *ch, int64_t p_min, int64_t p_max)
{
    const int64_t below_one = (INT64_C(1) << ch->frac_bits) - 1;
    return (cam_extent_t){ch->value_offset + ((p_min - 1) >> ch->frac_bits),
                          ch->value_offset + ((p_max + 1 + below_one) >> ch->frac_bits)};
}

cam_extent_t cam_extent_widened(const cam_channel_t *ch, bool is_around, cam_extent_t known)
{
    const int64_t one = INT64_C(1) << ch->frac_bits;
    cam_extent_t range = {((known.low - ch->value_offset) * one + 1) * SCALE,
                          ((known.high - ch->value_offset) * one - 1) * SCALE};
    const uint32_t n = ch->n_slices << ch->log2_knots;
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t next = is_around ? cam_bounds_next(ch, i) : i + 1u;
        if (next < n) {
            widen_by_segment(&range, &ch->knots[i], &ch->knots[next]);
        }
    }
    // Rounding to whole LSB and units again does not change an end that was not widened.
    return cam_extent_of_knots(
        ch, range.low >= 0 ? range.low / SCALE : -((SCALE - 1 - range.low) / SCALE),
        range.high >= 0 ? (range.high + SCALE - 1) / SCALE : -(-range.high / SCALE));
}
