// SPDX-License-Identifier: Apache-2.0
/// sim_firmware: the controller on the simulator's port. Only one exists at a time, because a
/// process has one port.
#ifndef SIM_FIRMWARE_H
#define SIM_FIRMWARE_H

#include "cam_fix.h"     // cam_wrap_sub
#include "cam_machine.h" // cam_machine_t
#include "hal_host.h"    // hal_host_tick
#include <stdatomic.h>   // atomic_load_explicit

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
    const cam_tick_record_t *r =
        atomic_load_explicit(&f->machine.core->newest, memory_order_relaxed);
    f->tick = r->tick;
    f->state = r->want.state;
    f->following_nm = cam_wrap_sub(r->in.actual_nm[hal_axis_u], r->want.u_due_q6 >> 6);
    for (uint32_t hz = 0; hz < sim_firmware_busy_hz; hz += hal_host.tick_hz) {
        cam_machine_ilc_poll(&f->machine, f->state, !cam_record_is_u_at_rest(r));
    }
}

#endif
