// SPDX-License-Identifier: Apache-2.0
// Drives and an oscillator for Python, which judge loops and fits: drive_plant.py. They share no
// code with the simulator.
#include <math.h>   // copysign, fabs, rint
#include <stddef.h> // size_t
#include <stdint.h> // int32_t

#define EXPORTED __attribute__((visibility("default")))

enum { most_delay = 256 };

/// A force drive in steps of 2.5 us: mass, dry friction with rest, amplifier, delay, mode.
typedef struct {
    double mass_kg, friction_n;
    double lag; ///< share by which the force approaches its command in a step
    double mode_rad_per_s, mode_damping, mode_share;
    double pos_m, vel_m_per_s, force_n;
    double mode_m, mode_m_per_s; ///< what the mode adds to the scale
    int32_t delay, i;            ///< [steps] delay of a command; place of the next one
    double commands_n[most_delay];
} force_drive_t;

static const double sub_s = 2.5e-6;

/// Move the drive over n steps of 2.5 us by a command [N] and a force from outside [N].
EXPORTED void force_drive_move(force_drive_t *d, double command_n, double outer_n, int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        d->commands_n[d->i] = command_n;
        const double late_n = d->commands_n[(d->i + most_delay - d->delay) % most_delay];
        d->i = (d->i + 1) % most_delay;
        d->force_n += d->lag * (late_n - d->force_n);
        const double push_n = d->force_n + outer_n;
        const double free_m_per_s = d->vel_m_per_s + sub_s * push_n / d->mass_kg;
        const double held = sub_s * d->friction_n / d->mass_kg; // at most all of the speed
        const double left = fmax(0.0, fabs(free_m_per_s) - held);
        const double vel_m_per_s = copysign(left, free_m_per_s);
        const double acc = (vel_m_per_s - d->vel_m_per_s) / sub_s;
        d->pos_m += sub_s * 0.5 * (vel_m_per_s + d->vel_m_per_s);
        d->vel_m_per_s = vel_m_per_s;
        const double w = d->mode_rad_per_s;
        const double back = w * w * d->mode_m + 2.0 * d->mode_damping * w * d->mode_m_per_s;
        d->mode_m_per_s -= sub_s * (d->mode_share * acc + back);
        d->mode_m += sub_s * d->mode_m_per_s;
    }
}

/// A position drive whose linear part flows exactly over a step; states y, v of slide and mode.
typedef struct {
    double flow[4][4], given[4]; ///< of a step
    double kick_nm_per_s;        ///< speed that friction takes in half a step
    double friction_nm_per_s2, stiffness_per_s2, gain, mode_share, quantum_nm;
    int32_t delay, n_steps; ///< [steps]; steps of a tick
} position_drive_t;

static double rounded(double value, double quantum)
{
    return rint(value / quantum) * quantum;
}

/// Take the speed that friction takes in half a step; the mode feels it as any acceleration.
static void rub(const position_drive_t *d, double s[4])
{
    const double loss = copysign(fmin(fabs(s[1]), d->kick_nm_per_s), s[1]);
    s[1] -= loss;
    s[3] += d->mode_share * loss;
}

/// Play set-points [nm] of n ticks; positions [nm] at the ticks are written to y_nm.
EXPORTED void position_drive_play(const position_drive_t *d, const double *u_nm, int32_t n,
                                  double *y_nm)
{
    double s[4] = {0.0};
    for (int32_t i = 0; i < n * d->n_steps; i++) {
        if (i % d->n_steps == 0) {
            y_nm[i / d->n_steps] = rounded(s[0] + s[2], d->quantum_nm);
        }
        const double set_nm = i < d->delay ? 0.0 : u_nm[(i - d->delay) / d->n_steps];
        const double command_nm = rounded(set_nm, d->quantum_nm);
        const double push = fabs(d->gain * command_nm - s[0]) * d->stiffness_per_s2;
        const int stands = fabs(s[1]) <= 0.0 && push <= d->friction_nm_per_s2;
        const double before_nm = s[0];
        rub(d, s);
        double after[4];
        for (size_t row = 0; row < 4; row++) {
            after[row] = d->given[row] * command_nm;
            for (size_t column = 0; column < 4; column++) {
                after[row] += d->flow[row][column] * s[column];
            }
        }
        rub(d, after);
        for (size_t row = 0; row < 4; row++) {
            s[row] = after[row];
        }
        if (stands) {
            s[3] += d->mode_share * s[1];
            s[1] = 0.0;
            s[0] = before_nm;
        }
    }
}

/// Mass, damper and spring, which may harden.
typedef struct {
    double mass_kg, viscous_n_s_per_m, stiffness_n_per_m, cubic_n_per_m3;
} oscillator_t;

static double bend(const oscillator_t *o, double x, double v, double force_n)
{
    const double spring_n = o->stiffness_n_per_m * x + o->cubic_n_per_m3 * x * x * x;
    return (force_n - o->viscous_n_s_per_m * v - spring_n) / o->mass_kg;
}

/// Write the positions [m] at n forces [N], by Runge and Kutta in steps of h_s.
EXPORTED void oscillator_play(const oscillator_t *o, const double *force_n, int32_t n, double h_s,
                              double *x_m)
{
    double x = 0.0, v = 0.0;
    for (int32_t i = 0; i < n; i++) {
        x_m[i] = x;
        const double now_n = force_n[i], next_n = i + 1 < n ? force_n[i + 1] : 0.0;
        const double middle_n = (now_n + next_n) / 2.0, half_s = h_s / 2.0;
        const double a = bend(o, x, v, now_n);
        const double b = bend(o, x + half_s * v, v + half_s * a, middle_n);
        const double c = bend(o, x + half_s * v + half_s * half_s * a, v + half_s * b, middle_n);
        const double d = bend(o, x + h_s * v + h_s * half_s * b, v + h_s * c, next_n);
        x += h_s * v + h_s * h_s / 6.0 * (a + b + c);
        v += h_s / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
}

/// Write the positions [m] of a drive that accelerates at most so much, by Euler: w_rad_per_s and a
/// damping of 0.7, 20 steps of h_s for each of n set-points.
EXPORTED void limited_drive_play(double w_rad_per_s, double most_m_per_s2, const double *u_m,
                                 int32_t n, double h_s, double *y_m)
{
    double y = 0.0, v = 0.0;
    for (int32_t i = 0; i < n * 20; i++) {
        if (i % 20 == 0) {
            y_m[i / 20] = y;
        }
        const double w = w_rad_per_s, a = w * w * (u_m[i / 20] - y) - 1.4 * w * v;
        v += h_s * fmin(fmax(a, -most_m_per_s2), most_m_per_s2);
        y += h_s * v;
    }
}
