// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible.h"
#include "cam_fix.h"    // cam_divided_up_u64, cam_greater_u64
#include "cam_motion.h" // cam_jerk_filter_most_log2
#include "cam_plan.h"   // cam_plan_ticks
#include "hal/hal.h"    // hal_takes_force
#include <stdbool.h>    // bool
#include <stddef.h>     // size_t

/// Without a jerk: shortest window of U, which is also at least two ticks, and that of X and Z.
enum { least_u_ns = 800000, least_xz_ns = 6400000 };

static const cam_param_id_t jerks[hal_n_axes] = {
    cam_param_u_jerk_m_per_s3, cam_param_x_jerk_m_per_s3, cam_param_z_jerk_m_per_s3};
static const cam_param_id_t accelerations[hal_n_axes] = {cam_param_u_acceleration_mm_per_s2,
                                                         cam_param_x_acceleration_mm_per_s2,
                                                         cam_param_z_acceleration_mm_per_s2};

/// @return [ns] interval of the set-points of an axis, rounded down
static uint64_t step_ns(hal_axis_t axis, uint32_t tick_hz)
{
    const uint32_t ticks = axis == hal_axis_u ? 1u : (uint32_t)cam_plan_ticks(tick_hz);
    return UINT64_C(1000000000) * ticks / tick_hz;
}

/// @return [ns] window of an axis: 2 a / jerk, over which the acceleration reverses. Without a jerk
/// that of U is at least k1 and 4 a k2 / v: the jerk adds at most half of U's speed to its command
static uint64_t window_ns(const cam_params_t *p, hal_axis_t axis, uint32_t tick_hz)
{
    const uint64_t a = (uint64_t)cam_param_get(p, accelerations[axis]);
    const int32_t jerk = cam_param_get(p, jerks[axis]);
    if (jerk > 0) {
        return cam_divided_up_u64(a * 2000000u, (uint64_t)jerk);
    }
    if (axis != hal_axis_u) {
        return least_xz_ns;
    }
    const uint64_t by_k2 =
        cam_divided_up_u64(4u * a * (uint64_t)p->k2_us2, (uint64_t)p->u_speed_um_per_s);
    const uint64_t least = cam_greater_u64(least_u_ns, 2u * step_ns(axis, tick_hz));
    return cam_greater_u64(least, cam_greater_u64((uint64_t)p->k1_ns, by_k2));
}

uint32_t cam_gains_log2_window(const cam_params_t *params, hal_axis_t axis, uint32_t tick_hz)
{
    const uint64_t wanted_ns = window_ns(params, axis, tick_hz);
    uint32_t log2 = 0;
    while (log2 < (uint32_t)cam_jerk_filter_most_log2 &&
           step_ns(axis, tick_hz) << log2 < wanted_ns) {
        log2++;
    }
    return log2;
}

int64_t cam_gains_bound(const cam_params_t *params, cam_param_id_t id, uint32_t tick_hz)
{
    const int64_t v = params->u_speed_um_per_s;
    const int64_t a = params->u_acceleration_mm_per_s2;
    const uint32_t n_steps = UINT32_C(1) << cam_gains_log2_window(params, hal_axis_u, tick_hz);
    const int64_t u_ns = (int64_t)step_ns(hal_axis_u, tick_hz) * n_steps;
    switch (id) {
    case cam_param_k1_ns: // the acceleration commands about U's speed at most
        return u_ns / 2 + v * 750000 / a;
    case cam_param_k2_us2: // the jerk alone commands no more than U's speed
        return v * u_ns / (2 * a);
    case cam_param_u_friction_nm: // nor does its reversal in a step
        return v * (int64_t)step_ns(hal_axis_u, tick_hz) / 2000000;
    default:
        break;
    }
    // The least jerk whose window fits.
    const hal_axis_t axis = id == cam_param_x_jerk_m_per_s3   ? hal_axis_x
                            : id == cam_param_z_jerk_m_per_s3 ? hal_axis_z
                                                              : hal_axis_u;
    const uint64_t most_ns = step_ns(axis, tick_hz) << cam_jerk_filter_most_log2;
    const uint64_t twice_a = (uint64_t)cam_param_get(params, accelerations[axis]) * 2000000u;
    return (int64_t)cam_divided_up_u64(twice_a, most_ns);
}

cam_refusal_t cam_gains_check(const cam_params_t *params, uint32_t tick_hz)
{
    static const cam_param_id_t gains[] = {cam_param_k1_ns, cam_param_k2_us2,
                                           cam_param_u_friction_nm};
    const size_t n_gains = hal_takes_force() ? 3u : 2u; // a drive of its own may hide its friction
    for (size_t i = 0; i < hal_n_axes + n_gains; i++) {
        const bool is_jerk = i < (size_t)hal_n_axes;
        const cam_param_id_t id = is_jerk ? jerks[i] : gains[i - hal_n_axes];
        const int64_t value = cam_param_get(params, id);
        const int64_t bound = cam_gains_bound(params, id, tick_hz);
        if (is_jerk ? value > 0 && value < bound : value > bound) {
            return cam_refusal_of(is_jerk ? cam_err_jerk : cam_err_gain, id, value, bound);
        }
    }
    return cam_refusal_none();
}
