// SPDX-License-Identifier: Apache-2.0
#include "cam_resolution_limit.h"
#include "hal/hal.h" // hal_axis_scale
#include <stddef.h>  // NULL

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

uint32_t cam_resolution_limit_form_pm(const cam_table_t *table)
{
    const uint64_t z_pm = hal_axis_scale(hal_axis_z).command_pm * part_slope_ppm(table) / 1000000u;
    const uint64_t ux_pm =
        (uint64_t)hal_axis_scale(hal_axis_u).command_pm + hal_axis_scale(hal_axis_x).command_pm;
    return pm_saturated((ux_pm + z_pm) / 2u);
}

uint32_t cam_resolution_limit_count_pm(const cam_table_t *table, int32_t counts_per_turn)
{
    const uint64_t turn_pm = (uint64_t)table->u1_peak_nm_per_rad * turn_urad / 1000u;
    return pm_saturated(turn_pm / (uint64_t)counts_per_turn);
}
