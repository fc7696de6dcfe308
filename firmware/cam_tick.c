// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_tick.h"
#include "cam/cam_fix.h" // cam_sat_i32
#include "hal/hal.h"     // all reads and writes

cam_t g_cam;

static void sense_isr(cam_t *c, cam_sense_t *in)
{
    in->clock = hal_clock_isr();
    in->encoder = hal_encoder_read_isr();
    in->actual_nm[hal_axis_u] = hal_axis_read_nm_isr(hal_axis_u);
    in->actual_nm[hal_axis_x] = hal_axis_read_nm_isr(hal_axis_x);
    in->actual_nm[hal_axis_z] = hal_axis_read_nm_isr(hal_axis_z);
    in->inputs = hal_inputs_read_isr();
    in->request = atomic_load_explicit(&c->request, memory_order_acquire);
}

/// While off, nobody relies on the angle: the index is forgotten, so every enable homes anew.
static cam_angle_t angle_isr(cam_t *c, const cam_config_t *cfg, const cam_sense_t *in)
{
    if (c->play.state == cam_state_off) {
        cam_spindle_forget_isr(&c->spindle);
    }
    return cam_spindle_step_isr(&c->spindle, &cfg->spindle, in, c->play.speed.alpha_q48);
}

/// Inverse of a second-order drive: what must be commanded for the tool to be at pos.
static int32_t feed_forward_nm(const cam_config_t *cfg, const cam_move_t *m)
{
    const int64_t velocity_q10 = ((int64_t)cfg->k1_q16 * m->vel_q10) >> 16;
    const int64_t acceleration_q10 = ((int64_t)cfg->k2_q16 * m->acc_q10) >> 16;
    return cam_sat_i32((m->pos_q10 + velocity_q10 + acceleration_q10 + 512) >> 10);
}

static hal_setpoint_t setpoint(const cam_config_t *cfg, const cam_move_t *m, int32_t pos_nm)
{
    return (hal_setpoint_t){
        .pos_nm = pos_nm,
        .vel_um_per_s = cam_sat_i32(((int64_t)m->vel_q10 * cfg->um_per_s_q24) >> 24),
        .acc_mm_per_s2 = cam_sat_i32(((int64_t)m->acc_q10 * cfg->mm_per_s2_q24) >> 24),
    };
}

static int32_t plain_nm(const cam_move_t *m)
{
    return cam_sat_i32((m->pos_q10 + 512) >> 10);
}

static void record(const cam_t *c, const cam_config_t *cfg, const cam_angle_t *angle,
                   const cam_want_t *want, const cam_safe_t *safe, cam_tick_record_t *r)
{
    const cam_move_t *axis = safe->axis;
    r->tick = c->tick;
    r->config = cfg->generation;
    r->pos_q32 = angle->pos_q32;
    r->speed_q32 = angle->speed_q32;
    r->z_nm = want->z_nm;
    r->u_set_q6 = cam_sat_i32(axis[hal_axis_u].pos_q10 >> 4);
    r->u_due_q6 = want->u_due_q6;
    r->out[hal_axis_u] = setpoint(cfg, &axis[hal_axis_u], feed_forward_nm(cfg, &axis[hal_axis_u]));
    r->out[hal_axis_x] = setpoint(cfg, &axis[hal_axis_x], plain_nm(&axis[hal_axis_x]));
    r->out[hal_axis_z] = setpoint(cfg, &axis[hal_axis_z], plain_nm(&axis[hal_axis_z]));
    r->spindle_mrpm = safe->spindle_mrpm;
    r->outputs = safe->outputs;
    r->faults = c->guard.faults;
    r->state = safe->state;
}

void cam_tick_steps_isr(cam_t *c, const cam_sense_t *in, cam_tick_record_t *out)
{
    const cam_config_t *cfg = cam_config_take_isr(&c->config);
    const cam_angle_t angle = angle_isr(c, cfg, in);
    const cam_want_t want = cam_play_step_isr(&c->play, &cfg->play, in, &angle);
    const cam_safe_t safe = cam_guard_step_isr(&c->guard, &cfg->guard, in, &angle, &want);
    cam_play_settle_isr(&c->play, safe.state, safe.axis, c->guard.is_retracted);
    record(c, cfg, &angle, &want, &safe, out);
    c->tick++;
}

static void actuate_isr(const cam_tick_record_t *r)
{
    hal_outputs_write_isr(r->outputs);
    hal_axis_write_isr(hal_axis_u, r->out[hal_axis_u]);
    hal_axis_write_isr(hal_axis_x, r->out[hal_axis_x]);
    hal_axis_write_isr(hal_axis_z, r->out[hal_axis_z]);
    hal_spindle_write_isr(r->spindle_mrpm);
}

/// The half that is not the newest is filled, then becomes the newest.
static void publish_status(cam_t *c, const cam_tick_record_t *r)
{
    const uint32_t n = atomic_load_explicit(&c->n_published, memory_order_relaxed);
    cam_status_t *s = &c->status[(n + 1u) & 1u];
    s->tick = r->tick;
    s->config = r->config;
    s->request = c->play.request;
    s->state = r->state;
    s->faults = r->faults;
    s->first_fault = c->guard.first_faults;
    s->is_synced = c->spindle.is_synced;
    s->is_retracted = c->guard.is_retracted;
    s->inputs = r->in.inputs;
    s->pos_q32 = r->pos_q32;
    s->speed_q32 = r->speed_q32;
    s->z_nm = r->z_nm;
    s->u_set_q6 = r->u_set_q6;
    s->u_actual_nm = r->in.actual_nm[hal_axis_u];
    s->following_nm = c->guard.following_q6 / 64;
    s->n_late = c->guard.n_late;
    s->max_period = c->guard.max_period;
    for (uint32_t i = 0; i < cam_n_faults; i++) {
        s->fault_count[i] = c->guard.count[i];
    }
    atomic_store_explicit(&c->n_published, n + 1u, memory_order_release);
}

static void publish_isr(cam_t *c, const cam_tick_record_t *r)
{
    const uint32_t in_use = atomic_load_explicit(&c->config.in_use, memory_order_relaxed);
    cam_trace_commit_isr(&c->trace, c->config.half[in_use].is_traced);
    publish_status(c, r);
}

void cam_tick_isr(cam_t *c)
{
    cam_tick_record_t *r = cam_trace_slot_isr(&c->trace);
    sense_isr(c, &r->in);
    cam_tick_steps_isr(c, &r->in, r); // angle -> play -> guard
    actuate_isr(r);
    publish_isr(c, r);
}

void cam_isr(void)
{
    cam_tick_isr(&g_cam);
}
