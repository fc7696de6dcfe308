// SPDX-License-Identifier: Apache-2.0
#include "cam_tick_inner.h"
#include "cam_fix.h" // cam_fence_release_isr, cam_wrap_add
#include "hal/hal.h" // all reads and writes

cam_t g_cam;

/// Take a measured position. Beyond cam_sense_most_nm it is clamped, and the drives are reported as
/// not ready.
static void sense_axis(cam_sense_t *in, hal_axis_t axis, int32_t nm)
{
    int32_t taken_nm = nm;
    if (taken_nm < -cam_sense_most_nm || taken_nm >= cam_sense_most_nm) {
        taken_nm = nm < 0 ? -cam_sense_most_nm : cam_sense_most_nm - 1;
        in->inputs &= ~(uint32_t)hal_in_drive_ready;
    }
    in->actual_nm[axis] = taken_nm;
}

static void sense_isr(cam_t *c, cam_sense_t *in)
{
    in->clock = hal_clock_isr();
    hal_encoder_read_isr(&in->encoder);
    in->swing_q32 = hal_swing_read_q32_isr();
    in->inputs = hal_inputs_read_isr();
    sense_axis(in, hal_axis_u, cam_wrap_add(hal_axis_read_nm_isr(hal_axis_u), c->motion.u.home_nm));
    sense_axis(in, hal_axis_x, hal_axis_read_nm_isr(hal_axis_x));
    sense_axis(in, hal_axis_z, hal_axis_read_nm_isr(hal_axis_z));
    in->request = atomic_load_explicit(&c->request, CAM_ORDER_ACQUIRE);
    cam_fence_acquire_isr();
}

/// Calculate U's force from the last tick's command and enable; it leaves before anything else is
/// calculated. Disabling the drives also ends the force limit of homing against a stop. A fault of
/// the supervision takes effect in this tick, on the force in the next. Not inlined: a tick without
/// it saves no registers for it.
static __attribute__((noinline)) void servo_isr(cam_t *c, const cam_config_t *cfg,
                                                cam_tick_record_t *r)
{
    const bool is_on = cam_guard_holds_isr(&c->guard, &c->motion);
    c->motion.u_press_q6 = is_on ? c->motion.u_press_q6 : 0;
    c->force.servo.most_q6 = c->motion.u_press_q6;
    cam_force_step_isr(&c->force, &cfg->force, r, is_on, &c->motion);
    hal_force_write_isr(r->force_q6);
    c->motion.faults |= cam_force_watch_isr(&c->force, &cfg->force, r, &c->motion);
}

static void decide_isr(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r)
{
    r->config = cfg->generation;
    cam_spindle_step_isr(&c->spindle, &cfg->spindle, &r->in, c->motion.alpha_q40, &r->angle);
    cam_play_step_isr(&c->play, &cfg->play, r, &c->motion);
    const int32_t u_nm = cam_axis_command_isr(&cfg->command, r, &c->motion);
    cam_guard_step_isr(&c->guard, &cfg->guard, r, u_nm, &c->motion);
}

static void actuate_isr(cam_t *c, const cam_tick_record_t *r)
{
    hal_outputs_write_isr(r->want.outputs);
    hal_axis_write_isr(hal_axis_u, &r->out[hal_axis_u]);
    hal_axis_write_isr(hal_axis_x, &r->out[hal_axis_x]);
    hal_axis_write_isr(hal_axis_z, &r->out[hal_axis_z]);
    if (c->motion.swing.is_new) { // of the last plan
        c->motion.swing.is_new = false;
        hal_swing_write_isr(&c->motion.swing.set);
    }
    hal_spindle_write_isr(r->want.spindle_mrpm);
}

/// Plan the axes: in manual jog them, otherwise follow the table or position them.
static void plan_by_state(cam_t *c, const cam_config_t *cfg, const cam_tick_record_t *r)
{
    if (c->motion.state == cam_state_manual) {
        cam_jog_isr(&c->jog, &cfg->play, r, &c->motion);
    } else {
        cam_jog_idle_isr(&c->jog, &cfg->play, r);
        cam_plan_isr(&c->plan, &cfg->play, r, &c->motion);
    }
}

/// Run the plan. Its faults take effect in the next tick. Not inlined: a tick without it saves no
/// registers for it.
static __attribute__((noinline)) void plan_isr(cam_t *c, const cam_config_t *cfg,
                                               const cam_tick_record_t *r)
{
    cam_motion_t *m = &c->motion;
    const cam_axis_motion_t before[hal_n_axes] = {
        [hal_axis_x] = m->axis[hal_axis_x], [hal_axis_z] = m->axis[hal_axis_z]};
    c->until_plan = cfg->play.plan_ticks;
    if (m->was_off) { // every enable searches the index again, even after an off of a few ticks
        cam_spindle_forget_isr(&c->spindle, &r->in.encoder);
    }
    uint32_t faults = cam_spindle_check_index_isr(&c->spindle, &cfg->spindle, &r->in.encoder);
    faults |= cam_spindle_check_inertia_isr(&c->spindle, &cfg->spindle, m->is_playing);
    plan_by_state(c, cfg, r); // replaces m->faults
    m->was_off = false;
    faults |= cam_axis_command_plan_isr(&cfg->command, m, before);
    faults |= cam_guard_plan_isr(&c->guard, &cfg->guard, &cfg->play, r);
    cam_turn_bins_plan_isr(&c->bins, r, m);
    cam_acknowledge_isr(&c->acknowledge, &cfg->play.acknowledge, r, m);
    m->faults |= faults;
}

static void publish_isr(cam_t *c, cam_tick_record_t *r)
{
    cam_turn_bins_add_isr(&c->bins, r);
    cam_fence_release_isr(); // the record is complete before the number that hands it over
    cam_trace_commit_isr(&c->trace, r);
}

void cam_tick_isr(cam_t *c)
{
    const cam_config_t *cfg = cam_config_take_isr(&c->config); // the same for the whole tick
    cam_tick_record_t *r = cam_trace_begin_isr(&c->trace);
    sense_isr(c, &r->in); // the only reads from the machine
    if (cfg->force.is_used) {
        servo_isr(c, cfg, r); // position loop of U and its supervision, on the last command
    }
    decide_isr(c, cfg, r); // observe -> play -> command -> guard
    actuate_isr(c, r);     // all other writes to the machine
    if (--c->until_plan <= 0) {
        plan_isr(c, cfg, r);
    }
    publish_isr(c, r); // record, learning data
}

void cam_isr(void)
{
    cam_tick_isr(&g_cam);
}
