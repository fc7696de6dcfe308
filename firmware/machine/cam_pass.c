// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_inner.h"
#include "cam_feasible.h" // cam_feasible_check
#include "hal/hal.h"      // hal_has_swing
#include <stdbool.h>      // bool
#include <stddef.h>       // NULL

uint32_t cam_pass_count(const cam_table_t *table)
{
    return table != NULL && table->n_passes > 0u ? table->n_passes : 1u;
}

cam_params_t cam_pass_params(const cam_params_t *params, const cam_table_t *table, uint32_t i)
{
    cam_params_t here = *params;
    if (!hal_has_swing()) {
        here.swing_speed_mdeg_per_s = 0;
    }
    if (table == NULL || table->passes == NULL) {
        return here;
    }
    const cam_pass_t *pass = &table->passes[i];
    here.feed_nm = params->feed_nm > 0 ? params->feed_nm : (int32_t)pass->feed_nm;
    here.spindle_mrpm =
        params->spindle_mrpm > 0 ? params->spindle_mrpm : (int32_t)pass->spindle_mrpm;
    here.x_trim_nm = params->x_trim_nm + pass->allowance_nm;
    return here;
}

uint32_t cam_pass_first(const cam_params_t *params, const cam_table_t *table)
{
    const uint32_t last = cam_pass_count(table) - 1u;
    const uint32_t asked = params->pass > 0 ? (uint32_t)params->pass - 1u : 0u;
    return asked < last ? asked : last;
}

uint32_t cam_pass_next(const cam_params_t *params, const cam_table_t *table, uint32_t i)
{
    const bool is_last = i + 1u >= cam_pass_count(table);
    return params->pass > 0 || is_last ? cam_pass_first(params, table) : i + 1u;
}

/// @return [r/min / 1000] speed of a pass with the override, rounded up; a parameter replaces the
///         table's
static uint32_t speed_mrpm_of(const cam_params_t *params, const cam_table_t *table)
{
    const uint64_t mrpm =
        params->spindle_mrpm > 0 ? (uint64_t)params->spindle_mrpm : table->spindle_mrpm;
    return (uint32_t)((mrpm * (uint64_t)params->spindle_override_ppm + 999999u) / 1000000u);
}

cam_refusal_t cam_pass_feasibility(const cam_table_t *table, const cam_params_t *params,
                                   uint32_t tick_hz, uint32_t i)
{
    const cam_params_t here = cam_pass_params(params, table, i);
    cam_refusal_t found = cam_feasible(table, &here, speed_mrpm_of(&here, table), tick_hz);
    found.pass = table->passes != NULL ? i + 1u : 0u;
    return found;
}

cam_refusal_t cam_pass_check(const cam_table_t *table, const cam_params_t *params, uint32_t tick_hz)
{
    for (uint32_t i = 0; i < cam_pass_count(table); i++) {
        const cam_params_t here = cam_pass_params(params, table, i);
        if (cam_feasible_check(table, &here, speed_mrpm_of(&here, table), tick_hz) != cam_ok) {
            return cam_pass_feasibility(table, params, tick_hz, i);
        }
    }
    return cam_refusal_none();
}

uint32_t cam_pass_highest_mrpm(const cam_table_t *table, const cam_params_t *params,
                               uint32_t tick_hz)
{
    uint32_t least_mrpm = UINT32_MAX;
    for (uint32_t k = 0; k < cam_pass_count(table); k++) {
        const cam_params_t here = cam_pass_params(params, table, k);
        const uint32_t mrpm = cam_feasible_highest_mrpm(table, &here, tick_hz);
        least_mrpm = mrpm < least_mrpm ? mrpm : least_mrpm;
    }
    return least_mrpm;
}
