// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_inner.h"
#include "cam_feasible.h" // cam_demand_clearance_nm
#include "cam_fix.h"      // cam_sat_i32, cam_smaller_i64
#include "cam_build.h"    // cam_units_scale
#include <stddef.h>       // NULL

// Orders

/// @return whether an order is pending or an axis is moving
static bool is_axis_moving(const cam_machine_t *m, const cam_status_t *status)
{
    return status->jog.serial != m->offsets.serial || status->jog.phase != cam_jog_rest;
}

/// @return [tick] when an order given now expires
static uint32_t patience_end(const cam_machine_t *m, const cam_status_t *status)
{
    return status->tick + m->tick_hz * (uint32_t)cam_jog_patience_ms / 1000u;
}

/// Offer the interrupt the configuration in force with another order.
static cam_err_t offer_order(cam_machine_t *m, const cam_jog_order_t *order)
{
    cam_config_t *copy = cam_config_copy(&m->core->config);
    if (copy == NULL) {
        return cam_err_busy;
    }
    copy->play.jog.order = *order;
    cam_machine_offer_copy(m);
    return cam_ok;
}

static cam_err_t give_order(cam_machine_t *m, const cam_status_t *status, cam_jog_order_t *order)
{
    order->serial = m->offsets.serial + 1u;
    order->until = patience_end(m, status);
    const cam_err_t err = offer_order(m, order);
    m->offsets.serial += err == cam_ok ? 1u : 0u;
    return err;
}

/// @return cam_ok when an order of this kind may be given: only a jog replaces a jog
static cam_err_t check_order(const cam_machine_t *m, const cam_status_t *status, hal_axis_t axis,
                             cam_jog_phase_t kind)
{
    if ((uint32_t)axis >= (uint32_t)hal_n_axes ||
        (axis == hal_axis_z && m->params.z_is_measured != 0)) {
        return cam_err_hand_axis;
    }
    if (cam_machine_is_pending(m, status)) {
        return cam_err_busy;
    }
    if (status->state != cam_state_manual) {
        return cam_err_state;
    }
    const cam_jog_phase_t given = cam_machine_newest_config(m)->play.jog.order.begin;
    const bool may_replace = kind == cam_jog_jog && (given == cam_jog_jog || given == cam_jog_rest);
    return is_axis_moving(m, status) && !may_replace ? cam_err_hand_moves : cam_ok;
}

/// @return [nm / 1024 per plan] a speed, clamped to 1 .. most_q10
static int32_t order_speed_q10(const cam_machine_t *m, int32_t um_per_s, int32_t most_q10)
{
    const int64_t per_plan_q10 = cam_units_scale(
        um_per_s, INT64_C(1024000) * cam_machine_newest_config(m)->play.plan_ticks, m->tick_hz);
    return (int32_t)cam_clamp_i64(per_plan_q10, 1, most_q10);
}

/// Limits of jogs and steps, in port coordinates.
typedef struct {
    int64_t low_q10, high_q10;
} limits_t;

/// @return the stroke of U; the travel of X or Z less an eighth of the acceleration, the largest
///         overshoot of stepwise braking (cam_motion.h)
static limits_t limits_of(const cam_machine_t *m, const cam_status_t *status, hal_axis_t axis)
{
    const cam_jog_config_t *jog = &cam_machine_newest_config(m)->play.jog;
    if (axis == hal_axis_u) {
        return (limits_t){-jog->u_end_q10, jog->u_end_q10};
    }
    const bool is_known = cam_offsets_is_known(&m->params, status, axis);
    const cam_offsets_travel_t t = cam_offsets_travel(&m->offsets, &m->params, axis, is_known);
    const int64_t room_q10 = jog->limits[axis].acceleration_q10 / 8 + 1;
    return (limits_t){(int64_t)t.low_nm * 1024 + room_q10, (int64_t)t.high_nm * 1024 - room_q10};
}

/// @return [nm] the measured position of an axis, in port coordinates
static int32_t port_nm(const cam_status_t *status, hal_axis_t axis)
{
    const int32_t actual_nm[hal_n_axes] = {status->u_actual_nm, status->x_actual_nm,
                                           status->z_actual_nm};
    return actual_nm[axis];
}

cam_err_t cam_machine_manual(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    cam_err_t err = status.state == cam_state_off ? cam_machine_check_drives(&m->params, &status)
                                                  : cam_err_state;
    err = err == cam_ok ? cam_machine_check_acknowledge(m, &status) : err;
    return err == cam_ok ? cam_machine_post(m, &status, cam_request_manual) : err;
}

cam_verdict_t cam_machine_jog(cam_machine_t *m, hal_axis_t axis, int32_t um_per_s)
{
    const cam_status_t status = cam_machine_status(m);
    const cam_err_t err = check_order(m, &status, axis, cam_jog_jog);
    if (err != cam_ok) {
        return (cam_verdict_t){.err = err};
    }
    const cam_play_config_t *play = &cam_machine_newest_config(m)->play;
    const int32_t most_q10 = play->jog.limits[axis].speed_q10;
    const int32_t most =
        (int32_t)cam_units_scale(most_q10, m->tick_hz, INT64_C(1024000) * play->plan_ticks);
    if (!cam_is_between(um_per_s, -most, most)) {
        return (cam_verdict_t){cam_err_hand_speed, most};
    }
    const limits_t limits = limits_of(m, &status, axis);
    cam_jog_order_t order = {
        .begin = um_per_s == 0 ? cam_jog_rest : cam_jog_jog,
        .axis = axis,
        .sense = um_per_s < 0 ? -1 : 1,
        .speed_q10 = order_speed_q10(m, um_per_s < 0 ? -um_per_s : um_per_s, most_q10),
        .low_q10 = limits.low_q10,
        .high_q10 = limits.high_q10,
    };
    return (cam_verdict_t){give_order(m, &status, &order), um_per_s};
}

cam_verdict_t cam_machine_step(cam_machine_t *m, hal_axis_t axis, int32_t nm)
{
    const cam_status_t status = cam_machine_status(m);
    const cam_err_t err = check_order(m, &status, axis, cam_jog_step);
    if (err != cam_ok) {
        return (cam_verdict_t){.err = err};
    }
    const limits_t limits = limits_of(m, &status, axis);
    const int64_t to_q10 = ((int64_t)port_nm(&status, axis) + nm) * 1024;
    const int64_t end_q10 = nm < 0 ? limits.low_q10 : limits.high_q10;
    if (nm < 0 ? to_q10 < end_q10 : to_q10 > end_q10) {
        const int32_t shift_nm = cam_offsets_shift_nm(&m->offsets, &m->params, axis);
        return (cam_verdict_t){cam_err_travel, cam_sat_i32(end_q10 / 1024 + shift_nm)};
    }
    cam_jog_order_t order = {
        .begin = cam_jog_step,
        .axis = axis,
        .sense = nm < 0 ? -1 : 1,
        .speed_q10 = cam_machine_newest_config(m)->play.jog.limits[axis].speed_q10,
        .low_q10 = limits.low_q10,
        .high_q10 = limits.high_q10,
        .distance_q10 = (int64_t)nm * 1024,
    };
    return (cam_verdict_t){give_order(m, &status, &order), nm};
}

/// @return [mN / 64] force with which U searches its stop; a hot motor has it as well
static int32_t press_q6(const cam_params_t *p)
{
    const int64_t most_mn = cam_smaller_i64(p->servo_continuous_mn, p->servo_force_limit_mn);
    return 64 * (int32_t)cam_smaller_i64(p->u_home_force_mn, most_mn);
}

cam_err_t cam_machine_home_axis(cam_machine_t *m, hal_axis_t axis)
{
    const cam_status_t status = cam_machine_status(m);
    cam_err_t err = check_order(m, &status, axis, cam_jog_search);
    if (err != cam_ok) {
        return err;
    }
    enum { none, here, by_switch, by_index, by_stop, by_stop_index };
    const cam_offsets_axis_t a = cam_offsets_axis(&m->params, axis);
    const bool has_stop = a.method == by_stop || a.method == by_stop_index;
    if (a.method == none || (has_stop && !hal_takes_force())) {
        return cam_err_home_none;
    }
    const cam_play_config_t *play = &cam_machine_newest_config(m)->play;
    const cam_jog_config_t *jog = &play->jog;
    const int32_t most_q10 = jog->limits[axis].speed_q10;
    const uint64_t plans_in_20_ms = m->tick_hz / (50u * (uint32_t)play->plan_ticks);
    const int64_t end_q10 =
        axis == hal_axis_u ? jog->u_end_q10 : (int64_t)CAM_OFFSETS_FAR_NM * 1024;
    cam_jog_order_t order = {
        .begin = a.method == here ? cam_jog_here : cam_jog_search,
        .axis = axis,
        .sense = a.sense,
        .has_index = a.method == by_index || a.method == by_stop_index,
        .speed_q10 = order_speed_q10(m, a.search_um_per_s, most_q10),
        .slow_q10 = order_speed_q10(m, a.slow_um_per_s, most_q10),
        .low_q10 = -end_q10,
        .high_q10 = end_q10,
        .distance_q10 = (int64_t)a.way_nm * 1024,
        .home_nm = a.home_nm,
        .press_q6 = has_stop ? press_q6(&m->params) : 0,
        .still_plans = (uint16_t)cam_greater_u64(plans_in_20_ms, 1),
    };
    err = give_order(m, &status, &order);
    const bool is_search = axis == hal_axis_u && order.begin == cam_jog_search;
    m->offsets.has_searched_u = m->offsets.has_searched_u || (err == cam_ok && is_search);
    return err;
}

cam_err_t cam_machine_jog_stop(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    cam_jog_order_t order = {.begin = cam_jog_rest};
    return give_order(m, &status, &order);
}

void cam_machine_keep_alive(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    m->identify.alive_tick = status.tick;
    cam_jog_order_t order = cam_machine_newest_config(m)->play.jog.order;
    if (status.state == cam_state_manual && order.begin != cam_jog_jog &&
        is_axis_moving(m, &status)) {
        order.until = patience_end(m, &status);
        (void)offer_order(m, &order); // when busy, the next sign of life is still in time
    }
}

// Positions

int32_t cam_machine_position_nm(const cam_machine_t *m, hal_axis_t axis)
{
    const cam_status_t status = cam_machine_status(m);
    const int64_t shift_nm = cam_offsets_shift_nm(&m->offsets, &m->params, axis);
    return cam_sat_i32(port_nm(&status, axis) + shift_nm);
}

cam_verdict_t cam_machine_zero(cam_machine_t *m, hal_axis_t axis, int32_t nm)
{
    const cam_status_t status = cam_machine_status(m);
    const bool is_x = axis == hal_axis_x;
    if (!is_x && axis != hal_axis_z) {
        return (cam_verdict_t){.err = cam_err_hand_axis};
    }
    const cam_param_id_t id = is_x ? cam_param_x_datum_nm : cam_param_z_datum_nm;
    const int32_t now_nm = cam_param_get(&m->params, id);
    if (status.state == cam_state_manual && is_axis_moving(m, &status)) {
        return (cam_verdict_t){cam_err_hand_moves, now_nm};
    }
    if (!cam_offsets_is_known(&m->params, &status, axis)) {
        return (cam_verdict_t){cam_err_not_homed, now_nm};
    }
    // The tip is at the radius X - U.
    const int64_t part_nm = is_x ? (int64_t)nm / 2 + status.u_actual_nm : nm;
    const int64_t tool_nm = cam_offsets_axis(&m->params, axis).tool_nm;
    const int64_t datum_nm = part_nm - tool_nm - cam_machine_position_nm(m, axis);
    const cam_err_t err = cam_machine_set_param(m, id, cam_sat_i32(datum_nm));
    return (cam_verdict_t){err, cam_param_get(&m->params, id)};
}

/// @return whether an axis must be homed first. A search changes U's counts, so that U must then be
///         homed even where homing_required is 0.
static bool lacks_home(const cam_machine_t *m, const cam_status_t *status, hal_axis_t axis)
{
    if (axis == hal_axis_u && m->offsets.has_searched_u) {
        return (status->jog.homed >> (uint32_t)axis & 1u) == 0u;
    }
    return m->params.homing_required != 0 &&
           !(axis == hal_axis_z && m->params.z_is_measured != 0) &&
           !cam_offsets_is_known(&m->params, status, axis);
}

/// @return whether a range of part coordinates is within the travel of an axis
static bool is_in_travel(const cam_machine_t *m, const cam_status_t *status, hal_axis_t axis,
                         int64_t low_nm, int64_t high_nm)
{
    const limits_t limits = limits_of(m, status, axis);
    const int64_t origin_nm = cam_offsets_origin_nm(&m->offsets, &m->params, axis);
    return (low_nm + origin_nm) * 1024 >= limits.low_q10 &&
           (high_nm + origin_nm) * 1024 <= limits.high_q10;
}

bool cam_machine_is_x_in_travel(const cam_machine_t *m, const cam_status_t *status,
                                int32_t x_trim_nm)
{
    const cam_table_t *t = &m->table;
    const bool is_rehearsed = m->params.rehearse_turns > 0 && t->speed.knots == NULL;
    const int32_t away_nm = is_rehearsed ? cam_demand_half_stroke_nm(t, &m->params) : 0;
    const int64_t most_off_nm = (int64_t)cam_demand_clearance_nm(t, &m->params) + away_nm;
    bool is_in = true;
    for (uint32_t i = 0; i < cam_pass_count(t) && is_in; i++) {
        const int64_t left_nm =
            (int64_t)x_trim_nm + (t->passes != NULL ? t->passes[i].allowance_nm : 0);
        is_in = is_in_travel(m, status, hal_axis_x, left_nm + t->x_min_nm,
                             left_nm + t->x_max_nm + most_off_nm);
    }
    return is_in;
}

cam_err_t cam_machine_check_positions(const cam_machine_t *m, const cam_status_t *status)
{
    if (status->jog.n_found != m->offsets.n_found) {
        return cam_err_busy;
    }
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        if (lacks_home(m, status, (hal_axis_t)i)) {
            return cam_err_not_homed;
        }
    }
    const bool is_z_in =
        m->params.z_is_measured != 0 || is_in_travel(m, status, hal_axis_z, m->table.z_first_nm,
                                                     cam_feed_profile_z_last_nm(&m->table));
    return is_z_in && cam_machine_is_x_in_travel(m, status, m->params.x_trim_nm) ? cam_ok
                                                                                 : cam_err_travel;
}

void cam_machine_jog_poll(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    if (status.jog.n_found == m->offsets.n_found) {
        return;
    }
    m->offsets.known |= status.jog.homed;
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        m->offsets.home_nm[i] = status.jog.found_nm[i];
    }
    const cam_table_t *table = m->has_table ? &m->table : NULL;
    if (cam_machine_hand_over(m, &m->params, table, m->pass) == cam_ok) {
        m->offsets.n_found = status.jog.n_found;
    } // otherwise the next call retries
}
