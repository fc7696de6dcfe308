// SPDX-License-Identifier: Apache-2.0
#include "sim_config.h"
#include "cam_feasible.h" // cam_gains_check
#include <stdio.h>        // snprintf

/// The largest acceleration of U up to the present one with which these gains are taken.
/// @return [mm/s^2], 0 where none is
static int32_t acceleration_for_gains(const cam_params_t *params, uint32_t tick_hz)
{
    const cam_param_id_t id = cam_param_u_acceleration_mm_per_s2;
    cam_params_t trial = *params;
    int32_t good = 0;
    int32_t low = cam_param_info(id)->min;
    int32_t high = cam_param_get(params, id);
    while (low <= high) {
        const int32_t middle = low + (high - low) / 2;
        const bool is_taken = cam_param_set(&trial, id, middle) == cam_ok &&
                              cam_gains_check(&trial, tick_hz).err == cam_ok;
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

static bool refuse(const cam_machine_t *m, const cam_params_t *params, const cam_refusal_t *refusal,
                   common_error_t *e)
{
    const cam_param_info_t *info = cam_param_info(refusal->param);
    const char *what = cam_err_text(refusal->err);
    if (info == NULL) {
        return common_error(e, "parameters: refused: %s", what);
    }
    char bound[80] = "";
    if (refusal->err == cam_err_gain || refusal->err == cam_err_jerk) {
        (void)snprintf(bound, sizeof bound, "; with the other parameters it is at %s %lld",
                       refusal->err == cam_err_jerk ? "least" : "most", (long long)refusal->limit);
    }
    char refused[256];
    (void)snprintf(refused, sizeof refused, "parameter %s = %lld: refused: %s%s", info->name,
                   (long long)refusal->needed, what, bound);
    switch (refusal->err) {
    case cam_err_gain:
        return refuse_slow_drive(refused, params, m->tick_hz, e);
    case cam_err_jerk:
        return common_error(e, "%s; change it, or them, in the machine file or by --set", refused);
    case cam_err_servo_force:
        return common_error(e,
                            "refused: %s: %.6g N, limit %.6g N; give a smaller [u] "
                            "acceleration_mm_per_s2 or speed_mm_per_s in the machine file, or a "
                            "larger force_limit_n",
                            what, (double)refusal->needed * 1e-3, (double)refusal->limit * 1e-3);
    case cam_err_param_tick:
        return common_error(e,
                            "%s of %.0f Hz; give at most %lld in the machine file or --set, or a "
                            "machine with a faster tick_hz",
                            refused, (double)m->tick_hz, (long long)refusal->limit);
    default:
        return common_error(e, "%s; change the machine file or --set", refused);
    }
}

bool sim_params_apply(cam_machine_t *machine, const cam_params_t *params, common_error_t *e)
{
    cam_machine_stage_begin(machine);
    for (uint32_t i = 0; i < (uint32_t)cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        const int32_t value = cam_param_get(params, id);
        const cam_err_t err = cam_machine_stage(machine, id, value);
        if (err != cam_ok) {
            const cam_refusal_t refusal = cam_refusal_of(err, id, value, 0);
            return refuse(machine, params, &refusal, e);
        }
    }
    const cam_err_t err = cam_machine_stage_commit(machine);
    const cam_refusal_t refusal = cam_machine_refusal(machine, err);
    return err == cam_ok || refuse(machine, params, &refusal, e);
}
