// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible.h"
#include "cam_fix.h"  // cam_clamp_i64
#include "cam_tick.h" // cam_guard_history
#include "hal/hal.h"  // hal_axis_scale
#include <stdbool.h>  // bool
#include <stddef.h>   // NULL

enum { least_jump_counts = 8, quantisation_counts = 4, most_jump_counts = 1 << 30 };
enum {
    beat_bandwidths = 6, ///< of the observer: counts that beat faster average
    beat_ripple = 500,   ///< a spindle's ripple of 0.2 % moves the beat by a 500th of the counts
    beat_ripple_bandwidths = 10, ///< at most: a beat that moves farther passes whole counts quickly
};
enum { least_following_nm = 10000, most_following_nm = 200000, unknown_following_nm = 100000 };

int32_t cam_derived_limits_jump_counts(const cam_params_t *params, uint32_t tick_hz)
{
    const cam_params_t *p = params;
    if (p->jump_window_counts > 0) {
        return p->jump_window_counts;
    }
    // Twice the lag of the observer per tick: N times 2 alpha T / w_o of 2 pi; 2 pi^2 = 987 / 50.
    const uint64_t n = (uint64_t)p->counts_per_turn;
    const uint64_t alpha = (uint64_t)p->spindle_acceleration_mrad_per_s2;
    const uint64_t lag =
        cam_divided_up_u64(n * alpha * 100u, 987u * (uint64_t)p->observer_bandwidth_mHz * tick_hz);
    // Twice a hundredth of the travel per tick at the highest speed.
    const uint64_t ripple =
        cam_divided_up_u64(n * (uint64_t)p->spindle_limit_mrpm, UINT64_C(3000000) * tick_hz);
    const uint64_t window = cam_greater_u64(lag + ripple + quantisation_counts, least_jump_counts);
    return (int32_t)cam_smaller_i64((int64_t)window + p->index_tolerance_counts, most_jump_counts);
}

int32_t cam_derived_limits_following_nm(const cam_params_t *params, const cam_table_t *table)
{
    if (params->following_limit_nm > 0) {
        return params->following_limit_nm;
    }
    const int64_t u_nm = table != NULL ? (int64_t)table->u_max_nm - table->u_min_nm : 0;
    const bool is_led = params->k1_ns > 0 || (table != NULL && hal_takes_force());
    const int32_t least_nm = is_led ? least_following_nm : unknown_following_nm;
    return (int32_t)cam_clamp_i64(u_nm * params->amplitude_ppm / 5000000, least_nm,
                                  most_following_nm);
}

int32_t cam_derived_limits_approach_nm(const cam_params_t *params, const cam_table_t *table,
                                       uint32_t tick_hz)
{
    const cam_params_t *p = params;
    // Products of ns, us^2, um/s and mm/s^2 are in 1e-6 nm.
    const int64_t v_um_per_s =
        cam_clamp_i64(p->u_jog_um_per_s, p->u_speed_um_per_s / cam_derived_limits_approach_share,
                      p->u_speed_um_per_s);
    const int64_t a_mm_per_s2 = p->u_acceleration_mm_per_s2 / cam_derived_limits_approach_share;
    const int64_t late_nm = p->lead_ns * v_um_per_s / 2000000 + v_um_per_s * 500 / tick_hz;
    const int64_t lag_nm = (p->k1_ns * v_um_per_s + p->k2_us2 * a_mm_per_s2) / 1000000;
    const int64_t cut_nm = cam_derived_limits_following_nm(params, table);
    const int64_t off_nm = lag_nm / 2 + late_nm;
    const int64_t weak_nm = hal_takes_force() ? unknown_following_nm : 0; // a loop of power-up
    const int64_t wrong_nm = p->following_limit_nm > 0 ? 0 : off_nm > weak_nm ? off_nm : weak_nm;
    return cam_sat_i32(lag_nm + (cut_nm > wrong_nm ? cut_nm : wrong_nm));
}

int32_t cam_derived_limits_usual_mHz(int32_t wanted_mHz, uint32_t tick_hz)
{
    return cam_clamp_i32(wanted_mHz, 0, (int32_t)(tick_hz * 50u));
}

int32_t cam_derived_limits_most(cam_param_id_t id, uint32_t tick_hz)
{
    const cam_param_info_t *info = cam_param_info(id);
    const int64_t hz = (int64_t)tick_hz;
    int64_t most = info != NULL ? info->max : 0;
    switch (id) {
    case cam_param_observer_bandwidth_mHz:
        most = cam_smaller_i64(most, hz * 80); // MATHS.md (188)
        break;
    case cam_param_lead_ns: // less than the history by 2^-16 tick
        most = cam_smaller_i64(most, ((cam_guard_history - 2) * INT64_C(1000000000) - 15259) / hz);
        break;
    case cam_param_k1_ns:
        most = cam_smaller_i64(most, INT64_C(32766) * 1000000000 / hz);
        break;
    case cam_param_k2_us2:
        most = cam_smaller_i64(most, INT64_C(32766) * 1000000000000 / (hz * hz));
        break;
    case cam_param_x_speed_um_per_s:
    case cam_param_z_speed_um_per_s: {
        const hal_axis_t axis = id == cam_param_x_speed_um_per_s ? hal_axis_x : hal_axis_z;
        const int32_t output_um_per_s = hal_axis_scale(axis).most_um_per_s; // 0: no limit
        most = output_um_per_s > 0 ? cam_smaller_i64(most, output_um_per_s) : most;
        break;
    }
    default:
        break;
    }
    return (int32_t)most;
}

cam_refusal_t cam_derived_limits_check(const cam_params_t *params, uint32_t tick_hz)
{
    for (uint32_t i = 0; i < (uint32_t)cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        const int32_t value = cam_param_get(params, id);
        const int32_t most = cam_derived_limits_most(id, tick_hz);
        const bool is_output = id == cam_param_x_speed_um_per_s || id == cam_param_z_speed_um_per_s;
        if (value > most) {
            return cam_refusal_of(is_output ? cam_err_param_output : cam_err_param_tick, id, value,
                                  most);
        }
    }
    const int64_t due_ns = (int64_t)params->lead_ns + params->u_scale_latency_ns;
    const int32_t most_ns = cam_derived_limits_most(cam_param_lead_ns, tick_hz);
    if (due_ns > most_ns) {
        return cam_refusal_of(cam_err_param_tick, cam_param_lead_ns, due_ns, most_ns);
    }
    return cam_gains_check(params, tick_hz);
}

/// Largest slope that counts: a steeper part is a step, whose form does not depend on half a step
/// of Z. 2 pi in millionths.
enum { most_slope_ppm = 4000000, turn_urad = 6283185 };

/// @return [1e-6] steepest change of the radius over the height; lobes are straight along Z
static uint64_t part_slope_ppm(const cam_table_t *t)
{
    if (t == NULL || t->lobes != NULL || t->u.span_nm == 0u) {
        return 0;
    }
    const uint64_t u_ppm = (uint64_t)t->u_change.most * (t->u.n_slices - 1u) * 1000000u;
    const uint64_t ppm = t->x_slope_ppm + u_ppm / t->u.span_nm;
    return ppm < most_slope_ppm ? ppm : (uint64_t)most_slope_ppm;
}

static uint32_t pm_saturated(uint64_t pm)
{
    return pm < UINT32_MAX ? (uint32_t)pm : UINT32_MAX;
}

uint32_t cam_derived_limits_form_pm(const cam_table_t *table)
{
    const uint64_t z_pm = hal_axis_scale(hal_axis_z).command_pm * part_slope_ppm(table) / 1000000u;
    const uint64_t ux_pm =
        (uint64_t)hal_axis_scale(hal_axis_u).command_pm + hal_axis_scale(hal_axis_x).command_pm;
    return pm_saturated((ux_pm + z_pm) / 2u);
}

uint32_t cam_derived_limits_averaging_mrpm(const cam_params_t *params, uint32_t mrpm,
                                           uint32_t tick_hz)
{
    const int64_t counts = params->counts_per_turn;
    const int64_t counts_mhz = counts * mrpm / 60;
    const int64_t tick_mhz = (int64_t)tick_hz * 1000;
    const int64_t whole_mhz = (counts_mhz + tick_mhz / 2) / tick_mhz * tick_mhz;
    const int64_t observer_mhz = params->observer_bandwidth_mHz;
    const int64_t apart_mhz =
        observer_mhz * beat_bandwidths +
        cam_smaller_i64(counts_mhz / beat_ripple, observer_mhz * beat_ripple_bandwidths);
    const int64_t rpm = (whole_mhz - apart_mhz) * 60 / counts / 1000;
    const bool is_averaging = cam_abs_i64(counts_mhz - whole_mhz) >= apart_mhz;
    const bool is_possible = apart_mhz < tick_mhz / 2 && whole_mhz > 0 && !hal_has_edge_time();
    return is_possible && !is_averaging ? (uint32_t)rpm * 1000u : 0u;
}

uint32_t cam_derived_limits_count_pm(const cam_table_t *table, int32_t counts_per_turn)
{
    const uint64_t turn_pm = (uint64_t)table->u1_peak_nm_per_rad * turn_urad / 1000u;
    return pm_saturated(turn_pm / (uint64_t)counts_per_turn);
}
