// SPDX-License-Identifier: Apache-2.0
#include "cam_plan_inner.h"
#include "cam_fix.h" // cam_sat_sub

static bool is_at(const cam_axis_motion_t *m, int64_t position_q10)
{
    return m->pos_q10 == position_q10 && m->vel_q10 == 0;
}

/// Keep the tool out of the work and brake the feed axes. @return true when all of them rest
static bool stay_out(const cam_play_config_t *cfg, cam_motion_t *m)
{
    m->u_target_q10 = cfg->u_retract_q10;
    const bool is_x_at_rest =
        cam_plan_move_brake_isr(m, hal_axis_x, cfg, &cfg->approach[hal_axis_x]);
    const bool is_z_at_rest =
        cam_plan_move_brake_isr(m, hal_axis_z, cfg, &cfg->approach[hal_axis_z]);
    if (cfg->swing.is_swung) {
        cam_swing_rest_isr(&m->swing, cfg, &cfg->swing.gentle);
    }
    return is_at(&m->axis[hal_axis_u], cfg->u_retract_q10) && is_x_at_rest && is_z_at_rest &&
           (!cfg->swing.is_swung || m->swing.is_there);
}

/// @return [nm / 1024] start of X over a height. A rehearsal starts farther off by half the stroke
/// of U, so the tool never gets closer than at the start of a cut, MATHS.md (139).
static int64_t x_begin_q10(const cam_play_config_t *cfg, const cam_motion_t *m, int32_t z_nm)
{
    const int64_t away_q10 = m->state == cam_state_rehearsing ? cfg->rehearse_x_q10 : 0;
    return cam_plan_move_profile_q10(cfg, z_nm, 0, cfg->x_trim_q4) + away_q10;
}

/// Move Z to the start of the cut, then X: the tool approaches the work only where it will cut. If
/// X is not clear of the work at every height (after a cut that ended at a smaller radius), it
/// moves out first.
/// @return true when both are there
static bool approach_xz(const cam_play_config_t *cfg, cam_motion_t *m)
{
    const cam_axis_motion_t *x = &m->axis[hal_axis_x];
    const int64_t z_q10 = ((int64_t)cfg->z_first_nm + cfg->z_origin_nm) * 1024;
    if (x->pos_q10 < cfg->x_clear_q10 && !is_at(&m->axis[hal_axis_z], z_q10)) {
        (void)cam_plan_move_to_isr(m, hal_axis_x, cfg, &cfg->approach[hal_axis_x],
                                   cfg->x_clear_q10);
        (void)cam_plan_move_brake_isr(m, hal_axis_z, cfg, &cfg->approach[hal_axis_z]);
        return false;
    }
    if (is_at(&m->axis[hal_axis_z], z_q10)) {
        return cam_plan_move_to_isr(m, hal_axis_x, cfg, &cfg->approach[hal_axis_x],
                                    x_begin_q10(cfg, m, cfg->z_first_nm));
    }
    (void)cam_plan_move_to_isr(m, hal_axis_z, cfg, &cfg->approach[hal_axis_z], z_q10);
    (void)cam_plan_move_brake_isr(m, hal_axis_x, cfg, &cfg->approach[hal_axis_x]);
    return false;
}

/// Move X to its start over a measured Z, once U is ready.
/// @param z_nm  [nm] in port coordinates
/// @return      true when X is there
static bool approach_x(const cam_play_config_t *cfg, int32_t z_nm, bool is_u_there, cam_motion_t *m)
{
    m->axis[hal_axis_z] = (cam_axis_motion_t){.pos_q10 = (int64_t)z_nm * 1024};
    if (!is_u_there) {
        (void)cam_plan_move_brake_isr(m, hal_axis_x, cfg, &cfg->approach[hal_axis_x]);
        return false;
    }
    return cam_plan_move_to_isr(m, hal_axis_x, cfg, &cfg->approach[hal_axis_x],
                                x_begin_q10(cfg, m, cam_sat_sub(z_nm, cfg->z_origin_nm)));
}

/// Move all axes to the start of the cut or its rehearsal, after the swing has come to rest at 0.
/// @return true when all are there
static bool approach(const cam_play_config_t *cfg, int32_t z_nm, cam_motion_t *m)
{
    if (cfg->swing.is_swung && !m->swing.is_there) {
        (void)stay_out(cfg, m);
        return false;
    }
    m->u_target_q10 = 0;
    const bool is_u_there = is_at(&m->axis[hal_axis_u], 0);
    const bool is_xz_there =
        cfg->is_z_measured ? approach_x(cfg, z_nm, is_u_there, m) : approach_xz(cfg, m);
    return is_u_there && is_xz_there;
}

/// In state fault the guard retracts U, X moves off by the clearance, within its travel, and Z
/// brakes. After the state manual X brakes, too.
static void move_off(const cam_play_config_t *cfg, int32_t z_nm, cam_motion_t *m)
{
    const int64_t off_q10 = m->x_left_q10 + (int64_t)cfg->x_clearance_nm * 1024;
    const int64_t high_q10 = (int64_t)cfg->x_high_nm * 1024;
    const int64_t most_q10 = high_q10 > m->x_left_q10 ? high_q10 : m->x_left_q10;
    const int64_t x_q10 = off_q10 < most_q10 ? off_q10 : most_q10;
    const cam_motion_limits_t *x_limits = &cfg->leave[hal_axis_x];
    if (cfg->swing.is_swung) {
        cam_swing_rest_isr(&m->swing, cfg, &cfg->swing.full);
    }
    const bool is_x_off = m->is_by_hand ? cam_plan_move_brake_isr(m, hal_axis_x, cfg, x_limits)
                                        : cam_plan_move_to_isr(m, hal_axis_x, cfg, x_limits, x_q10);
    bool is_z_at_rest = true;
    if (cfg->is_z_measured) {
        m->axis[hal_axis_z] = (cam_axis_motion_t){.pos_q10 = (int64_t)z_nm * 1024};
    } else {
        is_z_at_rest = cam_plan_move_brake_isr(m, hal_axis_z, cfg, &cfg->leave[hal_axis_z]);
    }
    m->is_clear = is_x_off && is_z_at_rest && (!cfg->swing.is_swung || m->swing.is_there);
}

/// Plan the axes of the present state. @return as cam_positioning_isr()
static bool plan_state(const cam_play_config_t *cfg, const cam_tick_record_t *r, cam_motion_t *m)
{
    if (m->state == cam_state_fault) {
        move_off(cfg, r->in.actual_nm[hal_axis_z], m);
        return false;
    }
    m->is_clear = false;
    if (m->state == cam_state_engaging || m->state == cam_state_rehearsing) {
        return approach(cfg, r->in.actual_nm[hal_axis_z], m);
    }
    if (m->state == cam_state_off) {
        cam_swing_follow_isr(&m->swing, r->in.swing_q32);
    } else if (m->state == cam_state_homing) {
        // It ends when the angle is known, the spindle turns and the tool is out of the work.
        const bool is_out = stay_out(cfg, m);
        const bool is_turning = r->angle.is_synced && r->angle.speed_q32 >= cfg->turning_q32;
        m->state = is_out && !m->was_off && is_turning ? cam_state_ready : cam_state_homing;
    } else {
        (void)stay_out(cfg, m);
    }
    return false;
}

bool cam_positioning_isr(const cam_play_config_t *cfg, const cam_tick_record_t *r, cam_motion_t *m)
{
    m->phase_step_q32 = 0; // only the cut moves these
    m->scale_step_q30 = 0;
    m->height_step_q32 = 0;
    const bool is_idle = m->state == cam_state_off || m->state == cam_state_fault;
    m->spindle_mrpm = is_idle ? 0 : cam_mul_shift(cfg->spindle_mrpm, cfg->spindle_rate_q30, 30);
    m->alpha_q40 = 0;
    m->alpha_u = 0;
    m->faults = 0;
    const bool is_there = plan_state(cfg, r, m);
    m->is_filtering = m->state != cam_state_off;
    return is_there;
}
