// SPDX-License-Identifier: Apache-2.0
#include "budget_force.h"
#include "cam_tick.h" // g_cam
#include "hal_host.h" // hal_host
#include <stddef.h>   // offsetof
#include <string.h>   // memcpy

enum { patience = 60000 };

/// All that a tick can change: of the rig everything in front of its image.
typedef struct {
    cam_t controller;
    hal_host_t port;
    uint8_t rig[offsetof(fixture_rig_t, image)];
} moment_t;

static bool is_combination; ///< the next tick is several rare things at once

bool budget_force_is_combined(void)
{
    return is_combination;
}

static void keep(moment_t *moment, const fixture_rig_t *rig)
{
    moment->controller = g_cam;
    moment->port = hal_host;
    memcpy(moment->rig, rig, sizeof moment->rig);
}

static void bring_back(const moment_t *moment, fixture_rig_t *rig)
{
    memcpy(rig, moment->rig, sizeof moment->rig);
    hal_host = moment->port;
    g_cam = moment->controller;
}

/// One tick from where the session stands, then back: with or without a plan, with an index edge or
/// without, and a cause of a fault.
static void try_tick(fixture_rig_t *rig, bool is_planned, bool is_edge, void (*cause)(void),
                     bool is_combined)
{
    static moment_t before;
    keep(&before, rig);
    g_cam.until_plan = is_planned ? 1 : 2;
    g_cam.spindle.n_index -= is_edge ? 1u : 0u;
    cause();
    is_combination = is_combined;
    fixture_rig_tick(rig);
    is_combination = false;
    bring_back(&before, rig);
}

static void no_fault(void) {}

static void press_estop(void)
{
    hal_host_fault_estop(true);
}

/// All that the guard itself finds wrong: U does not follow, its set-point jumps, the drives fail.
static void break_u(void)
{
    hal_host_fault_drive(true);
    hal_host.in.axis_nm[hal_axis_u] += 1 << 24;
    hal_host.in.swing_q32 += 1 << 30;
    g_cam.motion.u.set_q6 += 1 << 24;
}

/// What the plan finds wrong: Z is off its place, the swing does not follow.
static void break_z(void)
{
    hal_host.in.axis_nm[hal_axis_z] += 1 << 24;
    hal_host.in.swing_q32 += 1 << 30;
}

/// The spindle turns in the other sense.
static void turn_back(void)
{
    g_cam.spindle.speed_q64 = -g_cam.spindle.speed_q64;
}

/// The first edge makes the angle known.
static void forget_index(void)
{
    g_cam.spindle.is_synced = false;
}

static void come_late(void)
{
    hal_host_fault_late(300);
    hal_host_fault_estop(true);
}

/// There is no fault, but the longest path through the angle.
static void come_off_time(void)
{
    hal_host_fault_late(40);
}

static void break_u_off_time(void)
{
    come_off_time();
    break_u();
}

/// The operator's stop.
static void ask_to_stop(void)
{
    const uint32_t serial = g_cam.play.request + 1u;
    atomic_store(&g_cam.request, serial << 8 | (uint32_t)cam_request_stop);
}

static void break_u_while_stopping(void)
{
    ask_to_stop();
    break_u_off_time();
}

static void stop_off_time(void)
{
    ask_to_stop();
    come_off_time();
}

typedef void (*cause_t)(void);

static void try_causes(fixture_rig_t *rig, const cause_t *causes, uint32_t n_causes,
                       bool is_combined)
{
    for (uint32_t i = 0; i < n_causes; i++) {
        for (int k = 0; k < 4; k++) {
            try_tick(rig, k % 2 == 1, k / 2 == 1, causes[i], is_combined);
        }
    }
}

/// By force: every tick with and without a plan and an index edge, without a fault and with those
/// that take the longest paths. Then what makes a tick long, together.
static void try_all_causes(fixture_rig_t *rig)
{
    static const cause_t causes[] = {no_fault,  press_estop,  break_u,   break_z,
                                     turn_back, forget_index, come_late, ask_to_stop};
    static const cause_t combinations[] = {come_off_time, break_u_off_time, break_u_while_stopping,
                                           stop_off_time};
    try_causes(rig, causes, sizeof causes / sizeof causes[0], false);
    try_causes(rig, combinations, sizeof combinations / sizeof combinations[0], true);
}

/// In the first ticks of the fault state, too: the retract begins.
static void try_retract(fixture_rig_t *rig)
{
    static moment_t before;
    keep(&before, rig);
    hal_host_fault_estop(true);
    for (int i = 0; i < 12; i++) {
        fixture_rig_tick(rig);
        try_all_causes(rig);
    }
    bring_back(&before, rig);
}

/// Bring an opened session into a state. @return whether it was reached
static bool bring(fixture_rig_t *rig, cam_state_t state)
{
    if (state != cam_state_disengaging) {
        return fixture_rig_bring(rig, state);
    }
    return fixture_rig_bring(rig, cam_state_cutting) && cam_machine_stop(&rig->machine) == cam_ok &&
           fixture_rig_until(rig, state, patience) < patience;
}

/// The approach was seen, now the table.
static void try_table(fixture_rig_t *rig)
{
    while (!g_cam.motion.is_playing) {
        fixture_rig_tick(rig);
    }
    fixture_rig_ticks(rig, 1500);
    try_all_causes(rig);
    try_retract(rig);
}

bool budget_force_states(fixture_rig_t *rig, void (*open)(void))
{
    static const cam_state_t states[] = {cam_state_off,     cam_state_homing,
                                         cam_state_ready,   cam_state_engaging,
                                         cam_state_cutting, cam_state_disengaging};
    for (uint32_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        open();
        if (!bring(rig, states[i])) {
            return false;
        }
        for (int k = 0; k < 48; k++) {
            fixture_rig_ticks(rig, 23);
            try_all_causes(rig);
        }
        try_retract(rig);
        if (states[i] == cam_state_engaging) {
            try_table(rig);
        }
    }
    return true;
}
