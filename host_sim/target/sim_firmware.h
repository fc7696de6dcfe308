// SPDX-License-Identifier: Apache-2.0
/// sim_firmware: the controller as the simulator uses it, in this process or on a target.
///
/// In this process it runs on the simulator's port, on a target through sim_remote.h, with the same
/// functions and the same results to the bit. A target can be lost at any time; then ticks return
/// false, calls return cam_err_busy, and sim_firmware_is_lost() gives the reason. Only one
/// controller exists at a time, because a process has one port.
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
    cam_status_t status;   ///< of a target after the last tick
    // read after every tick; a whole status costs as much as two ticks
    uint32_t tick;        ///< number of the last tick
    cam_state_t state;    ///< of the last tick
    int32_t following_nm; ///< [nm] following error of U in the last tick
} sim_firmware_t;

/// Start the controller in state off, after the machine is initialised.
/// @param target  a target of sim_target.h, NULL: in this process
/// @param image   path of its image; unused without a target
/// @return        false and *e when the target does not start; then nothing to close
bool sim_firmware_open(sim_firmware_t *f, const char *target, const char *image, common_error_t *e);

void sim_firmware_close(sim_firmware_t *f);

/// @return true, with the reason in *e, when the target no longer answers
bool sim_firmware_is_lost(const sim_firmware_t *f, common_error_t *e);

/// Tick rate up to which the main loop does more than one piece of learning per tick.
enum { sim_firmware_busy_hz = 10000 };

/// One tick: hal_host.in -> hal_host.out, then one piece of learning, or several at a low tick
/// rate, as often as in a real main loop.
/// @return false when the target is lost
static inline bool sim_firmware_tick(sim_firmware_t *f)
{
    if (f->remote != NULL) {
        const bool is_there = sim_remote_tick(f->remote, &f->status);
        f->tick = f->status.tick;
        f->state = f->status.state;
        f->following_nm = f->status.following_nm;
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
        cam_machine_ilc_poll(&f->machine, f->state, !cam_record_is_u_at_rest(r));
    }
    return true;
}

/// @return the controller's full status after the last tick
static inline cam_status_t sim_firmware_status(const sim_firmware_t *f)
{
    return f->remote != NULL ? f->status : cam_machine_status(&f->machine);
}

/// @return the source of tick records, for cam_trace_pop()
static inline cam_trace_t *sim_firmware_trace(sim_firmware_t *f)
{
    return f->remote != NULL ? &f->remote->trace : &f->machine.core->trace;
}

// The slow side, as in cam_machine.h

int32_t sim_firmware_param(sim_firmware_t *f, cam_param_id_t id);
CAM_MUST_USE cam_err_t sim_firmware_set_param(sim_firmware_t *f, cam_param_id_t id, int32_t value);
CAM_MUST_USE cam_err_t sim_firmware_select_table(sim_firmware_t *f, const void *image, size_t size);
/// For the speed that start would use.
cam_feasibility_t sim_firmware_feasibility(sim_firmware_t *f);
CAM_MUST_USE cam_err_t sim_firmware_enable(sim_firmware_t *f);
CAM_MUST_USE cam_err_t sim_firmware_start(sim_firmware_t *f);
CAM_MUST_USE cam_err_t sim_firmware_stop(sim_firmware_t *f);
/// Hold or resume the feed.
CAM_MUST_USE cam_err_t sim_firmware_hold(sim_firmware_t *f, bool is_held);
void sim_firmware_poll(sim_firmware_t *f);

/// Learning as a whole, and of a harmonic: 0 .. cam_ilc_harmonics, 0 is the mean.
cam_ilc_status_t sim_firmware_learning(sim_firmware_t *f);
cam_ilc_harmonic_t sim_firmware_harmonic(sim_firmware_t *f, uint32_t k);

/// Flip the lowest bit of a byte of the table image in the controller's memory.
/// @param image  the selected image: the controller's memory when it runs in this process
/// @param at     offset in it
void sim_firmware_flip(sim_firmware_t *f, uint8_t *image, size_t at);

#endif
