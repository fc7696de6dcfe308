// SPDX-License-Identifier: Apache-2.0
#include "cam_tick.h"
#include "cam_fence.h" // cam_fence_release_isr
#include "cam_fix.h"   // cam_clamp_i32
#include "cam_seal.h"  // cam_seal_word
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

/// Inverse of a second-order drive, MATHS.md (56) and (189): what is added to U so that the tool is
/// there. It is limited to what fits a word together with U, far beyond every stroke: a command
/// that large is refused.
/// @return [nm / 64]
static int32_t feed_forward_q6(const cam_config_t *cfg, const cam_move_t *u)
{
    const int64_t more_q26 = (int64_t)cfg->k1_q16 * u->vel_q10 + (int64_t)cfg->k2_q16 * u->acc_q10;
    const int32_t most_high = 1 << 18; // of the high word: 2^50 / 2^32, beyond every stroke
    const int32_t high = cam_clamp_i32((int32_t)(more_q26 >> 32), -most_high, most_high - 1);
    const uint32_t low = (uint32_t)(uint64_t)more_q26;
    return (int32_t)((uint32_t)high << 12 | low >> 20);
}

static hal_setpoint_t setpoint(const cam_move_t *m, int32_t pos_nm)
{
    return (hal_setpoint_t){.pos_nm = pos_nm, .vel_q10 = m->vel_q10, .acc_q10 = m->acc_q10};
}

/// The guard is in charge: its set-point of U is written, and the cut has ended.
static void take_over(cam_t *c, cam_want_t *want)
{
    if (c->motion.state != cam_state_fault) {
        c->motion.x_left_q10 = c->motion.axis[hal_axis_x].pos_q10;
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
    const cam_verdict_t verdict = cam_guard_step_isr(&c->guard, &cfg->guard, r, &c->motion);
    obey_guard(c, r, verdict);
    if (!verdict.is_in_charge) { // what U does in a fault is not to be learned
        cam_gather_isr(&c->gather, r->angle.pos_q32, r->angle.measured_q32, r->want.u_due_q6,
                       r->in.actual_nm[hal_axis_u]);
    }
}

/// @return [nm / 64] the command of U without what was learned of it
static int32_t plain_command_q6(const cam_t *c, const cam_config_t *cfg, const cam_tick_record_t *r)
{
    return cam_wrap_add(r->want.u_set_q6, feed_forward_q6(cfg, &c->motion.axis[hal_axis_u]));
}

/// In the tick of a fault the command of U goes on with its last step. What that differs from the
/// command of the retract, a correction that was learned or a wave, fades away over the next ticks:
/// by a sixteenth each, towards 0 and to it.
/// @return [nm / 64] the difference
static int32_t faded_q6(const cam_t *c, int32_t plain_q6, bool is_new)
{
    const int32_t next_nm = cam_wrap_add(c->guard.told_nm, c->guard.told_step_nm);
    return is_new
               ? cam_wrap_sub((int32_t)((uint32_t)next_nm * 64u), plain_q6)
               : c->motion.c_q6 - c->motion.c_q6 / 16 - (c->motion.c_q6 > 0) + (c->motion.c_q6 < 0);
}

/// The command of U is beyond its limits: it is not written, but a fault. The nearest one that is
/// within them is written in its place, and the retract begins with the next tick. In off U may
/// stand anywhere, and is told the end of the stroke that is nearer to it.
/// @return [nm] command of U
CAM_STAGE static int32_t refuse_command(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r,
                                        int32_t u_nm)
{
    if (r->want.state == cam_state_off) {
        return cam_clamp_i32(u_nm, -cfg->guard.told_range_nm, cfg->guard.told_range_nm);
    }
    int32_t nearest_nm = u_nm;
    if (r->want.state == cam_state_fault) {
        c->guard.faults |= CAM_FAULT_BIT(command);
        r->want.faults = c->guard.faults;
    } else {
        obey_guard(
            c, r,
            cam_guard_enter_isr(&c->guard, &cfg->guard, r->want.state, CAM_FAULT_BIT(command)));
        nearest_nm = cam_wrap_add(c->guard.told_nm, c->guard.told_step_nm);
    }
    nearest_nm = cam_guard_nearest_isr(&c->guard, &cfg->guard, nearest_nm);
    c->motion.c_q6 =
        cam_wrap_sub((int32_t)((uint32_t)nearest_nm * 64u), plain_command_q6(c, cfg, r));
    return nearest_nm;
}

/// @return [nm] command of U, judged
static int32_t command_u_nm(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r, bool was_fault)
{
    const int32_t plain_q6 = plain_command_q6(c, cfg, r);
    if (r->want.state == cam_state_fault) {
        c->motion.c_q6 = faded_q6(c, plain_q6, !was_fault);
    }
    const int32_t wanted_nm = cam_sat_add(cam_wrap_add(plain_q6, c->motion.c_q6), 32) >> 6;
    const bool is_allowed =
        cam_guard_allows_isr(&c->guard, &cfg->guard, wanted_nm, r->angle.is_off_time);
    const int32_t u_nm = is_allowed ? wanted_nm : refuse_command(c, cfg, r, wanted_nm);
    cam_guard_told_isr(&c->guard, u_nm);
    return u_nm;
}

/// Write the set-points into the record, in the form that the drives take. Those of X and Z are
/// their places rounded down, which the guard has kept since it judged them; the plan has added
/// half a nanometre to X, which is thus rounded to nearest.
static void command(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r, bool was_fault)
{
    const cam_move_t *axis = c->motion.axis;
    const int32_t u_nm = command_u_nm(c, cfg, r, was_fault);
    r->out[hal_axis_u] = setpoint(&axis[hal_axis_u], cam_wrap_sub(u_nm, c->motion.u_home_nm));
    r->out[hal_axis_x] = setpoint(&axis[hal_axis_x], c->guard.led_nm[hal_axis_x]);
    r->out[hal_axis_z] = setpoint(&axis[hal_axis_z], c->guard.led_nm[hal_axis_z]);
}

/// The state is not the one that the last tick left behind. @return fault corrupt
CAM_STAGE static uint32_t mend_state(cam_t *c)
{
    const cam_tick_record_t *last = atomic_load_explicit(&c->newest, memory_order_relaxed);
    const cam_state_t was = last != NULL ? last->want.state : cam_state_off;
    return cam_guard_mend_state_isr(&c->guard, &c->motion, was);
}

static inline void steps_isr(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r)
{
    r->config = cfg->generation;
    cam_spindle_step_isr(&c->spindle, &cfg->spindle, &r->in, c->motion.alpha_q40, &r->angle);
    CAM_TICK_MARK(angle);
    r->want.faults = c->motion.faults | r->angle.faults | cam_sense_faults(&r->in);
    if (c->motion.state != c->guard.state) {
        r->want.faults |= mend_state(c);
    }
    cam_play_step_isr(&c->play, &cfg->play, &r->in, &r->angle, &c->motion, &r->want);
    if (!cam_guard_is_on_course_isr(&c->guard, &c->motion)) {
        r->want.faults |= cam_guard_mend_isr(&c->guard, &c->motion);
    }
    CAM_TICK_MARK(play);
    const bool was_fault = c->motion.state == cam_state_fault;
    guard_isr(c, cfg, r);
    CAM_TICK_MARK(guard);
    command(c, cfg, r, was_fault);
    cam_guard_keep_isr(&c->guard, &c->motion);
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
    c->motion.axis[hal_axis_u].pos_q10 += (int64_t)nm * 1024;
    cam_glide_shift_isr(&c->motion.glide[hal_axis_u], (int64_t)nm * 1024);
    c->motion.u_target_q10 += (int64_t)nm * 1024;
    c->guard.u_set_q6 = cam_wrap_add(c->guard.u_set_q6, by_q6);
    c->guard.u_seal = c->guard.u_set_q6 ^ c->guard.u_step_q6;
    c->guard.told_nm = cam_wrap_add(c->guard.told_nm, nm);
    cam_play_shift_isr(&c->play, by_q6);
}

/// Plan the axes: by hand in the state manual, else by table or to rest.
static void plan_axes(cam_t *c, const cam_config_t *cfg, const cam_tick_record_t *r)
{
    if (c->motion.state != cam_state_manual) {
        cam_hand_idle_isr(&c->hand, &cfg->play, r);
        cam_plan_isr(&c->plan, &cfg->play, r, &c->motion);
        return;
    }
    const int32_t shift_nm = cam_hand_isr(&c->hand, &cfg->play, r, &c->motion);
    if (shift_nm != 0) {
        shift_u(c, shift_nm);
    }
}

/// The sum of cam_seal_more(), with the loop written out by the compiler: two instructions a word.
CAM_STAGE static uint32_t seal_of(const cam_plan_t *plan)
{
    enum { n_words = sizeof *plan / sizeof(uint32_t) };
    _Static_assert(sizeof *plan % sizeof(uint32_t) == 0 && n_words <= 64, "whole words, no loop");
    const cam_seal_word_t *words = (const cam_seal_word_t *)plan; // MISRA D21
    uint32_t sum = 0;
#pragma GCC unroll 64
    for (uint32_t i = 0; i < (uint32_t)n_words; i++) {
        sum = cam_seal_word(sum, words[i]);
    }
    return sum;
}

/// @return fault corrupt where something that only plans and the slow side write is not what they
/// wrote. The flag that axes play is kept twice, and only a fault ends it between two plans.
static uint32_t inspect(cam_t *c)
{
    const cam_motion_t *m = &c->motion;
    const bool is_ended = c->plan.is_laid != m->is_playing && m->state != cam_state_fault;
    const bool is_changed = is_ended || c->plan_seal != seal_of(&c->plan) || c->config.is_mended;
    c->config.is_mended = false;
    const uint32_t led = cam_guard_inspect_isr(&c->guard, &c->motion);
    return is_changed ? CAM_FAULT_BIT(corrupt) : led;
}

/// Do what belongs to every n-th tick only.
CAM_STAGE static void plan_isr(cam_t *c, const cam_config_t *cfg, const cam_tick_record_t *r)
{
    const uint32_t seen = inspect(c) | watch_index(c, cfg, r);
    const cam_move_t before[hal_n_axes] = {
        [hal_axis_x] = c->motion.axis[hal_axis_x], [hal_axis_z] = c->motion.axis[hal_axis_z]};
    c->until_plan = cfg->play.plan_ticks;
    if ((seen & CAM_FAULT_BIT(corrupt)) == 0u) { // else the axes move on until the guard leads them
        plan_axes(c, cfg, r);
    }
    c->motion.was_off = false;
    c->plan.is_laid = c->motion.is_playing;
    c->plan_seal = seal_of(&c->plan);
    const uint32_t refused = cam_guard_increments_isr(&c->guard, &cfg->guard, &c->motion, before);
    cam_guard_keep_isr(&c->guard, &c->motion);
    cam_gather_plan_isr(&c->gather, r, &c->motion);
    cam_acknowledge_isr(&c->acknowledge, &cfg->play.acknowledge, r, &c->motion);
    c->motion.faults |= seen | refused | cam_guard_plan_isr(&c->guard, &cfg->guard, r);
}

/// A count beyond the period is none of ours: a bit of it flipped, and the plan is due at once.
static bool is_plan_due(cam_t *c, const cam_config_t *cfg)
{
    c->until_plan--;
    return (uint32_t)c->until_plan - 1u >= (uint32_t)cfg->play.plan_ticks;
}

void cam_tick_steps_isr(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r)
{
    steps_isr(c, cfg, r);
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

void cam_tick_isr(cam_t *c)
{
    const cam_config_t *cfg = cam_config_take_isr(&c->config);
    cam_tick_record_t *r = cam_trace_slot_isr(&c->trace, cfg->trace_room);
    r->tick = atomic_load_explicit(&c->n_ticks, memory_order_relaxed);
    atomic_store_explicit(&c->n_begun, r->tick, memory_order_relaxed);
    cam_fence_release_isr(); // a reader that sees what this tick writes sees that it has begun
    sense_isr(c, &r->in);
    CAM_TICK_MARK(sense);
    steps_isr(c, cfg, r); // angle -> play -> guard
    actuate_isr(c, r);
    cam_fence_release_isr(); // what is compared is what lies in memory
    const bool is_as_judged = cam_guard_written_isr(&c->guard, r);
    CAM_TICK_MARK(actuate);
    if (is_plan_due(c, cfg)) {
        plan_isr(c, cfg, r);
    }
    if (!is_as_judged) {
        c->motion.faults |= CAM_FAULT_BIT(corrupt);
    }
    CAM_TICK_MARK(plan);
    publish_isr(c, r);
}

void cam_isr(void)
{
    cam_tick_isr(&g_cam);
}

/// A word of any structure.
typedef uint32_t __attribute__((may_alias)) any_word_t;

/// Copy words that the interrupt may be writing; what was read then is not used. C11 calls that a
/// race, because the interrupt's words are no atomics: it would pay for them in every tick. They
/// are read as volatile ones, so that the compiler takes each of them once and as it is.
__attribute__((noinline, no_sanitize("thread"))) static void copy_words(void *to, const void *from,
                                                                        size_t n_bytes)
{
    any_word_t *words = to;                   // MISRA D20
    const volatile any_word_t *shared = from; // MISRA D20
    for (size_t i = 0; i < n_bytes / sizeof *words; i++) {
        words[i] = shared[i];
    }
}

#define COPY(to, from)                                                                             \
    do {                                                                                           \
        _Static_assert(sizeof(to) == sizeof(from) && sizeof(to) % sizeof(uint32_t) == 0u,          \
                       "words");                                                                   \
        copy_words(&(to), &(from), sizeof(to));                                                    \
    } while (false)

/// The count of ticks that have ended is n when a reading begins; where the newest tick that has
/// begun is number n - 1 behind it, none was in progress.
bool cam_tick_moment(const cam_t *c, cam_moment_t *now)
{
    uint32_t n_ended = 0;
    uint32_t begun = 0;
    do {
        n_ended = atomic_load_explicit(&c->n_ticks, memory_order_acquire);
        const cam_tick_record_t *newest = atomic_load_explicit(&c->newest, memory_order_acquire);
        if (newest == NULL) {
            *now = (cam_moment_t){.record.want.state = cam_state_off};
            return false;
        }
        COPY(now->record, *newest);
        COPY(now->spindle, c->spindle);
        COPY(now->motion, c->motion);
        COPY(now->guard, c->guard);
        COPY(now->hand, c->hand);
        COPY(now->acknowledge, c->acknowledge);
        COPY(now->plan, c->plan);
        atomic_thread_fence(memory_order_acquire);
        begun = atomic_load_explicit(&c->n_begun, memory_order_relaxed);
    } while (begun + 1u != n_ended);
    return true;
}

cam_status_t cam_tick_status(const cam_t *c)
{
    cam_moment_t now;
    (void)cam_tick_moment(c, &now);
    const cam_tick_record_t *r = &now.record;
    const cam_guard_t *guard = &now.guard;
    cam_status_t status = {
        .tick = r->tick,
        .config = r->config,
        .request = r->in.request >> 8,
        .state = r->want.state,
        .faults = r->want.faults,
        .first_fault = guard->first_faults,
        .is_synced = r->angle.is_synced,
        .is_retracted = r->want.is_retracted,
        .is_u_at_rest = r->out[hal_axis_u].vel_q10 == 0 && r->out[hal_axis_u].acc_q10 == 0,
        .inputs = r->in.inputs,
        .outputs = r->want.outputs,
        .hand = now.hand,
        .acknowledge = now.acknowledge,
        .pos_q32 = r->angle.pos_q32,
        .speed_q32 = r->angle.speed_q32,
        .z_nm = r->want.z_nm,
        .u_set_q6 = r->want.u_set_q6,
        .u_actual_nm = r->in.actual_nm[hal_axis_u],
        .x_actual_nm = r->in.actual_nm[hal_axis_x],
        .z_actual_nm = r->in.actual_nm[hal_axis_z],
        .following_nm = cam_wrap_sub(r->in.actual_nm[hal_axis_u], r->want.u_due_q6 >> 6),
        .n_late = now.spindle.n_late,
        .max_period = now.spindle.max_period,
    };
    for (uint32_t i = 0; i < cam_n_faults; i++) {
        status.fault_count[i] = cam_guard_count(guard, (cam_fault_t)i);
    }
    return status;
}
