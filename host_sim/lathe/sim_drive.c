// SPDX-License-Identifier: Apache-2.0
#include "sim_drive.h"
#include "sim_units.h" // sim_round, sim_clamp, SIM_TWO_PI
#include <math.h>      // cos, cosh, exp, INFINITY, sqrt

enum { n_sub_steps = 16 };

/// The even and odd parts of e^(r t) about -d w: cos and sin(q t) / q, cosh and sinh(q t) / q, or 1
/// and t.
static void even_odd(double omega, double damping, double t, double *even, double *odd)
{
    const double below = 1.0 - damping * damping;
    const double q = omega * sqrt(sim_abs(below));
    if (q * t < 1e-8) {
        *even = 1.0;
        *odd = t;
    } else if (below > 0.0) {
        *even = cos(q * t);
        *odd = sin(q * t) / q;
    } else {
        *even = cosh(q * t);
        *odd = sinh(q * t) / q;
    }
}

sim_drive_flow_t sim_drive_flow(double omega_rad_per_s, double damping, double time_s)
{
    double even;
    double odd;
    even_odd(omega_rad_per_s, damping, time_s, &even, &odd);
    const double decay = exp(-damping * omega_rad_per_s * time_s);
    const double half = damping * omega_rad_per_s * odd;
    return (sim_drive_flow_t){
        .pp = decay * (even + half),
        .pv = decay * odd,
        .vp = -decay * omega_rad_per_s * omega_rad_per_s * odd,
        .vv = decay * (even - half),
        .time_s = time_s,
    };
}

static void set_dead_time(sim_drive_t *d, const sim_drive_config_t *config)
{
    const double omega = SIM_TWO_PI * config->bandwidth_hz;
    const double delay_ticks = config->delay_us * 1e-6 / d->period_s;
    double part = sim_fraction(delay_ticks);
    d->n_delay = (uint32_t)sim_floor(delay_ticks);
    if (part > 1.0 - 1e-9) { // 75 us of 25 us ticks is 2.9999999999999996
        d->n_delay++;
        part = 0.0;
    }
    d->is_split = part > 1e-9;
    part = d->is_split ? part : 0.0;
    d->before = sim_drive_flow(omega, config->damping, part * d->period_s);
    d->after = sim_drive_flow(omega, config->damping, (1.0 - part) * d->period_s);
}

static double quantised(const sim_drive_t *d, double micro)
{
    return d->quantum_micro > 0.0 ? sim_round(micro * d->per_quantum_micro) * d->quantum_micro
                                  : micro;
}

/// @return the command, rounded to its own quantum
static double commanded(const sim_drive_t *d, double micro)
{
    const double quantum = d->command_quantum_micro;
    return quantum > 0.0 ? sim_round(micro / quantum) * quantum : quantised(d, micro);
}

static sim_friction_law_t law_of(const sim_drive_t *d, const sim_drive_config_t *config)
{
    sim_friction_law_t law = {
        .stiffness_per_s2 = d->stiffness_per_s2,
        .drag_per_s = d->drag_per_s,
        .acceleration_micro_per_s2 = d->acceleration_micro_per_s2,
        .speed_micro_per_s = d->speed_micro_per_s,
        .friction_micro_per_s2 = config->friction_m_per_s2 * SIM_DRIVE_MICRO_PER_M,
    };
    if (d->is_force) { // the force is limited, not the acceleration
        law.stiffness_per_s2 = config->stiffness_n_per_m / config->mass_kg;
        law.drag_per_s = config->viscous_n_s_per_m / config->mass_kg;
        law.acceleration_micro_per_s2 = INFINITY;
        law.lag_per_s = SIM_TWO_PI * config->amplifier_hz;
        law.stop_micro = config->stop_units * SIM_MICRO;
        law.stop_per_s2 = config->stop_n_per_um * 1e6 / config->mass_kg;
    }
    law.longest_s = sim_friction_longest_s(&law);
    return law;
}

void sim_drive_init(sim_drive_t *d, const sim_drive_config_t *config, double start_micro,
                    double period_s)
{
    const double omega = SIM_TWO_PI * config->bandwidth_hz;
    *d = (sim_drive_t){
        .pos_micro = start_micro,
        .stiffness_per_s2 = omega * omega,
        .drag_per_s = 2.0 * config->damping * omega,
        .speed_micro_per_s = config->speed_units_per_s * SIM_MICRO,
        .acceleration_micro_per_s2 = config->acceleration_units_per_s2 * SIM_MICRO,
        .quantum_micro = config->quantum_micro,
        .per_quantum_micro = config->quantum_micro > 0.0 ? 1.0 / config->quantum_micro : 0.0,
        .period_s = period_s,
        .command_quantum_micro = config->command_quantum_micro,
        .per_force_micro_per_s2 =
            config->mass_kg > 0.0 ? SIM_DRIVE_MICRO_PER_M / config->mass_kg : 0.0,
        .force_limit_n = config->force_limit_n,
        .is_force = config->kind == sim_drive_force,
        .is_relative = config->is_relative != 0.0,
    };
    d->law = law_of(d, config);
    set_dead_time(d, config);
    for (uint32_t i = 0; i < sim_drive_ring; i++) {
        d->command_micro[i] = d->is_force ? 0.0 : commanded(d, start_micro);
    }
}

/// Acceleration of the unlimited system at a position and speed.
static double acceleration(const sim_drive_t *d, double pos_micro, double vel, double command_micro)
{
    return d->stiffness_per_s2 * (command_micro - pos_micro) - d->drag_per_s * vel;
}

/// Move with constant acceleration and limited speed.
static void move(sim_drive_t *d, double acceleration_micro_per_s2, double dt_s)
{
    const double wanted = d->vel_micro_per_s + acceleration_micro_per_s2 * dt_s;
    const double vel = sim_clamp(wanted, -d->speed_micro_per_s, d->speed_micro_per_s);
    d->pos_micro += 0.5 * (d->vel_micro_per_s + vel) * dt_s;
    d->vel_micro_per_s = vel;
}

static double limited_acceleration(const sim_drive_t *d, double pos_micro, double vel,
                                   double command_micro)
{
    return sim_clamp(acceleration(d, pos_micro, vel, command_micro), -d->acceleration_micro_per_s2,
                     d->acceleration_micro_per_s2);
}

static void limited_piece(sim_drive_t *d, double command_micro, double time_s)
{
    const double h = time_s / n_sub_steps;
    for (int i = 0; i < n_sub_steps; i++) { // midpoint acceleration: second order
        const double first =
            limited_acceleration(d, d->pos_micro, d->vel_micro_per_s, command_micro);
        const double pos_micro = d->pos_micro + 0.5 * h * (d->vel_micro_per_s + 0.25 * h * first);
        const double vel = d->vel_micro_per_s + 0.5 * h * first;
        move(d, limited_acceleration(d, pos_micro, vel, command_micro), h);
    }
}

static bool is_beyond(double value, double limit)
{
    return sim_abs(value) > limit;
}

/// Move in sub-steps against friction and an external force; noinline keeps the exact path short.
__attribute__((noinline)) static void rough_piece(sim_drive_t *d, double command_micro,
                                                  double time_s)
{
    sim_friction_state_t s = {d->pos_micro, d->vel_micro_per_s, d->push_micro_per_s2};
    const double input = d->is_force ? command_micro : d->stiffness_per_s2 * command_micro;
    sim_friction_move(&d->law, &s, input, d->disturb_micro_per_s2, time_s);
    d->pos_micro = s.pos_micro;
    d->vel_micro_per_s = s.vel_micro_per_s;
    d->push_micro_per_s2 = s.push_micro_per_s2;
}

static void piece(sim_drive_t *d, double command_micro, const sim_drive_flow_t *flow)
{
    if (d->is_force || d->law.friction_micro_per_s2 > 0.0 || d->disturb_micro_per_s2 != 0.0) {
        rough_piece(d, command_micro, flow->time_s);
        return;
    }
    const double limit = d->acceleration_micro_per_s2;
    const double off_micro = d->pos_micro - command_micro;
    if (off_micro == 0.0 && d->vel_micro_per_s == 0.0) { // at rest at the command
        return;
    }
    const double pos_micro = command_micro + flow->pp * off_micro + flow->pv * d->vel_micro_per_s;
    const double vel = flow->vp * off_micro + flow->vv * d->vel_micro_per_s;
    if (is_beyond(acceleration(d, d->pos_micro, d->vel_micro_per_s, command_micro), limit) ||
        is_beyond(acceleration(d, pos_micro, vel, command_micro), limit) ||
        is_beyond(vel, d->speed_micro_per_s)) {
        limited_piece(d, command_micro, flow->time_s);
        return;
    }
    d->pos_micro = pos_micro;
    d->vel_micro_per_s = vel;
}

static void brake(sim_drive_t *d, double dt_s)
{
    const double limit = d->acceleration_micro_per_s2;
    d->push_micro_per_s2 = 0.0;
    if (d->vel_micro_per_s != 0.0) {
        move(d, sim_clamp(-d->vel_micro_per_s / dt_s, -limit, limit), dt_s);
    }
}

static double delayed(const sim_drive_t *d, uint32_t ticks)
{
    return d->command_micro[(d->i_command - ticks) % sim_drive_ring];
}

/// @return the force of the next step per mass
static double pushed(const sim_drive_t *d, bool is_enabled)
{
    const double force_n = sim_clamp(d->force_n, -d->force_limit_n, d->force_limit_n);
    return is_enabled ? force_n * d->per_force_micro_per_s2 : 0.0;
}

/// A relative drive stands still at enable, whatever is commanded, and moves by what is added.
static void begin_relative(sim_drive_t *d, double command_micro)
{
    d->origin_micro = d->pos_micro - command_micro;
    for (uint32_t i = 0; i < (uint32_t)sim_drive_ring && !d->is_force; i++) {
        d->command_micro[i] = d->pos_micro;
    }
}

/// Append a command to the delay line.
static void take(sim_drive_t *d, int32_t command_micro, bool is_enabled)
{
    const double input = commanded(d, command_micro);
    if (d->is_relative && is_enabled && !d->was_enabled) {
        begin_relative(d, input);
    }
    d->was_enabled = is_enabled;
    const double command = input + d->origin_micro;
    d->i_command++;
    d->command_micro[d->i_command % sim_drive_ring] = d->is_force ? pushed(d, is_enabled) : command;
    d->middle_s = 0.0;
}

void sim_drive_step(sim_drive_t *d, int32_t command_micro, bool is_enabled)
{
    take(d, command_micro, is_enabled);
    if (d->is_blocked) {
        d->vel_micro_per_s = 0.0;
    } else if (!is_enabled) {
        brake(d, d->period_s);
    } else {
        if (d->is_split) {
            piece(d, delayed(d, d->n_delay + 1u), &d->before);
            d->middle = (sim_drive_place_t){d->pos_micro, d->vel_micro_per_s};
            d->middle_s = d->before.time_s;
        }
        piece(d, delayed(d, d->n_delay), &d->after);
    }
}

void sim_drive_disturb(sim_drive_t *d, double force_n)
{
    d->disturb_micro_per_s2 = force_n * d->per_force_micro_per_s2;
}

/// Move for any time with the command of some ticks ago.
static void move_for(sim_drive_t *d, uint32_t ticks, double dt_s)
{
    const double omega = sqrt(d->stiffness_per_s2);
    const sim_drive_flow_t flow = sim_drive_flow(omega, 0.5 * d->drag_per_s / omega, dt_s);
    piece(d, delayed(d, ticks), &flow);
}

void sim_drive_step_in(sim_drive_t *d, int32_t command_micro, bool is_enabled, double dt_s)
{
    take(d, command_micro, is_enabled);
    if (d->is_blocked) {
        d->vel_micro_per_s = 0.0;
    } else if (!is_enabled) {
        brake(d, dt_s);
    } else {
        const double first_s = d->is_split ? fmin(d->before.time_s, dt_s) : 0.0;
        if (first_s > 0.0) {
            move_for(d, d->n_delay + 1u, first_s);
            d->middle = (sim_drive_place_t){d->pos_micro, d->vel_micro_per_s};
            d->middle_s = first_s;
        }
        if (dt_s > first_s) {
            move_for(d, d->n_delay, dt_s - first_s);
        }
    }
}

void sim_drive_linger(sim_drive_t *d, double dt_s, bool is_enabled)
{
    if (d->is_blocked || dt_s <= 0.0) {
        return;
    }
    if (!is_enabled) {
        brake(d, dt_s);
        return;
    }
    move_for(d, d->n_delay, dt_s);
}

int32_t sim_drive_reported_micro(const sim_drive_t *d, double micro)
{
    return (int32_t)sim_round(sim_clamp(quantised(d, micro), INT32_MIN, INT32_MAX));
}

int32_t sim_drive_measured_micro(const sim_drive_t *d)
{
    return sim_drive_reported_micro(d, d->pos_micro);
}
