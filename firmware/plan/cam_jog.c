// SPDX-License-Identifier: Apache-2.0
#include "cam_plan_inner.h"
#include "cam_fix.h" // cam_clamp_i64, cam_is_within, cam_wrap_diff, ..

static void end_order(cam_jog_t *h, cam_jog_end_t how)
{
    h->phase = cam_jog_rest;
    h->end = how;
}

/// Drives without power lose their position, and U loses it with its scale.
static void forget_homes(cam_jog_t *h, const cam_tick_record_t *r)
{
    if ((r->in.inputs & hal_in_drive_ready) == 0u) {
        h->homed = 0;
    }
    if ((r->want.faults & CAM_FAULT_BIT(u_runaway)) != 0u) {
        h->homed &= ~(UINT32_C(1) << (uint32_t)hal_axis_u);
    }
}

/// @param of_u  input of U; those of X and Z are the next bits
static bool is_input_on(const cam_tick_record_t *r, hal_axis_t axis, uint32_t of_u)
{
    return (r->in.inputs & (of_u << (uint32_t)axis)) != 0u;
}

static bool has_expired(const cam_jog_order_t *o, const cam_tick_record_t *r)
{
    return cam_wrap_diff(o->until, r->tick) <= 0;
}

/// Begin a phase of homing, within the travel of the order.
static void begin_phase(cam_jog_t *h, const cam_jog_order_t *o, cam_jog_phase_t phase,
                        int64_t from_q10)
{
    const int32_t sense = phase == cam_jog_search ? o->sense : -o->sense;
    h->phase = phase;
    h->target_q10 =
        cam_clamp_i64(cam_wrap_add_i64(from_q10, sense * o->distance_q10), o->low_q10, o->high_q10);
}

/// [nm] limit of a shift of U's origin: the range of set-points in nm / 64.
enum { most_shift_nm = 1 << 25 };

enum {
    still_nm = 1000,    ///< U stands while it moves by no more than this
    left_nm = 10000,    ///< U has left its stop at this distance
    follows_nm = 10000, ///< ... and follows its set-point within this
};

/// The home is found. @return [nm] shift of U's position
static int32_t take_home(cam_jog_t *h, const cam_jog_config_t *cfg, const cam_tick_record_t *r,
                         cam_motion_t *m)
{
    const hal_axis_t axis = h->axis;
    const int32_t at_nm = h->phase == cam_jog_release && cfg->order.press_q6 != 0
                              ? h->stood_nm
                              : r->in.actual_nm[axis];
    const int64_t shift_nm = axis == hal_axis_u ? (int64_t)cfg->order.home_nm - at_nm : 0;
    const int64_t u_q10 = cam_wrap_add_i64(m->axis[hal_axis_u].pos_q10, shift_nm * 1024);
    const bool is_in_stroke =
        shift_nm == 0 || cam_is_between(u_q10, -cfg->u_end_q10, cfg->u_end_q10);
    if (shift_nm <= -most_shift_nm || shift_nm >= most_shift_nm || !is_in_stroke) {
        end_order(h, cam_jog_no_stroke);
        return 0;
    }
    h->homed |= UINT32_C(1) << (uint32_t)axis;
    h->n_found++;
    h->found_nm[axis] = at_nm;
    m->u_press_q6 = axis == hal_axis_u ? 0 : m->u_press_q6;
    end_order(h, cam_jog_done);
    return (int32_t)shift_nm;
}

/// Begin a phase of homing. U's origin is shifted, so that its stroke is ahead of it.
/// @param u_q10  [nm / 1024] new position of U
/// @return       [nm] shift of U's position
static int32_t begin_from(cam_jog_t *h, const cam_jog_config_t *cfg, const cam_motion_t *m,
                          cam_jog_phase_t phase, int64_t u_q10)
{
    const cam_jog_order_t *o = &cfg->order;
    int64_t from_q10 = m->axis[o->axis].pos_q10;
    int64_t shift_nm = 0;
    if (o->axis == hal_axis_u) {
        shift_nm = cam_wrap_sub_i64(u_q10, from_q10) / 1024;
        from_q10 = cam_wrap_add_i64(from_q10, shift_nm * 1024);
        if (shift_nm <= -most_shift_nm || shift_nm >= most_shift_nm) {
            end_order(h, cam_jog_no_stroke);
            return 0;
        }
    }
    begin_phase(h, o, phase, from_q10);
    return (int32_t)shift_nm;
}

/// Forget the home and begin the search or, on the switch, the release, with U at an end of its
/// stroke. @return [nm] shift of U's position
static int32_t begin_homing(cam_jog_t *h, const cam_jog_config_t *cfg, const cam_tick_record_t *r,
                            cam_motion_t *m)
{
    const cam_jog_order_t *o = &cfg->order;
    h->homed &= ~(UINT32_C(1) << (uint32_t)o->axis);
    h->n_still = 0;
    m->u_press_q6 = o->press_q6 != 0 ? o->press_q6 : m->u_press_q6; // U may be on its stop
    return o->press_q6 == 0 && is_input_on(r, o->axis, hal_in_home_u)
               ? begin_from(h, cfg, m, cam_jog_release, o->sense * cfg->u_end_q10)
               : begin_from(h, cfg, m, cam_jog_search, -o->sense * cfg->u_end_q10);
}

/// Begin the release from the stop, at half of the stroke: the set-point must brake first.
/// @return [nm] shift of U's position
static int32_t leave_stop(cam_jog_t *h, const cam_jog_config_t *cfg, const cam_tick_record_t *r,
                          const cam_motion_t *m)
{
    const int64_t u_q10 = cfg->order.sense * cfg->u_end_q10 / 2;
    const int32_t shift_nm = begin_from(h, cfg, m, cam_jog_release, u_q10);
    h->stood_nm = cam_wrap_add(r->in.actual_nm[hal_axis_u], shift_nm);
    return shift_nm;
}

/// @return [nm / 1024] end of a jog or step: within the travel, or no farther out than now. Passing
/// the end by the overshoot of braking does not count as outside
static int64_t travel_q10(const cam_jog_config_t *cfg, int64_t pos_q10)
{
    const cam_jog_order_t *o = &cfg->order;
    const int64_t room_q10 = cfg->limits[o->axis].acceleration_q10;
    const int64_t low_q10 = pos_q10 < o->low_q10 - room_q10 ? pos_q10 : o->low_q10;
    const int64_t high_q10 = pos_q10 > o->high_q10 + room_q10 ? pos_q10 : o->high_q10;
    const int64_t far_q10 = o->sense > 0 ? high_q10 : low_q10;
    return o->begin == cam_jog_jog
               ? far_q10
               : cam_clamp_i64(cam_wrap_add_i64(pos_q10, o->distance_q10), low_q10, high_q10);
}

/// Begin the order of the configuration. @return [nm] shift of U's position
static int32_t begin_order(cam_jog_t *h, const cam_jog_config_t *cfg, const cam_tick_record_t *r,
                           cam_motion_t *m)
{
    const cam_jog_order_t *o = &cfg->order;
    const bool was_running = h->phase != cam_jog_rest;
    h->serial = o->serial;
    if (o->begin == cam_jog_rest) {
        end_order(h, was_running ? cam_jog_stopped : h->end);
        return 0;
    }
    h->axis = o->axis;
    h->phase = o->begin;
    h->end = cam_jog_runs;
    if (has_expired(o, r)) { // before it finds or forgets a home
        end_order(h, cam_jog_silent);
        return 0;
    }
    if (o->begin == cam_jog_here) {
        return take_home(h, cfg, r, m);
    }
    if (o->begin == cam_jog_search) {
        return begin_homing(h, cfg, r, m);
    }
    h->target_q10 = travel_q10(cfg, m->axis[o->axis].pos_q10);
    return 0;
}

/// @return whether U has stood under its largest force for long enough
static bool has_met_stop(cam_jog_t *h, const cam_jog_order_t *o, const cam_tick_record_t *r)
{
    const int32_t at_nm = r->in.actual_nm[hal_axis_u];
    const bool is_pressing = o->sense * r->force_q6 >= o->press_q6;
    if (is_pressing && cam_is_within(cam_wrap_sub(at_nm, h->stood_nm), still_nm)) {
        h->n_still++;
    } else {
        h->n_still = 0;
        h->stood_nm = at_nm;
    }
    return h->n_still >= o->still_plans;
}

/// @return whether U has come back from its stop as ordered, into its stroke where the stop is the
///         home
static bool has_left_stop(const cam_jog_t *h, const cam_jog_config_t *cfg,
                          const cam_tick_record_t *r, const cam_motion_t *m)
{
    const cam_jog_order_t *o = &cfg->order;
    const int32_t back_nm = cam_wrap_sub(h->stood_nm, r->in.actual_nm[hal_axis_u]);
    const int64_t u_q10 =
        cam_wrap_add_i64(m->axis[hal_axis_u].pos_q10, ((int64_t)o->home_nm - h->stood_nm) * 1024);
    const bool is_in_stroke = o->sense > 0 ? u_q10 <= cfg->u_end_q10 : u_q10 >= -cfg->u_end_q10;
    const int64_t off_q10 =
        cam_wrap_sub_i64(m->axis[hal_axis_u].pos_q10, (int64_t)r->in.actual_nm[hal_axis_u] * 1024);
    const bool follows =
        cam_is_between(off_q10, -follows_nm * INT64_C(1024), follows_nm * INT64_C(1024));
    return follows && (int64_t)o->sense * back_nm >= left_nm && (o->has_index || is_in_stroke);
}

/// @return whether the axis is on the switch, or U at the stop, that the order searches
static bool is_on_home(cam_jog_t *h, const cam_jog_config_t *cfg, const cam_tick_record_t *r,
                       const cam_motion_t *m)
{
    if (cfg->order.press_q6 == 0) {
        return is_input_on(r, h->axis, hal_in_home_u);
    }
    return h->phase == cam_jog_search ? has_met_stop(h, &cfg->order, r)
                                      : !has_left_stop(h, cfg, r, m);
}

/// Check whether homing has found its switch, stop or index. @return [nm] shift of U's position
static int32_t look_for_home(cam_jog_t *h, const cam_jog_config_t *cfg, const cam_tick_record_t *r,
                             cam_motion_t *m)
{
    const cam_jog_order_t *o = &cfg->order;
    const cam_axis_motion_t *axis = &m->axis[h->axis];
    const bool is_on = is_on_home(h, cfg, r, m);
    // No longer braking towards the switch, but moving back from it.
    const bool is_back = o->sense > 0 ? axis->vel_q10 < 0 : axis->vel_q10 > 0;
    if (h->phase == cam_jog_search && is_on) {
        if (o->press_q6 != 0) {
            return leave_stop(h, cfg, r, m);
        }
        begin_phase(h, o, cam_jog_release, axis->pos_q10);
    } else if (h->phase == cam_jog_release && !is_on && is_back) {
        if (!o->has_index) {
            return take_home(h, cfg, r, m);
        }
        begin_phase(h, o, cam_jog_index, axis->pos_q10);
    } else if (h->phase == cam_jog_index && is_input_on(r, h->axis, hal_in_index_u)) {
        return take_home(h, cfg, r, m);
    } else {
        // the phase continues
    }
    return 0;
}

static bool is_u_at_rest(const cam_motion_t *m)
{
    const cam_axis_motion_t *u = &m->axis[hal_axis_u];
    return u->vel_q10 == 0 && u->acc_q10 == 0;
}

/// Move the axis of the order, within limits that may have been lowered meanwhile. U itself moves
/// from tick to tick. @return whether it has reached the end of the phase
static bool move_axis(const cam_jog_t *h, const cam_play_config_t *cfg, cam_motion_t *m)
{
    const cam_jog_order_t *o = &cfg->jog.order;
    const bool is_slow = h->phase == cam_jog_release || h->phase == cam_jog_index;
    cam_motion_limits_t limits = cfg->jog.limits[h->axis];
    const int32_t ordered_q10 = is_slow ? o->slow_q10 : o->speed_q10;
    limits.speed_q10 = ordered_q10 < limits.speed_q10 ? ordered_q10 : limits.speed_q10;
    if (h->axis != hal_axis_u) {
        return cam_plan_move_to_isr(m, h->axis, cfg, &limits, h->target_q10);
    }
    const int32_t speed_q10 = cam_plan_move_share(cfg, limits.speed_q10);
    m->u_speed_q10 = speed_q10 > 0 ? speed_q10 : 1;
    m->u_target_q10 = h->target_q10;
    return m->axis[hal_axis_u].pos_q10 == h->target_q10 && is_u_at_rest(m);
}

/// Move the axis of the order, or brake another one. @return whether it rests
static bool plan_axis(cam_jog_t *h, hal_axis_t axis, const cam_play_config_t *cfg, cam_motion_t *m)
{
    static const cam_jog_end_t ends[cam_jog_n_phases] = {
        [cam_jog_jog] = cam_jog_limit,        [cam_jog_step] = cam_jog_done,
        [cam_jog_search] = cam_jog_no_switch, [cam_jog_release] = cam_jog_no_release,
        [cam_jog_index] = cam_jog_no_index,
    };
    if (h->phase != cam_jog_rest && axis == h->axis) {
        if (move_axis(h, cfg, m)) {
            end_order(h, ends[h->phase]);
        }
        return false;
    }
    if (axis != hal_axis_u) {
        return cam_plan_move_brake_isr(m, axis, cfg, &cfg->jog.limits[axis]);
    }
    m->u_speed_q10 = 0;
    return is_u_at_rest(m);
}

/// @return whether all axes rest
static bool move_axes(cam_jog_t *h, const cam_play_config_t *cfg, cam_motion_t *m)
{
    const bool is_u_still = plan_axis(h, hal_axis_u, cfg, m);
    const bool is_x_still = plan_axis(h, hal_axis_x, cfg, m);
    const bool is_z_still = plan_axis(h, hal_axis_z, cfg, m);
    m->is_filtering = true;
    return is_u_still && is_x_still && is_z_still;
}

/// Shift U's origin without moving U.
static void rebase_u(cam_motion_t *m, int32_t by_nm)
{
    const int64_t by_q10 = (int64_t)by_nm * 1024;
    m->u.home_nm = cam_wrap_add(m->u.home_nm, by_nm);
    m->u.set_q6 = cam_sat_i32(m->u.set_q6 + by_nm * INT64_C(64));
    m->u.nm = cam_clamp_i32(cam_sat_add(m->u.nm, by_nm), -(1 << 25), (1 << 25) - 1);
    m->axis[hal_axis_u].pos_q10 = cam_wrap_add_i64(m->axis[hal_axis_u].pos_q10, by_q10);
    m->u_target_q10 = cam_wrap_add_i64(m->u_target_q10, by_q10);
    cam_jerk_filter_shift_isr(&m->filter[hal_axis_u], by_q10);
}

void cam_jog_isr(cam_jog_t *h, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                 cam_motion_t *m)
{
    const cam_jog_order_t *o = &cfg->jog.order;
    int32_t shift_nm = 0;
    m->faults = 0;
    m->spindle_mrpm = 0;
    m->is_clear = false;
    forget_homes(h, r);
    if (o->serial != h->serial) {
        shift_nm = begin_order(h, &cfg->jog, r, m);
    } else if (h->phase != cam_jog_rest) {
        shift_nm = look_for_home(h, &cfg->jog, r, m);
    } else {
        // no order
    }
    if (h->phase != cam_jog_rest && m->is_stopping) {
        end_order(h, cam_jog_stopped);
    }
    if (h->phase != cam_jog_rest && has_expired(o, r)) {
        end_order(h, cam_jog_silent);
    }
    if (shift_nm != 0) { // the order's target already counts from the new origin
        rebase_u(m, shift_nm);
    }
    const bool are_at_rest = shift_nm == 0 && move_axes(h, cfg, m);
    if (m->is_stopping && are_at_rest) {
        m->is_stopping = false;
        m->state = cam_state_off;
    }
}

void cam_jog_idle_isr(cam_jog_t *h, const cam_play_config_t *cfg, const cam_tick_record_t *r)
{
    forget_homes(h, r);
    h->serial = cfg->jog.order.serial;
    if (h->phase != cam_jog_rest) {
        end_order(h, cam_jog_stopped);
    }
}
