// SPDX-License-Identifier: Apache-2.0
#include "cam_guard.h"
#include "cam_fix.h" // cam_clamp_i32, cam_sat_i32

/// After these the drives are disabled at once: one of them, or the position loop, does not work.
#define LOST (CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(u_travel) | CAM_FAULT_BIT(u_runaway))
#define ARMED_IN_FAULT                                                                             \
    (LOST | CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(bus) | CAM_FAULT_BIT(command) |                   \
     CAM_FAULT_BIT(u_force))
#define ARMED_MOVING (ARMED_IN_FAULT | CAM_FAULT_BIT(late_tick) | CAM_FAULT_BIT(table))
#define ARMED_ENABLED (ARMED_MOVING | CAM_FAULT_BIT(index_missing))
/// Jogging needs neither the spindle nor its encoder.
#define ARMED_MANUAL                                                                               \
    (ARMED_MOVING | CAM_FAULT_BIT(following_error) | CAM_FAULT_BIT(setpoint_speed) |               \
     CAM_FAULT_BIT(setpoint_acceleration) | CAM_FAULT_BIT(setpoint_range))
#define ARMED_SYNCED                                                                               \
    (ARMED_MANUAL | CAM_FAULT_BIT(index_missing) | CAM_FAULT_BIT(encoder_jump) |                   \
     CAM_FAULT_BIT(lost_counts))
#define ARMED_IN_WORK                                                                              \
    (ARMED_SYNCED | CAM_FAULT_BIT(reverse) | CAM_FAULT_BIT(spindle_stopped) |                      \
     CAM_FAULT_BIT(overspeed) | CAM_FAULT_BIT(z_range) | CAM_FAULT_BIT(swing))

/// Marks the states that set the output hal_out_in_cut.
#define IN_CUT (UINT32_C(1) << 31)
_Static_assert(cam_n_faults < 32, "one bit is free");

static const uint32_t armed[cam_n_states] = {
    [cam_state_off] = 0,
    [cam_state_homing] = ARMED_ENABLED | CAM_FAULT_BIT(spindle_stopped),
    [cam_state_ready] = ARMED_SYNCED,
    [cam_state_engaging] = ARMED_IN_WORK,
    [cam_state_cutting] = ARMED_IN_WORK | IN_CUT,
    [cam_state_disengaging] = ARMED_IN_WORK,
    [cam_state_fault] = ARMED_IN_FAULT,
    [cam_state_rehearsing] = ARMED_IN_WORK,
    [cam_state_identifying] = ARMED_SYNCED,
    [cam_state_manual] = ARMED_MANUAL,
    [cam_state_holding] = ARMED_IN_WORK | IN_CUT,
};

uint32_t cam_guard_armed(cam_state_t state)
{
    return (uint32_t)state < cam_n_states ? armed[state] & ~IN_CUT : 0u;
}

/// Count all new faults at once: bit i of word k of `count` is bit k of the counter of fault i, so
/// the carry ripples from word to word.
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

uint32_t cam_guard_plan_isr(cam_guard_t *g, const cam_guard_config_t *cfg,
                            const cam_tick_record_t *r)
{
    const int32_t speed_q32 = r->angle.speed_q32;
    const bool is_homing =
        r->want.state == cam_state_homing; // then reverse rotation counts as standstill
    const uint32_t most_ticks = is_homing ? cfg->homing_ticks : cfg->stopped_ticks;
    count_new(g);
    const bool is_watched = (cam_guard_armed(r->want.state) & CAM_FAULT_BIT(spindle_stopped)) != 0u;
    const bool is_standing =
        is_watched && speed_q32 < cfg->stopped_q32 && (is_homing || speed_q32 > -cfg->stopped_q32);
    g->n_stopped = is_standing ? g->n_stopped + cfg->plan_ticks : 0u;
    return (speed_q32 < -cfg->stopped_q32 ? CAM_FAULT_BIT(reverse) : 0u) |
           (g->n_stopped > most_ticks ? CAM_FAULT_BIT(spindle_stopped) : 0u) |
           (speed_q32 > cfg->overspeed_q32 ? CAM_FAULT_BIT(overspeed) : 0u);
}

/// Once the encoder has advanced in the work, it must not stand.
/// @return spindle_stopped or none
static uint32_t standing_encoder(cam_guard_t *g, uint32_t watched, bool is_still)
{
    const bool is_in_work = (watched & CAM_FAULT_BIT(reverse)) != 0u;
    const bool has_stopped = g->is_going && is_in_work && is_still;
    g->is_going = is_in_work && !is_still;
    return has_stopped ? CAM_FAULT_BIT(spindle_stopped) : 0u;
}

/// @param watched  faults that are armed
/// @return         all faults of a tick, whether armed or not
static uint32_t faults_of(cam_guard_t *g, const cam_guard_config_t *cfg, const cam_tick_record_t *r,
                          const cam_motion_t *m, uint32_t watched, int32_t step_q6)
{
    const cam_sense_t *in = &r->in;
    const cam_angle_t *angle = &r->angle;
    const cam_want_t *want = &r->want;
    uint32_t faults = want->faults;
    faults |= standing_encoder(g, watched, angle->is_still);
    const int32_t off_nm = in->actual_nm[hal_axis_u] - (want->u_due_q6 >> 6);
    if (!cam_is_within(off_nm, cfg->following_nm)) {
        const bool is_pressing = m->u_press_q6 != 0; // on its stop, with limited force
        if (m->is_playing || (!cam_is_within(off_nm, cfg->approach_nm) && !is_pressing)) {
            faults |= CAM_FAULT_BIT(following_error);
        }
    }
    if (!cam_is_within(want->u_set_q6, cfg->u_range_q6)) {
        faults |= CAM_FAULT_BIT(setpoint_range);
    }
    if (!cam_is_within(step_q6, cfg->u_vel_q6)) {
        faults |= CAM_FAULT_BIT(setpoint_speed);
    }
    const int32_t change_q6 = cam_sat_sub(step_q6, g->u_step_q6);
    if (!cam_is_within(change_q6, cfg->u_acc_q6)) {
        const int32_t most_q6 = angle->is_off_time ? cfg->u_acc_off_q6 : cfg->u_acc_q6;
        if (!cam_is_within(change_q6, most_q6)) {
            faults |= CAM_FAULT_BIT(setpoint_acceleration);
        }
    }
    return faults;
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

bool cam_guard_holds_isr(const cam_guard_t *g, const cam_motion_t *m)
{
    const bool is_let_go = m->is_retracted || (g->faults & LOST) != 0u;
    return m->state != cam_state_off && !(m->state == cam_state_fault && is_let_go);
}

/// Replace the set-points of play by those of the retract. The drives stay enabled until it has
/// ended, or a fault of LOST.
static void write_retract(cam_guard_t *g, cam_tick_record_t *r, const cam_motion_t *m)
{
    g->u_set_q6 = cam_sat_i32(m->axis[hal_axis_u].pos_q10 >> 4);
    r->want.state = cam_state_fault;
    r->want.spindle_mrpm = 0;
    r->want.u_set_q6 = g->u_set_q6;
    r->want.faults = g->faults;
    r->want.outputs = cam_guard_holds_isr(g, m) ? hal_out_fault | hal_out_enable : hal_out_fault;
    r->want.is_retracted = m->is_retracted;
}

/// Latch faults and enter the state fault. In this tick U continues from its last set-point with
/// the speed and acceleration of its last step, because the new set-point is not trusted.
static void latch(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                  cam_motion_t *m, uint32_t faults)
{
    const int32_t most_q10 = cfg->leave.acceleration_q10;
    // While identifying, u_acc_q10 lacks the acceleration of the wave.
    const int32_t acc_q10 = r->want.state == cam_state_identifying
                                ? 0
                                : cam_clamp_i32(g->u_acc_q10, -most_q10, most_q10);
    const int32_t vel_q10 = cam_sat_i32((int64_t)g->u_step_q6 * 16 + acc_q10);
    cam_axis_motion_t *u = &m->axis[hal_axis_u];
    *u = (cam_axis_motion_t){
        .pos_q10 = (int64_t)g->u_set_q6 * 16 + vel_q10, .vel_q10 = vel_q10, .acc_q10 = acc_q10};
    cam_jerk_filter_begin_isr(&m->filter[hal_axis_u], u, cfg->leave.log2_window);
    g->faults |= faults;
    g->first_faults = g->faults;
    m->x_left_q10 = (int64_t)cam_sat_i32(m->axis[hal_axis_x].pos_q10 >> 10) * 1024; // as commanded
    m->state = cam_state_fault;
    m->is_playing = false;
    m->is_retracted = false;
    write_retract(g, r, m);
}

/// In the ticks after a fault U retracts (in manual it brakes) while the plan moves the other axes
/// off. The drives are disabled when all axes are at rest.
static void retract(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                    cam_motion_t *m)
{
    cam_axis_motion_t *u = &m->axis[hal_axis_u];
    cam_jerk_filter_t *filter = &m->filter[hal_axis_u];
    g->faults |= r->want.faults & ARMED_IN_FAULT;
    const bool is_u_out = m->is_by_hand
                              ? cam_jerk_filter_stop_isr(filter, u, &cfg->leave)
                              : cam_jerk_filter_to_isr(filter, u, &cfg->leave, cfg->u_retract_q10);
    m->is_retracted = m->is_retracted || (is_u_out && m->is_clear);
    write_retract(g, r, m);
}

void cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                        cam_motion_t *m)
{
    cam_want_t *want = &r->want;
    const uint32_t watched = armed[want->state];
    if (want->state == cam_state_off) { // set-points follow the axes, and no fault is latched
        g->u_set_q6 = want->u_set_q6;
        g->u_step_q6 = 0;
        g->u_acc_q10 = 0;
        g->faults = 0;
        g->counted = 0;
        g->n_stopped = 0;
        want->faults = 0;
        want->outputs = 0;
        want->is_retracted = true;
        return;
    }
    if (want->state == cam_state_fault) {
        retract(g, cfg, r, m);
        return;
    }
    const int32_t step_q6 = cam_sat_sub(want->u_set_q6, g->u_set_q6);
    const uint32_t faults = faults_of(g, cfg, r, m, watched, step_q6) & watched;
    if (faults != 0u) {
        latch(g, cfg, r, m, faults);
        return;
    }
    g->u_set_q6 = want->u_set_q6;
    g->u_step_q6 = step_q6;
    g->u_acc_q10 = m->axis[hal_axis_u].acc_q10;
    want->faults = 0;
    want->outputs = (watched & IN_CUT) != 0u ? hal_out_enable | hal_out_in_cut : hal_out_enable;
    want->is_retracted = false;
}

void cam_guard_refuse_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                          cam_motion_t *m)
{
    if (m->state != cam_state_fault) {
        latch(g, cfg, r, m, CAM_FAULT_BIT(command));
    }
    g->faults |= CAM_FAULT_BIT(command);
    r->want.faults = g->faults;
}
