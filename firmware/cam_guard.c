// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_guard.h"
#include "cam/cam_fix.h" // cam_is_within, cam_wrap_sub

#define ARMED_ENABLED                                                                              \
    (CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(bus) | CAM_FAULT_BIT(late_tick) | \
     CAM_FAULT_BIT(index_missing) | CAM_FAULT_BIT(table))
#define ARMED_SYNCED                                                                               \
    (ARMED_ENABLED | CAM_FAULT_BIT(encoder_jump) | CAM_FAULT_BIT(lost_counts) |                    \
     CAM_FAULT_BIT(following_error) | CAM_FAULT_BIT(setpoint_speed) |                              \
     CAM_FAULT_BIT(setpoint_acceleration) | CAM_FAULT_BIT(setpoint_range))
#define ARMED_IN_WORK                                                                              \
    (ARMED_SYNCED | CAM_FAULT_BIT(reverse) | CAM_FAULT_BIT(spindle_stopped) |                      \
     CAM_FAULT_BIT(overspeed) | CAM_FAULT_BIT(z_range))

static const uint32_t armed[cam_n_states] = {
    [cam_state_homing] = ARMED_ENABLED | CAM_FAULT_BIT(spindle_stopped),
    [cam_state_ready] = ARMED_SYNCED,
    [cam_state_engaging] = ARMED_IN_WORK,
    [cam_state_cutting] = ARMED_IN_WORK,
    [cam_state_disengaging] = ARMED_IN_WORK,
    [cam_state_fault] = CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(bus),
};

uint32_t cam_guard_armed(cam_state_t state)
{
    return (uint32_t)state < cam_n_states ? armed[state] : 0u;
}

static uint32_t bit_if(bool is_set, uint32_t bit)
{
    return is_set ? bit : 0u;
}

_Static_assert(CAM_FAULT_BIT(estop) == hal_in_estop && CAM_FAULT_BIT(drive) == hal_in_drive_ready &&
                   CAM_FAULT_BIT(bus) == hal_in_bus_lost,
               "an input is its own fault");

static uint32_t judge_inputs(uint32_t inputs)
{
    return (inputs ^ hal_in_drive_ready) & (hal_in_estop | hal_in_drive_ready | hal_in_bus_lost);
}

/// Slower than stopped or faster than allowed.
CAM_STAGE static uint32_t judge_odd_speed(cam_guard_t *g, const cam_guard_config_t *cfg,
                                          int32_t speed_q32, cam_state_t state)
{
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

static uint32_t judge_spindle(cam_guard_t *g, const cam_guard_config_t *cfg, int32_t speed_q32,
                              cam_state_t state)
{
    if (speed_q32 < cfg->stopped_q32 || speed_q32 > cfg->overspeed_q32) {
        return judge_odd_speed(g, cfg, speed_q32, state);
    }
    g->n_stopped = 0;
    return 0;
}

/// A tick off its time moves the set-point by more than a tick's way, the next one by less again.
CAM_STAGE static int32_t slack(const cam_guard_config_t *cfg, int32_t step_q6)
{
    const int32_t way_q6 = cam_clamp_i32(step_q6, -cfg->u_vel_q6, cfg->u_vel_q6);
    return way_q6 < 0 ? -way_q6 : way_q6;
}

/// Everything that a tick may be blamed for. Differences of set-points wrap only where they are far
/// beyond the limits, and what is left of them is so, too.
static uint32_t blame(cam_guard_t *g, const cam_guard_config_t *cfg, const cam_sense_t *in,
                      const cam_angle_t *angle, const cam_want_t *want, int32_t step_q6)
{
    uint32_t faults = judge_inputs(in->inputs) | angle->faults | want->faults |
                      judge_spindle(g, cfg, angle->speed_q32, want->state);
    const int32_t off_nm = cam_wrap_sub(in->actual_nm[hal_axis_u], want->u_due_q6 >> 6);
    if (!cam_is_within(off_nm, cfg->following_nm)) {
        faults |= CAM_FAULT_BIT(following_error);
    }
    if (!cam_is_within(want->u_set_q6, cfg->u_range_q6)) {
        faults |= CAM_FAULT_BIT(setpoint_range);
    }
    if (!cam_is_within(step_q6, cfg->u_vel_q6)) {
        faults |= CAM_FAULT_BIT(setpoint_speed);
    }
    const int32_t change_q6 = cam_wrap_sub(step_q6, g->u_step_q6);
    const int32_t more_q6 = angle->is_off_time ? slack(cfg, step_q6) : 0;
    if (!cam_is_within(change_q6, cfg->u_acc_q6 + more_q6)) {
        faults |= CAM_FAULT_BIT(setpoint_acceleration);
    }
    return faults;
}

/// What is new is counted, all faults at once: bit i of the words of `count` is the number of fault
/// i, and the carry of one word is what the next one counts. The tick of the fault is busy enough:
/// those after it count.
static void count_new(cam_guard_t *g)
{
    uint32_t carry = g->faults & ~g->counted;
    for (uint32_t k = 0; k < cam_guard_count_bits && carry != 0u; k++) {
        const uint32_t sum = g->count[k] ^ carry;
        carry &= g->count[k];
        g->count[k] = sum;
    }
    g->counted = g->faults;
}

uint32_t cam_guard_count(const cam_guard_t *g, cam_fault_t fault)
{
    const uint32_t n = ((g->faults & ~g->counted) >> fault) & 1u; // still to be counted
    uint32_t counted = 0;
    for (uint32_t k = 0; k < cam_guard_count_bits; k++) {
        counted |= ((g->count[k] >> fault) & 1u) << k;
    }
    return (counted + n) % (1u << cam_guard_count_bits);
}

/// In the tick of the fault all axes go on as they did, U from where it was written last; the
/// retract begins with the next one.
static void enter_fault(cam_guard_t *g, const cam_guard_config_t *cfg, uint32_t faults,
                        cam_move_t *axis)
{
    g->first_faults = faults;
    g->is_retracted = false;
    g->x_off_q10 = axis[hal_axis_x].pos_q10 + cfg->x_clearance_q10;
    g->u_set_q6 += g->u_step_q6;
    axis[hal_axis_u] =
        (cam_move_t){.pos_q10 = (int64_t)g->u_set_q6 * 16, .vel_q10 = g->u_step_q6 * 16};
}

static void retract(cam_guard_t *g, const cam_guard_config_t *cfg, cam_move_t *axis)
{
    const cam_move_limits_t *limits = cfg->limits;
    const bool is_u_out =
        cam_move_to_isr(&axis[hal_axis_u], &limits[hal_axis_u], cfg->u_retract_q10);
    const bool is_x_off = cam_move_to_isr(&axis[hal_axis_x], &limits[hal_axis_x], g->x_off_q10);
    const bool is_z_at_rest = cam_move_stop_isr(&axis[hal_axis_z], &limits[hal_axis_z]);
    g->u_set_q6 = cam_sat_i32(axis[hal_axis_u].pos_q10 >> 4);
    g->is_retracted = g->is_retracted || (is_u_out && is_x_off && is_z_at_rest);
}

static uint32_t outputs(const cam_guard_t *g, cam_state_t state)
{
    static const uint32_t bits[cam_n_states] = {
        [cam_state_homing] = hal_out_enable,
        [cam_state_ready] = hal_out_enable,
        [cam_state_engaging] = hal_out_enable,
        [cam_state_cutting] = hal_out_enable | hal_out_in_cut,
        [cam_state_disengaging] = hal_out_enable,
        [cam_state_fault] = hal_out_fault,
    };
    const bool is_drive_lost = (g->faults & CAM_FAULT_BIT(drive)) != 0u;
    const bool is_held = state == cam_state_fault && !g->is_retracted && !is_drive_lost;
    return bits[state] | bit_if(is_held, hal_out_enable);
}

/// A fault that is armed makes the state; the first one, too, the set-points.
CAM_STAGE static void react(cam_guard_t *g, const cam_guard_config_t *cfg, uint32_t faults,
                            cam_want_t *want, cam_move_t *axis)
{
    g->faults |= faults;
    if (want->state == cam_state_fault) {
        count_new(g);
        retract(g, cfg, axis);
    } else {
        enter_fault(g, cfg, faults, axis);
    }
    want->state = cam_state_fault;
    want->spindle_mrpm = 0;
    want->u_set_q6 = g->u_set_q6;
    want->faults = g->faults;
    want->is_retracted = g->is_retracted;
}

/// What play wants is written. Off: set-points follow the axes, which is not a motion, and a reset
/// has ended the latch.
static void accept(cam_guard_t *g, cam_want_t *want, int32_t step_q6)
{
    const bool is_off = want->state == cam_state_off;
    g->u_set_q6 = want->u_set_q6;
    g->u_step_q6 = is_off ? 0 : step_q6;
    if (is_off) {
        g->faults = 0;
        g->counted = 0;
    }
    want->faults = 0;
    want->is_retracted = is_off;
}

void cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg, const cam_sense_t *in,
                        const cam_angle_t *angle, cam_want_t *want, cam_move_t *axis)
{
    const int32_t step_q6 = cam_wrap_sub(want->u_set_q6, g->u_set_q6);
    const uint32_t faults = blame(g, cfg, in, angle, want, step_q6) & armed[want->state];
    if (faults != 0u || want->state == cam_state_fault) {
        react(g, cfg, faults, want, axis);
    } else {
        accept(g, want, step_q6);
    }
    want->outputs = outputs(g, want->state);
}
