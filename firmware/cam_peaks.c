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
    int64_t second;  ///< second derivative, times 512
} bounds_t;

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

/// Bernstein coefficients of the quintic of TABLE_FORMAT.md and of its derivative; those at its
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
    const int64_t c5 = 6 * dp - 3 * dv + da;
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
    widen(&b->second, second_512(a0, c3, c4, c5));
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
    const int64_t second = ((((b.second >> 9) + 1) * per_turn * mdeg_per_rad_turn) >> 13) + 1;
    return (cam_swing_peaks_t){
        .most_mdeg = saturated(((b.tenfold / 10 + 1) * mdeg_per_turn >> down) + 1),
        .first_mdeg_per_rad = saturated((b.twice * per_turn * mdeg_per_rad >> (down + 1u)) + 1),
        .second_mdeg_per_rad2 = saturated((second * per_turn >> (down - 13u)) + 1),
    };
}
