// SPDX-License-Identifier: Apache-2.0
/// sim_firmware: the controller as the simulator drives it, wherever it runs.
///
/// It runs in this process, on the port of the simulator, or on a target behind a wire
/// (sim_remote.h), with the same functions and the same answers to the bit. A target can be lost in
/// the middle; then ticks return false, calls return cam_err_busy, and sim_firmware_is_lost() says
/// why. There is one controller at a time, because the port is one per process.
#ifndef SIM_FIRMWARE_H
#define SIM_FIRMWARE_H

#include "cam_fix.h"      // cam_wrap_sub
#include "cam_machine.h"  // cam_machine_t
#include "cam_trace.h"    // cam_trace_t
#include "hal_host.h"     // hal_host_tick
#include "common_error.h" // common_error_t
#include "sim_remote.h"   // sim_remote_t
#include <stdatomic.h>    // atomic_load_explicit
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t

typedef struct {
    cam_machine_t machine; ///< in this process
    sim_remote_t *remote;  ///< NULL: in this process
    cam_status_t told;     ///< by a target, of the last tick
    // what is looked at behind every tick; a whole status costs as much as two ticks
    uint32_t tick;        ///< number of the last tick
    cam_state_t state;    ///< of the last tick
    int32_t following_nm; ///< [nm] following error of U in the last tick
} sim_firmware_t;

/// Bring the controller into state off, after the machine is initialised.
/// @param target  of sim_target.h, NULL: in this process
/// @param image   path of its image, not used without a target
/// @return        false and *e when the target does not start; nothing to close then
bool sim_firmware_open(sim_firmware_t *f, const char *target, const char *image, common_error_t *e);

void sim_firmware_close(sim_firmware_t *f);

/// @return true, and *e says why, when the target does not answer any more
bool sim_firmware_is_lost(const sim_firmware_t *f, common_error_t *e);

/// Rate up to which a main loop learns more than one piece from tick to tick.
enum { sim_firmware_busy_hz = 10000 };

/// One tick: hal_host.in -> hal_host.out, and behind it one piece of learning, or behind a slow
/// tick several, which is as often as a main loop of its own calls it.
/// @return false when the target is lost
static inline bool sim_firmware_tick(sim_firmware_t *f)
{
    if (f->remote != NULL) {
        const bool is_there = sim_remote_tick(f->remote, &f->told);
        f->tick = f->told.tick;
        f->state = f->told.state;
        f->following_nm = f->told.following_nm;
        return is_there;
    }
    hal_host_tick();
    // No tick is in progress here, so the record need not be copied.
    const cam_tick_record_t *r =
        atomic_load_explicit(&f->machine.core->newest, memory_order_relaxed);
    f->tick = r->tick;
    f->state = r->want.state;
    f->following_nm = cam_wrap_sub(r->in.actual_nm[hal_axis_u], r->want.u_due_q6 >> 6);
    for (uint32_t hz = 0; hz < sim_firmware_busy_hz; hz += hal_host.tick_hz) {
        cam_machine_ilc_poll(&f->machine, f->state);
    }
    return true;
}

/// @return all that the controller tells of the last tick
static inline cam_status_t sim_firmware_status(const sim_firmware_t *f)
{
    return f->remote != NULL ? f->told : cam_machine_status(&f->machine);
}

/// @return where records of the ticks come from, by cam_trace_pop()
static inline cam_trace_t *sim_firmware_trace(sim_firmware_t *f)
{
    return f->remote != NULL ? &f->remote->trace : &f->machine.core->trace;
}

// The slow side, as in cam_machine.h

int32_t sim_firmware_param(sim_firmware_t *f, cam_param_id_t id);
CAM_MUST_USE cam_err_t sim_firmware_set_param(sim_firmware_t *f, cam_param_id_t id, int32_t value);
CAM_MUST_USE cam_err_t sim_firmware_select_table(sim_firmware_t *f, const void *image, size_t size);
/// Of the speed that start would use.
cam_feasibility_t sim_firmware_feasibility(sim_firmware_t *f);
CAM_MUST_USE cam_err_t sim_firmware_enable(sim_firmware_t *f);
CAM_MUST_USE cam_err_t sim_firmware_start(sim_firmware_t *f);
CAM_MUST_USE cam_err_t sim_firmware_stop(sim_firmware_t *f);
/// Hold the feed, or let it go on.
CAM_MUST_USE cam_err_t sim_firmware_hold(sim_firmware_t *f, bool is_held);
void sim_firmware_poll(sim_firmware_t *f);

/// What was learned as a whole, and of a harmonic: 0 .. cam_ilc_harmonics, 0 is the mean.
cam_ilc_status_t sim_firmware_learning(sim_firmware_t *f);
cam_ilc_harmonic_t sim_firmware_harmonic(sim_firmware_t *f, uint32_t k);

/// The lowest bit of a byte of the table image flips in the controller's memory.
/// @param image  that was selected: the controller's memory when it runs in this process
/// @param at     place within it
void sim_firmware_flip(sim_firmware_t *f, uint8_t *image, size_t at);

#endif
