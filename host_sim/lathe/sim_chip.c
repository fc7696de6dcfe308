// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_units.h" // sim_abs

/// Below this speed the spindle counts as stopped, without a chip.
#define LEAST_TURNS_PER_S 1e-3

double sim_chip_force_n(const sim_chip_config_t *c, double depth_mm, double z_mm_per_s,
                        double turns_per_s)
{
    if (depth_mm <= 0.0 || sim_abs(turns_per_s) < LEAST_TURNS_PER_S) {
        return 0.0;
    }
    const double thick_mm = sim_abs(z_mm_per_s) / sim_abs(turns_per_s);
    return c->kc_n_per_mm2 * c->radial_share * depth_mm * thick_mm;
}

double sim_chip_bend_um(const sim_chip_config_t *c, double force_n)
{
    return c->tool_stiffness_n_per_um > 0.0 ? force_n / c->tool_stiffness_n_per_um : 0.0;
}
