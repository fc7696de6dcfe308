// SPDX-License-Identifier: Apache-2.0
#include "cam_learning_inner.h"
#include "cam_doubles.h" // cam_limit, cam_nearest
#include "cam_fix.h"     // cam_clamp_i32
#include <string.h>      // memset

enum { most_halved = 4 }; ///< halvings of the gain that mask a harmonic

void cam_harmonic_correction_forget(cam_harmonic_correction_t *s)
{
    (void)memset(s, 0, sizeof *s);
    cam_harmonic_correction_restart_guard(s);
}

void cam_harmonic_correction_restart_guard(cam_harmonic_correction_t *s)
{
    for (uint32_t k = 0; k < cam_ilc_terms; k++) {
        s->best_q6[k] = UINT32_MAX;
        s->last_q6[k] = UINT32_MAX;
        s->n_halved[k] = 0;
    }
}

/// @return rounded to whole nm, limited
static int32_t whole_q6(int32_t q6)
{
    return 64 * cam_clamp_i32((q6 + 32) >> 6, -INT16_MAX, INT16_MAX);
}

static void keep(cam_harmonic_correction_t *s, uint32_t k, cam_complex_t q6)
{
    s->kept_q6[k] = (cam_complex_t){.re = whole_q6(q6.re), .im = whole_q6(q6.im)};
}

void cam_harmonic_correction_set_probe(cam_harmonic_correction_t *s, int32_t size_q6, uint32_t n,
                                       uint32_t which)
{
    for (uint32_t k = 0; k < cam_ilc_terms; k++) {
        const int64_t size = k <= n && (which >> k & 1u) != 0u ? (int64_t)size_q6 : 0;
        const uint32_t step = 128u * k * k / n;
        s->c_q6[k].re = (int32_t)(size * cam_cos_q24(step) >> 24);
        s->c_q6[k].im = (int32_t)(size * cam_sin_q24(step) >> 24);
    }
}

/// @return whether U responds with less than a tenth, or by 20 % out of proportion to the probe
static bool is_unusable(cam_complex_t small, cam_complex_t large)
{
    const uint64_t square = cam_complex_square(large);
    const uint64_t off = cam_complex_square(cam_complex_sub(large, small));
    return square * 100u < UINT64_C(1) << 24 || off * 25u > square;
}

void cam_harmonic_correction_probe(cam_harmonic_correction_t *s, uint32_t stage, uint32_t k,
                                   cam_complex_t error_q6)
{
    if (stage == 0u) {
        keep(s, k, error_q6);
        return;
    }
    const uint32_t bit = UINT32_C(1) << k;
    if (stage > 2u && (s->masked & bit) == 0u) {
        return; // its response is known
    }
    const cam_complex_t decrease = cam_complex_sub(s->kept_q6[k], error_q6);
    const cam_complex_t gain = cam_gain_ratio(decrease, s->c_q6[k]);
    const bool is_masked = stage >= 2u && is_unusable(s->gain[k], gain);
    s->masked = is_masked ? s->masked | bit : s->masked & ~bit;
    s->gain[k] = gain;
}

/// @param is_good  small enough to learn from; such an error may double by noise
/// @return whether an error has a new cause, such as a gap in the material: it has doubled in a
///         turn, which learning cannot do; if it doubles again, learning diverges
static bool is_of_new_cause(cam_harmonic_correction_t *s, uint32_t k, uint32_t size_q6,
                            bool is_good)
{
    const bool is_new = !is_good && size_q6 / 2u > s->last_q6[k];
    s->last_q6[k] = is_new ? UINT32_MAX : size_q6;
    return is_new;
}

/// Guard of a harmonic. @return whether its error is small enough to learn from
static bool is_as_good(cam_harmonic_correction_t *s, uint32_t k, uint32_t size_q6,
                       uint32_t floor_q6)
{
    const uint32_t best_q6 = s->best_q6[k] > floor_q6 ? s->best_q6[k] : floor_q6;
    const bool is_good = size_q6 / 3u <= best_q6 / 2u;
    const bool is_new = is_of_new_cause(s, k, size_q6, is_good);
    if (is_new || size_q6 < s->best_q6[k]) {
        // The turn in which it appears may show half of it.
        s->best_q6[k] = is_new && size_q6 < UINT32_MAX / 2u ? 2u * size_q6 : size_q6;
        keep(s, k, s->c_q6[k]);
    }
    if (is_good || is_new) {
        return true;
    }
    s->c_q6[k] = s->kept_q6[k];
    s->n_halved[k]++;
    s->masked |= s->n_halved[k] >= most_halved ? UINT32_C(1) << k : 0u;
    return false;
}

/// @return mu E / G in the unit of E, its parts limited to +-2^30; 0 when G is 0
static cam_complex_t correction_change(cam_complex_t error, cam_complex_t gain, int32_t mu_q16)
{
    const double square_q24 = (double)cam_complex_square(gain);
    const double by = square_q24 > 0.0 ? mu_q16 / (square_q24 * 16.0) : 0.0;
    const double re = (double)error.re * gain.re + (double)error.im * gain.im;
    const double im = (double)error.im * gain.re - (double)error.re * gain.im;
    return (cam_complex_t){.re = cam_nearest(cam_limit(re * by, 0x1p30)),
                           .im = cam_nearest(cam_limit(im * by, 0x1p30))};
}

/// Add a change, scaled down where the size would grow beyond the room, and subtract the growth
/// from the room.
static cam_complex_t extended(cam_complex_t c, cam_complex_t change, uint32_t *room_q6)
{
    const int64_t room = (int64_t)*room_q6;
    const int64_t before = cam_complex_size(c);
    cam_complex_t next = cam_complex_add(c, change);
    if (cam_complex_size(next) > before + room) {
        const int64_t size = cam_complex_size(change);
        next.re = c.re + (int32_t)(change.re * room / size);
        next.im = c.im + (int32_t)(change.im * room / size);
    }
    const int64_t grown = cam_complex_size(next) - before;
    *room_q6 = (uint32_t)cam_clamp_i64(room - grown, 0, room);
    return next;
}

bool cam_harmonic_correction_learn(cam_harmonic_correction_t *s, uint32_t k, cam_complex_t error_q6,
                                   uint32_t floor_q6, int32_t mu_q16, uint32_t *room_q6)
{
    // The mean is not guarded: it has no phase, and the cutting force moves it.
    const bool is_guarded = k > 0u;
    const uint32_t size_q6 = cam_complex_size(error_q6);
    const bool is_calm = size_q6 <= s->last_q6[k];
    if ((s->masked >> k & 1u) != 0u || (is_guarded && !is_as_good(s, k, size_q6, floor_q6))) {
        return is_calm;
    }
    const cam_complex_t change = correction_change(error_q6, s->gain[k], mu_q16 >> s->n_halved[k]);
    s->c_q6[k] = extended(s->c_q6[k], change, room_q6);
    return is_calm;
}

void cam_harmonic_correction_age(cam_harmonic_correction_t *s, uint32_t k)
{
    const uint32_t best_q6 = s->best_q6[k];
    s->best_q6[k] = best_q6 < UINT32_MAX / 2u ? best_q6 + best_q6 / 16u + 1u : best_q6;
}

void cam_harmonic_correction_restore(cam_harmonic_correction_t *s)
{
    for (uint32_t k = 0; k < cam_ilc_terms; k++) {
        s->c_q6[k] = s->best_q6[k] != UINT32_MAX ? s->kept_q6[k] : s->c_q6[k];
    }
}

void cam_harmonic_correction_scale(cam_harmonic_correction_t *s, uint32_t part_q16)
{
    for (uint32_t k = 0; k < cam_ilc_terms; k++) {
        s->c_q6[k].re = (int32_t)((int64_t)s->c_q6[k].re * part_q16 >> 16);
        s->c_q6[k].im = (int32_t)((int64_t)s->c_q6[k].im * part_q16 >> 16);
    }
}

uint32_t cam_harmonic_correction_sum_q6(const cam_harmonic_correction_t *s)
{
    uint32_t sum = 0;
    for (uint32_t k = 0; k < cam_ilc_terms; k++) {
        sum += cam_complex_size(s->c_q6[k]);
    }
    return sum;
}

void cam_harmonic_correction_rotate(cam_harmonic_correction_t *s, uint32_t angle_q32)
{
    for (uint32_t k = 1; k < cam_ilc_terms; k++) {
        s->c_q6[k] = cam_harmonics_rotated(s->c_q6[k], k, angle_q32);
        keep(s, k, cam_harmonics_rotated(s->kept_q6[k], k, angle_q32));
    }
}
