// SPDX-License-Identifier: Apache-2.0
#include "sim_params.h"
#include "cam_derived_limits.h" // cam_derived_limits_most
#include "cam_gains.h"          // cam_gains_check

/// Refuse gains or a jerk. The message names the one that is wrong in the whole set, which need not
/// be the parameter set last. @return false
static bool refuse_gains(const cam_params_t *params, uint32_t tick_hz, common_error_t *e)
{
    cam_param_id_t which = cam_n_params;
    const cam_err_t err = cam_gains_check(params, tick_hz, &which);
    const long long bound = cam_gains_bound(params, which, tick_hz);
    return common_error(e,
                        "parameter %s = %d: refused: %s; with the other parameters it is at %s "
                        "%lld; change it, or them, in the machine file or by --set",
                        cam_param_info(which)->name, (int)cam_param_get(params, which),
                        cam_err_text(err), err == cam_err_jerk ? "least" : "most", bound);
}

static bool refuse(const cam_params_t *params, cam_param_id_t id, cam_err_t err, uint32_t tick_hz,
                   common_error_t *e)
{
    const char *name = cam_param_info(id)->name;
    const int value = (int)cam_param_get(params, id);
    if (err == cam_err_gain || err == cam_err_jerk) {
        return refuse_gains(params, tick_hz, e);
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

bool sim_params_apply(const cam_params_t *params, uint32_t tick_hz, sim_params_set_t set,
                      void *controller, common_error_t *e)
{
    cam_param_id_t which = cam_n_params;
    const bool are_gains_right = cam_gains_check(params, tick_hz, &which) == cam_ok;
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
            const bool is_later = are_gains_right && (err == cam_err_gain || err == cam_err_jerk);
            is_left = is_left || is_later;
            if (err != cam_ok && !is_later) {
                return refuse(params, id, err, tick_hz, e);
            }
        }
    }
    return true;
}
