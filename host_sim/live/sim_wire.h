// SPDX-License-Identifier: Apache-2.0
/// sim_wire: the connection of the controller's process to the lathe's, one packet each way per
/// tick.
///
///     lathe        time stamp, hal_host.in  ->  controller: cam_isr()
///     controller   hal_host.out, what plays ->  lathe: one period passes
///
/// All inputs and outputs of the port are sent as they are in memory, so a new one in hal_host.h
/// needs no change here. Both ends must be the same program, which the first packets check. Each
/// waits for the other, so the bytes of a session depend on the commands of each tick and not on
/// the computer's scheduling. The end of the partner is noticed at once; stopping it (SIGSTOP)
/// stops the time of both.
#ifndef SIM_WIRE_H
#define SIM_WIRE_H

#include "common_error.h" // common_error_t
#include "hal_host.h"     // hal_host_t
#include <stdbool.h>      // bool
#include <stdint.h>       // uint8_t, uint32_t

typedef struct {
    uint32_t clock; ///< [1 / hal_host_clock_hz] time stamp of the next tick
    uint8_t in[sizeof((hal_host_t *)0)->in];
} sim_wire_sensed_t;

/// State of the controller that the lathe's gauge needs.
typedef struct {
    uint32_t table_crc32; ///< table in use, 0: none
    int32_t phase_udeg;   ///< rotation of the part
    uint32_t is_waiting;  ///< 1: nothing is enabled before the button is pressed
    uint32_t session;     ///< session of the commander, 0: none
} sim_wire_played_t;

typedef struct {
    sim_wire_played_t played;
    uint8_t out[sizeof((hal_host_t *)0)->out];
} sim_wire_written_t;

/// A packet socket (SOCK_SEQPACKET) to the partner.
typedef struct {
    int fd;
    bool is_lost;             ///< the partner has ended; nothing more is sent or received
    sim_wire_played_t played; ///< from the controller's last packet
} sim_wire_t;

/// Exchange greetings with the partner.
/// @param fd       descriptor of a packet socket
/// @param tick_hz  the partner must have the same
/// @return         false and *e when it is not a packet socket or the partner is another program
bool sim_wire_open(sim_wire_t *w, int fd, uint32_t tick_hz, common_error_t *e);

// Lathe: send inputs, wait for outputs. @return false when the partner is lost

bool sim_wire_send_sensed(sim_wire_t *w);
bool sim_wire_receive_written(sim_wire_t *w);

// Controller: wait for inputs, send outputs. @return false when the partner is lost

bool sim_wire_receive_sensed(sim_wire_t *w);
bool sim_wire_send_written(sim_wire_t *w, const sim_wire_played_t *played);

#endif
