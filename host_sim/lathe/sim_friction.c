// SPDX-License-Identifier: Apache-2.0
#include "sim_drive.h"
#include "sim_units.h" // sim_abs, sim_clamp
#include <math.h>      // ceil, exp, fmax, sqrt
#include <stdbool.h>   // bool

enum { least_sub_steps = 4, most_reversals = 4, halvings = 40 };

double sim_friction_longest_s(const sim_friction_law_t *law)
{
    const double stop_per_s = law->stop_micro > 0.0 ? 2.0 * sqrt(law->stop_per_s2) : 0.0;
    const double fastest_per_s = law->drag_per_s + law->lag_per_s + sqrt(law->stiffness_per_s2) +
                                 stop_per_s; // above every pole's magnitude
    return fastest_per_s > 0.0 ? 0.25 / fastest_per_s : 1.0;
}

/// Forces on the slide except friction, per mass.
typedef struct {
    const sim_friction_law_t *law;
    double input, disturb;
} act_t;

/// @return acceleration by the stops, which push and never pull
static double by_stop(const sim_friction_law_t *law, const sim_friction_state_t *s)
{
    const double beyond = sim_abs(s->pos_micro) - law->stop_micro;
    if (law->stop_micro <= 0.0 || beyond <= 0.0) {
        return 0.0;
    }
    const double sign = s->pos_micro > 0.0 ? 1.0 : -1.0;
    const double damping = sqrt(law->stop_per_s2) * sign * s->vel_micro_per_s;
    return -sign * fmax(0.0, law->stop_per_s2 * beyond + damping);
}

static double acceleration(const act_t *a, const sim_friction_state_t *s)
{
    const sim_friction_law_t *law = a->law;
    const double wanted = s->push_micro_per_s2 - law->stiffness_per_s2 * s->pos_micro -
                          law->drag_per_s * s->vel_micro_per_s;
    const double limit = law->acceleration_micro_per_s2;
    return sim_clamp(wanted, -limit, limit) + a->disturb + by_stop(law, s);
}

static sim_friction_state_t rate(const act_t *a, const sim_friction_state_t *s, double friction)
{
    return (sim_friction_state_t){
        .pos_micro = s->vel_micro_per_s,
        .vel_micro_per_s = acceleration(a, s) - friction,
        .push_micro_per_s2 = (a->input - s->push_micro_per_s2) * a->law->lag_per_s,
    };
}

static sim_friction_state_t ahead(const sim_friction_state_t *s, const sim_friction_state_t *rate_,
                                  double h_s)
{
    return (sim_friction_state_t){
        .pos_micro = s->pos_micro + h_s * rate_->pos_micro,
        .vel_micro_per_s = s->vel_micro_per_s + h_s * rate_->vel_micro_per_s,
        .push_micro_per_s2 = s->push_micro_per_s2 + h_s * rate_->push_micro_per_s2,
    };
}

/// One step of the classical Runge-Kutta method.
/// @param friction  [micro/s2] signed, constant
static sim_friction_state_t after(const act_t *a, const sim_friction_state_t *s, double friction,
                                  double h_s)
{
    const sim_friction_state_t r1 = rate(a, s, friction);
    const sim_friction_state_t s2 = ahead(s, &r1, 0.5 * h_s);
    const sim_friction_state_t r2 = rate(a, &s2, friction);
    const sim_friction_state_t s3 = ahead(s, &r2, 0.5 * h_s);
    const sim_friction_state_t r3 = rate(a, &s3, friction);
    const sim_friction_state_t s4 = ahead(s, &r3, h_s);
    const sim_friction_state_t r4 = rate(a, &s4, friction);
    const sim_friction_state_t mean = {
        .pos_micro = (r1.pos_micro + 2.0 * (r2.pos_micro + r3.pos_micro) + r4.pos_micro) / 6.0,
        .vel_micro_per_s = (r1.vel_micro_per_s + 2.0 * (r2.vel_micro_per_s + r3.vel_micro_per_s) +
                            r4.vel_micro_per_s) /
                           6.0,
        .push_micro_per_s2 =
            (r1.push_micro_per_s2 + 2.0 * (r2.push_micro_per_s2 + r3.push_micro_per_s2) +
             r4.push_micro_per_s2) /
            6.0,
    };
    return ahead(s, &mean, h_s);
}

/// @return [s] time, below h_s, at which the speed crosses zero
static double reversal_s(const act_t *a, const sim_friction_state_t *s, double sign,
                         double friction, double h_s)
{
    double low = 0.0;
    double high = h_s;
    for (int i = 0; i < halvings; i++) {
        const double middle = 0.5 * (low + high);
        const bool is_before = sign * after(a, s, friction, middle).vel_micro_per_s >= 0.0;
        low = is_before ? middle : low;
        high = is_before ? high : middle;
    }
    return low;
}

/// Limit the speed; the travel is then that of the mean speed.
static void keep_speed(const sim_friction_law_t *law, sim_friction_state_t *s, double from_pos,
                       double from_vel, double h_s)
{
    const double limit = law->speed_micro_per_s;
    if (sim_abs(s->vel_micro_per_s) > limit) {
        s->vel_micro_per_s = sim_clamp(s->vel_micro_per_s, -limit, limit);
        s->pos_micro = from_pos + 0.5 * (from_vel + s->vel_micro_per_s) * h_s;
    }
}

/// One sub-step, split at reversals.
static void sub_step(const act_t *a, sim_friction_state_t *s, double h_s)
{
    const double friction = a->law->friction_micro_per_s2;
    for (int i = 0; i < most_reversals && h_s > 0.0; i++) {
        double sign = s->vel_micro_per_s > 0.0 ? 1.0 : -1.0;
        if (s->vel_micro_per_s == 0.0) {
            const double force = acceleration(a, s);
            if (friction > 0.0 && sim_abs(force) <= friction) {
                break;
            }
            sign = force > 0.0 ? 1.0 : -1.0;
        }
        const sim_friction_state_t from = *s;
        *s = after(a, &from, sign * friction, h_s);
        if (friction <= 0.0 || sign * s->vel_micro_per_s >= 0.0) {
            keep_speed(a->law, s, from.pos_micro, from.vel_micro_per_s, h_s);
            return;
        }
        const double moving_s = reversal_s(a, &from, sign, sign * friction, h_s);
        *s = after(a, &from, sign * friction, moving_s);
        s->vel_micro_per_s = 0.0;
        h_s -= moving_s;
    }
    // The slide sticks: only the push changes.
    const double decay = exp(-a->law->lag_per_s * h_s);
    s->push_micro_per_s2 = a->input + (s->push_micro_per_s2 - a->input) * decay;
}

void sim_friction_move(const sim_friction_law_t *law, sim_friction_state_t *s,
                       double input_micro_per_s2, double disturb_micro_per_s2, double time_s)
{
    const double wanted = ceil(time_s / law->longest_s);
    const int n = wanted > least_sub_steps ? (int)wanted : least_sub_steps;
    const act_t act = {law, input_micro_per_s2, disturb_micro_per_s2};
    if (law->lag_per_s == 0.0) {
        s->push_micro_per_s2 = input_micro_per_s2;
    }
    for (int i = 0; i < n; i++) {
        sub_step(&act, s, time_s / n);
    }
}
