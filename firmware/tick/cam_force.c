// SPDX-License-Identifier: Apache-2.0
#include "cam_tick_inner.h"
#include "cam_fix.h" // cam_clamp_i32, cam_is_within, cam_sat_i32, cam_wrap_add_i64, ..

/// @return [nm / 64] within the range of a word
static int32_t to_q6(int32_t nm)
{
    return cam_clamp_i32(nm, -(1 << 25), (1 << 25) - 1) * 64;
}

/// @return [nm / 1024 per tick^2] acceleration by a force
static int32_t acceleration_q10(const cam_force_config_t *cfg, int32_t force_q6)
{
    return cam_sat_i32((int64_t)force_q6 * cfg->motion_q24 >> 20);
}

/// Push a U whose scale is frozen outwards, by its mass, up to the speed at which it leaves; never
/// into the work, since it may be a U that is blocked. @return [mN / 64]
static int32_t push_out_q6(cam_force_t *f, const cam_force_config_t *cfg)
{
    const int32_t wanted_q6 = cam_sat_i32(-((int64_t)cfg->servo.mass_q14 * f->excess_q10 >> 18));
    const int32_t force_q6 = cam_servo_push_isr(&f->servo, &cfg->servo, wanted_q6);
    const int32_t rest_q10 = cam_sat_add(f->excess_q10, acceleration_q10(cfg, force_q6));
    f->excess_q10 = rest_q10 > 0 ? rest_q10 : 0;
    return force_q6;
}

void cam_force_step_isr(cam_force_t *f, const cam_force_config_t *cfg, cam_tick_record_t *r,
                        bool is_on, cam_motion_t *m)
{
    const cam_axis_motion_t *u = &m->axis[hal_axis_u];
    const bool is_identifying = m->state == cam_state_identifying;
    const cam_servo_input_t in = {.set_q6 = m->u.nm * 64,
                                  .vel_q10 = u->vel_q10,
                                  .acc_q10 = u->acc_q10,
                                  .actual_q6 = to_q6(r->in.actual_nm[hal_axis_u]),
                                  .push_q6 = is_identifying ? m->u_push_q6 : 0};
    r->force_q6 = 0;
    if (is_on) {
        if (!f->is_on) {
            cam_servo_start_isr(&f->servo, &cfg->servo, &in);
        }
        r->force_q6 = cam_servo_step_isr(&f->servo, &cfg->servo, &in);
    } else if (m->u_blind_ticks > 0u) {
        m->u_blind_ticks--;
        r->force_q6 = push_out_q6(f, cfg);
    } else {
        cam_servo_rest_isr(&f->servo, &cfg->servo);
    }
    f->is_on = is_on;
}

/// @param vel_q24  [nm / 2^24 per tick] of the observer
/// @return         [mN / 64] force that accelerates U: the written one less spring and drag
static int32_t net_force_q6(const cam_force_config_t *cfg, const cam_tick_record_t *r,
                            int64_t vel_q24)
{
    const int64_t held_q24 =
        (int64_t)cfg->servo.stiffness_q18 * to_q6(r->in.actual_nm[hal_axis_u]) +
        (int64_t)cfg->servo.drag_q14 * cam_sat_i32(vel_q24 >> 14);
    return cam_sat_sub(r->force_q6, cam_sat_i32(held_q24 >> 18));
}

/// Compare the reading with the observer, then move the observer to the next tick. Their difference
/// wraps at 33 mm, beyond any accepted deviation (`servo_runaway_nm`, at most 10 mm).
/// @param read_nm  in port coordinates: a new home does not move the observer
/// @return [nm / 64] reading minus observer
static int32_t observe(cam_force_t *f, const cam_force_config_t *cfg, int32_t read_nm,
                       int32_t net_q6)
{
    const uint32_t seen_q6 = (uint32_t)((uint64_t)f->pos_q24 >> 18);
    const int32_t off_q6 = cam_wrap_diff((uint32_t)read_nm * 64u, seen_q6);
    const int64_t push_q30 = (int64_t)off_q6 * cfg->vel_q24 + (int64_t)net_q6 * cfg->motion_q24;
    const int64_t step_q24 = cam_wrap_add_i64(f->vel_q24, (int64_t)off_q6 * cfg->pos_q18);
    f->pos_q24 = cam_wrap_add_i64(f->pos_q24, step_q24);
    f->vel_q24 = cam_wrap_add_i64(f->vel_q24, push_q30 >> 6);
    return off_q6;
}

/// @return a speed, less an amount that stops U but does not turn it back
static int32_t slowed(int32_t speed_q10, int32_t less_q10)
{
    return cam_sat_sub(speed_q10, cam_clamp_i32(speed_q10, -less_q10, less_q10));
}

/// A reading that stands to the last digit is that of a U that stands. It is frozen if U was asked
/// to move meanwhile, and must have: by the speed of its last step, less a quantum, and by what its
/// force has changed since it was asked to. Constant forces, as weight and chip, do not count.
/// @param read_nm, set_nm  in port coordinates, as for observe()
static bool is_frozen(cam_force_t *f, const cam_force_config_t *cfg, int32_t read_nm,
                      int32_t set_nm, int32_t force_q6, bool is_pushed)
{
    enum { most_nm = 1 << 20 };
    const int32_t step_nm = cam_wrap_sub(read_nm, f->still_nm);
    if (step_nm != 0) {
        f->still_nm = read_nm;
        f->stood_nm = set_nm;
        f->speed_q10 = slowed(cam_clamp_i32(step_nm, -most_nm, most_nm) * 1024, cfg->quantum_q10);
        f->driven_q10 = f->speed_q10;
    }
    const bool is_at_rest = cam_is_within(cam_wrap_sub(set_nm, f->stood_nm), cfg->unseen_nm);
    if (step_nm != 0 || (is_at_rest && !is_pushed)) {
        f->reference_q6 = force_q6;
        f->free_q10 = 0;
        f->n_still = 0;
        return false;
    }
    const int32_t more_q10 = acceleration_q10(cfg, cam_sat_sub(force_q6, f->reference_q6));
    f->driven_q10 = cam_sat_add(f->driven_q10, more_q10);
    f->speed_q10 = slowed(cam_sat_add(f->speed_q10, more_q10), cfg->held_q10);
    f->free_q10 = cam_sat_add(f->free_q10, f->speed_q10);
    f->n_still += cam_is_within(f->free_q10, cfg->unseen_nm * 1024) ? 0u : 1u;
    return f->n_still > cfg->still_ticks;
}

/// @return whether U is beyond its travel, unless it returns, or cannot stop before its end:
///         v^2 > 2 a s
static bool is_beyond(const cam_force_config_t *cfg, int32_t pos_nm, int32_t vel_nm)
{
    const bool is_down = vel_nm < 0 || (vel_nm == 0 && pos_nm < 0);
    const int32_t room_nm =
        is_down ? cam_sat_add(cfg->travel_nm, pos_nm) : cam_sat_sub(cfg->travel_nm, pos_nm);
    return room_nm < 0 || (int64_t)vel_nm * vel_nm > (int64_t)cfg->braking_nm * room_nm;
}

/// @return whether a limit switch stops U; in manual one that U leaves does not
static bool is_at_line(uint32_t inputs, const cam_motion_t *m)
{
    if ((inputs & (hal_in_limit_u_low | hal_in_limit_u_high)) == 0u) {
        return false;
    }
    const int32_t vel_q10 = m->axis[hal_axis_u].vel_q10;
    const bool is_by_hand = m->state == cam_state_manual;
    const bool is_low = (inputs & hal_in_limit_u_low) != 0u;
    const bool is_high = (inputs & hal_in_limit_u_high) != 0u;
    return (is_low && (!is_by_hand || vel_q10 < 0)) || (is_high && (!is_by_hand || vel_q10 > 0));
}

/// A U that rests, or that a stop holds.
static void start_supervision(cam_force_t *f, int32_t force_q6)
{
    f->reference_q6 = force_q6;
    f->driven_q10 = 0;
    f->speed_q10 = 0;
    f->free_q10 = 0;
    f->n_still = 0;
    f->n_limited = 0;
}

uint32_t cam_force_watch_isr(cam_force_t *f, const cam_force_config_t *cfg,
                             const cam_tick_record_t *r, cam_motion_t *m)
{
    const int32_t read_nm = r->in.actual_nm[hal_axis_u];
    const int32_t port_nm = cam_wrap_sub(read_nm, m->u.home_nm);
    const int32_t set_nm = cam_wrap_sub(m->u.nm, m->u.home_nm);
    if (!f->is_on) {
        f->pos_q24 = (int64_t)port_nm * (INT64_C(1) << 24);
        f->vel_q24 = 0;
        f->still_nm = port_nm;
        f->stood_nm = set_nm;
        start_supervision(f, 0);
        return 0;
    }
    const int32_t net_q6 = net_force_q6(cfg, r, f->vel_q24);
    const int32_t off_q6 = observe(f, cfg, port_nm, net_q6);
    const bool is_blind = is_frozen(f, cfg, port_nm, set_nm, r->force_q6, m->u_push_q6 != 0);
    const bool is_runaway = is_blind || !cam_is_within(off_q6, cfg->runaway_q6);
    const int32_t vel_nm = cam_sat_i32(cam_wrap_add_i64(f->vel_q24, 1 << 23) >> 24);
    m->is_u_beyond = m->state != cam_state_manual && is_beyond(cfg, read_nm, vel_nm);
    const bool is_at_end = m->is_u_beyond || is_at_line(r->in.inputs, m);
    const uint32_t travel = is_at_end ? CAM_FAULT_BIT(u_travel) : 0u;
    if (m->u_press_q6 != 0) { // pressing on its stop, U looks blocked or not measured
        start_supervision(f, r->force_q6);
        return travel;
    }
    if (is_blind && !m->is_by_hand) {
        f->excess_q10 =
            cam_clamp_i32(cam_sat_add(f->driven_q10, cfg->push_speed_q10), 0, cfg->most_excess_q10);
        m->u_blind_ticks = cfg->blind_ticks;
    }
    f->n_limited = f->servo.is_limited ? f->n_limited + 1u : f->n_limited - (f->n_limited > 0u);
    return travel | (is_runaway ? CAM_FAULT_BIT(u_runaway) : 0u) |
           (f->n_limited > cfg->limited_ticks ? CAM_FAULT_BIT(u_force) : 0u);
}
