// SPDX-License-Identifier: Apache-2.0
#include "sim_params.h"
#include "cam_derived_limits.h" // cam_derived_limits_most
#include "cam_gains.h"          // cam_gains_check
#include "cam_servo_setup.h"    // cam_servo_setup
#include <stdio.h>              // snprintf

/// The largest acceleration of U up to the present one with which these gains are taken.
/// @return [mm/s^2], 0 where none is
static int32_t acceleration_for_gains(const cam_params_t *params, uint32_t tick_hz)
{
    const cam_param_id_t id = cam_param_u_acceleration_mm_per_s2;
    cam_params_t trial = *params;
    cam_param_id_t which = cam_n_params;
    int32_t good = 0;
    int32_t low = cam_param_info(id)->min;
    int32_t high = cam_param_get(params, id);
    while (low <= high) {
        const int32_t middle = low + (high - low) / 2;
        const bool is_taken = cam_param_set(&trial, id, middle) == cam_ok &&
                              cam_gains_check(&trial, tick_hz, &which) == cam_ok;
        good = is_taken ? middle : good;
        low = is_taken ? middle + 1 : low;
        high = is_taken ? high : middle - 1;
    }
    return good;
}

/// Refuse k1 or k2, which a slow drive of U makes large.
/// @return false
static bool refuse_slow_drive(const char *refused, const cam_params_t *params, uint32_t tick_hz,
                              common_error_t *e)
{
    const int32_t most = acceleration_for_gains(params, tick_hz);
    if (most == 0) {
        return common_error(e,
                            "%s; it follows from [u] bandwidth_hz of the machine file unless it is "
                            "set; this drive is too slow: give a larger bandwidth_hz",
                            refused);
    }
    return common_error(e,
                        "%s; it follows from [u] bandwidth_hz of the machine file unless it is "
                        "set; such a drive needs [u] acceleration_mm_per_s2 of at most %d, or a "
                        "lower [machine] tick_hz",
                        refused, (int)most);
}

/// Refuse gains or a jerk. The message names the one that is wrong in the whole set, which need not
/// be the parameter set last. @return false
static bool refuse_gains(const cam_params_t *params, uint32_t tick_hz, common_error_t *e)
{
    cam_param_id_t which = cam_n_params;
    const cam_err_t err = cam_gains_check(params, tick_hz, &which);
    const long long bound = cam_gains_bound(params, which, tick_hz);
    char refused[256];
    (void)snprintf(refused, sizeof refused,
                   "parameter %s = %d: refused: %s; with the other parameters it is at %s %lld",
                   cam_param_info(which)->name, (int)cam_param_get(params, which),
                   cam_err_text(err), err == cam_err_jerk ? "least" : "most", bound);
    if (err == cam_err_gain) {
        return refuse_slow_drive(refused, params, tick_hz, e);
    }
    return common_error(e, "%s; change it, or them, in the machine file or by --set", refused);
}

/// Refuse the position loop of a U that takes forces. @return false
static bool refuse_servo(const cam_params_t *params, uint32_t tick_hz, common_error_t *e)
{
    cam_servo_config_t made;
    cam_param_id_t which = cam_n_params;
    const cam_err_t err = cam_servo_setup(params, tick_hz, &made, &which);
    if (err == cam_err_servo_force) {
        return common_error(e,
                            "refused: %s: %.6g N, limit %.6g N; give a smaller [u] "
                            "acceleration_mm_per_s2 or speed_mm_per_s in the machine file, or a "
                            "larger force_limit_n",
                            cam_err_text(err), (double)cam_servo_needed_mn(params) * 1e-3,
                            params->servo_force_limit_mn * 1e-3);
    }
    return common_error(e, "parameter %s = %d: refused: %s; change the machine file or --set",
                        cam_param_info(which)->name, (int)cam_param_get(params, which),
                        cam_err_text(err));
}

static bool refuse(const cam_params_t *params, cam_param_id_t id, cam_err_t err, uint32_t tick_hz,
                   common_error_t *e)
{
    const char *name = cam_param_info(id)->name;
    const int value = (int)cam_param_get(params, id);
    if (err == cam_err_gain || err == cam_err_jerk) {
        return refuse_gains(params, tick_hz, e);
    }
    if (err == cam_err_servo || err == cam_err_servo_force) {
        return refuse_servo(params, tick_hz, e);
    }
    if (err == cam_err_param_tick) {
        return common_error(e,
                            "parameter %s = %d: refused: %s of %.0f Hz; give at most %d in the "
                            "machine file or --set, or a machine with a faster tick_hz",
                            name, value, cam_err_text(err), (double)tick_hz,
                            (int)cam_derived_limits_most(id, tick_hz));
    }
    return common_error(e, "parameter %s = %d: refused: %s; change the machine file or --set", name,
                        value, cam_err_text(err));
}

/// @return whether an error may vanish when the other parameters are set
static bool may_vanish(cam_err_t err)
{
    return err == cam_err_gain || err == cam_err_jerk || err == cam_err_servo ||
           err == cam_err_servo_force;
}

bool sim_params_apply(const cam_params_t *params, uint32_t tick_hz, sim_params_set_t set,
                      void *controller, common_error_t *e)
{
    cam_param_id_t which = cam_n_params;
    cam_servo_config_t made;
    const bool is_set_right = cam_gains_check(params, tick_hz, &which) == cam_ok &&
                              cam_servo_setup(params, tick_hz, &made, &which) == cam_ok;
    bool is_left = true;
    for (uint32_t round = 0; round < cam_n_params && is_left; round++) {
        is_left = false;
        for (uint32_t i = 0; i < cam_n_params; i++) {
            const cam_param_id_t id = (cam_param_id_t)i;
            const int32_t value = cam_param_get(params, id);
            cam_err_t err = set(controller, id, value);
            if (err == cam_err_busy) { // learning still adapts to the parameter set before
                err = set(controller, id, value);
            }
            const bool is_later = is_set_right && may_vanish(err) && round + 1u < cam_n_params;
            is_left = is_left || is_later;
            if (err != cam_ok && !is_later) {
                return refuse(params, id, err, tick_hz, e);
            }
        }
    }
    return true;
}
