// SPDX-License-Identifier: Apache-2.0
#include "cam_plan_inner.h"
#include "cam_motion.h" // cam_envelope_smooth_q30
#include "cam_fix.h"    // cam_wrap_add

/// [1] in the unit of shares.
#define ONE_Q30 (INT32_C(1) << 30)

/// @param s_q31  [1 / 2^31] 0 .. 2^31 - 1
/// @return       [1 / 2^30] 1 minus the smooth step, exactly 0 at its end
static int32_t left_q30(int32_t s_q31)
{
    return s_q31 < INT32_MAX ? ONE_Q30 - cam_envelope_smooth_q30(s_q31) : 0;
}

cam_share_t cam_shaft_share(int32_t change_q31, bool has_speed)
{
    const int32_t half_q31 = INT32_C(1) << 30;
    if (!has_speed) {
        return (cam_share_t){left_q30(change_q31), ONE_Q30};
    }
    return change_q31 < half_q31 ? (cam_share_t){left_q30(2 * change_q31), ONE_Q30}
                                 : (cam_share_t){0, left_q30(2 * (change_q31 - half_q31) + 1)};
}

/// Select a lobe: its pattern, and its phase in addition to the operator's.
static void take(cam_shaft_t *s, const cam_table_t *t, uint32_t i, cam_motion_t *m)
{
    const cam_lobe_t *lobe = &t->lobes[i];
    const cam_height_t at = cam_lobes_slice(t->u.n_slices, lobe->pattern);
    m->phase_q32 = cam_wrap_add(m->phase_q32, (int32_t)(lobe->phase_q32 - s->phase_q32));
    m->height_q32 = (int64_t)((uint64_t)at.i << 32 | (uint32_t)at.w_q31 << 1);
    m->height_step_q32 = 0;
    s->i_lobe = i;
    s->phase_q32 = lobe->phase_q32;
}

void cam_shaft_begin_isr(cam_shaft_t *s, const cam_table_t *t, int32_t z_nm, cam_motion_t *m)
{
    s->phase_q32 = 0;
    s->z_q8 = (int64_t)z_nm * 256;
    s->speed_q8 = 0;
    if (t->n_lobes > 0u) {
        take(s, t, cam_lobes_find(t, z_nm), m);
    }
}

int32_t cam_shaft_smooth_isr(cam_shaft_t *s, int32_t z_nm)
{
    const int64_t predicted_q8 = cam_wrap_add_i64(s->z_q8, s->speed_q8);
    const int64_t off_q8 = cam_wrap_sub_i64((int64_t)z_nm * 256, predicted_q8);
    s->z_q8 = cam_wrap_add_i64(predicted_q8, off_q8 >> 3); // two equal poles: 1/8 and (1/8)^2 / 4
    s->speed_q8 = cam_wrap_add_i64(s->speed_q8, off_q8 >> 8);
    return (int32_t)(cam_wrap_add_i64(s->z_q8, 128) >> 8);
}

cam_share_t cam_shaft_plan_isr(cam_shaft_t *s, const cam_table_t *t, int32_t z_nm, cam_motion_t *m)
{
    const uint32_t i = cam_lobes_find(t, z_nm);
    if (i != s->i_lobe && m->scale_q30 == 0) {
        take(s, t, i, m);
    }
    return i == s->i_lobe
               ? cam_shaft_share(cam_lobes_change_q31(t, i, z_nm), t->speed.knots != NULL)
               : (cam_share_t){0, 0};
}
