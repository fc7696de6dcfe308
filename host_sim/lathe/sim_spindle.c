// SPDX-License-Identifier: Apache-2.0
#include "sim_encoder.h"
#include "sim_units.h" // sim_sine, SIM_TWO_PI, sim_clamp
#include <math.h>      // exp
#include <stdbool.h>   // bool

void sim_spindle_init(sim_spindle_t *s, const sim_spindle_config_t *config)
{
    *s = (sim_spindle_t){
        .turn = config->start_turn,
        .limit_rad_per_s2 = config->torque_Nm / config->inertia_kgm2,
        .bandwidth_rad_per_s = config->bandwidth_rad_per_s,
        .ripple = config->ripple,
        .ripple_per_turn = config->ripple_per_turn,
        .ripple_2 = config->ripple_2,
        .ripple_per_turn_2 = config->ripple_per_turn_2,
    };
}

/// Exact solution of the first-order loop; the torque limits the change of the speed.
static double speed_after(const sim_spindle_t *s, double set_rad_per_s, double dt_s)
{
    const double gap = set_rad_per_s - s->speed_rad_per_s;
    if (sim_abs(gap) < 1e-9) { // settled: saves the exponential
        return set_rad_per_s;
    }
    const double limit = s->limit_rad_per_s2 * dt_s;
    const double wanted = gap * (1.0 - exp(-s->bandwidth_rad_per_s * dt_s));
    return s->speed_rad_per_s + sim_clamp(wanted, -limit, limit);
}

/// The ripple is a function of the angle, not of time.
static double rippled(const sim_spindle_t *s, double turn)
{
    const double first = 1.0 + s->ripple * sim_sine(s->ripple_per_turn * turn);
    return s->ripple_2 > 0.0 ? first + s->ripple_2 * sim_sine(s->ripple_per_turn_2 * turn) : first;
}

void sim_spindle_step(sim_spindle_t *s, double set_rad_per_s, double dt_s)
{
    const double after = speed_after(s, set_rad_per_s, dt_s);
    const double mean_turns = 0.5 * (s->speed_rad_per_s + after) * dt_s / SIM_TWO_PI;
    s->speed_rad_per_s = after;
    // The ripple at the middle of the step makes the angle second-order accurate.
    const bool is_rippled = s->ripple > 0.0 || s->ripple_2 > 0.0;
    s->turn += is_rippled ? mean_turns * rippled(s, s->turn + 0.5 * mean_turns) : mean_turns;
}

double sim_spindle_true_rad_per_s(const sim_spindle_t *s)
{
    return s->speed_rad_per_s * rippled(s, s->turn);
}
