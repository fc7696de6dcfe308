// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_drive.h" // sim_drive_flow
#include "sim_units.h" // SIM_TWO_PI

void sim_mode_init(sim_mode_t *m, const sim_mode_config_t *config)
{
    *m = (sim_mode_t){
        .omega_rad_per_s = SIM_TWO_PI * config->hz,
        .damping = config->damping,
        .share = config->share,
        .is_on_scale = config->is_on_scale != 0.0,
    };
}

/// Coefficients of a polynomial, the constant first.
typedef struct {
    double c[4];
} cubic_t;

/// @return the cubic through positions and speeds at both ends, relative to the first position
static cubic_t cubic_of(const sim_mode_travel_t *travel, double dt_s)
{
    const double gone = travel->pos_micro[1] - travel->pos_micro[0];
    const double v0 = travel->vel_micro_per_s[0];
    const double v1 = travel->vel_micro_per_s[1];
    return (cubic_t){{
        0.0,
        v0,
        (3.0 * gone - (2.0 * v0 + v1) * dt_s) / (dt_s * dt_s),
        ((v0 + v1) * dt_s - 2.0 * gone) / (dt_s * dt_s * dt_s),
    }};
}

/// @return the polynomial r with r'' + drag r' + w2 r = -x'', a particular motion of y - x
static cubic_t answer_to(const cubic_t *x, double drag, double w2)
{
    const double a0 = -2.0 * x->c[2];
    const double a1 = -6.0 * x->c[3];
    const double r1 = a1 / w2;
    return (cubic_t){{(a0 - drag * r1) / w2, r1, 0.0, 0.0}};
}

void sim_mode_step(sim_mode_t *m, const sim_mode_travel_t *travel, double dt_s)
{
    if (m->omega_rad_per_s == 0.0 || dt_s <= 0.0) {
        return;
    }
    const double w = m->omega_rad_per_s;
    const cubic_t x = cubic_of(travel, dt_s);
    const cubic_t r = answer_to(&x, 2.0 * m->damping * w, w * w);
    const sim_drive_flow_t flow = sim_drive_flow(w, m->damping, dt_s);
    const double off = m->pos_micro - r.c[0];
    const double vel = m->vel_micro_per_s - r.c[1];
    m->pos_micro = r.c[0] + r.c[1] * dt_s + flow.pp * off + flow.pv * vel;
    m->vel_micro_per_s = r.c[1] + flow.vp * off + flow.vv * vel;
}

double sim_mode_tip_micro(const sim_mode_t *m)
{
    return m->share * m->pos_micro;
}
