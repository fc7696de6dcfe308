// SPDX-License-Identifier: Apache-2.0
#include "cam_tick_inner.h"
#include "cam_fix.h" // cam_abs_i64, cam_clamp_i32, cam_is_within, ..

/// After these the drives are disabled at once: one of them, or the position loop, does not work. A
/// U with a frozen scale is pushed outwards first, and at a limit switch the loop works.
#define LOST (CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(u_travel) | CAM_FAULT_BIT(u_runaway))
#define ARMED_IN_FAULT                                                                             \
    (LOST | CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(bus) | CAM_FAULT_BIT(command) |                   \
     CAM_FAULT_BIT(u_force))
#define ARMED_MOVING (ARMED_IN_FAULT | CAM_FAULT_BIT(late_tick) | CAM_FAULT_BIT(table))
#define ARMED_ENABLED (ARMED_MOVING | CAM_FAULT_BIT(index_missing) | CAM_FAULT_BIT(setpoint_range))
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

uint32_t cam_guard_plan_isr(cam_guard_t *g, const cam_guard_config_t *cfg,
                            const cam_play_config_t *play, const cam_tick_record_t *r)
{
    const int32_t speed_q32 = r->angle.speed_q32;
    const int32_t turning_q32 = play->turning_q32;
    const bool is_homing =
        r->want.state == cam_state_homing; // then reverse rotation counts as standstill
    const uint32_t most_ticks = is_homing ? cfg->homing_ticks : cfg->stopped_ticks;
    const bool is_watched = (cam_guard_armed(r->want.state) & CAM_FAULT_BIT(spindle_stopped)) != 0u;
    const bool is_standing =
        is_watched && speed_q32 < turning_q32 && (is_homing || speed_q32 > -turning_q32);
    g->n_stopped = is_standing ? g->n_stopped + (uint32_t)play->plan_ticks : 0u;
    return (speed_q32 < -turning_q32 ? CAM_FAULT_BIT(reverse) : 0u) |
           (g->n_stopped > most_ticks ? CAM_FAULT_BIT(spindle_stopped) : 0u) |
           (speed_q32 > cfg->overspeed_q32 ? CAM_FAULT_BIT(overspeed) : 0u);
}

static void keep_set(cam_guard_t *g, const cam_tick_record_t *r, uint32_t home_q6)
{
    g->history_q6[r->tick % cam_guard_history] = (int32_t)((uint32_t)r->want.u_set_q6 - home_q6);
}

/// @return [nm / 64] what U's scale should show now: the set-point of one lead plus the scale's
/// latency ago, interpolated between two ticks. It wraps only in off, without a following error
static int32_t due_q6(cam_guard_t *g, const cam_guard_config_t *cfg, uint32_t tick,
                      uint32_t home_q6)
{
    const int32_t a_q6 = g->history_q6[(tick - cfg->due_ticks) % cam_guard_history];
    const int32_t b_q6 = g->due_q6;
    g->due_q6 = a_q6;
    const uint32_t twice_q6 = 2u * ((uint32_t)b_q6 - (uint32_t)a_q6);
    const int32_t due_q6 = cam_wrap_add(a_q6, (int32_t)home_q6);
    return cam_mulhi_add(due_q6, (int32_t)twice_q6, cfg->due_part_q31);
}

/// @return following_error or none. A motion by time has a limit of its own; U may press on its
///         stop, with limited force
static uint32_t faults_of_following(const cam_guard_config_t *cfg, const cam_tick_record_t *r,
                                    const cam_motion_t *m)
{
    const int32_t off_nm = cam_wrap_sub(r->in.actual_nm[hal_axis_u], r->want.u_due_q6 >> 6);
    if (cam_is_within(off_nm, cfg->following_nm)) {
        return 0;
    }
    const bool is_pressing = m->u_press_q6 != 0;
    const bool is_near = is_pressing || cam_is_within(off_nm, cfg->approach_nm);
    return is_near && !m->is_playing ? 0u : CAM_FAULT_BIT(following_error);
}

/// @return faults of the set-point: beyond its limits are step or change of step
static uint32_t faults_of_setpoint(const cam_guard_config_t *cfg, const cam_u_t *last,
                                   const cam_u_t *next, bool is_off_time)
{
    const int32_t change_q6 = cam_sat_sub(next->set_step_q6, last->set_step_q6);
    uint32_t faults = 0;
    if (!cam_is_within(next->set_step_q6, cfg->u_vel_q6)) {
        faults |= CAM_FAULT_BIT(setpoint_speed);
    }
    if (!cam_is_within(change_q6, cfg->u_acc_q6)) {
        const int32_t most_q6 = is_off_time ? cfg->u_acc_off_q6 : cfg->u_acc_q6;
        if (!cam_is_within(change_q6, most_q6)) {
            faults |= CAM_FAULT_BIT(setpoint_acceleration);
        }
    }
    return faults;
}

/*@ predicate cam_limits(cam_guard_config_t *cfg) = 0 <= cfg->range_nm <= 0x1000000 &&
      0 <= cfg->step_nm <= 0x3FFFFFFF && 0 <= cfg->change_nm <= 0x3FFFFFFF &&
      0 <= cfg->change_off_nm <= 0x3FFFFFFF;
*/
/// Accept a command exactly if position, step and change of step are within their limits.
/*@ requires valid: \valid_read(u) && \valid_read(cfg);
    requires limits: cam_limits(cfg);
    requires flag: is_off_time == 0 || is_off_time == 1;
    assigns \result \from *u, *cfg, is_off_time;
    ensures exact: \result <==> \abs(u->nm) <= cfg->range_nm && \abs(u->step_nm) <= cfg->step_nm &&
      (\abs(u->change_nm) <= cfg->change_nm ||
       (is_off_time && \abs(u->change_nm) <= cfg->change_off_nm));
*/
static bool is_allowed(const cam_guard_config_t *cfg, const cam_u_t *u, bool is_off_time)
{
    return cam_is_within(u->nm, cfg->range_nm) && cam_is_within(u->step_nm, cfg->step_nm) &&
           (cam_is_within(u->change_nm, cfg->change_nm) ||
            (is_off_time && cam_is_within(u->change_nm, cfg->change_off_nm)));
}

/// @return U with the set-point and the command of this tick
static cam_u_t moved_to(const cam_u_t *u, int32_t set_q6, int32_t nm)
{
    const int32_t step_nm = cam_sat_sub(nm, u->nm);
    return (cam_u_t){.home_nm = u->home_nm,
                     .set_q6 = set_q6,
                     .set_step_q6 = cam_sat_sub(set_q6, u->set_q6),
                     .nm = nm,
                     .step_nm = step_nm,
                     .change_nm = cam_sat_sub(step_nm, u->step_nm)};
}

/// @return fault of the command, or none: setpoint_range where the set-point, too, leaves the
///         stroke; else command
static uint32_t faults_of_command(const cam_guard_config_t *cfg, const cam_u_t *next,
                                  bool is_off_time)
{
    if (is_allowed(cfg, next, is_off_time)) {
        return 0;
    }
    const bool is_in_stroke = cam_is_within(next->set_q6 >> 6, cfg->range_nm);
    return is_in_stroke ? CAM_FAULT_BIT(command) : CAM_FAULT_BIT(setpoint_range);
}

/// @param next  U if it is accepted
/// @return      all faults of a tick, whether armed or not
static uint32_t faults_of(const cam_guard_config_t *cfg, const cam_tick_record_t *r,
                          const cam_motion_t *m, const cam_u_t *next)
{
    const bool is_off_time = r->angle.is_off_time;
    uint32_t faults = cam_record_faults(r, m) | faults_of_following(cfg, r, m) |
                      faults_of_setpoint(cfg, &m->u, next, is_off_time) |
                      faults_of_command(cfg, next, is_off_time);
    if (r->angle.has_stopped && cam_state_is_in_work(r->want.state)) {
        faults |= CAM_FAULT_BIT(spindle_stopped);
    }
    return faults;
}

bool cam_guard_holds_isr(const cam_guard_t *g, const cam_motion_t *m)
{
    if (m->state != cam_state_fault) {
        return m->state != cam_state_off;
    }
    const uint32_t lost = m->is_u_beyond ? LOST : LOST & ~CAM_FAULT_BIT(u_travel);
    return !m->is_retracted && (g->faults & lost) == 0u;
}

/// Write the command of U to the record, from the port's origin on.
static void write_u(cam_tick_record_t *r, const cam_motion_t *m)
{
    const int32_t port_nm = cam_wrap_sub(m->u.nm, m->u.home_nm);
    r->out[hal_axis_u] = cam_record_setpoint(&m->axis[hal_axis_u], port_nm);
}

/// @return [nm per tick] the last step of U's command; where it changed faster than U accelerates,
///         by the reversal of friction or a tick off its time, the smaller one of the last two
static int32_t steady_step_nm(const cam_guard_config_t *cfg, const cam_u_t *u)
{
    const int32_t before_nm = cam_sat_sub(u->step_nm, u->change_nm);
    const bool is_steady = cam_is_within(u->change_nm, cfg->u.acceleration_q10 >> 10) ||
                           cam_abs_i64(u->step_nm) <= cam_abs_i64(before_nm);
    return is_steady ? u->step_nm : before_nm;
}

/// Latch faults and enter the state fault. U continues from its last command: a motion by time with
/// its acceleration, the section or a wave at constant speed.
static void latch(cam_guard_t *g, const cam_guard_config_t *cfg, cam_motion_t *m, uint32_t faults)
{
    const bool is_by_time = !m->is_playing && m->state != cam_state_identifying;
    const int64_t most_q10 = cfg->u.acceleration_q10;
    const int64_t acc_q10 = is_by_time ? m->u.change_nm * INT64_C(1024) : 0;
    cam_axis_motion_t *u = &m->axis[hal_axis_u];
    *u = (cam_axis_motion_t){.pos_q10 = m->u.nm * INT64_C(1024),
                             .vel_q10 = cam_sat_i32(steady_step_nm(cfg, &m->u) * INT64_C(1024)),
                             .acc_q10 = (int32_t)cam_clamp_i64(acc_q10, -most_q10, most_q10)};
    cam_jerk_filter_begin_isr(&m->filter[hal_axis_u], u, cfg->u.log2_window);
    g->faults |= faults;
    g->first_faults = g->faults;
    m->x_left_q10 = (int64_t)cam_sat_i32(m->axis[hal_axis_x].pos_q10 >> 10) * 1024; // as commanded
    m->state = cam_state_fault;
    m->is_playing = false;
    m->is_retracted = false;
}

/// Limit a command to the stroke. From beyond it, it may not move farther out.
/*@ requires range: 0 <= range_nm <= 0x1000000;
    assigns \result \from last_nm, range_nm, nm;
    ensures place: \min(-range_nm, last_nm) <= \result <= \max(range_nm, last_nm);
    ensures same: -range_nm <= nm <= range_nm ==> \result == nm;
*/
static int32_t within_stroke_nm(int32_t last_nm, int32_t range_nm, int64_t nm)
{
    const int32_t least_nm = last_nm < -range_nm ? last_nm : -range_nm;
    const int32_t most_nm = last_nm > range_nm ? last_nm : range_nm;
    return (int32_t)cam_clamp_i64(nm, least_nm, most_nm);
}

/// @return whether the command of U is out of the work, at its retract position or beyond
static bool is_out(const cam_guard_config_t *cfg, const cam_motion_t *m)
{
    return m->u.nm * INT64_C(1024) <= cfg->u_retract_q10;
}

/// In state fault retract U; after manual, and out of the work at its lower limit switch, brake it.
/// At the end of its stroke it stops. @return whether it rests there
static bool retract_u(const cam_guard_config_t *cfg, bool is_low, cam_motion_t *m)
{
    const bool stays = m->is_by_hand || (is_low && is_out(cfg, m));
    cam_axis_motion_t *u = &m->axis[hal_axis_u];
    cam_jerk_filter_t *filter = &m->filter[hal_axis_u];
    const bool is_there = stays ? cam_jerk_filter_stop_isr(filter, u, &cfg->u)
                                : cam_jerk_filter_to_isr(filter, u, &cfg->u, cfg->u_retract_q10);
    const int64_t moved_nm = u->pos_q10 >> 10;
    const int32_t nm = within_stroke_nm(m->u.nm, cfg->range_nm, moved_nm);
    if (nm != moved_nm) {
        *u = (cam_axis_motion_t){.pos_q10 = nm * INT64_C(1024)};
        cam_jerk_filter_begin_isr(filter, u, cfg->u.log2_window);
    }
    m->u = moved_to(&m->u, nm * 64, nm);
    return is_there;
}

/// Overwrite set-point and command with the retract. The drives stay enabled until it has ended, or
/// until a fault of LOST. A U with a frozen scale is pushed outwards after that, unless it is out.
static void retract(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                    cam_motion_t *m)
{
    cam_want_t *want = &r->want;
    const bool is_low = (r->in.inputs & (uint32_t)hal_in_limit_u_low) != 0u;
    const bool is_u_out = retract_u(cfg, is_low, m);
    m->is_retracted = m->is_retracted || (is_u_out && m->is_clear);
    const bool is_lost = (g->faults & CAM_FAULT_BIT(drive)) != 0u || m->is_u_beyond;
    if (is_low || is_lost || is_out(cfg, m)) {
        m->u_blind_ticks = 0;
    }
    want->state = cam_state_fault;
    want->spindle_mrpm = 0;
    want->u_set_q6 = m->u.set_q6;
    want->faults = g->faults;
    const bool is_enabled = cam_guard_holds_isr(g, m) || m->u_blind_ticks > 0u;
    want->outputs = is_enabled ? hal_out_fault | hal_out_enable : hal_out_fault;
    want->is_retracted = m->is_retracted;
    write_u(r, m);
}

/// In off set-points and command follow U, within its stroke, and no fault is latched.
static void follow(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                   int32_t u_nm, cam_motion_t *m)
{
    cam_want_t *want = &r->want;
    m->u = (cam_u_t){
        .home_nm = m->u.home_nm,
        .set_q6 = want->u_set_q6,
        .nm = cam_clamp_i32(u_nm, -cfg->range_nm, cfg->range_nm),
    };
    m->u_blind_ticks = 0;
    g->faults = 0;
    g->n_stopped = 0;
    want->faults = 0;
    want->outputs = 0;
    want->is_retracted = true;
    write_u(r, m);
}

/// @return whether the command of the tick was accepted; otherwise the state is fault
static bool accept(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                   int32_t u_nm, cam_motion_t *m)
{
    cam_want_t *want = &r->want;
    const uint32_t watched = armed[want->state];
    const cam_u_t next = moved_to(&m->u, want->u_set_q6, u_nm);
    const uint32_t faults = faults_of(cfg, r, m, &next) & watched;
    if (faults != 0u) {
        latch(g, cfg, m, faults);
        return false;
    }
    m->u = next;
    want->faults = 0;
    want->outputs = (watched & IN_CUT) != 0u ? hal_out_enable | hal_out_in_cut : hal_out_enable;
    want->is_retracted = false;
    write_u(r, m);
    return true;
}

void cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                        int32_t u_nm, cam_motion_t *m)
{
    cam_want_t *want = &r->want;
    const uint32_t home_q6 = 64u * (uint32_t)m->u.home_nm;
    keep_set(g, r, home_q6);
    want->u_due_q6 = due_q6(g, cfg, r->tick, home_q6);
    if (want->state == cam_state_off) {
        follow(g, cfg, r, u_nm, m);
    } else if (want->state == cam_state_fault || !accept(g, cfg, r, u_nm, m)) {
        g->faults |= cam_record_faults(r, m) & armed[cam_state_fault];
        retract(g, cfg, r, m);
        keep_set(g, r, home_q6);
    } else {
        // accepted
    }
}
