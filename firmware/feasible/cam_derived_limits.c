// SPDX-License-Identifier: Apache-2.0
#include "cam_derived_limits.h"
#include "cam_cut.h"   // cam_cut_divided_up
#include "cam_fix.h"   // cam_clamp_i64
#include "cam_gains.h" // cam_gains_check
#include "cam_play.h"  // cam_play_history
#include "hal/hal.h"   // hal_axis_scale
#include <stdbool.h>   // bool
#include <stddef.h>    // NULL, size_t

enum { least_jump_counts = 8, quantisation_counts = 4, most_jump_counts = 1 << 30 };
enum { least_following_nm = 10000, most_following_nm = 200000, unknown_following_nm = 100000 };

/// @return [counts] twice the observer's lag per tick while the spindle accelerates: N times
///         2 alpha T / w_o of 2 pi, with 2 pi^2 = 987 / 50
static uint64_t twice_lag_counts(const cam_params_t *p, uint32_t tick_hz)
{
    const uint64_t moved =
        (uint64_t)p->counts_per_turn * (uint64_t)p->spindle_acceleration_mrad_per_s2;
    return cam_cut_divided_up(moved * 100u, 987u * (uint64_t)p->observer_bandwidth_mHz * tick_hz);
}

/// @return [counts] twice a hundredth of what the spindle turns in a tick at its highest speed
static uint64_t twice_ripple_counts(const cam_params_t *p, uint32_t tick_hz)
{
    const uint64_t fastest = (uint64_t)p->counts_per_turn * (uint64_t)p->spindle_limit_mrpm;
    return cam_cut_divided_up(fastest, UINT64_C(3000000) * tick_hz);
}

int32_t cam_derived_limits_jump_counts(const cam_params_t *params, uint32_t tick_hz)
{
    if (params->jump_window_counts > 0) {
        return params->jump_window_counts;
    }
    const uint64_t derived = twice_lag_counts(params, tick_hz) +
                             twice_ripple_counts(params, tick_hz) + quantisation_counts;
    const uint64_t window = cam_cut_greater(derived, least_jump_counts);
    return (int32_t)cam_cut_smaller((int64_t)window + params->index_tolerance_counts,
                                    most_jump_counts);
}

int32_t cam_derived_limits_following_nm(const cam_params_t *params, const cam_table_t *table)
{
    if (params->following_limit_nm > 0) {
        return params->following_limit_nm;
    }
    const int64_t u_nm = table != NULL ? (int64_t)table->u_max_nm - table->u_min_nm : 0;
    const int32_t least_nm = params->k1_ns > 0 ? least_following_nm : unknown_following_nm;
    return (int32_t)cam_clamp_i64(u_nm * params->amplitude_ppm / 5000000, least_nm,
                                  most_following_nm);
}

/// @return [nm] half of what a drive lags in its approach, and its way in half a tick. Parameters
/// are in ns, us^2, um/s and mm/s^2, whose products are 1e-6 nm
static int64_t approach_nm(const cam_params_t *p, uint32_t tick_hz)
{
    const int64_t v_um_per_s = p->u_speed_um_per_s / cam_derived_limits_approach_share;
    const int64_t a_mm_per_s2 = p->u_acceleration_mm_per_s2 / cam_derived_limits_approach_share;
    const int64_t lag_ns = (int64_t)p->k1_ns + p->lead_ns;
    return (lag_ns * v_um_per_s + p->k2_us2 * a_mm_per_s2) / 2000000 +
           v_um_per_s * 500 / (int64_t)tick_hz;
}

int32_t cam_derived_limits_approach_nm(const cam_params_t *params, const cam_table_t *table,
                                       uint32_t tick_hz)
{
    const int64_t cut_nm = cam_derived_limits_following_nm(params, table);
    if (params->following_limit_nm > 0) {
        return (int32_t)cut_nm;
    }
    const int64_t way_nm = approach_nm(params, tick_hz);
    return cam_sat_i32(cut_nm > way_nm ? cut_nm : way_nm);
}

int32_t cam_derived_limits_usual_mHz(int32_t wanted_mHz, uint32_t tick_hz)
{
    return cam_clamp_i32(wanted_mHz, 0, (int32_t)(tick_hz * 50u));
}

/// @return [um/s] highest speed of an axis, by its output where the port names one
static int64_t output_um_per_s(hal_axis_t axis, int64_t most)
{
    const int32_t fastest_um_per_s = hal_axis_scale(axis).most_um_per_s;
    return fastest_um_per_s > 0 ? cam_cut_smaller(most, fastest_um_per_s) : most;
}

int32_t cam_derived_limits_most(cam_param_id_t id, uint32_t tick_hz)
{
    const cam_param_info_t *info = cam_param_info(id);
    const int64_t hz = (int64_t)tick_hz;
    int64_t most = info != NULL ? info->max : 0;
    switch (id) {
    case cam_param_observer_bandwidth_mHz:
        most = cam_cut_smaller(most, hz * 80); // MATHS.md (188)
        break;
    case cam_param_lead_ns: // less than the history by 2^-16 tick
        most = cam_cut_smaller(most, ((cam_play_history - 2) * INT64_C(1000000000) - 15259) / hz);
        break;
    case cam_param_k1_ns:
        most = cam_cut_smaller(most, INT64_C(32766) * 1000000000 / hz);
        break;
    case cam_param_k2_us2:
        most = cam_cut_smaller(most, INT64_C(32766) * 1000000000000 / (hz * hz));
        break;
    case cam_param_x_speed_um_per_s:
        most = output_um_per_s(hal_axis_x, most);
        break;
    case cam_param_z_speed_um_per_s:
        most = output_um_per_s(hal_axis_z, most);
        break;
    default:
        break;
    }
    return (int32_t)most;
}

/// @return whether each parameter of a list is within cam_derived_limits_most()
static bool are_within(const cam_params_t *params, const cam_param_id_t *ids, size_t n,
                       uint32_t tick_hz)
{
    bool fits = true;
    for (size_t i = 0; i < n; i++) {
        fits = fits && cam_param_get(params, ids[i]) <= cam_derived_limits_most(ids[i], tick_hz);
    }
    return fits;
}

cam_err_t cam_derived_limits_check(const cam_params_t *params, uint32_t tick_hz)
{
    static const cam_param_id_t by_tick[] = {cam_param_observer_bandwidth_mHz, cam_param_lead_ns,
                                             cam_param_k1_ns, cam_param_k2_us2};
    static const cam_param_id_t by_output[] = {cam_param_x_speed_um_per_s,
                                               cam_param_z_speed_um_per_s};
    const int64_t due_ns = (int64_t)params->lead_ns + params->u_scale_latency_ns;
    if (due_ns > cam_derived_limits_most(cam_param_lead_ns, tick_hz) ||
        !are_within(params, by_tick, sizeof by_tick / sizeof by_tick[0], tick_hz)) {
        return cam_err_param_tick;
    }
    const size_t n_outputs = sizeof by_output / sizeof by_output[0];
    if (!are_within(params, by_output, n_outputs, tick_hz)) {
        return cam_err_param_output;
    }
    cam_param_id_t which = cam_n_params;
    return cam_gains_check(params, tick_hz, &which);
}
