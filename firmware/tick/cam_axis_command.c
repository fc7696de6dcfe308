// SPDX-License-Identifier: Apache-2.0
#include "cam_tick_inner.h"
#include "cam_fix.h" // cam_clamp_i32, cam_is_within
#include <stdbool.h> // bool

/// Inverse of a second-order drive, MATHS.md (56) and (189), and its friction, which acts against
/// the motion, in full from a speed of 4 nm per tick on. Limited to 2^30, far beyond every stroke:
/// a command that large is refused.
/// @return [nm / 64]
/*@ requires valid: \valid_read(by) && \valid_read(u);
    assigns \result \from *by, *u;
    ensures word: -0x40000000 <= \result < 0x40000000;
*/
static int32_t feed_forward_q6(const cam_u_gains_t *by, const cam_axis_motion_t *u)
{
    const int32_t sense_q12 = cam_clamp_i32(u->vel_q10, -4096, 4095);
    const int64_t more_q26 = (int64_t)by->k1_q16 * u->vel_q10 + (int64_t)by->k2_q16 * u->acc_q10 +
                             (int64_t)by->friction_q14 * sense_q12;
    //@ assert sign: more_q26 < 0 || more_q26 >= 0;
    const int32_t most_high = 1 << 18; // of the high word: 2^50 / 2^32, beyond every stroke
    const int32_t high = cam_clamp_i32((int32_t)(more_q26 >> 32), -most_high, most_high - 1);
    const uint32_t low = (uint32_t)(uint64_t)more_q26;
    return (int32_t)((uint32_t)high << 12 | low >> 20);
}

/// @return [nm / 64] command of U in the cut
static int32_t leading_q6(const cam_u_gains_t *by, const cam_axis_motion_t *u, int32_t set_q6,
                          int32_t correction_q6)
{
    const int32_t more_q6 = feed_forward_q6(by, u) + by->chip_q6;
    const int32_t plain_q6 = cam_sat_add(set_q6, cam_mulhi_add(more_q6, set_q6, by->chip_q32));
    return cam_sat_add(plain_q6, correction_q6);
}

/// U is rounded to nearest. X and Z are rounded down; the plan adds half a nanometre to X, which
/// rounds X to nearest.
int32_t cam_axis_command_isr(const cam_axis_command_config_t *cfg, cam_tick_record_t *r,
                             const cam_motion_t *m)
{
    const cam_axis_motion_t *u = &m->axis[hal_axis_u];
    const cam_axis_motion_t *x = &m->axis[hal_axis_x];
    const cam_axis_motion_t *z = &m->axis[hal_axis_z];
    const int32_t set_q6 = r->want.u_set_q6;
    const int32_t u_q6 = m->is_playing ? leading_q6(&cfg->in_cut, u, set_q6, m->c_q6) : set_q6;
    r->out[hal_axis_x] = cam_record_setpoint(x, (int32_t)(x->pos_q10 >> 10));
    r->out[hal_axis_z] = cam_record_setpoint(z, (int32_t)(z->pos_q10 >> 10));
    return cam_sat_add(u_q6, 32) >> 6;
}

/// An axis faster than its limit may keep its speed until it brakes.
/// @return whether the plan of an axis is within the limits
static bool is_plan_allowed(const cam_axis_command_config_t *cfg, uint32_t axis,
                            const cam_axis_motion_t *now, const cam_axis_motion_t *before)
{
    const int32_t jump_q10 = cam_sat_i32(cam_wrap_sub_i64(now->pos_q10, before->pos_q10));
    const int32_t change_q10 = cam_sat_sub(now->vel_q10, before->vel_q10);
    const int32_t was_q10 = before->vel_q10;
    const int32_t amount_q10 = was_q10 < 0 ? cam_sat_sub(0, was_q10) : was_q10;
    return (cam_is_within(now->vel_q10, cfg->vel_q10[axis]) ||
            cam_is_within(now->vel_q10, amount_q10)) &&
           cam_is_within(change_q10, cfg->change_q10[axis]) &&
           cam_is_within(jump_q10, cfg->jump_q10[axis]);
}

/// @return fault command where the plan of an axis was refused, or none
static uint32_t command_plan(const cam_axis_command_config_t *cfg, cam_motion_t *m, uint32_t axis,
                             const cam_axis_motion_t *before)
{
    cam_axis_motion_t *now = &m->axis[axis];
    uint32_t faults = 0;
    if (m->state != cam_state_off && !is_plan_allowed(cfg, axis, now, before)) {
        *now = *before;
        m->is_filtering = false;
        faults = CAM_FAULT_BIT(command);
    }
    m->change_q10[axis] = cam_sat_sub(now->vel_q10, before->vel_q10);
    return faults;
}

uint32_t cam_axis_command_plan_isr(const cam_axis_command_config_t *cfg, cam_motion_t *m,
                                   const cam_axis_motion_t before[hal_n_axes])
{
    return command_plan(cfg, m, (uint32_t)hal_axis_x, &before[hal_axis_x]) |
           command_plan(cfg, m, (uint32_t)hal_axis_z, &before[hal_axis_z]);
}
