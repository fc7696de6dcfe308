// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_guard.h"
#include "cam/cam_fix.h" // cam_abs_i64, cam_wrap_diff

#define ARMED_ENABLED                                                                              \
    (CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(late_tick) |                      \
     CAM_FAULT_BIT(index_missing) | CAM_FAULT_BIT(table))
#define ARMED_SYNCED                                                                               \
    (ARMED_ENABLED | CAM_FAULT_BIT(encoder_jump) | CAM_FAULT_BIT(lost_counts) |                    \
     CAM_FAULT_BIT(following_error) | CAM_FAULT_BIT(setpoint_speed) |                              \
     CAM_FAULT_BIT(setpoint_acceleration) | CAM_FAULT_BIT(setpoint_range))
#define ARMED_IN_WORK                                                                              \
    (ARMED_SYNCED | CAM_FAULT_BIT(reverse) | CAM_FAULT_BIT(spindle_stopped) |                      \
     CAM_FAULT_BIT(overspeed) | CAM_FAULT_BIT(z_range))

uint32_t cam_guard_armed(cam_state_t state)
{
    switch (state) {
    case cam_state_homing:
        return ARMED_ENABLED | CAM_FAULT_BIT(spindle_stopped);
    case cam_state_ready:
        return ARMED_SYNCED;
    case cam_state_engaging:
    case cam_state_cutting:
    case cam_state_disengaging:
        return ARMED_IN_WORK;
    case cam_state_fault:
        return CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive);
    case cam_state_off:
    case cam_n_states:
        break;
    }
    return 0;
}

static uint32_t bit_if(bool is_set, uint32_t bit)
{
    return is_set ? bit : 0u;
}

static uint32_t judge_inputs(uint32_t inputs)
{
    return bit_if((inputs & hal_in_estop) != 0u, CAM_FAULT_BIT(estop)) |
           bit_if((inputs & hal_in_drive_ready) == 0u, CAM_FAULT_BIT(drive));
}

static uint32_t judge_clock(cam_guard_t *g, const cam_guard_config_t *cfg, uint32_t clock)
{
    const uint32_t period = clock - g->last_clock;
    const bool is_late = g->has_clock && period > cfg->late_clocks;
    g->max_period = g->has_clock && period > g->max_period ? period : g->max_period;
    g->n_late += is_late ? 1u : 0u;
    g->was_off_time = g->is_off_time;
    g->is_off_time = g->has_clock && period > cfg->off_time_clocks;
    g->last_clock = clock;
    g->has_clock = true;
    return bit_if(is_late, CAM_FAULT_BIT(late_tick));
}

static uint32_t judge_spindle(cam_guard_t *g, const cam_guard_config_t *cfg,
                              const cam_angle_t *angle, cam_state_t state)
{
    const int32_t speed_q32 = angle->speed_q32;
    // While homing, turning backwards is no better than standing.
    const bool is_homing = state == cam_state_homing;
    const bool is_stopped =
        speed_q32 < cfg->stopped_q32 && (is_homing || speed_q32 > -cfg->stopped_q32);
    const uint32_t patience = is_homing ? cfg->homing_ticks : cfg->stopped_ticks;
    const bool is_watched = (cam_guard_armed(state) & CAM_FAULT_BIT(spindle_stopped)) != 0u;
    g->n_stopped = is_stopped && is_watched ? g->n_stopped + 1u : 0u;
    return bit_if(speed_q32 < -cfg->stopped_q32, CAM_FAULT_BIT(reverse)) |
           bit_if(g->n_stopped > patience, CAM_FAULT_BIT(spindle_stopped)) |
           bit_if(speed_q32 > cfg->overspeed_q32, CAM_FAULT_BIT(overspeed));
}

static uint32_t judge_u(cam_guard_t *g, const cam_guard_config_t *cfg, const cam_sense_t *in,
                        const cam_want_t *want)
{
    const int64_t pos_q10 = want->axis[hal_axis_u].pos_q10;
    const int64_t vel_q10 = pos_q10 - g->axis[hal_axis_u].pos_q10;
    const int64_t acc_q10 = vel_q10 - g->u_step_q10;
    // A tick off its time moves the set-point by more than a tick's way, the next one by less
    // again.
    const int64_t slack_q10 = g->is_off_time || g->was_off_time ? cam_abs_i64(vel_q10) : 0;
    g->u_step_q10 = vel_q10;
    g->following_q6 = cam_sat_i32((int64_t)in->actual_nm[hal_axis_u] * 64 - want->u_due_q6);
    return bit_if(cam_abs_i64(g->following_q6) > cfg->following_q6,
                  CAM_FAULT_BIT(following_error)) |
           bit_if(cam_abs_i64(vel_q10) > cfg->u_vel_q10, CAM_FAULT_BIT(setpoint_speed)) |
           bit_if(cam_abs_i64(acc_q10) > cfg->u_acc_q10 + slack_q10,
                  CAM_FAULT_BIT(setpoint_acceleration)) |
           bit_if(pos_q10 < cfg->u_low_q10 || pos_q10 > cfg->u_high_q10,
                  CAM_FAULT_BIT(setpoint_range));
}

static void latch(cam_guard_t *g, uint32_t faults)
{
    const uint32_t fresh = faults & ~g->faults;
    if (fresh == 0u) {
        return;
    }
    for (uint32_t i = 0; i < cam_n_faults; i++) {
        g->count[i] += (fresh >> i) & 1u;
    }
    g->faults |= faults;
}

/// From motion to retract without a step: the axes go on from where they were written last, U at
/// the speed of its last step, which the table's speed is half a tick ahead of.
static void enter_fault(cam_guard_t *g, const cam_guard_config_t *cfg, uint32_t faults,
                        int64_t u_step_q10)
{
    g->axis[hal_axis_u].vel_q10 = cam_sat_i32(u_step_q10);
    g->first_faults = faults;
    g->is_retracted = false;
    g->x_off_q10 = g->axis[hal_axis_x].pos_q10 + cfg->x_clearance_q10;
}

static void retract(cam_guard_t *g, const cam_guard_config_t *cfg)
{
    const bool is_u_out =
        cam_move_to_isr(&g->axis[hal_axis_u], &cfg->limits[hal_axis_u], cfg->u_retract_q10);
    const bool is_x_off =
        cam_move_to_isr(&g->axis[hal_axis_x], &cfg->limits[hal_axis_x], g->x_off_q10);
    const bool is_z_at_rest = cam_move_stop_isr(&g->axis[hal_axis_z], &cfg->limits[hal_axis_z]);
    g->u_step_q10 = g->axis[hal_axis_u].vel_q10;
    g->is_retracted = g->is_retracted || (is_u_out && is_x_off && is_z_at_rest);
}

/// Take what play wants as the last written set-points; X and Z get their speed from the
/// difference.
static void accept(cam_guard_t *g, const cam_want_t *want)
{
    g->is_retracted = false;
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const int64_t moved_q10 = want->axis[i].pos_q10 - g->axis[i].pos_q10;
        g->axis[i] = want->axis[i];
        if (i != hal_axis_u) {
            g->axis[i].vel_q10 = cam_sat_i32(moved_q10);
        }
    }
}

/// Off: set-points follow the axes, which is not a motion; and a reset has ended the latch.
static void rest(cam_guard_t *g)
{
    g->faults = 0;
    g->is_retracted = true;
    g->u_step_q10 = 0;
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        g->axis[i].vel_q10 = 0;
    }
}

static uint32_t outputs(const cam_guard_t *g, cam_state_t state)
{
    const bool is_drive_lost = (g->faults & CAM_FAULT_BIT(drive)) != 0u;
    const bool is_held =
        state == cam_state_fault ? !g->is_retracted && !is_drive_lost : state != cam_state_off;
    return bit_if(is_held, hal_out_enable) | bit_if(g->faults != 0u, hal_out_fault) |
           bit_if(state == cam_state_cutting, hal_out_in_cut);
}

cam_safe_t cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg, const cam_sense_t *in,
                              const cam_angle_t *angle, const cam_want_t *want)
{
    const int64_t u_step_q10 = g->u_step_q10; // of the set-point written last
    const uint32_t seen = judge_inputs(in->inputs) | judge_clock(g, cfg, in->clock) |
                          judge_spindle(g, cfg, angle, want->state) | judge_u(g, cfg, in, want) |
                          angle->faults | want->faults;
    const uint32_t faults = seen & cam_guard_armed(want->state);
    const bool is_entering = faults != 0u && want->state != cam_state_fault;
    latch(g, faults);
    if (is_entering) {
        enter_fault(g, cfg, faults, u_step_q10);
    }
    const cam_state_t state = is_entering ? cam_state_fault : want->state;
    if (state == cam_state_fault) {
        retract(g, cfg);
    } else {
        accept(g, want);
    }
    if (state == cam_state_off) {
        rest(g);
    }
    return (cam_safe_t){
        .state = state,
        .axis = {g->axis[hal_axis_u], g->axis[hal_axis_x], g->axis[hal_axis_z]},
        .spindle_mrpm = state == cam_state_fault ? 0 : want->spindle_mrpm,
        .outputs = outputs(g, state),
    };
}
