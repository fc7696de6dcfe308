// SPDX-License-Identifier: Apache-2.0
// Learned values by index.
#include "cam_learning_inner.h"
#include "cam_fix.h" // cam_is_between, cam_is_within
#include <stddef.h>  // NULL

#define IS_PROBED (UINT32_C(1) << 30) ///< bit of the masks: U was probed
#define MASKS ((UINT32_C(1) << cam_ilc_terms) - 1u)

/// @param index  of any value but the masks, which are no word
static const int32_t *word_of(const cam_ilc_t *t, uint32_t index)
{
    // All but the pairs of the harmonics, in the order of the indices.
    const int32_t *const scalars[] = {
        &t->speed_q32,
        &t->drive.k1_q16,
        &t->drive.k2_q16,
        NULL,
        (const int32_t *)&t->phase_q32,
        &t->drive.friction_q6,
        &t->drive.chip_q32,
        &t->chip_mean_q32,
    };
    if (index < cam_ilc_value_correction) {
        return scalars[index];
    }
    if (index >= cam_ilc_value_friction) {
        return scalars[cam_ilc_value_correction + index - cam_ilc_value_friction];
    }
    const cam_complex_t *pair = NULL;
    if (index >= cam_ilc_value_ripple) {
        pair = &t->ripple.mean[(index - cam_ilc_value_ripple) / 2u];
    } else if (index >= cam_ilc_value_gain) {
        pair = &t->correction.gain[(index - cam_ilc_value_gain) / 2u];
    } else {
        pair = &t->correction.c_q6[(index - cam_ilc_value_correction) / 2u];
    }
    return (index - cam_ilc_value_correction) % 2u == 0u ? &pair->re : &pair->im;
}

static bool is_in_range(uint32_t index, int32_t value)
{
    switch (index) {
    case cam_ilc_value_speed:
        return cam_is_between(value, 0, 1 << 29); // at least 8 ticks per turn
    case cam_ilc_value_k1:
    case cam_ilc_value_k2:
        return cam_is_within(value, 1 << 30);
    case cam_ilc_value_masked:
        return ((uint32_t)value & ~(MASKS | IS_PROBED)) == 0u;
    case cam_ilc_value_phase:
    case cam_ilc_value_chip:
    case cam_ilc_value_chip_mean:
        return true;
    default:
        break;
    }
    if (index >= cam_ilc_value_gain && index < cam_ilc_value_ripple) {
        return cam_is_between(value, INT16_MIN, INT16_MAX);
    }
    const bool is_nm = index < cam_ilc_value_gain || index == cam_ilc_value_friction;
    return cam_is_within(value, is_nm ? cam_ilc_most_nm * 64 : (int32_t)cam_ripple_most);
}

int32_t cam_ilc_get(const cam_ilc_t *t, uint32_t index)
{
    if (index == cam_ilc_value_masked) {
        return (int32_t)(t->correction.masked | (t->correction.is_probed ? IS_PROBED : 0u));
    }
    return index < cam_ilc_n_values ? *word_of(t, index) : 0;
}

bool cam_ilc_set(cam_ilc_t *t, uint32_t index, int32_t value)
{
    if (index >= cam_ilc_n_values || !is_in_range(index, value)) {
        return false;
    }
    if (index == cam_ilc_value_masked) {
        t->correction.masked = (uint32_t)value & MASKS;
        t->correction.is_probed = ((uint32_t)value & IS_PROBED) != 0u;
    } else {
        *(int32_t *)word_of(t, index) = value; // of t, which may change here
    }
    if (index >= cam_ilc_value_ripple && index < cam_ilc_value_friction && t->ripple.n_mean == 0u) {
        t->ripple.n_mean = 1u;
    }
    t->blending = cam_ilc_blend_all;
    return true;
}
