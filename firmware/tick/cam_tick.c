// SPDX-License-Identifier: Apache-2.0
#include "cam_tick.h"
#include "cam_fence.h" // cam_fence_release_isr
#include "cam_fix.h"   // cam_clamp_i32
#include "hal/hal.h"   // all reads and writes
#include <stddef.h>    // NULL

/// The end of a stage, sense .. actuate. Nothing, unless a test that counts the stages defines it
/// in front of this file (tests/budget/stage_mark.h).
#ifndef CAM_TICK_MARK
#define CAM_TICK_MARK(stage) ((void)0)
#endif

cam_t g_cam;

static void sense_isr(cam_t *c, cam_sense_t *in)
{
    in->clock = hal_clock_isr();
    hal_encoder_read_isr(&in->encoder);
    const int32_t u_nm =
        hal_axis_read_nm_isr(hal_axis_u); // in pairs: two words are stored by one instruction
    const int32_t x_nm = hal_axis_read_nm_isr(hal_axis_x);
    in->actual_nm[hal_axis_u] = cam_wrap_add(u_nm, c->motion.u_home_nm);
    in->actual_nm[hal_axis_x] = x_nm;
    const int32_t z_nm = hal_axis_read_nm_isr(hal_axis_z);
    const int32_t swing_q32 = hal_swing_read_q32_isr();
    in->actual_nm[hal_axis_z] = z_nm;
    in->swing_q32 = swing_q32;
    in->inputs = hal_inputs_read_isr();
    in->request = atomic_load_explicit(&c->request, CAM_ORDER_ACQUIRE);
    cam_fence_acquire_isr();
}

static hal_setpoint_t setpoint(const cam_axis_motion_t *m, int32_t pos_nm)
{
    return (hal_setpoint_t){.pos_nm = pos_nm, .vel_q10 = m->vel_q10, .acc_q10 = m->acc_q10};
}

/// The guard is in charge: its set-point of U is written, and the cut has ended.
static void take_over(cam_t *c, cam_want_t *want)
{
    if (c->motion.state != cam_state_fault) {
        c->motion.x_left_q10 = (int64_t)c->watch.led_nm[hal_axis_x] * 1024; // as it is told
    }
    c->motion.axis[hal_axis_u] = c->guard.u;
    c->motion.state = cam_state_fault;
    c->motion.is_playing = false;
    c->motion.is_retracted = want->is_retracted;
    want->state = cam_state_fault;
    want->spindle_mrpm = 0;
    want->u_set_q6 = c->guard.u_set_q6;
}

static void obey_guard(cam_t *c, cam_tick_record_t *r, cam_verdict_t verdict)
{
    r->want.faults = verdict.faults;
    r->want.outputs = verdict.outputs;
    r->want.is_retracted = verdict.is_retracted;
    if (verdict.is_in_charge) {
        take_over(c, &r->want);
    }
}

static void guard_isr(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r)
{
    const cam_verdict_t verdict =
        cam_guard_step_isr(&c->guard, &cfg->guard, r, &c->motion, &c->command.u);
    obey_guard(c, r, verdict);
    if (!verdict.is_in_charge) { // what U does in a fault is not to be learned
        cam_turn_bins_add_isr(&c->bins, r->angle.pos_q32, r->angle.measured_q32, r->want.u_due_q6,
                              r->in.actual_nm[hal_axis_u]);
    }
}

/// What U was told last is what the record of the last tick says, unless a bit of it has flipped.
/// @return fault corrupt or none
static uint32_t mend_told(cam_t *c)
{
    const cam_tick_record_t *last = atomic_load_explicit(&c->newest, memory_order_relaxed);
    const int32_t u_nm = c->command.u.nm;
    if (last != NULL) {
        c->command.u.nm = cam_wrap_add(last->out[hal_axis_u].pos_nm, c->watch.u_home_nm);
    }
    return c->command.u.nm != u_nm ? CAM_FAULT_BIT(corrupt) : 0u;
}

/// In state fault the retract goes on; what has flipped has led it away from what U is told, and it
/// begins again from there.
static void retract_on(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r)
{
    cam_axis_command_nearest_isr(&c->command, &cfg->command, r, &c->motion, false);
    r->want.faults = c->guard.faults;
    if ((c->guard.faults & CAM_FAULT_BIT(corrupt)) != 0u) {
        cam_guard_begin_isr(&c->guard, &cfg->guard, &c->command.u);
        c->motion.axis[hal_axis_u] = c->guard.u;
        r->want.u_set_q6 = c->guard.u_set_q6;
        cam_axis_command_fade_isr(&c->command, &cfg->command, r, &c->motion);
    }
}

/// U would be told what is beyond its limits: a fault, and the retract begins with the next tick.
CAM_STAGE static void refuse_command(cam_t *c, cam_tick_record_t *r)
{
    const cam_config_t *cfg = atomic_load_explicit(&c->config.in_use, memory_order_relaxed);
    const uint32_t faults = CAM_FAULT_BIT(command) | mend_told(c);
    if (c->motion.state == cam_state_fault) {
        c->guard.faults |= faults;
        retract_on(c, cfg, r);
        return;
    }
    obey_guard(c, r,
               cam_guard_enter_isr(&c->guard, &cfg->guard, r->want.state, faults, &c->command.u));
    cam_axis_command_nearest_isr(&c->command, &cfg->command, r, &c->motion, true);
}

/// Write the set-points into the record, in the form that the drives take. Those of X and Z are
/// their places rounded down, as they were watched; the plan has added half a nanometre to X, which
/// is thus rounded to nearest.
static void tell(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r, bool is_new)
{
    const cam_axis_motion_t *axis = c->motion.axis;
    if (!cam_axis_command_isr(&c->command, &cfg->command, r, &c->motion, is_new)) {
        refuse_command(c, r);
    }
    const int32_t u_nm = cam_wrap_sub(c->command.u.nm, c->motion.u_home_nm);
    r->out[hal_axis_u] = setpoint(&axis[hal_axis_u], u_nm);
    r->out[hal_axis_x] = setpoint(&axis[hal_axis_x], c->watch.led_nm[hal_axis_x]);
    r->out[hal_axis_z] = setpoint(&axis[hal_axis_z], c->watch.led_nm[hal_axis_z]);
}

/// The state is not the one that the last tick left behind. @return fault corrupt
CAM_STAGE static uint32_t mend_state(cam_t *c)
{
    const cam_tick_record_t *last = atomic_load_explicit(&c->newest, memory_order_relaxed);
    const cam_state_t was = last != NULL ? last->want.state : cam_state_off;
    return cam_watch_mend_state_isr(&c->watch, &c->motion, was);
}

/// X or Z is not where its last place and its increment lead. @return fault corrupt, in off none
CAM_STAGE static uint32_t mend_course(cam_t *c)
{
    const cam_tick_record_t *last = atomic_load_explicit(&c->newest, memory_order_relaxed);
    return cam_watch_mend_isr(&c->watch, &c->command, &c->motion, last);
}

/// angle -> play: what the tick wants.
static inline void want_isr(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r)
{
    r->config = cfg->generation;
    cam_spindle_step_isr(&c->spindle, &cfg->spindle, &r->in, c->motion.alpha_q40, &r->angle);
    CAM_TICK_MARK(angle);
    r->want.faults = c->motion.faults | r->angle.faults | cam_sense_faults(&r->in);
    if (c->motion.state != c->watch.state) {
        r->want.faults |= mend_state(c);
    }
    cam_play_step_isr(&c->play, &cfg->play, &r->in, &r->angle, &c->motion, &r->want);
    if (!cam_watch_is_on_course_isr(&c->watch, &c->command, &c->motion)) {
        r->want.faults |= mend_course(c);
    }
    CAM_TICK_MARK(play);
}

/// guard -> tell: what the axes will be told.
static inline void judge_isr(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r)
{
    const bool was_fault = c->motion.state == cam_state_fault;
    guard_isr(c, cfg, r);
    CAM_TICK_MARK(guard);
    tell(c, cfg, r, !was_fault);
    cam_watch_keep_isr(&c->watch, &c->motion);
    if (cfg->switches.n > 0u) {
        r->want.outputs |= cam_switches_step_isr(&c->switches, &cfg->switches, r);
    }
}

/// The angle is forgotten where the state was off in any tick since the last plan, because every
/// enable homes anew; an off as short as that of the command home counts, too.
static uint32_t watch_index(cam_t *c, const cam_config_t *cfg, const cam_tick_record_t *r)
{
    if (!c->motion.was_off) {
        return cam_spindle_watch_isr(&c->spindle, &cfg->spindle, &r->in.encoder);
    }
    cam_spindle_forget_isr(&c->spindle, &r->in.encoder);
    return 0;
}

/// Let U of the controller become another number at the same place: everything that is compared
/// with the next tick's reading moves along, so that the drive gets the set-point of before.
static void shift_u(cam_t *c, int32_t nm)
{
    const int32_t by_q6 = (int32_t)((uint32_t)nm * 64u);
    c->motion.u_home_nm = cam_wrap_add(c->motion.u_home_nm, nm);
    c->watch.u_home_nm = cam_wrap_add(c->watch.u_home_nm, nm);
    const int64_t by_q10 = (int64_t)nm * 1024;
    cam_axis_motion_t *u = &c->motion.axis[hal_axis_u];
    u->pos_q10 = cam_wrap_add_i64(u->pos_q10, by_q10);
    cam_jerk_filter_shift_isr(&c->motion.filter[hal_axis_u], by_q10);
    c->motion.u_target_q10 = cam_wrap_add_i64(c->motion.u_target_q10, by_q10);
    c->guard.u_set_q6 = cam_wrap_add(c->guard.u_set_q6, by_q6);
    c->guard.u_seal = c->guard.u_set_q6 ^ c->guard.u_step_q6;
    cam_axis_command_shift_isr(&c->command, nm);
    cam_play_shift_isr(&c->play, by_q6);
}

/// Plan the axes: by hand in the state manual, else by table or to rest.
static void plan_axes(cam_t *c, const cam_config_t *cfg, const cam_tick_record_t *r)
{
    if (c->motion.state != cam_state_manual) {
        cam_jog_idle_isr(&c->jog, &cfg->play, r);
        cam_plan_isr(&c->plan, &cfg->play, r, &c->motion);
        return;
    }
    const int32_t shift_nm = cam_jog_isr(&c->jog, &cfg->play, r, &c->motion);
    if (shift_nm != 0) {
        shift_u(c, shift_nm);
    }
}

/// @return fault corrupt where something that only plans and the slow side write is not what they
/// wrote
static uint32_t inspect(cam_t *c)
{
    const uint32_t offered = c->config.is_mended ? CAM_FAULT_BIT(corrupt) : 0u;
    c->config.is_mended = false;
    return offered | cam_watch_inspect_isr(&c->watch, &c->motion, &c->plan);
}

/// Do what belongs to every n-th tick only.
CAM_STAGE static void plan_isr(cam_t *c, const cam_config_t *cfg, const cam_tick_record_t *r)
{
    const uint32_t seen = inspect(c) | watch_index(c, cfg, r);
    const cam_axis_motion_t before[hal_n_axes] = {
        [hal_axis_x] = c->motion.axis[hal_axis_x], [hal_axis_z] = c->motion.axis[hal_axis_z]};
    c->until_plan = cfg->play.plan_ticks;
    // What was changed is not planned with: the axes move on until the fault, in which they brake
    // and leave whatever is seen, for no other plan would end that.
    if ((seen & CAM_FAULT_BIT(corrupt)) == 0u || c->motion.state == cam_state_fault) {
        plan_axes(c, cfg, r);
    }
    c->motion.was_off = false;
    const uint32_t refused =
        cam_axis_command_plan_isr(&c->command, &cfg->command, &c->motion, before);
    cam_watch_plan_isr(&c->watch, &c->motion, &c->plan);
    cam_turn_bins_plan_isr(&c->bins, r, &c->motion);
    cam_acknowledge_isr(&c->acknowledge, &cfg->play.acknowledge, r, &c->motion);
    c->motion.faults |= seen | refused | cam_guard_plan_isr(&c->guard, &cfg->guard, r);
}

/// A count beyond the period is none of ours: a bit of it flipped, and the plan is due at once.
static bool is_plan_due(cam_t *c, const cam_config_t *cfg)
{
    c->until_plan = cam_wrap_sub(c->until_plan, 1);
    return (uint32_t)c->until_plan - 1u >= (uint32_t)cfg->play.plan_ticks;
}

void cam_tick_steps_isr(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r)
{
    atomic_store_explicit(&c->config.in_use, cfg, memory_order_relaxed);
    want_isr(c, cfg, r);
    judge_isr(c, cfg, r);
    if (is_plan_due(c, cfg)) {
        plan_isr(c, cfg, r);
    }
}

static void actuate_isr(cam_t *c, const cam_tick_record_t *r)
{
    hal_outputs_write_isr(r->want.outputs);
    hal_axis_write_isr(hal_axis_u, &r->out[hal_axis_u]);
    hal_axis_write_isr(hal_axis_x, &r->out[hal_axis_x]);
    hal_axis_write_isr(hal_axis_z, &r->out[hal_axis_z]);
    hal_spindle_write_isr(r->want.spindle_mrpm);
    if (c->motion.swing.is_new) {
        c->motion.swing.is_new = false;
        hal_swing_write_isr(&c->motion.swing.set);
    }
}

/// The slow side reads the status from the record, whose place is written again two ticks later at
/// the earliest.
static void publish_isr(cam_t *c, const cam_tick_record_t *r)
{
    cam_fence_release_isr(); // the record is complete before all three words that refer to it
    cam_trace_commit_isr(&c->trace);
    atomic_store_explicit(&c->newest, r, CAM_ORDER_RELEASE);
    atomic_store_explicit(&c->n_ticks, r->tick + 1u, CAM_ORDER_RELEASE);
}

/// A tick that has begun and has not ended worked at another place, by a pointer of which a bit has
/// flipped, or was withheld. The first one of all has none before it, and is in off, where that is
/// no fault.
static void begin_isr(cam_t *c, cam_tick_record_t *r)
{
    r->tick = atomic_load_explicit(&c->n_ticks, memory_order_relaxed);
    if (atomic_load_explicit(&c->n_begun, memory_order_relaxed) + 1u != r->tick) {
        c->motion.faults |= CAM_FAULT_BIT(corrupt);
    }
    atomic_store_explicit(&c->n_begun, r->tick, memory_order_relaxed);
    cam_fence_release_isr(); // a reader that sees what this tick writes sees that it has begun
}

/// @return whether controller and record are still those with which the tick began, and the record
/// tells the axes what was judged
static bool is_as_judged(const cam_t *c, const cam_tick_record_t *r)
{
    cam_fence_release_isr(); // what is compared is what lies in memory
    const uint32_t begun = atomic_load_explicit(&c->n_begun, memory_order_relaxed);
    return ((begun ^ r->tick) | cam_watch_strayed(&c->watch, &c->command, r)) == 0u;
}

/// It is not, and is not written: the axes hold their set-points, and the next tick sees that this
/// one did not end.
CAM_STAGE static void withhold(cam_t *c)
{
    const cam_tick_record_t *last = atomic_load_explicit(&c->newest, memory_order_relaxed);
    if (last != NULL) {
        cam_watch_mend_home_isr(&c->watch, &c->command, &c->motion, last);
    }
}

void cam_tick_isr(cam_t *c)
{
    const cam_config_t *cfg = cam_config_take_isr(&c->config);
    cam_tick_record_t *r = cam_trace_slot_isr(&c->trace, cfg->trace_room);
    begin_isr(c, r);
    sense_isr(c, &r->in);
    CAM_TICK_MARK(sense);
    want_isr(c, cfg, r); // angle -> play
    cfg = cam_config_again_isr(&c->config, cfg, &r->want.faults);
    judge_isr(c, cfg, r); // guard -> tell
    if (!is_as_judged(c, r)) {
        withhold(c);
        return;
    }
    actuate_isr(c, r);
    CAM_TICK_MARK(actuate);
    if (is_plan_due(c, cfg)) {
        plan_isr(c, cfg, r);
    }
    CAM_TICK_MARK(plan);
    publish_isr(c, r);
}

void cam_isr(void)
{
    cam_tick_isr(&g_cam);
}
