// SPDX-License-Identifier: Apache-2.0
#include "sim_encoder.h"
#include "sim_units.h" // sim_sine, sim_floor

void sim_scale_init(sim_scale_t *s, const sim_scale_config_t *config, double pos_micro,
                    double step_s)
{
    *s = (sim_scale_t){
        .latency_steps = config->latency_us * 1e-6 / step_s,
        .error_micro = config->error_nm,
        .periods_per_micro = 2.0 / (config->period_um * 1e3),
        .step_s = step_s,
    };
    for (int i = 0; i < sim_scale_ring; i++) {
        s->pos_micro[i] = pos_micro;
    }
}

void sim_scale_push(sim_scale_t *s, double pos_micro, double vel_micro_per_s)
{
    s->i = (s->i + 1u) % sim_scale_ring;
    s->pos_micro[s->i] = pos_micro;
    s->vel_micro_per_s[s->i] = vel_micro_per_s;
}

/// @return [micro] position `latency_steps` ago, by the cubic between the neighbouring steps
static double earlier(const sim_scale_t *s)
{
    const uint32_t whole = (uint32_t)sim_floor(s->latency_steps);
    const double x = 1.0 - (s->latency_steps - whole); // 1 at the younger of the two
    const uint32_t young = (s->i + sim_scale_ring - whole) % sim_scale_ring;
    const uint32_t old = (young + sim_scale_ring - 1u) % sim_scale_ring;
    const double p0 = s->pos_micro[old];
    const double gone = s->pos_micro[young] - p0;
    const double v0 = s->vel_micro_per_s[old] * s->step_s;
    const double v1 = s->vel_micro_per_s[young] * s->step_s;
    const double square = 3.0 * gone - 2.0 * v0 - v1;
    const double cube = v0 + v1 - 2.0 * gone;
    return p0 + x * (v0 + x * (square + x * cube));
}

static double shown(const sim_scale_t *s, double seen_micro)
{
    return s->error_micro > 0.0
               ? seen_micro + s->error_micro * sim_sine(s->periods_per_micro * seen_micro)
               : seen_micro;
}

double sim_scale_read_micro(const sim_scale_t *s)
{
    return shown(s, s->latency_steps > 0.0 ? earlier(s) : s->pos_micro[s->i]);
}
