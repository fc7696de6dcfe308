// SPDX-License-Identifier: Apache-2.0
#include "cam_axis_command.h"
#include "cam_fix.h" // cam_clamp_i32, cam_is_within

/// Inverse of a second-order drive, MATHS.md (56) and (189). Limited to 2^30, far beyond every
/// stroke: a command that large is refused.
/// @return [nm / 64]
/*@ requires valid: \valid_read(by) && \valid_read(u);
    assigns \result \from *by, *u;
    ensures word: -0x40000000 <= \result < 0x40000000;
*/
static int32_t feed_forward_q6(const cam_u_gains_t *by, const cam_axis_motion_t *u)
{
    const int64_t more_q26 = (int64_t)by->k1_q16 * u->vel_q10 + (int64_t)by->k2_q16 * u->acc_q10;
    //@ assert sign: more_q26 < 0 || more_q26 >= 0;
    const int32_t most_high = 1 << 18; // of the high word: 2^50 / 2^32, beyond every stroke
    const int32_t high = cam_clamp_i32((int32_t)(more_q26 >> 32), -most_high, most_high - 1);
    const uint32_t low = (uint32_t)(uint64_t)more_q26;
    return (int32_t)((uint32_t)high << 12 | low >> 20);
}

/// Friction acts against the motion, in full from a speed of 4 nm per tick on.
/// @return [nm / 64]
static int32_t friction_q6(const cam_u_gains_t *by, const cam_axis_motion_t *u)
{
    const int32_t sense_q12 = cam_clamp_i32(u->vel_q10, -4096, 4096);
    return (int32_t)(((int64_t)sense_q12 * by->friction_q6) >> 12);
}

/// @return [nm / 64] command of U without the learned correction
static int32_t plain_q6(const cam_axis_command_config_t *cfg, const cam_tick_record_t *r,
                        const cam_motion_t *m)
{
    const cam_u_gains_t *by = m->is_playing ? &cfg->in_cut : &cfg->by_time;
    const cam_axis_motion_t *u = &m->axis[hal_axis_u];
    const int32_t more_q6 = feed_forward_q6(by, u) + friction_q6(by, u) + by->chip_q6;
    const int32_t set_q6 = r->want.u_set_q6;
    return cam_sat_add(set_q6, cam_mulhi_add(more_q6, set_q6, by->chip_q32));
}

/// @return [nm] command of U if its last step is repeated
static int32_t continued_nm(const cam_u_command_t *u)
{
    return u->nm + u->step_nm;
}

/// @return [nm / 64] state fault: command of U minus `plain`. In the first tick the command
/// continues with the acceleration of its set-point; then the difference decays to 0 by a sixteenth
/// per tick
static int32_t faded_q6(const cam_axis_command_t *t, const cam_axis_motion_t *u, int32_t plain,
                        bool is_new)
{
    const int32_t last_q6 = t->fading_q6;
    const int64_t on_q6 = (int64_t)continued_nm(&t->u) * 64 + (u->acc_q10 >> 4);
    return is_new ? cam_sat_i32(on_q6 - plain)
                  : last_q6 - last_q6 / 16 - (last_q6 > 0) + (last_q6 < 0);
}

/// @return [nm] rounded to nearest
static int32_t nearest_to_q6(int32_t q6)
{
    return cam_sat_add(q6, 32) >> 6;
}

/*@ predicate cam_limits(cam_axis_command_config_t *cfg) = 0 <= cfg->range_nm <= 0x1000000 &&
      0 <= cfg->step_nm <= 0x3FFFFFFF && 0 <= cfg->change_nm <= 0x3FFFFFFF &&
      0 <= cfg->change_off_nm <= 0x3FFFFFFF;
    predicate cam_is_command(cam_u_command_t *u) =
      -0x2000000 <= u->nm < 0x2000000 && \abs(u->step_nm) <= 0x4000000;
*/
/// Accept a command exactly if position, step and change of step are within their limits.
/*@ requires valid: \valid_read(u) && \valid_read(cfg);
    requires limits: cam_limits(cfg);
    requires command: cam_is_command(u) && \abs(u_nm) <= 0x2000000;
    requires flag: is_off_time == 0 || is_off_time == 1;
    assigns \result \from *u, *cfg, u_nm, is_off_time;
    ensures exact: \result <==> \abs(u_nm) <= cfg->range_nm &&
      \abs(u_nm - u->nm) <= cfg->step_nm &&
      (\abs(u_nm - u->nm - u->step_nm) <= cfg->change_nm ||
       (is_off_time && \abs(u_nm - u->nm - u->step_nm) <= cfg->change_off_nm));
*/
static bool is_allowed(const cam_u_command_t *u, const cam_axis_command_config_t *cfg, int32_t u_nm,
                       bool is_off_time)
{
    const int32_t step_nm = u_nm - u->nm;
    const int32_t change_nm = step_nm - u->step_nm;
    return cam_is_within(u_nm, cfg->range_nm) && cam_is_within(step_nm, cfg->step_nm) &&
           (cam_is_within(change_nm, cfg->change_nm) ||
            (is_off_time && cam_is_within(change_nm, cfg->change_off_nm)));
}

/*@ requires valid: \valid(u);
    requires command: -0x2000000 <= u->nm < 0x2000000 && \abs(u_nm) <= 0x2000000;
    assigns *u;
    ensures place: u->nm == u_nm;
    ensures step: u->step_nm == u_nm - \old(u->nm);
*/
static void commit(cam_u_command_t *u, int32_t u_nm)
{
    u->step_nm = u_nm - u->nm;
    u->nm = u_nm;
}

static hal_setpoint_t setpoint(const cam_axis_motion_t *m, int32_t pos_nm)
{
    return (hal_setpoint_t){.pos_nm = pos_nm, .vel_q10 = m->vel_q10, .acc_q10 = m->acc_q10};
}

/// Write the set-points to the record, in port coordinates. X and Z are rounded down; the plan adds
/// half a nanometre to X, which rounds X to nearest.
static void write_out(const cam_axis_command_t *t, cam_tick_record_t *r, const cam_motion_t *m)
{
    const cam_axis_motion_t *x = &m->axis[hal_axis_x];
    const cam_axis_motion_t *z = &m->axis[hal_axis_z];
    const int32_t u_nm = cam_wrap_sub(t->u.nm, m->u_home_nm);
    r->out[hal_axis_u] = setpoint(&m->axis[hal_axis_u], u_nm);
    r->out[hal_axis_x] = setpoint(x, (int32_t)(x->pos_q10 >> 10));
    r->out[hal_axis_z] = setpoint(z, (int32_t)(z->pos_q10 >> 10));
}

bool cam_axis_command_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                          cam_tick_record_t *r, const cam_motion_t *m)
{
    const int32_t plain = plain_q6(cfg, r, m);
    int32_t more_q6 = m->c_q6;
    if (!m->is_playing) {
        const bool is_fault = m->state == cam_state_fault;
        more_q6 = is_fault ? faded_q6(t, &m->axis[hal_axis_u], plain, !t->is_fault) : 0;
        t->fading_q6 = more_q6;
        t->is_fault = is_fault;
    }
    const int32_t u_nm = nearest_to_q6(cam_sat_add(plain, more_q6));
    if (m->state == cam_state_off) {
        *t = (cam_axis_command_t){.u.nm = cam_clamp_i32(u_nm, -cfg->range_nm, cfg->range_nm)};
    } else if (is_allowed(&t->u, cfg, u_nm, r->angle.is_off_time)) {
        commit(&t->u, u_nm);
    } else {
        return false;
    }
    write_out(t, r, m);
    return true;
}

/// Nearest accepted command. It is within the stroke, or no farther out than the last command. The
/// step is always within the speed limit, and its change within the acceleration limit unless
/// stroke or speed cut it. An acceptable command is returned unchanged.
/// @return [nm] command of U
/*@ requires valid: \valid_read(u) && \valid_read(cfg);
    requires limits: cam_limits(cfg);
    requires command: cam_is_command(u) && \abs(u_nm) <= 0x10000000;
    assigns \result \from *u, *cfg, u_nm;
    ensures place: \min(-cfg->range_nm, u->nm) <= \result <= \max(cfg->range_nm, u->nm);
    ensures step: \abs(\result - u->nm) <= cfg->step_nm;
    ensures change: \abs(\result) < cfg->range_nm && \abs(\result - u->nm) < cfg->step_nm ==>
      \abs(\result - u->nm - u->step_nm) <= cfg->change_nm;
    ensures same: \abs(u_nm) <= cfg->range_nm && \abs(u_nm - u->nm) <= cfg->step_nm &&
      \abs(u_nm - u->nm - u->step_nm) <= cfg->change_nm ==> \result == u_nm;
*/
static int32_t nearest_nm(const cam_u_command_t *u, const cam_axis_command_config_t *cfg,
                          int32_t u_nm)
{
    const int32_t wanted_nm = u_nm - u->nm - u->step_nm;
    const int32_t step_nm = u->step_nm + cam_clamp_i32(wanted_nm, -cfg->change_nm, cfg->change_nm);
    const int32_t within_nm = cam_clamp_i32(step_nm, -cfg->step_nm, cfg->step_nm);
    const int32_t least_nm = u->nm < -cfg->range_nm ? u->nm : -cfg->range_nm;
    const int32_t most_nm = u->nm > cfg->range_nm ? u->nm : cfg->range_nm;
    return cam_clamp_i32(u->nm + within_nm, least_nm, most_nm);
}

void cam_axis_command_nearest_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                  cam_tick_record_t *r, const cam_motion_t *m)
{
    const int32_t plain = plain_q6(cfg, r, m);
    const int32_t wanted_nm =
        t->is_fault ? nearest_to_q6(cam_sat_add(plain, t->fading_q6)) : continued_nm(&t->u);
    commit(&t->u, nearest_nm(&t->u, cfg, wanted_nm));
    t->fading_q6 = cam_sat_sub(t->u.nm * 64, plain);
    t->is_fault = true;
    write_out(t, r, m);
}

/// An axis faster than its limit may keep its speed until it brakes.
/// @return whether the plan of an axis is within the limits
static bool is_plan_allowed(const cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                            uint32_t axis, const cam_axis_motion_t *now,
                            const cam_axis_motion_t *before)
{
    const int32_t jump_q10 = cam_sat_i32(cam_wrap_sub_i64(now->pos_q10, before->pos_q10));
    const int32_t change_q10 = cam_sat_sub(now->vel_q10, t->vel_q10[axis]);
    const int32_t was_q10 = t->vel_q10[axis];
    const int32_t most_q10 = was_q10 < 0 ? cam_sat_add(~was_q10, 1) : was_q10; // its amount
    const bool is_no_faster = cam_is_within(now->vel_q10, most_q10);
    return (is_no_faster || cam_is_within(now->vel_q10, cfg->vel_q10[axis])) &&
           cam_is_within(change_q10, cfg->change_q10[axis]) &&
           cam_is_within(jump_q10, cfg->jump_q10[axis]);
}

/// @return fault command where the plan of an axis was refused, or none
static uint32_t command_plan(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                             cam_motion_t *m, uint32_t axis, const cam_axis_motion_t *before)
{
    cam_axis_motion_t *now = &m->axis[axis];
    uint32_t faults = 0;
    if (m->state != cam_state_off && !is_plan_allowed(t, cfg, axis, now, before)) {
        *now = *before;
        m->is_filtering = false;
        faults = CAM_FAULT_BIT(command);
    }
    m->change_q10[axis] = cam_sat_sub(now->vel_q10, t->vel_q10[axis]);
    t->vel_q10[axis] = now->vel_q10;
    return faults;
}

uint32_t cam_axis_command_plan_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                   cam_motion_t *m, const cam_axis_motion_t before[hal_n_axes])
{
    return command_plan(t, cfg, m, (uint32_t)hal_axis_x, &before[hal_axis_x]) |
           command_plan(t, cfg, m, (uint32_t)hal_axis_z, &before[hal_axis_z]);
}
