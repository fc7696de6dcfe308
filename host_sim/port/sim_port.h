// SPDX-License-Identifier: Apache-2.0
/// sim_port: connects the lathe to hal/host: the firmware's inputs and outputs.
///
/// Time advances in ticks. At the start of a tick the true state is written to hal_host.in; the
/// firmware runs; the lathe reads its outputs and advances by one period.
///
///     sense: lathe -> hal_host.in     tick                       advance: hal_host.out -> lathe
///
/// Between sense and advance the true state is that at the instant of sensing.
#ifndef SIM_PORT_H
#define SIM_PORT_H

#include "cam_fix.h"     // cam_wrap_sub
#include "cam_machine.h" // cam_machine_t
#include "hal_host.h"    // hal_host_tick
#include "sim_inject.h"  // sim_inject_t
#include "sim_lathe.h"   // sim_home_t, sim_lathe_t
#include "sim_random.h"  // sim_random_t
#include <stdatomic.h>   // atomic_load_explicit
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t, uint64_t, uint32_t

// When the controller's ticks occur, on its own clock and in machine time.
//
//     k T             timer grid of the controller's clock, T the nominal period
//     k T + e(k)      the tick: the interrupt is late by e(k)
//     / (1 + drift)   in machine time; the clocks of spindle and drives are exact
//
// jitter: e is evenly distributed from 0 to a share of T. burst: e is that share in one of 16
// ticks at random, 0 in the others. twice: one tick is repeated, a share of T after the first.

typedef struct {
    double drift;  ///< relative error of the controller's clock, above 0: fast; 1e-6: 1 ppm
    double jitter; ///< [periods] below 1
    double burst;  ///< [periods] below 1
    double twice;  ///< [periods] delay of a repeated tick; 0: none
    double rest;   ///< [periods] from the repeated tick to the next; 0: none
    double late;   ///< [periods] delay of the last tick after its grid
    sim_random_t random;
} sim_clock_t;

/// Interval from one tick to the next.
typedef struct {
    double dt_s;         ///< in machine time
    int32_t late_clocks; ///< beyond a period, on the controller's clock; below 0: early
} sim_clock_step_t;

/// Start with an exact clock and punctual ticks.
void sim_clock_init(sim_clock_t *c, uint64_t seed);

/// @param period_s  [s] T
/// @param clock_hz  frequency of the controller's clock
sim_clock_step_t sim_clock_next(sim_clock_t *c, double period_s, double clock_hz);

// The controller on the simulator's port. Only one exists at a time: a process has one port.

typedef struct {
    cam_machine_t machine;
    // read after every tick; a whole status costs as much as two ticks
    uint32_t tick;        ///< number of the last tick
    cam_state_t state;    ///< of the last tick
    int32_t following_nm; ///< [nm] following error of U in the last tick
} sim_firmware_t;

/// Start the controller in state off, after the machine is initialised.
static inline void sim_firmware_init(sim_firmware_t *f)
{
    *f = (sim_firmware_t){0};
    cam_machine_init(&f->machine, &g_cam, hal_tick_hz(), hal_clock_hz());
}

/// Tick rate up to which the main loop does more than one piece of learning per tick.
enum { sim_firmware_busy_hz = 10000 };

/// One tick: hal_host.in -> hal_host.out, then one piece of learning, or several at a low tick
/// rate, as often as in a real main loop.
static inline void sim_firmware_tick(sim_firmware_t *f)
{
    hal_host_tick();
    // No tick is in progress here, so the record need not be copied.
    const cam_tick_record_t *r = cam_trace_newest(&f->machine.core->trace);
    f->tick = r->tick;
    f->state = r->want.state;
    f->following_nm = cam_wrap_sub(r->in.actual_nm[hal_axis_u], r->want.u_due_q6 >> 6);
    for (uint32_t hz = 0; hz < sim_firmware_busy_hz; hz += hal_host.tick_hz) {
        cam_machine_ilc_poll(&f->machine, f->state, !cam_record_is_u_at_rest(r));
    }
}

// Lathe and port

typedef struct {
    sim_lathe_t lathe;
    double time_s;
    uint32_t n_swing;      ///< set-points of the swing applied
    int32_t swing_set_q32; ///< [turn / 2^32] set-point in force
    int32_t z_offset_nm;   ///< added to the measured Z
    sim_home_t home[hal_n_axes];
    uint32_t n_shown;  ///< [ticks] for which the port shows an index: the period of the plan
    sim_clock_t clock; ///< when ticks occur
    double late_s;     ///< delay of the next tick
    double lost_s;     ///< time beyond the nominal time of all ticks
} sim_port_t;

/// Reset hal/host, with the lathe at rest; U is measured.
/// @param x_nm, z_nm  positions at the start
/// @param seed        seed of all noise
void sim_port_init(sim_port_t *p, const sim_lathe_config_t *config, double x_nm, double z_nm,
                   uint64_t seed);

/// Before a tick: set the inputs of the firmware.
void sim_port_sense(sim_port_t *p);

/// After a tick: advance by one period.
void sim_port_advance(sim_port_t *p);

/// Apply an injection to lathe or port; other kinds (table-flip, stop, those of the nodes) do
/// nothing. Call it between sense and advance.
/// @param direction  +1 or -1: sense of cutting
void sim_port_inject(sim_port_t *p, const sim_inject_t *inject, int direction);

/// @return [degrees] set-point of the swing in the last tick
static inline double sim_port_swing_set_deg(const sim_port_t *p)
{
    return p->swing_set_q32 * (360.0 / 4294967296.0);
}

#endif
