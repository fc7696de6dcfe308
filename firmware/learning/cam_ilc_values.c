// SPDX-License-Identifier: Apache-2.0
// Learned values by index.
#include "cam_learning_inner.h"
#include "cam_fix.h" // cam_clamp_i32, cam_is_within

#define IS_PROBED (INT32_C(1) << 30) ///< bit of the masks: U was probed

int32_t cam_ilc_get(const cam_ilc_t *t, uint32_t index)
{
    const uint32_t i = index - cam_ilc_value_correction;
    const uint32_t j = index - cam_ilc_value_gain;
    const uint32_t l = index - cam_ilc_value_ripple;
    switch (index) {
    case cam_ilc_value_speed:
        return t->speed_q32;
    case cam_ilc_value_k1:
        return t->k1_q16;
    case cam_ilc_value_k2:
        return t->k2_q16;
    case cam_ilc_value_masked:
        return (int32_t)t->correction.masked | (t->correction.is_probed ? IS_PROBED : 0);
    case cam_ilc_value_phase:
        return (int32_t)t->phase_q32;
    case cam_ilc_value_friction:
        return t->friction_q6;
    case cam_ilc_value_chip:
        return t->chip_q32;
    case cam_ilc_value_chip_mean:
        return t->chip_mean_q32;
    default:
        break;
    }
    if (index < cam_ilc_value_gain) {
        const cam_complex_t c = t->correction.c_q6[i / 2u];
        return i % 2u == 0u ? c.re : c.im;
    }
    if (index < cam_ilc_value_ripple) {
        const cam_gain_t g = t->correction.gain[j / 2u];
        return j % 2u == 0u ? g.re_q12 : g.im_q12;
    }
    if (index < cam_ilc_value_friction) {
        return l % 2u == 0u ? t->ripple.mean[l / 2u].re : t->ripple.mean[l / 2u].im;
    }
    return 0;
}

/// Store a value. @return whether it is in range
static bool set_value(cam_ilc_t *t, uint32_t index, int32_t value)
{
    const uint32_t i = index - cam_ilc_value_correction;
    const uint32_t j = index - cam_ilc_value_gain;
    const uint32_t l = index - cam_ilc_value_ripple;
    const int32_t most_q16 = 1 << 30;
    const int16_t narrow = (int16_t)cam_clamp_i32(value, INT16_MIN, INT16_MAX);
    switch (index) {
    case cam_ilc_value_speed:
        t->speed_q32 = value;
        return cam_is_within(value, 1 << 29) && value >= 0; // at least 8 ticks per turn
    case cam_ilc_value_k1:
        t->k1_q16 = value;
        return cam_is_within(value, most_q16);
    case cam_ilc_value_k2:
        t->k2_q16 = value;
        return cam_is_within(value, most_q16);
    case cam_ilc_value_masked:
        t->correction.masked = (uint32_t)value & ((UINT32_C(1) << cam_ilc_terms) - 1u);
        t->correction.is_probed = (value & IS_PROBED) != 0;
        return value == cam_ilc_get(t, index);
    case cam_ilc_value_phase:
        t->phase_q32 = (uint32_t)value;
        return true;
    case cam_ilc_value_friction:
        t->friction_q6 = value;
        return cam_is_within(value, cam_ilc_most_nm * 64);
    case cam_ilc_value_chip:
        t->chip_q32 = value;
        return true;
    case cam_ilc_value_chip_mean:
        t->chip_mean_q32 = value;
        return true;
    default:
        break;
    }
    if (index < cam_ilc_value_gain) {
        cam_complex_t *c = &t->correction.c_q6[i / 2u];
        *(i % 2u == 0u ? &c->re : &c->im) = value;
        return cam_is_within(value, cam_ilc_most_nm * 64);
    }
    if (index < cam_ilc_value_ripple) {
        cam_gain_t *g = &t->correction.gain[j / 2u];
        *(j % 2u == 0u ? &g->re_q12 : &g->im_q12) = narrow;
        return narrow == value;
    }
    *(l % 2u == 0u ? &t->ripple.mean[l / 2u].re : &t->ripple.mean[l / 2u].im) = narrow;
    return cam_is_within(value, cam_ripple_most);
}

bool cam_ilc_set(cam_ilc_t *t, uint32_t index, int32_t value)
{
    if (index >= cam_ilc_n_values) {
        return false;
    }
    const int32_t before = cam_ilc_get(t, index);
    const bool is_good = set_value(t, index, value);
    if (!is_good) {
        (void)set_value(t, index, before);
    } else if (index >= cam_ilc_value_ripple && index < cam_ilc_value_friction &&
               t->ripple.n_mean == 0u) {
        t->ripple.n_mean = 1u;
    }
    t->blending = cam_ilc_blend_all;
    return is_good;
}
