// SPDX-License-Identifier: Apache-2.0
// Learning at another speed of the spindle.
#include "cam_fix.h" // cam_abs_i64
#include "cam_ilc_update.h"

enum {
    frozen_percent = 2, ///< largest deviation of the speed from that of the learning
    agreeing_turns = 2, ///< after which learning goes on at another speed
    mode_part = 4, ///< responses at neighbouring harmonics that differ by this part show a mode
};

bool cam_ilc_update_is_other_speed(const cam_ilc_t *t, int32_t speed_q32)
{
    const int64_t off_q32 = cam_abs_i64((int64_t)speed_q32 - t->speed_q32);
    return off_q32 * 100 > (int64_t)t->speed_q32 * frozen_percent;
}

static cam_complex_t complex_of(cam_gain_t g)
{
    return (cam_complex_t){.re = g.re_q12, .im = g.im_q12};
}

/// Convert the probed responses to another speed. Their ratio to the response of the drive's
/// constants is a function of the frequency, interpolated between the harmonics of the old speed.
/// Where it changes by more than a quarter, by a mode, the harmonic is masked.
static void adapt_responses(cam_ilc_t *t, const cam_ilc_setup_t *s, int32_t speed_q32)
{
    const int32_t k1_q16 = s->k1_q16 + t->k1_q16;
    const int32_t k2_q16 = s->k2_q16 + t->k2_q16;
    const cam_complex_t one = {.re = cam_gain_one_q12};
    cam_gain_t *gain = t->correction.gain;
    cam_complex_t ratio[cam_ilc_terms];
    for (uint32_t k = 1; k <= t->n_orders; k++) {
        const cam_gain_t model = cam_drive_gain(k, t->speed_q32, k1_q16, k2_q16);
        ratio[k] = complex_of(cam_gain_ratio(complex_of(gain[k]), complex_of(model)));
    }
    for (uint32_t k = 1; k <= t->n_orders && t->n_orders > 1u; k++) {
        const int64_t place_q8 = (int64_t)k * speed_q32 * 256 / t->speed_q32;
        const int64_t within_q8 = cam_clamp_i64(place_q8, 256, (int64_t)t->n_orders * 256 - 1);
        const cam_complex_t a = ratio[within_q8 >> 8];
        const cam_complex_t by = cam_complex_sub(ratio[(within_q8 >> 8) + 1], a);
        const int64_t part_q8 = within_q8 & 255;
        const cam_complex_t between = {.re = a.re + (int32_t)(by.re * part_q8 / 256),
                                       .im = a.im + (int32_t)(by.im * part_q8 / 256)};
        const bool is_mode = cam_complex_square(by) * mode_part * mode_part > cam_complex_square(a);
        t->correction.masked |= is_mode ? UINT32_C(1) << k : 0u;
        const cam_gain_t model = cam_drive_gain(k, speed_q32, k1_q16, k2_q16);
        gain[k] = cam_gain_ratio(cam_gain_of(between, model), one);
    }
}

void cam_ilc_update_follow_speed(cam_ilc_t *t, const cam_ilc_setup_t *s, int32_t speed_q32,
                                 bool is_even)
{
    const bool is_other = t->correction.is_probed && cam_ilc_update_is_other_speed(t, speed_q32);
    const bool is_frozen = t->phase == (uint8_t)cam_ilc_frozen;
    if (is_other && is_frozen) {
        t->n_steps = (uint8_t)(is_even ? t->n_steps + 1u : 0u);
        if (t->n_steps >= agreeing_turns) {
            adapt_responses(t, s, speed_q32);
            t->speed_q32 = speed_q32;
            cam_ilc_update_restart_guards(t);
            cam_ilc_update_phase(t, cam_ilc_cutting);
        }
    } else if (is_other ? t->phase == (uint8_t)cam_ilc_cutting : is_frozen) {
        cam_ilc_update_phase(t, is_other ? cam_ilc_frozen : cam_ilc_cutting);
    }
}
