// SPDX-License-Identifier: Apache-2.0
/// sim_wire: the wire between the controller's process and the lathe's, a packet each way per tick.
///
///     lathe        time stamp, hal_host.in  ->  controller: cam_isr()
///     controller   hal_host.out, what plays ->  lathe: one period passes
///
/// Whatever the port senses or writes crosses the wire as it lies in memory, so that a new input or
/// output of hal_host.h needs nothing here. Both ends must therefore be the same program, which the
/// first packet of each proves. Both wait for each other: the bytes of a session depend on what is
/// commanded in which tick, and not on how the computer shares its time. A partner that ended is
/// noticed at once, one that was only stopped (SIGSTOP) stops the time of both.
#ifndef SIM_WIRE_H
#define SIM_WIRE_H

#include "common_error.h" // common_error_t
#include "hal_host.h"     // hal_host_t
#include <stdbool.h>      // bool
#include <stdint.h>       // uint8_t, uint32_t

typedef struct {
    uint32_t clock; ///< [1 / hal_host_clock_hz] time stamp of the tick to come
    uint8_t in[sizeof((hal_host_t *)0)->in];
} sim_wire_sensed_t;

/// What the controller plays: the lathe moves without it, but its gauge must know.
typedef struct {
    uint32_t table_crc32; ///< of the table in use, 0: none
    int32_t phase_udeg;   ///< by which the part is turned
    uint32_t is_waiting;  ///< 1: nothing is enabled before somebody presses the button
    uint32_t session;     ///< of the commander, 0: nobody
} sim_wire_played_t;

typedef struct {
    sim_wire_played_t played;
    uint8_t out[sizeof((hal_host_t *)0)->out];
} sim_wire_written_t;

/// A socket for packets (SOCK_SEQPACKET), whose other end the partner has.
typedef struct {
    int fd;
    bool is_lost;             ///< the partner has ended; nothing is sent or received any more
    sim_wire_played_t played; ///< of the last packet of the controller
} sim_wire_t;

/// Greet the partner, and wait until it greets.
/// @param fd       of a socket for packets
/// @param tick_hz  that the partner must have, too
/// @return         false and *e when it is no such socket or the partner is another program
bool sim_wire_open(sim_wire_t *w, int fd, uint32_t tick_hz, common_error_t *e);

// Lathe: hand over what is sensed, wait for what is written. @return false when it is lost

bool sim_wire_tell_sensed(sim_wire_t *w);
bool sim_wire_take_written(sim_wire_t *w);

// Controller: wait for what is sensed, hand over what is written. @return false when it is lost

bool sim_wire_take_sensed(sim_wire_t *w);
bool sim_wire_tell_written(sim_wire_t *w, const sim_wire_played_t *played);

#endif
