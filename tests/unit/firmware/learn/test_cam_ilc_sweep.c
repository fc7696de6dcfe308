// SPDX-License-Identifier: Apache-2.0
// Machines that are not what the controller believes: each is learned, masked or left alone, and
// none is left worse than 1.5 times what it was without learning. A few of them in an ordinary run,
// all of the thousand and more with CAM_LONG=1 in the environment.
#include "cam_learning.h"
#include "unity.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h> // getenv
#include <string.h> // memset

enum { rehearsal_turns = 44, cut_turns = 10 };
enum { stride = 29 }; ///< no divisor of a number of values, so that all of them come
enum { tick_hz = 20000, n_steps = 4, n_ring = 256 };

static const double two_pi = 6.283185307179586;

/// U with dead time, friction, a mode and a scale, in floating point, and the interrupt's part of
/// learning at a known angle:
///
///     command   u(a + lead) + k1 u' + k2 u'' + c(a)          what cam_tick writes, MATHS.md (56)
///     U         y'' = w^2 (command(t - D) - y) - 2 d w y' - f sat(y' / v_s)
///     mode      q'' = -w_m^2 q - 2 d_m w_m q' - y'',  measured y + share q
///     scale     measured(t - L), rounded to the quantum
///
/// It has nothing in common with the simulator but the equations. Integrated by 4 semi-implicit
/// steps per tick.
typedef struct {
    double bandwidth_hz, damping, delay_us; ///< of the drive
    double friction_mm_s2;                  ///< [mm/s^2]
    double mode_hz, mode_damping, mode_share;
    double latency_us; ///< of the scale, not known to the controller
    double quantum_um;
} drive_t;

typedef struct {
    drive_t truth, believed;
    double amplitude_mm[5]; ///< cosine of harmonic 0 .. 4 of the shape
    double rpm;
    uint32_t slow_turns; ///< the slow side takes a turn only every so many turns
} case_t;

static case_t what;
static cam_ilc_t ilc;
static cam_ilc_setup_t setup;
static cam_turn_bins_t bins;
static cam_learned_t learned;
static cam_state_t state;
static double y, v, q, p;      ///< mm, mm/s: U and its mode
static double command[n_ring]; ///< mm
static double set[n_ring];     ///< nm
static double shown[n_ring];   ///< mm
static int64_t pos_q32;
static uint64_t now; ///< tick
static uint32_t generation;
static double turn_square; ///< of the turn that runs
static uint32_t turn_ticks;
static double rms_um; ///< of the last whole turn: true U against what was due

static int32_t q16(double value)
{
    return (int32_t)floor(value * 65536.0 + 0.5);
}

static double lead_ticks(void)
{
    return what.believed.delay_us * 1e-6 * tick_hz + 0.5;
}

/// Everything at rest, nothing learned.
static void init(const case_t *machine)
{
    what = *machine;
    cam_ilc_init(&ilc);
    memset(&bins, 0, sizeof bins);
    memset(&learned, 0, sizeof learned);
    memset(command, 0, sizeof command);
    memset(set, 0, sizeof set);
    memset(shown, 0, sizeof shown);
    y = v = q = p = turn_square = rms_um = 0.0;
    pos_q32 = 0;
    now = 0;
    turn_ticks = 0;
    generation = 1;
    const drive_t *b = &what.believed;
    const double w = two_pi * b->bandwidth_hz / tick_hz; // rad per tick
    const double due = lead_ticks() + b->latency_us * 1e-6 * tick_hz;
    const double part = due - floor(due);
    const int32_t k1_q16 = q16(2.0 * b->damping / w);
    const int32_t k2_q16 = q16(1.0 / (w * w));
    setup = (cam_ilc_setup_t){
        .angle_step_q23 = INT16_MAX,
        .observer_step_q23 = INT16_MAX,
        .reason = cam_ilc_all,
        .n_harmonics = 16,
        .gain_q16 = 32768,
        .cut_gain_q16 = 9830,
        .probe_q6 = 1000 * 64,
        .scale_nm = (int32_t)(what.truth.quantum_um * 1e3),
        .most_q6 = cam_ilc_most_nm * 64,
        .k1_q16 = k1_q16,
        .k2_q16 = k2_q16,
        .between_q16 = q16(0.5 * part * (1.0 - part)),
        .k1_least_q16 = -k1_q16 - q16(lead_ticks() + 4.0),
        .k2_least_q16 = -k2_q16 - q16(16.0),
        .k1_most_q16 = k1_q16 + q16(lead_ticks() + 4.0),
        .k2_most_q16 = k2_q16 + q16(16.0),
    };
}

/// The shape and its derivatives per radian, in mm.
static void shape(double angle, double u[3])
{
    u[0] = u[1] = u[2] = 0.0;
    for (int k = 0; k < 5; k++) {
        const double a = what.amplitude_mm[k];
        if (a != 0.0) { // most are, and sines are what a machine computes longest
            u[0] += a * cos(k * angle);
            u[1] -= a * k * sin(k * angle);
            u[2] -= a * k * k * cos(k * angle);
        }
    }
}

static double ago(const double *ring, double ticks)
{
    const uint64_t whole = (uint64_t)ticks;
    const double part = ticks - (double)whole;
    return ring[(now - whole) % n_ring] * (1.0 - part) + ring[(now - whole - 1u) % n_ring] * part;
}

/// One tick of time; the dead time may change the command inside of it.
static void move(void)
{
    const drive_t *d = &what.truth;
    const double dt = 1.0 / (tick_hz * n_steps);
    const double w = two_pi * d->bandwidth_hz;
    const double wm = two_pi * d->mode_hz;
    for (int i = 0; i < n_steps; i++) {
        const double late = d->delay_us * 1e-6 * tick_hz - (i + 0.5) / n_steps;
        const uint64_t whole = late <= 0.0 ? 0u : (uint64_t)ceil(late);
        const double s = fmax(-1.0, fmin(1.0, v / 0.5)); // friction saturates at 0.5 mm/s
        const double a = w * w * (command[(now - whole) % n_ring] - y) - 2.0 * d->damping * w * v -
                         d->friction_mm_s2 * s;
        v += a * dt;
        y += v * dt;
        if (d->mode_hz > 0.0) {
            p += (-wm * wm * q - 2.0 * d->mode_damping * wm * p - a) * dt;
            q += p * dt;
        }
    }
}

static void plan(int32_t speed_q32)
{
    const cam_tick_record_t r = {.config = generation,
                                 .angle = {.pos_q32 = pos_q32, .speed_q32 = speed_q32},
                                 .want = {.state = state}};
    const cam_motion_t m = {.is_playing =
                                state == cam_state_rehearsing || state == cam_state_cutting,
                            .scale_q30 = 1 << 30};
    cam_turn_bins_plan_isr(&bins, &r, &m);
}

static void slow_side(void)
{
    const uint32_t at_q8 = (uint32_t)((uint64_t)pos_q32 >> 24);
    if (what.slow_turns > 1u && (at_q8 >> 8) % what.slow_turns > 1u) {
        return;
    }
    cam_ilc_poll(&ilc, &setup, state, &bins);
    if (cam_ilc_is_blending(&ilc, at_q8)) {
        cam_ilc_blend(&ilc, &setup, at_q8, &learned);
        generation++;
    }
}

static void tick(void)
{
    const double turn_per_tick = what.rpm / 60.0 / tick_hz;
    const double w = two_pi * turn_per_tick; // rad per tick
    const uint32_t at_q32 = (uint32_t)(uint64_t)pos_q32;
    const double angle = at_q32 / 4294967296.0 * two_pi;
    double u[3];
    shape(angle + w * lead_ticks(), u);
    const double k1 = (setup.k1_q16 + learned.k1_q16) / 65536.0;
    const double k2 = (setup.k2_q16 + learned.k2_q16) / 65536.0;
    const uint32_t ahead_q32 = at_q32 + (uint32_t)(turn_per_tick * lead_ticks() * 4294967296.0);
    const double place = ahead_q32 / 16777216.0;
    const int i = (int)place;
    const double correction_nm = learned.c[i] + (place - i) * (learned.c[i + 1] - learned.c[i]);
    const double command_nm = (u[0] + k1 * w * u[1] + k2 * w * w * u[2]) * 1e6 + correction_nm;
    const double measured_mm = y + what.truth.mode_share * q;
    now++;
    command[now % n_ring] = floor(command_nm + 0.5) * 1e-6;
    set[now % n_ring] = u[0] * 1e6;
    shown[now % n_ring] = measured_mm;
    const double seen_nm = ago(shown, what.truth.latency_us * 1e-6 * tick_hz) * 1e6;
    const double quantum_nm = what.truth.quantum_um * 1e3;
    const double due_nm = ago(set, lead_ticks() + what.believed.latency_us * 1e-6 * tick_hz);
    const cam_tick_record_t r = {
        .in.actual_nm = {(int32_t)(floor(seen_nm / quantum_nm + 0.5) * quantum_nm)},
        .angle = {.pos_q32 = pos_q32, .measured_q32 = at_q32},
        .want.u_due_q6 = (int32_t)floor(due_nm * 64.0)};
    cam_turn_bins_add_isr(&bins, &r);
    shape(angle, u);
    turn_square += (measured_mm - u[0]) * (measured_mm - u[0]) * 1e6;
    turn_ticks++;
    if (now % 8u == 0u) {
        plan((int32_t)(turn_per_tick * 4294967296.0));
    }
    move();
    slow_side();
    const int64_t before = pos_q32 >> 32;
    pos_q32 += (int64_t)(turn_per_tick * 4294967296.0);
    if (pos_q32 >> 32 != before) {
        rms_um = sqrt(turn_square / turn_ticks);
        turn_square = 0.0;
        turn_ticks = 0;
    }
}

/// Play whole turns in a state.
static void turns(cam_state_t played, uint32_t n)
{
    state = played;
    for (const int64_t end = (pos_q32 >> 32) + (int64_t)n; pos_q32 >> 32 < end;) {
        tick();
    }
}

/// @return steps from one machine that is tried to the next one
static int each(void)
{
    const char *is_long = getenv("CAM_LONG");
    return is_long != NULL && *is_long == '1' ? 1 : stride;
}

/// Rehearse a machine and cut with it: its error, but for the scale's own noise, is no worse than
/// without learning. @return whether it was learned to a fifth or to noise
static bool is_learned(const case_t *machine, const char *of_which, int i)
{
    char name[80];
    (void)snprintf(name, sizeof name, "%s, machine %d", of_which, i);
    init(machine);
    setup.reason = cam_ilc_not_asked;
    turns(cam_state_rehearsing, 4);
    const double before_um = rms_um;
    init(machine);
    turns(cam_state_rehearsing, rehearsal_turns);
    double worst_um = rms_um;
    for (int k = 0; k < cut_turns; k++) {
        turns(cam_state_cutting, 1);
        worst_um = fmax(worst_um, rms_um);
    }
    const double noise_um = 0.02 + 0.15 * what.truth.quantum_um;
    TEST_ASSERT_TRUE_MESSAGE(worst_um <= 1.5 * (before_um + noise_um), name);
    return worst_um < 0.2 * before_um || worst_um < noise_um;
}

static case_t usual(void)
{
    const drive_t drive = {
        .bandwidth_hz = 300.0, .damping = 0.7, .delay_us = 75.0, .quantum_um = 0.01};
    return (case_t){.truth = drive,
                    .believed = drive,
                    .amplitude_mm = {0.5, 0.0, 0.5, 0.0, 0.01},
                    .rpm = 3000.0};
}

/// Bandwidth, damping and dead time wrong: at the harmonics that are learned this spans half to
/// twice the gain and more than 80 degrees of phase to either side.
static void test_no_wrong_drive_is_made_worse(void)
{
    static const double bandwidth[] = {0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5};
    static const double damping[] = {0.5, 0.7, 1.0, 1.4, 2.0};
    static const double delay_us[] = {-75.0, -40.0, 0.0, 60.0, 150.0, 300.0};
    static const double friction[] = {0.0, 10000.0};
    uint32_t n = 0, n_learned = 0;
    case_t machine = usual();
    for (int i = 0; i < 8 * 5 * 6 * 2; i += each()) {
        machine.believed.bandwidth_hz = 300.0 * bandwidth[i % 8];
        machine.believed.damping = 0.7 * damping[i / 8 % 5];
        machine.truth.delay_us = 75.0 + delay_us[i / 40 % 6];
        machine.truth.friction_mm_s2 = friction[i / 240];
        n++;
        n_learned += is_learned(&machine, "wrong drives", i) ? 1u : 0u;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(n * 8u / 10u, n_learned);
}

/// A mode that the scale sees, anywhere in the harmonics and beyond, weak and strong.
static void test_no_mode_is_driven(void)
{
    static const double mode_hz[] = {250.0, 400.0, 550.0, 700.0, 800.0, 1000.0, 1500.0, 2500.0};
    static const double mode_damping[] = {0.02, 0.03, 0.1};
    static const double share[] = {0.1, 0.5, 1.0};
    static const double wrong[] = {0.8, 1.2};
    case_t machine = usual();
    machine.truth.friction_mm_s2 = 5000.0;
    for (int i = 0; i < 8 * 3 * 3 * 2 * 2; i += each()) {
        machine.truth.mode_hz = mode_hz[i % 8];
        machine.truth.mode_damping = mode_damping[i / 8 % 3];
        machine.truth.mode_share = share[i / 24 % 3];
        machine.believed.bandwidth_hz = 300.0 * wrong[i / 72 % 2];
        machine.truth.quantum_um = i / 144 == 0 ? 0.01 : 1.0;
        (void)is_learned(&machine, "modes", i);
    }
}

/// A slow side that takes only some of the turns, a scale that is late, other speeds.
static void test_no_latency_makes_it_worse(void)
{
    static const double rpm[] = {600.0, 1500.0, 2500.0, 3000.0, 4500.0, 6000.0};
    static const double latency_us[] = {0.0, 20.0, 50.0};
    static const uint32_t slow[] = {1, 3, 4};
    static const double wrong[] = {0.7, 0.9, 1.3};
    case_t machine = usual();
    for (int i = 0; i < 6 * 3 * 3 * 3; i += each()) {
        machine.rpm = rpm[i % 6];
        machine.amplitude_mm[2] = 0.5 * 3000.0 / (machine.rpm > 3000.0 ? machine.rpm : 3000.0);
        machine.believed.latency_us = latency_us[i / 6 % 3];
        machine.truth.latency_us = latency_us[i / 6 % 3];
        machine.slow_turns = slow[i / 18 % 3];
        machine.believed.bandwidth_hz = 300.0 * wrong[i / 54];
        (void)is_learned(&machine, "latencies and speeds", i);
    }
}

/// Drives of other kinds, from a slow one to a piezo.
static void test_no_other_drive_is_made_worse(void)
{
    static const double bandwidth_hz[] = {120.0, 200.0, 300.0, 500.0, 1000.0};
    static const double damping[] = {0.3, 0.7, 1.0};
    static const double wrong[] = {0.7, 0.85, 1.15, 1.4};
    static const double delay[] = {0.5, 2.0};
    case_t machine = usual();
    for (int i = 0; i < 5 * 3 * 4 * 2; i += each()) {
        machine.truth.bandwidth_hz = bandwidth_hz[i % 5];
        machine.truth.damping = damping[i / 5 % 3];
        machine.believed = machine.truth;
        machine.believed.bandwidth_hz *= wrong[i / 15 % 4];
        machine.believed.delay_us *= delay[i / 60];
        (void)is_learned(&machine, "other drives", i);
    }
}
