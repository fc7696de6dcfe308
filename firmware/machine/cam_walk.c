// SPDX-License-Identifier: Apache-2.0
// From what is in force to what was learned, step by step; and learned values as others see them.
#include "cam_fix.h"       // cam_clamp_i32
#include "cam_harmonics.h" // cam_harmonics_lead
#include "cam_teach.h"
#include <stddef.h> // NULL

enum {
    rehearsal_step_nm = 1000,
    cut_step_nm = 50,
    angle_step = 13, ///< [turn / 2^23] 10 urad
    any_step = 1 << 17,
};

bool cam_teach_is_walking(const cam_teach_t *t)
{
    return t->is_walking && t->bin == NULL;
}

/// @return [nm] by how much the command may change
static int32_t step_nm(cam_state_t state)
{
    if (!cam_state_is_in_work(state)) {
        return any_step;
    }
    return state == cam_state_rehearsing ? rehearsal_step_nm : cut_step_nm;
}

/// Lead a constant towards its target. @param per_q8  [nm per unit, 2^-8] what it changes
static bool lead(int32_t *value, int32_t target, int32_t most_nm, uint32_t per_q8)
{
    const int64_t most =
        most_nm < any_step ? ((int64_t)most_nm << 24) / ((int64_t)per_q8 + 1) : INT64_C(1) << 32;
    *value = cam_sat_i32(cam_clamp_i64(target, *value - most, *value + most));
    return *value == target;
}

static bool lead_angles(const cam_teach_t *t, const cam_teach_setup_t *s, cam_learned_t *in,
                        int32_t most)
{
    cam_complex_t order[cam_harmonics_most] = {0};
    for (uint32_t k = 1; k <= cam_harmonics_most && s->ripple_turns > 0u; k++) {
        order[k - 1u] = cam_ripple_order(&t->ripple, k);
    }
    const bool is_known = s->ripple_turns > 0u && t->ripple.n_mean > 0u;
    const cam_complex_t shown = is_known ? order[0] : s->eccentricity;
    order[0] = shown;
    bool is_there = cam_harmonics_lead(in->dm, order, 1, cam_ripple_down, most);
    order[0] = cam_complex_sub(shown, s->eccentricity);
    is_there = cam_harmonics_lead(in->d, order, 1, cam_ripple_down, most) && is_there;
    return is_there;
}

/// @return the first turn that may be learned from: in a rehearsal U has half a turn to settle, in
/// the
///         cut, whose steps are small, a turn may begin with them
static uint32_t good_from(cam_state_t state, uint32_t at_q8)
{
    const uint32_t turn = at_q8 >> 8;
    const uint32_t part = at_q8 & 0xFFu;
    if (state == cam_state_cutting) {
        return turn + (part < 64u ? 0u : 1u);
    }
    return turn + (part < 128u ? 1u : 2u);
}

void cam_teach_walk(cam_teach_t *t, const cam_teach_setup_t *setup, uint32_t at_q8,
                    cam_learned_t *in)
{
    const int32_t most_nm = step_nm((cam_state_t)t->state);
    bool is_there = cam_harmonics_lead(in->c, t->shape.c_q6, 0, 6, most_nm);
    is_there = lead(&in->k1_q16, t->k1_q16, most_nm, t->speed_w << 8) && is_there;
    is_there = lead(&in->k2_q16, t->k2_q16, most_nm, t->acceleration_w) && is_there;
    is_there = lead_angles(t, setup, in, most_nm < any_step ? angle_step : any_step) && is_there;
    if (is_there) {
        t->is_walking = false;
        t->good_from = good_from((cam_state_t)t->state, at_q8);
    }
}
