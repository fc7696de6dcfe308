// SPDX-License-Identifier: Apache-2.0
#include "sim_servo.h"
#include "sim_units.h" // sim_abs, sim_clamp, SIM_TWO_PI
#include <complex.h>   // cexp, I
#include <math.h>      // exp, INFINITY

/// Corners of the speed filter and of the integral, relative to w.
#define FILTER_PER_W 8.0
#define SUM_PER_W 0.005

/// The fit: lines from FIRST_HZ on, dead times in steps up to LONGEST_S.
enum { n_lines = 60, n_steps = 400 };
#define FIRST_HZ 20.0
#define LONGEST_S 2e-3

void sim_servo_init(sim_servo_t *s, const sim_drive_config_t *config, double period_s)
{
    const double w = SIM_TWO_PI * config->bandwidth_hz;
    const double tuned = config->tuned_mass_kg / config->mass_kg;
    const double drag_per_s = config->viscous_n_s_per_m / config->mass_kg;
    *s = (sim_servo_t){
        .kp_per_s2 = tuned * w * w,
        .kd_per_s = tuned * 2.0 * config->damping * w - drag_per_s,
        .ki_per_s3 = tuned * w * w * w * SUM_PER_W,
        .filter = 1.0 - exp(-FILTER_PER_W * w * period_s),
        .limit_micro_per_s2 = config->force_limit_n / config->mass_kg * SIM_DRIVE_MICRO_PER_M,
        .period_s = period_s,
    };
}

double sim_servo_push(sim_servo_t *s, double command_micro, double read_micro)
{
    if (!s->is_running) {
        s->is_running = true;
        s->last_micro = read_micro;
        s->speed_micro_per_s = 0.0;
        s->sum_micro_per_s2 = 0.0;
    }
    const double difference = (read_micro - s->last_micro) / s->period_s;
    const double off = command_micro - read_micro;
    s->last_micro = read_micro;
    s->speed_micro_per_s += s->filter * (difference - s->speed_micro_per_s);
    const double sum = s->sum_micro_per_s2 + s->ki_per_s3 * s->period_s * off;
    const double push = s->kp_per_s2 * off + sum - s->kd_per_s * s->speed_micro_per_s;
    if (sim_abs(push) <= s->limit_micro_per_s2) {
        s->sum_micro_per_s2 = sum;
    }
    return sim_clamp(push, -s->limit_micro_per_s2, s->limit_micro_per_s2);
}

void sim_servo_rest(sim_servo_t *s)
{
    s->is_running = false;
}

/// @return the inverse of the closed loop's frequency response
static double complex inverse_at(const sim_drive_config_t *c, const sim_servo_t *s, double omega)
{
    const double complex p = I * omega;
    const double complex back = 1.0 - cexp(-p * s->period_s); // 1 - 1 / z
    const double complex to_force = s->kp_per_s2 + s->ki_per_s3 * s->period_s / back;
    const double complex speed =
        back / s->period_s * s->filter / (1.0 - (1.0 - s->filter) * (1.0 - back));
    const double complex plant =
        p * p + p * c->viscous_n_s_per_m / c->mass_kg + c->stiffness_n_per_m / c->mass_kg;
    const double complex lag = (1.0 + p / (SIM_TWO_PI * c->amplifier_hz)) *
                               cexp(p * (c->delay_us * 1e-6 + 0.5 * s->period_s));
    return 1.0 + (plant * lag + s->kd_per_s * speed) / to_force;
}

/// Data of the fit.
typedef struct {
    double omega[n_lines];
    double complex inverse[n_lines];
} lines_t;

/// The two constants that fit best for a dead time. @return mean square of the relative error
static double fit(const lines_t *lines, double lead_s, sim_servo_equivalent_t *fitted)
{
    double w2 = 0.0;
    double w4 = 0.0;
    double sum_k1 = 0.0;
    double sum_k2 = 0.0;
    for (int i = 0; i < n_lines; i++) {
        const double w = lines->omega[i];
        const double complex off = cexp(-I * w * lead_s) * lines->inverse[i] - 1.0;
        w2 += w * w;
        w4 += w * w * w * w;
        sum_k1 += w * cimag(off);
        sum_k2 -= w * w * creal(off);
    }
    *fitted = (sim_servo_equivalent_t){.k1_s = sum_k1 / w2, .k2_s2 = sum_k2 / w4, .lead_s = lead_s};
    double error = 0.0;
    for (int i = 0; i < n_lines; i++) {
        const double w = lines->omega[i];
        const double complex off = cexp(-I * w * lead_s) * lines->inverse[i] - 1.0 -
                                   I * w * fitted->k1_s + w * w * fitted->k2_s2;
        error += creal(off) * creal(off) + cimag(off) * cimag(off);
    }
    return error / n_lines;
}

sim_servo_equivalent_t sim_servo_equivalent(const sim_drive_config_t *config, double period_s)
{
    sim_servo_t servo;
    lines_t lines;
    sim_servo_init(&servo, config, period_s);
    const double first = SIM_TWO_PI * FIRST_HZ;
    const double last = SIM_TWO_PI * (config->bandwidth_hz > 2.0 * FIRST_HZ ? config->bandwidth_hz
                                                                            : 2.0 * FIRST_HZ);
    for (int i = 0; i < n_lines; i++) {
        lines.omega[i] = first + (last - first) * i / (n_lines - 1);
        lines.inverse[i] = inverse_at(config, &servo, lines.omega[i]);
    }
    // The error has several minima over the dead time; only those with positive constants count.
    sim_servo_equivalent_t best = {0};
    double least = INFINITY;
    for (int i = 0; i <= n_steps; i++) {
        sim_servo_equivalent_t fitted;
        const double error = fit(&lines, LONGEST_S * i / n_steps, &fitted);
        if (error < least && fitted.k1_s >= 0.0 && fitted.k2_s2 >= 0.0) {
            least = error;
            best = fitted;
        }
    }
    return best;
}
