// SPDX-License-Identifier: Apache-2.0
#include "cam_play.h"
#include "cam_angle.h" // cam_angle_next_turn
#include "cam_eval.h"  // cam_eval_segment
#include "cam_fix.h"   // cam_mulhi
#include "cam_plan.h"  // cam_plan_task_isr

/// Tasks of a round that requests may put off.
enum { request_put_off = 3 };

/// Disengage position while nobody asked for one.
#define NEVER_Q32 (INT64_MAX / 2)

/// U with its velocity and acceleration: derivatives per knot times knots per tick. The slow change
/// of envelope, amplitude and height adds nothing worth naming to them (a skirt: 1e-6 of the
/// speed). What does not fit is a fault of this tick, which writes nothing of it. The place is kept
/// by the guard.
/// @return [nm / 64] U
CAM_STAGE static int32_t surface(cam_play_t *p, const cam_play_config_t *cfg, int32_t speed_q32,
                                 uint32_t theta_q32)
{
    const cam_u_scale_t *by = &cfg->u;
    const cam_channel_t *ch = &cfg->table->u;
    const uint64_t height_q32 = (uint64_t)p->height_q32;
    const cam_height_t z = {.i = (uint32_t)(height_q32 >> 32),
                            .w_q31 = (int32_t)((uint32_t)height_q32 >> 1)};
    const cam_fine_t fine = cam_eval_quintic(cam_eval_segment(ch, theta_q32, z));
    const int32_t scale_q30 = p->scale_q30;
    const int32_t speed = (int32_t)((uint32_t)speed_q32 << by->speed_shift);
    const int32_t rate = cam_mulhi(speed, scale_q30);
    const int32_t rate2 = cam_mulhi(speed, rate);
    const int64_t acceleration =
        (int64_t)(fine.d2 >> by->a_down) * rate2 + (int64_t)fine.d1 * p->alpha_u;
    const int32_t offset = cam_mulhi(by->offset, scale_q30);
    const int32_t y = cam_mulhi_add(offset, fine.y, scale_q30 >> by->scale_down);
    p->axis[hal_axis_u].vel_q10 = (int32_t)((uint32_t)cam_mulhi(fine.d1, rate) << by->v_up);
    p->axis[hal_axis_u].acc_q10 = cam_shift_right(acceleration, by->a_shift);
    return (int32_t)((uint32_t)y << by->y_up);
}

static void advance(cam_move_t *m)
{
    m->pos_q10 += m->vel_q10;
}

/// What moves linearly within a round goes on.
static void move_on(cam_play_t *p, cam_want_t *want)
{
    advance(&p->axis[hal_axis_x]);
    advance(&p->axis[hal_axis_z]);
    p->phase_q32 = cam_wrap_add(p->phase_q32, p->phase_way_q32);
    p->scale_q30 += p->scale_way_q30;
    p->behind_q4 += p->behind_way_q4;
    p->height_q32 += p->height_way_q32;
    const int32_t set_nm = (int32_t)(p->axis[hal_axis_z].pos_q10 >> 10);
    want->z_nm = set_nm - (p->behind_q4 >> 4);
}

static int32_t u_of_angle(cam_play_t *p, const cam_play_config_t *cfg, const cam_angle_t *angle)
{
    const uint32_t angle_q32 = cam_angle_of_pos(cam_angle_ahead(angle, cfg->lead_q16));
    return surface(p, cfg, angle->speed_q32, angle_q32 - (uint32_t)p->phase_q32);
}

/// A tick that is busy, or that carries a request out, puts its task off. When the angle is at
/// fault, or too many tasks of a round were put off, the cut ends with this tick and the guard
/// takes over: U keeps its pace.
/// @return fault late_tick or none
CAM_STAGE static uint32_t play_on(cam_play_t *p, const cam_play_config_t *cfg,
                                  const cam_angle_t *angle, cam_want_t *want)
{
    const int32_t left = p->put_off_left - 1;
    p->put_off_left = left;
    if (!p->is_height_free) {
        p->height_q32 -= p->height_way_q32; // near an end of the table it waits
    }
    move_on(p, want);
    if (left >= 0 && (angle->faults | CAM_ANGLE_BUSY) == CAM_ANGLE_BUSY) {
        want->u_set_q6 = u_of_angle(p, cfg, angle);
        return 0;
    }
    const int32_t last_q6 = p->history_q6[p->n_history % cam_play_history];
    const int32_t before_q6 = p->history_q6[(p->n_history - 1u) % cam_play_history];
    want->u_set_q6 = cam_wrap_add(last_q6, cam_wrap_sub(last_q6, before_q6));
    return left < 0 ? CAM_FAULT_BIT(late_tick) : 0u;
}

/// Tool out of the work, feed axes at rest. @return true when all of them rest
static bool wait_retracted(cam_play_t *p, const cam_play_config_t *cfg)
{
    cam_move_t *axis = p->axis;
    const cam_move_limits_t *limits = cfg->approach;
    const bool is_u_there =
        cam_move_to_isr(&axis[hal_axis_u], &limits[hal_axis_u], cfg->u_retract_q10);
    const bool is_x_there = cam_move_stop_isr(&axis[hal_axis_x], &limits[hal_axis_x]);
    const bool is_z_there = cam_move_stop_isr(&axis[hal_axis_z], &limits[hal_axis_z]);
    const bool is_swing_there =
        !cfg->swing.is_swung || cam_swing_rest_isr(&p->swing, &cfg->swing.gentle, p->n_history);
    return is_u_there && is_x_there && is_z_there && is_swing_there;
}

/// The cut is laid onto whole turns of the master; everything is at its start.
static void lay(cam_play_t *p, const cam_play_config_t *cfg, const cam_angle_t *angle, int32_t z_nm)
{
    p->engage_at_q32 = cam_angle_next_turn(cam_angle_ahead(angle, cfg->told_q16));
    p->feed_at_q32 = p->engage_at_q32 + cfg->engage_q32;
    p->feed_turns_q32 = cfg->feed_q32;
    p->disengage_at_q32 = cfg->is_z_measured ? NEVER_Q32 : p->feed_at_q32 + cfg->feed_q32;
    p->phase_q32 = cfg->phase_q32;
    p->phase_way_q32 = 0;
    p->amplitude_q30 = cfg->amplitude_q30;
    p->scale_q30 = 0;
    p->scale_way_q30 = 0;
    p->plan.measured_nm = z_nm;
    p->plan.stop_turns_q32 = 0;
    p->plan.stop_end_q32 = p->engage_at_q32;
    p->behind_q4 = 0;
    p->behind_way_q4 = 0;
    p->height_q32 = 0; // U is at 0 until the first round has said where it is
    p->height_way_q32 = 0;
    p->is_height_free = false;
    p->task = 0;
    p->put_off_left = cfg->most_put_off;
    p->is_playing = true;
}

/// Where X waits for a cut that begins at a height.
static void place_x(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int64_t profile_q10 = cam_plan_profile_q10(&cfg->table->x, p->plan.x_value);
    p->plan.x_q10 = profile_q10 + (int64_t)cfg->x_clearance_nm * 1024;
}

/// Z to the start of the cut, X standing, then X: the tool nears the work where it will cut.
/// @return true when both are there
static bool approach_xz(cam_play_t *p, const cam_play_config_t *cfg)
{
    cam_move_t *x = &p->axis[hal_axis_x];
    cam_move_t *z = &p->axis[hal_axis_z];
    const int64_t z_q10 = (int64_t)cfg->z_first_nm * 1024;
    if (z->pos_q10 == z_q10 && z->vel_q10 == 0) {
        return cam_move_to_isr(x, &cfg->approach[hal_axis_x], p->plan.x_q10);
    }
    (void)cam_move_to_isr(z, &cfg->approach[hal_axis_z], z_q10);
    (void)cam_move_stop_isr(x, &cfg->approach[hal_axis_x]);
    return false;
}

/// X over a Z that others lead; its set-point is where it is. The tool nears the work when U is
/// ready. @return true when X is there
static bool approach_x(cam_play_t *p, const cam_play_config_t *cfg, int32_t z_nm, bool is_u_there)
{
    p->axis[hal_axis_z] = (cam_move_t){.pos_q10 = (int64_t)z_nm * 1024};
    if (!is_u_there) {
        (void)cam_move_stop_isr(&p->axis[hal_axis_x], &cfg->approach[hal_axis_x]);
        return false;
    }
    return cam_move_to_isr(&p->axis[hal_axis_x], &cfg->approach[hal_axis_x], p->plan.x_q10);
}

/// Of an approach, in p->task. A Z that others lead is found again while the axes move. A tool that
/// swings comes to rest at 0 first, where it stays until the cut is laid.
enum {
    step_swing,
    step_find,
    step_read,
    step_place,
    step_move,
    step_read_again,
    step_place_again,
    step_lay
};

/// Find out where X waits, in three ticks. @return the step of the next tick
CAM_STAGE static uint32_t find_x(cam_play_t *p, const cam_play_config_t *cfg, int32_t z_nm)
{
    const uint32_t step = p->task;
    if (step == step_place || step == step_place_again) {
        place_x(p, cfg);
        return step_move;
    }
    if (step == step_read || step == step_read_again) {
        p->plan.x_value = cam_eval_profile_at(p->plan.x_spot).y;
    } else if (step == step_swing) {
        return cfg->swing.is_swung && !p->swing.is_there ? step_swing : step_find;
    } else if (step == step_find || cfg->is_z_measured) {
        p->plan.x_spot = cam_eval_spot(&cfg->table->x, z_nm);
    } else {
        return step_move;
    }
    return step + 1u;
}

/// Axes to the start of the cut; at last the cut is laid.
static void approach(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                     const cam_angle_t *angle)
{
    const int32_t z_nm = cfg->is_z_measured ? in->actual_nm[hal_axis_z] : cfg->z_first_nm;
    if (p->task == step_lay) {
        lay(p, cfg, angle, z_nm);
        return;
    }
    const bool is_x_known = p->task >= step_move;
    if (angle->faults == 0u) { // a busy tick puts it off
        p->task = find_x(p, cfg, z_nm);
    }
    if (!is_x_known) {
        (void)wait_retracted(p, cfg);
        return;
    }
    const bool is_u_there = cam_move_to_isr(&p->axis[hal_axis_u], &cfg->approach[hal_axis_u], 0);
    const bool is_xz_there =
        cfg->is_z_measured ? approach_x(p, cfg, z_nm, is_u_there) : approach_xz(p, cfg);
    if (is_u_there && is_xz_there) {
        p->task = step_lay;
    }
}

static void follow_axes(cam_play_t *p, const cam_sense_t *in)
{
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        p->axis[i] = (cam_move_t){.pos_q10 = (int64_t)in->actual_nm[i] * 1024};
    }
    cam_swing_follow_isr(&p->swing, in->swing_q32, p->n_history);
}

/// Stop lays the end of the feed, and behind it that of the cut, where the last round has found
/// that they may lie (cam_plan.c).
static void stop(cam_play_t *p)
{
    if (p->plan.stop_end_q32 < p->disengage_at_q32) {
        p->feed_turns_q32 = p->plan.stop_turns_q32;
        p->disengage_at_q32 = p->plan.stop_end_q32;
    }
}

static bool is_new(const cam_play_t *p, uint32_t request)
{
    return request >> 8 != p->request;
}

/// While the axes follow the table there is nothing else to ask for.
/// @return faults that the request reports
CAM_STAGE static uint32_t obey_in_work(cam_play_t *p, uint32_t request)
{
    p->request = request >> 8;
    const uint32_t what = request & 0xFFu;
    if (what == (uint32_t)cam_request_stop) {
        stop(p);
    }
    return what == (uint32_t)cam_request_table_fault ? CAM_FAULT_BIT(table) : 0u;
}

/// Carry out a new request if it fits the state. @return faults that the request reports
CAM_STAGE static uint32_t obey(cam_play_t *p, const cam_play_config_t *cfg, uint32_t request)
{
    p->request = request >> 8;
    switch ((cam_request_t)(request & 0xFFu)) {
    case cam_request_enable:
        p->state = p->state == cam_state_off && cfg->table != NULL ? cam_state_homing : p->state;
        break;
    case cam_request_disable:
        p->state = cam_state_is_in_work(p->state) || p->state == cam_state_fault ? p->state
                                                                                 : cam_state_off;
        break;
    case cam_request_start:
        if (p->state == cam_state_ready) {
            p->state = cam_state_engaging;
            p->task = step_swing;
        }
        break;
    case cam_request_stop: // an approach has nothing to end
        p->state = p->state == cam_state_engaging ? cam_state_ready : p->state;
        break;
    case cam_request_reset:
        p->state = p->state == cam_state_fault && p->is_retracted ? cam_state_off : p->state;
        break;
    case cam_request_table_fault:
        return CAM_FAULT_BIT(table);
    case cam_request_none:
        break;
    }
    return 0;
}

/// A request in the work takes the place of a task. It waits for a tick that is not busy, in a
/// round that has put off little: asked for in every tick, it does not use up what busy ticks need.
static bool may_obey(const cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in)
{
    return is_new(p, in->request) && p->put_off_left > cfg->most_put_off - request_put_off;
}

/// All axes from the angle: U exactly, the others on their way. @return faults
static uint32_t play_table(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                           const cam_angle_t *angle, cam_want_t *want)
{
    if (angle->faults != 0u) {
        return play_on(p, cfg, angle, want);
    }
    if (may_obey(p, cfg, in)) {
        const uint32_t faults = obey_in_work(p, in->request);
        return faults | play_on(p, cfg, angle, want);
    }
    const uint32_t faults = cam_plan_task_isr(p, cfg, in, angle);
    move_on(p, want);
    want->u_set_q6 = u_of_angle(p, cfg, angle);
    return faults;
}

/// U set-point of lead ticks ago, between two of them: that is where the drive should be now. What
/// does not fit 32 bits is only seen while off, where nobody asks.
static int32_t due_q6(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int32_t a_q6 = p->history_q6[(p->n_history - cfg->lead_ticks) % cam_play_history];
    const int32_t b_q6 = p->due_q6;
    p->due_q6 = a_q6;
    const uint32_t twice_q6 = 2u * ((uint32_t)b_q6 - (uint32_t)a_q6);
    return cam_mulhi_add(a_q6, (int32_t)twice_q6, cfg->lead_part_q31);
}

static void remember(cam_play_t *p, int32_t u_q6)
{
    p->n_history++;
    p->history_q6[p->n_history % cam_play_history] = u_q6;
}

/// Everything that is not a cut: the axes move by time. @return [nm / 64] U
CAM_STAGE static int32_t move_axes(cam_play_t *p, const cam_play_config_t *cfg,
                                   const cam_sense_t *in, const cam_angle_t *angle)
{
    const bool is_idle = p->state == cam_state_off || p->state == cam_state_fault;
    p->speed = (cam_speed_t){.spindle_mrpm = is_idle ? 0 : cfg->spindle_mrpm};
    p->alpha_u = 0;
    if (p->state == cam_state_off) {
        follow_axes(p, in);
    } else if (p->state == cam_state_engaging) {
        approach(p, cfg, in, angle);
    } else if (p->state != cam_state_fault) {
        const bool is_out = wait_retracted(p, cfg);
        const bool is_homed = angle->is_synced && angle->speed_q32 >= cfg->turning_q32;
        p->state = p->state == cam_state_homing && is_homed && is_out ? cam_state_ready : p->state;
    }
    return cam_sat_i32(p->axis[hal_axis_u].pos_q10 >> 4);
}

void cam_play_step_isr(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                       const cam_angle_t *angle, cam_want_t *want)
{
    uint32_t faults = 0;
    if (p->is_playing) {
        faults = play_table(p, cfg, in, angle, want);
    } else {
        faults = is_new(p, in->request) ? obey(p, cfg, in->request) : 0u;
        want->z_nm = in->actual_nm[hal_axis_z];
        want->u_set_q6 = move_axes(p, cfg, in, angle);
    }
    remember(p, want->u_set_q6);
    want->u_due_q6 = due_q6(p, cfg);
    want->faults = faults;
    want->state = p->state;
    want->spindle_mrpm = p->speed.spindle_mrpm;
}
