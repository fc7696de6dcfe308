// SPDX-License-Identifier: Apache-2.0
#include "cam_learning_inner.h"
#include "cam_fix.h"     // CAM_TURN_Q32, cam_abs_i64
#include "cam_doubles.h" // CAM_PI, cam_limit, cam_nearest
#include <string.h>      // memset

#define MOST_Q32 INT64_C(67108864) ///< [turn / 2^32] largest plausible ripple: 1/64 turn

/// Subtract the angle of a uniform rotation from the mean angle of each bin.
/// @return false where a bin is empty or a deviation implausible
static bool subtract_uniform(cam_turn_bin_t *bin, uint32_t n_ticks)
{
    const int64_t per_tick_q40 = CAM_TURN_Q32 * 256 / n_ticks;
    int64_t begun = 0;
    bool is_good = true;
    for (uint32_t i = 0; i < cam_turn_bins_n && is_good; i++) {
        const int64_t n = bin[i].n;
        const int64_t begin_q32 = (int64_t)i << (32 - cam_turn_bins_log2);
        const int64_t uniform_q32 = per_tick_q40 * (2 * begun + n - 1) >> 9;
        const int64_t mean_q32 = n > 0 ? (int64_t)bin[i].angle_q24 * 256 / n : 0;
        const int64_t off_q32 = begin_q32 + mean_q32 - uniform_q32;
        const bool is_small = cam_abs_i64(off_q32) < MOST_Q32;
        is_good = is_small && n > 0;
        bin[i].angle_q24 = is_good ? (int32_t)off_q32 : 0;
        begun += n;
    }
    return is_good;
}

/// Remove the drift of a turn: extrapolated by half a bin, the deviation must be the same at both
/// ends; a difference comes from the assumed speed. @return [turn / 2^33] that difference
static int64_t close_ends(cam_turn_bin_t *bin)
{
    const cam_turn_bin_t *end = &bin[cam_turn_bins_n - 1];
    const int64_t first = 3 * (int64_t)bin[0].angle_q24 - bin[1].angle_q24;
    const int64_t last = 3 * (int64_t)end[0].angle_q24 - end[-1].angle_q24;
    const int64_t twice = last - first;
    const int64_t share = INT64_C(4) * cam_turn_bins_n;
    for (int32_t i = 0; i < cam_turn_bins_n; i++) {
        bin[i].angle_q24 -= (int32_t)(twice * (2 * (int64_t)i + 1) / share);
    }
    return twice;
}

int32_t cam_ripple_deviate(cam_turn_bin_t *bin)
{
    uint32_t n_ticks = 0;
    for (uint32_t i = 0; i < cam_turn_bins_n; i++) {
        n_ticks += (uint32_t)bin[i].n;
    }
    if (n_ticks < cam_turn_bins_n || !subtract_uniform(bin, n_ticks)) {
        return 0;
    }
    return cam_sat_i32((CAM_TURN_Q32 * 2 + close_ends(bin)) * 8 / n_ticks);
}

void cam_ripple_add(cam_ripple_t *r, uint32_t k, cam_complex_t angle_q32)
{
    cam_complex_t *sum = &r->sum[k - 1u];
    sum->re = cam_sat_i32((int64_t)sum->re + angle_q32.re);
    sum->im = cam_sat_i32((int64_t)sum->im + angle_q32.im);
}

void cam_ripple_drop(cam_ripple_t *r)
{
    (void)memset(r->sum, 0, sizeof r->sum);
    r->n = 0;
}

cam_complex_t cam_ripple_order(const cam_ripple_t *r, uint32_t k)
{
    const int32_t unit = 1 << cam_ripple_down;
    return (cam_complex_t){.re = r->mean[k - 1u].re * unit, .im = r->mean[k - 1u].im * unit};
}

uint32_t cam_ripple_sum(const cam_ripple_t *r)
{
    uint32_t sum = 0;
    for (uint32_t k = 1; k <= (uint32_t)cam_ilc_harmonics; k++) {
        sum += cam_complex_size(cam_ripple_order(r, k)) >> cam_ripple_down;
    }
    return sum;
}

/// @return [turn / 2^32] order 1, real, that a drift of the speed causes in the mean: d / (2 pi^2),
///         d the change of the speed per turn; order k has 1 / k^2 of it
static double drift_q32(const cam_ripple_t *r)
{
    const double change = ((double)r->last_q36 - r->first_q36) / r->last_q36;
    const double turns = r->n > 1u ? r->n - 1u : 1u;
    return change / turns * 0x1p32 / (2.0 * CAM_PI * CAM_PI);
}

/// @param n  turns in the sum, at least 1
static int32_t mean_of(double sum, uint32_t n)
{
    return cam_nearest(cam_limit(sum / n / (1 << cam_ripple_down), cam_ripple_most));
}

bool cam_ripple_close(cam_ripple_t *r, uint32_t n_turns, int32_t least_q32, int32_t speed_q36)
{
    r->first_q36 = r->n == 0u ? speed_q36 : r->first_q36;
    r->last_q36 = speed_q36;
    r->n++;
    if (r->n < n_turns) {
        return false;
    }
    const double drift = drift_q32(r) * r->n;
    const double least = (double)least_q32 * r->n;
    for (int32_t k = 1; k <= cam_ilc_harmonics; k++) {
        const double re = r->sum[k - 1].re - drift / (k * k);
        const double im = r->sum[k - 1].im;
        const bool is_seen = re * re + im * im > least * least;
        r->mean[k - 1].re = mean_of(is_seen ? re : 0.0, r->n);
        r->mean[k - 1].im = mean_of(is_seen ? im : 0.0, r->n);
    }
    r->n_mean = r->n;
    cam_ripple_drop(r);
    return true;
}
