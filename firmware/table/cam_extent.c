// SPDX-License-Identifier: Apache-2.0
#include "cam_extent.h"
#include "cam_bounds.h" // cam_bounds_next
#include "cam_fix.h"    // cam_is_between

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
    const int64_t tenth = SCALE / 10;
    const int64_t from = 10 * (int64_t)k0->p;
    const int64_t to = 10 * (int64_t)k1->p;
    const int64_t v0 = k0->v;
    const int64_t v1 = k1->v;
    return (hull_t){{from * tenth, (from + 2 * v0) * tenth, (from + 4 * v0 + k0->a) * tenth,
                     (to - 4 * v1 + k1->a) * tenth, (to - 2 * v1) * tenth, to * tenth}};
}

/// Both halves of an interval.
typedef struct {
    hull_t lower;
    hull_t upper;
} halves_t;

/// Halve an interval by de Casteljau's means, which are whole (SCALE). After r rounds the first
/// mean is coefficient r of the lower half, and the last one is coefficient 5 - r of the upper
/// half.
static halves_t halves_of(hull_t mean)
{
    halves_t half;
    for (int32_t r = 0; r < 6; r++) {
        half.lower.c[r] = mean.c[0];
        half.upper.c[5 - r] = mean.c[5 - r];
        for (int32_t i = 0; i + r < 5; i++) {
            mean.c[i] = (mean.c[i] + mean.c[i + 1]) >> 1;
        }
    }
    return half;
}

// Ranges are in LSB / SCALE below.
static bool is_covered(const cam_extent_t *range, const hull_t *hull)
{
    bool is_inside = true;
    for (int32_t i = 0; i < 6; i++) {
        is_inside = is_inside && cam_is_between(hull->c[i], range->low, range->high);
    }
    return is_inside;
}

static void cover(cam_extent_t *range, const hull_t *hull)
{
    for (int32_t i = 0; i < 6; i++) {
        range->low = hull->c[i] < range->low ? hull->c[i] : range->low;
        range->high = hull->c[i] > range->high ? hull->c[i] : range->high;
    }
}

/// Widen a range by both halves of a quarter of an interval, unless it covers the quarter.
static void widen_by_quarter(cam_extent_t *range, const hull_t *quarter)
{
    if (!is_covered(range, quarter)) {
        const halves_t eighths = halves_of(*quarter);
        cover(range, &eighths.lower);
        cover(range, &eighths.upper);
    }
}

static void widen_by_half(cam_extent_t *range, const hull_t *half)
{
    if (!is_covered(range, half)) {
        const halves_t quarters = halves_of(*half);
        widen_by_quarter(range, &quarters.lower);
        widen_by_quarter(range, &quarters.upper);
    }
}

static void widen_by_segment(cam_extent_t *range, const cam_knot_t *k0, const cam_knot_t *k1)
{
    const hull_t whole = hull_of(k0, k1);
    if (!is_covered(range, &whole)) { // few segments
        const halves_t halves = halves_of(whole);
        widen_by_half(range, &halves.lower);
        widen_by_half(range, &halves.upper);
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
