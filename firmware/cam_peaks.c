// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_peaks.h"
#include "cam/cam_fix.h" // cam_abs_i64

/// Thousandths of a degree in a turn, in a radian, in a radian divided by 2 pi; rounded up.
enum { mdeg_per_turn = 360000, mdeg_per_rad = 57296, mdeg_per_rad_turn = 9119 };

/// Fraction bits of the unit of an angle, in turns.
enum { unit_bits = 26 };

/// Largest magnitudes so far, in the LSB of the channel and per knot interval.
typedef struct {
    int64_t tenfold; ///< value, times 10
    int64_t twice;   ///< first derivative, times 2
    int64_t second;  ///< second derivative
} bounds_t;

static void widen(int64_t *bound, int64_t value)
{
    const int64_t magnitude = cam_abs_i64(value);
    *bound = magnitude > *bound ? magnitude : *bound;
}

/// Bernstein coefficients of the quintic of TABLE_FORMAT.md and of its derivatives; those at its
/// end are the next one's first.
static void add_segment(bounds_t *b, const cam_knot_t *k0, const cam_knot_t *k1, int64_t offset)
{
    const int64_t a0 = k0->a;
    const int64_t v0 = k0->v;
    const int64_t dp = (int64_t)k1->p - k0->p - v0 - a0;
    const int64_t dv = (int64_t)k1->v - v0 - 2 * a0;
    const int64_t da = (int64_t)k1->a - a0;
    const int64_t c3 = 10 * dp - 4 * dv + da;
    const int64_t c4 = -15 * dp + 7 * dv - 2 * da;
    const int64_t from = 10 * (k0->p + offset);
    const int64_t to = 10 * (k1->p + offset);
    widen(&b->tenfold, from);
    widen(&b->tenfold, from + 2 * v0);
    widen(&b->tenfold, from + 4 * v0 + a0);
    widen(&b->tenfold, to - INT64_C(4) * k1->v + k1->a);
    widen(&b->tenfold, to - INT64_C(2) * k1->v);
    widen(&b->twice, 2 * v0);
    widen(&b->twice, 2 * v0 + a0);
    widen(&b->twice, 2 * v0 + 2 * a0 + c3);
    widen(&b->twice, INT64_C(2) * k1->v - k1->a);
    widen(&b->second, 2 * a0);
    widen(&b->second, 2 * a0 + 2 * c3);
    widen(&b->second, 2 * a0 + 4 * c3 + 4 * c4);
}

static uint32_t saturated(int64_t v)
{
    return v < (int64_t)UINT32_MAX ? (uint32_t)v : UINT32_MAX;
}

cam_swing_peaks_t cam_peaks_of_swing(const cam_channel_t *ch)
{
    const uint32_t n_in_slice = UINT32_C(1) << ch->log2_knots;
    const uint32_t n = ch->n_slices << ch->log2_knots;
    const int64_t offset = (int64_t)ch->offset_nm * (INT64_C(1) << ch->frac_bits);
    bounds_t b = {0};
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t in_slice = i & (n_in_slice - 1u);
        const uint32_t next = i - in_slice + ((in_slice + 1u) & (n_in_slice - 1u));
        add_segment(&b, &ch->knots[i], &ch->knots[next], offset);
    }
    const int64_t per_turn = INT64_C(1) << (ch->log2_knots + ch->log2_repeat);
    const uint32_t down = unit_bits + ch->frac_bits;
    const int64_t second = ((b.second * per_turn * mdeg_per_rad_turn) >> 13) + 1;
    return (cam_swing_peaks_t){
        .most_mdeg = saturated(((b.tenfold / 10 + 1) * mdeg_per_turn >> down) + 1),
        .first_mdeg_per_rad = saturated((b.twice * per_turn * mdeg_per_rad >> (down + 1u)) + 1),
        .second_mdeg_per_rad2 = saturated((second * per_turn >> (down - 13u)) + 1),
    };
}
