// SPDX-License-Identifier: Apache-2.0
#include "learn_plant.h"
#include <math.h>
#include <string.h>

enum { n_steps = 4 };

static double omega(double hz)
{
    return 2.0 * M_PI * hz;
}

static int32_t q16(double v)
{
    return (int32_t)floor(v * 65536.0 + 0.5);
}

static double lead_ticks(const learn_plant_t *p)
{
    return p->what.believed.delay_us * 1e-6 * p->what.tick_hz + 0.5;
}

static void set_up(learn_plant_t *p)
{
    const learn_drive_t *b = &p->what.believed;
    const double hz = p->what.tick_hz;
    const double w = omega(b->bandwidth_hz);
    const double due = lead_ticks(p) + b->latency_us * 1e-6 * hz;
    const double part = due - floor(due);
    p->setup = (cam_ilc_setup_t){
        .angle_step_q23 = INT16_MAX,
        .observer_step_q23 = INT16_MAX,
        .reason = cam_ilc_all,
        .n_harmonics = 16,
        .gain_q16 = 32768,
        .cut_gain_q16 = 9830,
        .probe_q6 = 1000 * 64,
        .scale_nm = (int32_t)(p->what.truth.quantum_um * 1e3),
        .most_q6 = cam_ilc_most_nm * 64,
        .k1_q16 = q16(2.0 * b->damping / w * hz),
        .k2_q16 = q16(hz * hz / (w * w)),
        .between_q16 = q16(0.5 * part * (1.0 - part)),
    };
    p->setup.k1_least_q16 = -p->setup.k1_q16 - q16(lead_ticks(p) + 4.0);
    p->setup.k2_least_q16 = -p->setup.k2_q16 - q16(16.0);
    p->setup.k1_most_q16 = p->setup.k1_q16 + q16(lead_ticks(p) + 4.0);
    p->setup.k2_most_q16 = p->setup.k2_q16 + q16(16.0);
}

void learn_plant_init(learn_plant_t *p, const learn_case_t *what)
{
    memset(p, 0, sizeof *p);
    p->what = *what;
    cam_ilc_init(&p->ilc);
    set_up(p);
    p->generation = 1;
    p->scale = 1.0;
}

/// The shape and its derivatives per radian, in mm.
static void shape(const learn_plant_t *p, double angle, double *u, double *u1, double *u2)
{
    *u = *u1 = *u2 = 0.0;
    for (int k = 0; k < 5; k++) {
        const double a = p->what.amplitude_mm[k] * p->scale;
        if (a == 0.0) { // most are, and sines are what a machine computes longest
            continue;
        }
        *u += a * cos(k * angle);
        *u1 -= a * k * sin(k * angle);
        *u2 -= a * k * k * cos(k * angle);
    }
}

static double correction_nm(const learn_plant_t *p, uint32_t angle_q32)
{
    const double at = angle_q32 / 16777216.0;
    const int i = (int)at;
    return p->learned.c[i] + (at - i) * (p->learned.c[i + 1] - p->learned.c[i]);
}

static double ago(const double *ring, uint64_t tick, double ticks)
{
    const uint64_t whole = (uint64_t)ticks;
    const double part = ticks - (double)whole;
    return ring[(tick - whole) % learn_ring] * (1.0 - part) +
           ring[(tick - whole - 1u) % learn_ring] * part;
}

static void integrate(learn_plant_t *p, double command_mm, double dt)
{
    const learn_drive_t *d = &p->what.truth;
    const double w = omega(d->bandwidth_hz);
    const double s = p->v / 0.5; // friction saturates at 0.5 mm/s
    const double friction = d->friction_mm_s2 * (s > 1.0 ? 1.0 : s < -1.0 ? -1.0 : s);
    const double a =
        w * w * (command_mm - p->y) - 2.0 * d->damping * w * p->v - friction + d->push_mm_s2;
    p->v += a * dt;
    p->y += p->v * dt;
    if (d->mode_hz > 0.0) {
        const double wm = omega(d->mode_hz);
        p->p += (-wm * wm * p->q - 2.0 * d->mode_damping * wm * p->p - a) * dt;
        p->q += p->p * dt;
    }
}

static double measured_mm(const learn_plant_t *p)
{
    return p->y + p->what.truth.mode_share * p->q;
}

/// One tick of time; the dead time may change the command inside of it.
static void move(learn_plant_t *p)
{
    const double hz = p->what.tick_hz;
    const double delay = p->what.truth.delay_us * 1e-6 * hz;
    for (int i = 0; i < n_steps; i++) {
        const double late = delay - (i + 0.5) / n_steps;
        const uint64_t whole = late <= 0.0 ? 0u : (uint64_t)ceil(late);
        integrate(p, p->command[(p->tick - whole) % learn_ring], 1.0 / (hz * n_steps));
    }
}

static void plan(learn_plant_t *p)
{
    const cam_tick_record_t r = {
        .config = p->generation,
        .angle = {.pos_q32 = p->pos_q32,
                  .speed_q32 = (int32_t)(p->what.rpm / 60.0 * 4294967296.0 / p->what.tick_hz)},
        .want = {.state = p->state}};
    const cam_motion_t m = {.is_playing =
                                p->state == cam_state_rehearsing || p->state == cam_state_cutting,
                            .scale_q30 = 1 << 30,
                            .phase_q32 = p->phase_q32};
    cam_turn_bins_plan_isr(&p->bins, &r, &m);
}

static void slow_side(learn_plant_t *p)
{
    const uint32_t at_q8 = (uint32_t)((uint64_t)p->pos_q32 >> 24);
    if (p->what.slow_turns > 1u && (at_q8 >> 8) % p->what.slow_turns > 1u) {
        return;
    }
    cam_ilc_poll(&p->ilc, &p->setup, p->state, &p->bins);
    if (cam_ilc_is_blending(&p->ilc, at_q8)) {
        cam_ilc_blend(&p->ilc, &p->setup, at_q8, &p->learned);
        p->generation++;
    }
}

static void tick(learn_plant_t *p)
{
    const double hz = p->what.tick_hz;
    const double turn_per_tick = p->what.rpm / 60.0 / hz;
    const double w = 2.0 * M_PI * turn_per_tick; // rad per tick
    const uint32_t at_q32 = (uint32_t)(uint64_t)p->pos_q32;
    const double angle = at_q32 / 4294967296.0 * 2.0 * M_PI + w * lead_ticks(p);
    double u, u1, u2;
    shape(p, angle, &u, &u1, &u2);
    const double k1 = (p->setup.k1_q16 + p->learned.k1_q16) / 65536.0;
    const double k2 = (p->setup.k2_q16 + p->learned.k2_q16) / 65536.0;
    const uint32_t ahead_q32 = at_q32 + (uint32_t)(turn_per_tick * lead_ticks(p) * 4294967296.0);
    const double command_nm =
        (u + k1 * w * u1 + k2 * w * w * u2) * 1e6 + correction_nm(p, ahead_q32);
    p->tick++;
    p->command[p->tick % learn_ring] = floor(command_nm + 0.5) * 1e-6;
    p->set[p->tick % learn_ring] = u * 1e6;
    p->shown[p->tick % learn_ring] = measured_mm(p);
    const double seen = ago(p->shown, p->tick, p->what.truth.latency_us * 1e-6 * hz);
    const double quantum_nm = p->what.truth.quantum_um * 1e3;
    const int32_t actual_nm = (int32_t)(floor(seen * 1e6 / quantum_nm + 0.5) * quantum_nm);
    const double due_nm =
        ago(p->set, p->tick, lead_ticks(p) + p->what.believed.latency_us * 1e-6 * hz);
    const cam_tick_record_t r = {.in.actual_nm = {actual_nm},
                                 .angle = {.pos_q32 = p->pos_q32, .measured_q32 = at_q32},
                                 .want.u_due_q6 = (int32_t)floor(due_nm * 64.0)};
    cam_turn_bins_add_isr(&p->bins, &r);
    shape(p, angle - w * lead_ticks(p), &u, &u1, &u2);
    const double off_um = fabs(measured_mm(p) - u) * 1e3;
    p->turn_square += off_um * off_um;
    p->turn_most_um = fmax(p->turn_most_um, off_um);
    p->turn_ticks++;
    if (p->tick % 8u == 0u) {
        plan(p);
    }
    move(p);
    for (uint32_t i = p->what.polls_per_tick_q4; i >= 16u; i -= 16u) {
        slow_side(p);
    }
    const int64_t before = p->pos_q32 >> 32;
    p->pos_q32 += (int64_t)(turn_per_tick * 4294967296.0);
    if (p->pos_q32 >> 32 != before) {
        p->rms_um = sqrt(p->turn_square / p->turn_ticks);
        p->most_um = p->turn_most_um;
        p->turn_square = p->turn_most_um = 0.0;
        p->turn_ticks = 0;
        p->scale += p->what.growth_per_turn;
    }
}

void learn_plant_turns(learn_plant_t *p, cam_state_t state, uint32_t n_turns)
{
    p->state = state;
    const int64_t end = (p->pos_q32 >> 32) + (int64_t)n_turns;
    while (p->pos_q32 >> 32 < end) {
        tick(p);
    }
}
