// SPDX-License-Identifier: Apache-2.0
#include "cam_positioning.h"
#include "cam_interpolate.h" // cam_interpolate_profile_q10
#include "cam_fix.h"         // cam_sat_sub
#include "cam_plan_move.h"   // cam_plan_move_to_isr
#include "cam_swing.h"       // cam_swing_rest_isr

static bool is_at(const cam_axis_motion_t *m, int64_t place_q10)
{
    return m->pos_q10 == place_q10 && m->vel_q10 == 0;
}

/// Keep the tool out of the work and bring the feed axes to rest. @return true when all of them
/// rest
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

/// @return [nm / 1024] X over a height where a cut or a rehearsal begins. A rehearsal is farther
/// off by half the stroke of U: wherever U goes, the tool does not reach beyond the approach of a
/// cut, MATHS.md (139).
static int64_t x_begin_q10(const cam_play_config_t *cfg, const cam_motion_t *m, int32_t z_nm)
{
    const int64_t away_q10 = m->state == cam_state_rehearsing ? cfg->rehearse_x_q10 : 0;
    return cam_interpolate_profile_q10(cfg, z_nm, 0, cfg->x_trim_q4) + away_q10;
}

/// Move Z to the start of the cut while X stands, then X: the tool nears the work only where it
/// will cut. An X that is not off the work at every height, as after a cut that ended at a smaller
/// radius, moves out before.
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

/// Move X to its place over a measured Z, whose set-point is where it is. X nears the work only
/// when U is ready.
/// @param z_nm  [nm] by the port
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

/// Move all axes to the start of the cut or of its rehearsal; a tool that swings comes to rest at 0
/// first.
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

/// @return [nm / 1024] where X moves in the state fault: off its set-point in the tick of the
/// fault, but not farther than its travel goes
static int64_t moved_off_q10(const cam_play_config_t *cfg, int64_t left_q10)
{
    const int64_t off_q10 = left_q10 + (int64_t)cfg->x_clearance_nm * 1024;
    const int64_t high_q10 = (int64_t)cfg->x_high_nm * 1024;
    const int64_t most_q10 = high_q10 > left_q10 ? high_q10 : left_q10;
    return off_q10 < most_q10 ? off_q10 : most_q10;
}

/// In the state fault the guard leads U, X moves off, and Z brakes to rest. Behind the state manual
/// X brakes to rest as well.
static void move_off(const cam_play_config_t *cfg, int32_t z_nm, cam_motion_t *m)
{
    const int64_t x_q10 = moved_off_q10(cfg, m->x_left_q10);
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

/// Homing ends when the angle is known, the spindle turns and the tool is out of the work.
static void home(const cam_play_config_t *cfg, const cam_angle_t *angle, cam_motion_t *m)
{
    const bool is_out = stay_out(cfg, m);
    if (is_out && !m->was_off && angle->is_synced && angle->speed_q32 >= cfg->turning_q32) {
        m->state = cam_state_ready;
    }
}

/// What only the cut moves stands: amplitude, phase and height would go on with the increments of
/// the last plan of the cut, in the end beyond their words.
static void end_increments(cam_motion_t *m)
{
    m->phase_step_q32 = 0;
    m->scale_step_q30 = 0;
    m->lag_step_q4 = 0;
    m->height_step_q32 = 0;
}

/// Plan the axes by the state. @return as cam_positioning_isr()
static bool plan_rest(const cam_play_config_t *cfg, const cam_tick_record_t *r, cam_motion_t *m)
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
        home(cfg, &r->angle, m);
    } else {
        (void)stay_out(cfg, m);
    }
    return false;
}

bool cam_positioning_isr(const cam_play_config_t *cfg, const cam_tick_record_t *r, cam_motion_t *m)
{
    end_increments(m);
    const bool is_idle = m->state == cam_state_off || m->state == cam_state_fault;
    m->spindle_mrpm = is_idle ? 0 : cam_mul_shift(cfg->spindle_mrpm, cfg->spindle_rate_q30, 30);
    m->alpha_q40 = 0;
    m->alpha_u = 0;
    m->faults = 0;
    const bool is_there = plan_rest(cfg, r, m);
    m->is_filtering = m->state != cam_state_off;
    return is_there;
}
