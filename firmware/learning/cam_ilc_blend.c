// SPDX-License-Identifier: Apache-2.0
// Blending the learned values in.
#include "cam_learning_inner.h"
#include "cam_doubles.h" // cam_nearest
#include "cam_fix.h"     // cam_clamp_i64, cam_smaller_i64
#include <stddef.h>      // NULL

enum {
    rehearsal_step_nm = 1000,
    cut_step_nm = 50,
    rehearsal_angle_step = 131, ///< [turn / 2^23] 100 urad
    cut_angle_step = 13,        ///< 10 urad
    any_step = 1 << 17,
};

/// [turn / 256] between two computations of points: 25 per turn for each set
enum { step_q8 = 10 };

/// @return whether the points have to wait: a step makes the observed speed waver
static bool is_early(const cam_ilc_t *t, uint32_t at_q8)
{
    return t->state != cam_state_off && (int32_t)(at_q8 - t->blend_from_q8) < 0;
}

bool cam_ilc_is_blending(const cam_ilc_t *t, uint32_t at_q8)
{
    const bool is_cheap = (t->blending & cam_ilc_blend_drive) != 0u;
    const bool is_paced = t->blending != 0u || cam_ilc_chip_is_due(t);
    return t->bin == NULL && (is_cheap || (is_paced && !is_early(t, at_q8)));
}

/// @return the step for a state: of the rehearsal, of the cut, or unlimited
static int32_t step_of(cam_state_t state, int32_t rehearsal_step, int32_t cut_step)
{
    if (!cam_state_is_in_work(state)) {
        return any_step;
    }
    return state == cam_state_rehearsing ? rehearsal_step : cut_step;
}

/// @return [turn / 2^23] the step of the angles: smaller while they move U
static int32_t angle_step(const cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    const cam_state_t state = t->state;
    if (state == cam_state_off) {
        return any_step;
    }
    if (!cam_state_is_in_work(state) || (state == cam_state_engaging && !s->is_u_moving)) {
        return s->observer_step_q23;
    }
    const int32_t usual =
        state == cam_state_rehearsing ? rehearsal_angle_step : (int32_t)cut_angle_step;
    const int64_t of_u = cam_smaller_i64(usual, s->angle_step_q23);
    return (int32_t)cam_smaller_i64(of_u, s->observer_step_q23);
}

bool cam_ilc_slew(int32_t *value, int64_t target, int64_t most)
{
    *value = cam_sat_i32(cam_clamp_i64(target, *value - most, *value + most));
    return *value == target;
}

/// Move a constant towards its target. @param per_nm  [nm per unit, 2^16] effect on the command
static bool slew_constant(int32_t *value, int32_t target, int32_t most_nm, double per_nm)
{
    const int32_t most = cam_nearest(most_nm * 0x1p16 / (per_nm + 0x1p-8));
    return cam_ilc_slew(value, target, most_nm < any_step ? most : INT64_C(1) << 32);
}

static bool slew_angles(const cam_ilc_t *t, const cam_ilc_setup_t *s, cam_learned_t *in,
                        int32_t most)
{
    cam_complex_t order[cam_ilc_terms] = {0};
    const uint32_t sum = cam_ripple_sum(&t->ripple);
    const int64_t most_sum = cam_ripple_most;
    const int64_t of = sum > (uint32_t)cam_ripple_most ? (int64_t)sum : most_sum;
    for (uint32_t k = 1; k < cam_ilc_terms && s->ripple_turns > 0u; k++) {
        const cam_complex_t shown = cam_ripple_order(&t->ripple, k);
        order[k] = (cam_complex_t){.re = (int32_t)(shown.re * most_sum / of),
                                   .im = (int32_t)(shown.im * most_sum / of)};
    }
    const bool is_known = s->ripple_turns > 0u && t->ripple.n_mean > 0u;
    const cam_complex_t shown = is_known ? order[1] : s->eccentricity;
    order[1] = shown;
    const bool is_done = cam_harmonics_slew(in->dm, order, cam_ripple_down, most);
    order[1] = cam_complex_sub(shown, s->eccentricity);
    return cam_harmonics_slew(in->d, order, cam_ripple_down, most) && is_done;
}

/// @return the first turn to learn from: in a rehearsal U settles for half a turn; in the cut,
///         whose steps are small, a turn may begin with one
static uint32_t good_from(cam_state_t state, uint32_t at_q8)
{
    const uint32_t turn = at_q8 >> 8;
    const uint32_t part = at_q8 & 0xFFu;
    if (state == cam_state_cutting) {
        return turn + (part < 64u ? 0u : 1u);
    }
    return turn + (part < 128u ? 1u : 2u);
}

void cam_ilc_blend(cam_ilc_t *t, const cam_ilc_setup_t *setup, uint32_t at_q8, cam_learned_t *in)
{
    const int32_t most_nm = step_of(t->state, rehearsal_step_nm, cut_step_nm);
    uint8_t done = 0;
    // While U moves without cutting, new constants would step its command: they wait.
    const bool is_held = setup->is_u_moving && most_nm == any_step;
    const bool is_chip = !is_held && cam_ilc_chip_blend(t, setup->depth_nm, most_nm, in);
    if (t->blending == 0u) { // only the feed has changed
        t->blend_from_q8 = at_q8 + step_q8;
        return;
    }
    if ((t->blending & cam_ilc_blend_drive) != 0u && !is_held) {
        const bool is_k1 = slew_constant(&in->k1_q16, t->drive.k1_q16, most_nm, t->speed_nm);
        const bool is_k2 = slew_constant(&in->k2_q16, t->drive.k2_q16, most_nm, t->acceleration_nm);
        const bool is_friction =
            cam_ilc_slew(&in->friction_q6, t->drive.friction_q6, INT64_C(64) * most_nm);
        done |= is_k1 && is_k2 && is_friction && is_chip ? cam_ilc_blend_drive : 0u;
    }
    const bool is_due = !is_early(t, at_q8);
    const bool is_correction_next = (t->blending & cam_ilc_blend_correction) != 0u;
    if (is_due && is_correction_next) {
        done |= cam_harmonics_slew(in->c, t->correction.c_q6, 6, most_nm) ? cam_ilc_blend_correction
                                                                          : 0u;
        t->blend_from_q8 = at_q8 + step_q8;
    }
    if (is_due && !is_correction_next && (t->blending & cam_ilc_blend_ripple) != 0u) {
        done |= slew_angles(t, setup, in, angle_step(t, setup)) ? cam_ilc_blend_ripple : 0u;
        t->blend_from_q8 = at_q8 + 2u * step_q8;
    }
    t->blending &= (uint8_t)~done;
    if (t->blending == 0u) {
        t->good_from = good_from(t->state, at_q8);
    }
}
