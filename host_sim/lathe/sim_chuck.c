// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_units.h" // SIM_TWO_PI, sim_clamp, sim_cosine, sim_round, sim_sine

/// @return [1] share of the spring at a height
static double share_at(const sim_chuck_config_t *c, double z_mm)
{
    const double span_mm = c->jaw_height_mm - c->round_height_mm;
    return span_mm != 0.0 ? sim_clamp((z_mm - c->round_height_mm) / span_mm, 0.0, 1.0) : 1.0;
}

double sim_chuck_sprung_mm(const sim_chuck_config_t *c, double turn, double z_mm)
{
    if (c->spring_um == 0.0) {
        return 0.0;
    }
    const double half_turn = 0.5 / c->jaws; // from midway between two jaws to a jaw
    const double a = SIM_TWO_PI * half_turn;
    const double sin_a = sim_sine(half_turn);
    const double cos_a = sim_cosine(half_turn);
    const double slope = (sin_a + a * cos_a) / (2.0 * sin_a * sin_a);
    const double from_jaw = (turn - c->jaw_deg / 360.0) * c->jaws + 0.5;
    const double x_turn = (from_jaw - sim_round(from_jaw)) / c->jaws;
    const double x = SIM_TWO_PI * x_turn;
    const double out = slope * sim_cosine(x_turn) + 0.5 * x * sim_sine(x_turn) / sin_a - 1.0 / a;
    const double peak_to_valley = 0.5 * a - slope * (1.0 - cos_a);
    return 1e-3 * c->spring_um * share_at(c, z_mm) * out / peak_to_valley;
}
