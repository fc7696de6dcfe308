// SPDX-License-Identifier: Apache-2.0
/// sim_remote: the firmware on a target, one exchange per tick or call (pil_wire.h).
///
/// The machine stays at the simulator's port: a tick sends the port's readings, faults included,
/// and writes the target's answer to the port.
#ifndef SIM_REMOTE_H
#define SIM_REMOTE_H

#include "cam_trace.h"    // cam_trace_t
#include "pil_wire.h"     // pil_answer_t
#include "sim_emulator.h" // sim_emulator_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t

/// A request and the bytes that may follow it.
typedef struct {
    pil_request_t head;
    uint8_t bytes[pil_chunk_bytes];
} sim_remote_request_t;

typedef struct {
    sim_emulator_t emulator;
    pil_hello_t hello;
    sim_remote_request_t request;
    pil_answer_t answer;
    cam_trace_t trace; ///< records of the target still to be read
    bool is_lost;      ///< `error` has the reason
    common_error_t error;
} sim_remote_t;

/// Start the target with the rates of the simulator's port and the controller in state off.
/// @param target  of sim_target.h
/// @param image   path of its image
/// @return        NULL and *e when it does not start or its greeting differs
sim_remote_t *sim_remote_open(const char *target, const char *image, common_error_t *e);

/// @param r  may be NULL
void sim_remote_close(sim_remote_t *r);

/// One tick.
/// @param status  of the controller after the tick
/// @return        false when the target is lost; *status is unchanged
bool sim_remote_tick(sim_remote_t *r, cam_status_t *status);

/// A call of the slow side.
/// @return the firmware's result; cam_err_busy when the target is lost
cam_err_t sim_remote_call(sim_remote_t *r, pil_op_t op, uint32_t a, int32_t b);

/// Send a table image and select it.
/// @return as cam_machine_select_table(); cam_err_busy when the target is lost. An image too large
///         for the target loses it, with that reason
cam_err_t sim_remote_select_table(sim_remote_t *r, const void *image, size_t size);

#endif
