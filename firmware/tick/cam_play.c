// SPDX-License-Identifier: Apache-2.0
#include "cam_tick_inner.h"
#include "cam_fix.h"  // cam_angle_of_pos, cam_mulhi
#include "cam_eval.h" // cam_eval_segment
#include <stddef.h>   // NULL

/// Evaluate U with its velocity and acceleration: derivatives per knot times knots per tick. The
/// slow change of envelope, amplitude and height is neglected (a skirt: 1e-6 of the speed). A value
/// that overflows its word is a fault of this tick.
/// @return [nm / 64] U
static int32_t surface(cam_motion_t *m, const cam_play_config_t *cfg, int32_t speed_q32,
                       uint32_t theta_q32)
{
    const cam_u_scale_t *by = &cfg->u;
    const cam_channel_t *ch = &cfg->table->u;
    const uint64_t height_q32 = (uint64_t)m->height_q32;
    const uint32_t i = (uint32_t)(height_q32 >> 32);
    const uint32_t most = (uint32_t)((uint64_t)cfg->height_max_q32 >> 32);
    const cam_height_t z = {.i = i < most ? i : most, // always within the table
                            .w_q31 = (int32_t)((uint32_t)height_q32 >> 1)};
    const cam_value_t fine = cam_eval_quintic(cam_eval_segment(ch, theta_q32, z));
    const int32_t scale_q30 = m->scale_q30;
    const int32_t speed = (int32_t)((uint32_t)speed_q32 << by->speed_shift);
    const int32_t rate = cam_mulhi(speed, scale_q30);
    const int32_t rate2 = cam_mulhi(speed, rate);
    const int64_t acceleration =
        (int64_t)(fine.d2 >> by->a_down) * rate2 + (int64_t)fine.d1 * m->alpha_u;
    const int32_t offset = cam_mulhi(by->offset, scale_q30);
    const int32_t y = cam_mulhi_add(offset, fine.y, scale_q30 >> by->scale_down);
    m->axis[hal_axis_u].vel_q10 = (int32_t)((uint32_t)cam_mulhi(fine.d1, rate) << by->v_up);
    m->axis[hal_axis_u].acc_q10 = cam_shift_right(acceleration, by->a_shift);
    return (int32_t)((uint32_t)y << by->y_up);
}

/// Advance everything that is linear between two plans by one tick.
static void advance_all(cam_motion_t *m)
{
    cam_axis_motion_t *x = &m->axis[hal_axis_x];
    cam_axis_motion_t *z = &m->axis[hal_axis_z];
    x->pos_q10 = cam_wrap_add_i64(x->pos_q10, x->vel_q10);
    z->pos_q10 = cam_wrap_add_i64(z->pos_q10, z->vel_q10);
    m->phase_q32 = cam_wrap_add(m->phase_q32, m->phase_step_q32);
    m->scale_q30 = cam_sat_add(m->scale_q30, m->scale_step_q30);
    m->height_q32 = cam_wrap_add_i64(m->height_q32, m->height_step_q32);
}

/// Evaluate U at the spindle's angle.
/// @return [nm / 64] U
static int32_t play_table(const cam_play_config_t *cfg, const cam_angle_t *angle, cam_motion_t *m)
{
    const uint32_t even_q32 = cam_angle_of_pos(cam_angle_ahead(angle, cfg->lead_q16));
    const cam_learned_place_t at = cam_learned_place(even_q32);
    const uint32_t angle_q32 = even_q32 + cam_learned_turn_q32(cfg->d, at);
    m->c_q6 = cam_mulhi(cam_learned_at_q8(cfg->c, at), m->scale_q30);
    const int32_t more_q23 = cam_learned_faster_q23(cfg->d, at);
    const int32_t speed_q32 = cam_wrap_add(
        angle->speed_q32, (int32_t)((uint32_t)cam_mulhi(angle->speed_q32, more_q23) << 9));
    return surface(m, cfg, speed_q32, angle_q32 - (uint32_t)m->phase_q32);
}

/// Without enable all set-points follow the measured axes.
static void follow_axes(cam_motion_t *m, const cam_sense_t *in)
{
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        m->axis[i] = (cam_axis_motion_t){.pos_q10 = (int64_t)in->actual_nm[i] * 1024};
    }
    m->spindle_mrpm = 0;
    m->faults = 0;
    m->was_off = true;
    m->was_open = m->was_open || (in->inputs & (uint32_t)hal_in_estop) != 0u;
    m->is_by_hand = false;
    m->is_filtering = false;
}

/// Move U to the position of the wave and play it there; its end ends the state. The wave's gain
/// moves only while U rests. A wave of force goes to m->u_push_q6.
/// @return [nm / 64] what the wave adds to the set-point
static int32_t play_wave(cam_play_t *p, const cam_play_config_t *cfg, cam_motion_t *m)
{
    cam_axis_motion_t *u = &m->axis[hal_axis_u];
    const cam_excite_config_t *excite = &cfg->excite;
    int32_t wave_q6 = 0;
    bool is_over = false;
    if (u->pos_q10 == excite->place_q10 && u->vel_q10 == 0 && u->acc_q10 == 0) {
        is_over = cam_excite_step_isr(&p->excite, excite, &wave_q6);
    } else {
        (void)cam_jerk_filter_to_isr(&m->filter[hal_axis_u], u, &cfg->approach[hal_axis_u],
                                     excite->place_q10);
        is_over = p->excite.n_left == 0u;
    }
    m->state = is_over ? cam_state_ready : m->state;
    if (excite->is_force) {
        m->u_push_q6 = wave_q6;
        return 0;
    }
    return wave_q6;
}

/// Jog U to its target at the speed allowed by the plan, or brake it.
static void jog_u(const cam_play_config_t *cfg, cam_motion_t *m)
{
    cam_motion_limits_t limits = cfg->jog.limits[hal_axis_u];
    cam_jerk_filter_t *filter = &m->filter[hal_axis_u];
    if (m->u_speed_q10 > 0) {
        limits.speed_q10 = m->u_speed_q10;
        (void)cam_jerk_filter_to_isr(filter, &m->axis[hal_axis_u], &limits, m->u_target_q10);
    } else {
        (void)cam_jerk_filter_stop_isr(filter, &m->axis[hal_axis_u], &limits);
    }
}

/// Outside the cut U moves by time; in state fault the guard moves it. @return [nm / 64] U
static int32_t move_u(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                      cam_motion_t *m)
{
    cam_axis_motion_t *u = &m->axis[hal_axis_u];
    int32_t wave_q6 = 0;
    if (m->state == cam_state_off) {
        follow_axes(m, in);
    } else if (m->state == cam_state_fault) { // the guard moves U
        m->spindle_mrpm = 0;
    } else if (m->dwell_ticks > 0u) { // U's drive takes over where U stands
        m->dwell_ticks--;
    } else if (m->state == cam_state_identifying) {
        wave_q6 = play_wave(p, cfg, m);
    } else if (m->state == cam_state_manual) {
        jog_u(cfg, m);
    } else {
        (void)cam_jerk_filter_to_isr(&m->filter[hal_axis_u], u, &cfg->approach[hal_axis_u],
                                     m->u_target_q10);
    }
    return cam_sat_i32((u->pos_q10 >> 4) + wave_q6);
}

/// While the axes follow the table only stop and a table fault are obeyed; the next plan schedules
/// the end of a stopped cut.
static void obey_in_cut(cam_play_t *p, uint32_t request, cam_motion_t *m)
{
    const uint32_t what = request & 0xFFu;
    p->request = request >> 8;
    if (what == (uint32_t)cam_request_stop) {
        m->is_stopping = true;
    } else if (what == (uint32_t)cam_request_table_fault) {
        m->faults |= CAM_FAULT_BIT(table);
    } else {
        // ignored in this state
    }
}

/// @return whether a disable is ignored because the axes are in motion
static bool is_held(cam_state_t state)
{
    return cam_state_is_in_work(state) || state == cam_state_fault ||
           state == cam_state_identifying || state == cam_state_manual;
}

/// Faults that block enable. In off they are not latched.
#define HOLDS_OFF                                                                                  \
    (CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(bus) | CAM_FAULT_BIT(late_tick))

/// @return whether the drives may be enabled: no blocking fault, and acknowledged at the machine
static bool may_enable(const cam_play_config_t *cfg, const cam_motion_t *m, uint32_t faults)
{
    const bool is_acknowledged = m->is_acknowledged && !m->was_open;
    return m->state == cam_state_off && (faults & HOLDS_OFF) == 0u &&
           (is_acknowledged || !cfg->acknowledge.is_demanded);
}

/// Enable the drives with the axes where they are; from there U moves by time, after its rest.
static void switch_on(cam_motion_t *m, const cam_play_config_t *cfg, cam_state_t state)
{
    m->state = state;
    m->dwell_ticks = cfg->dwell_ticks;
    cam_jerk_filter_begin_isr(&m->filter[hal_axis_u], &m->axis[hal_axis_u],
                              cfg->approach[hal_axis_u].log2_window);
}

/// Enter the state manual: hold the axes where they are; the plan jogs them.
static void begin_manual(const cam_play_config_t *cfg, cam_motion_t *m, uint32_t faults)
{
    if (may_enable(cfg, m, faults)) {
        switch_on(m, cfg, cam_state_manual);
        m->u_speed_q10 = 0;
        m->is_by_hand = true;
        m->is_stopping = false;
    }
}

/// Carry out a new request outside the cut, if the state allows it.
static void obey(cam_play_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                 cam_motion_t *m)
{
    const uint32_t request = r->in.request;
    const uint32_t seen = cam_record_faults(r, m);
    p->request = request >> 8;
    switch ((cam_request_t)(request & 0xFFu)) {
    case cam_request_enable:
        if (may_enable(cfg, m, seen) && cfg->table != NULL) {
            switch_on(m, cfg, cam_state_homing);
            m->u_target_q10 = cfg->u_retract_q10;
        }
        break;
    case cam_request_disable: // jogged axes brake first
        m->is_stopping = m->state == cam_state_manual;
        m->state = is_held(m->state) ? m->state : cam_state_off;
        break;
    case cam_request_start:
        if (m->state == cam_state_ready) {
            m->state = cfg->rehearse_q32 > 0 ? cam_state_rehearsing : cam_state_engaging;
        }
        break;
    case cam_request_stop: // ends an approach at once
        if (m->state == cam_state_engaging || m->state == cam_state_rehearsing) {
            m->state = cam_state_ready;
        }
        p->excite.n_left = 0;
        break;
    case cam_request_reset:
        m->state = m->state == cam_state_fault && m->is_retracted ? cam_state_off : m->state;
        break;
    case cam_request_table_fault:
        m->faults |= CAM_FAULT_BIT(table);
        break;
    case cam_request_identify:
        if (m->state == cam_state_ready && cfg->excite.n > 0u) {
            m->state = cam_state_identifying;
            p->excite = (cam_excite_t){.at = cfg->excite.first, .n_left = cfg->excite.n_play};
            m->u_push_q6 = 0;
        }
        break;
    case cam_request_manual:
        begin_manual(cfg, m, seen);
        break;
    case cam_request_none:
        break;
    }
}

void cam_play_step_isr(cam_play_t *p, const cam_play_config_t *cfg, cam_tick_record_t *r,
                       cam_motion_t *m)
{
    const cam_sense_t *in = &r->in;
    cam_want_t *want = &r->want;
    const bool is_new = in->request >> 8 != p->request;
    advance_all(m);
    if (m->is_playing) {
        if (is_new) {
            obey_in_cut(p, in->request, m);
        }
        const int32_t z_nm = (int32_t)(m->axis[hal_axis_z].pos_q10 >> 10);
        want->z_nm = cam_sat_sub(z_nm, m->z_ahead_nm);
        want->u_set_q6 = play_table(cfg, &r->angle, m);
    } else {
        if (is_new) {
            obey(p, cfg, r, m);
        }
        want->z_nm = cam_sat_sub(in->actual_nm[hal_axis_z], cfg->z_origin_nm);
        want->u_set_q6 = move_u(p, cfg, in, m);
    }
    want->state = m->state;
    want->spindle_mrpm = m->spindle_mrpm;
}
