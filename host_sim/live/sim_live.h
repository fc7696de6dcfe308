// SPDX-License-Identifier: Apache-2.0
/// sim_live: a controller and a lathe that keep running, each in its own process, paced by the
/// clock.
///
///     CAN frames <-> stdin, stdout of the controller <-> sim_wire <-> lathe <- words on its stdin
///
/// The controller is the firmware with the loop of its main(), on the host port, operated over CAN
/// only. A frame on stdin or stdout is a hal_can_frame_t as it is in memory. The lathe is that of a
/// run (sim_port.h). Losing a process has these effects:
///
/// - the lathe: from the next tick on the controller reads drives not ready and bus lost, and
///   continues alone; encoder and axes keep their last readings.
/// - the controller: drives and spindle are disabled and brake to rest within their limits, and the
///   lathe reports all positions.
/// - the process at the other end of stdin: both end, with status 0.
///
/// The lathe gauges each part that is cut by the table given at its start, prints the result, and
/// mounts the next blank.
///
/// POSIX; needs no privileges and no CAN in the kernel.
#ifndef SIM_LIVE_H
#define SIM_LIVE_H

#include "common_error.h" // common_error_t
#include "hal_host.h"     // hal_host_t
#include "sim_cut.h"      // sim_cut_options_t
#include "sim_inject.h"   // sim_operator_t
#include "sim_port.h"     // sim_port_t
#include "sim_session.h"  // sim_session_t
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t
#include <stdint.h>       // int64_t, uint8_t, uint32_t

// Paces virtual time by the clock, or a multiple of it.
//
// Ticks come in bursts of about a millisecond, since a computer cannot sleep for 50 us. A slow
// computer catches up on a delay of up to 0.1 s; longer delays are dropped, so that a lathe that
// was held up does not rush afterwards.

typedef struct {
    double tick_ns; ///< [ns] clock time of a tick
    double due_ns;  ///< [ns] when the next tick is due
    double lost_ns; ///< [ns] delay dropped so far
} sim_pace_t;

/// Start now. @param speed_up  times faster than the clock
void sim_pace_init(sim_pace_t *p, double tick_hz, double speed_up);

/// End a tick: sleep if the next one is due in more than a millisecond.
void sim_pace_tick(sim_pace_t *p);

// The connection of the controller's process to the lathe's, one packet each way per tick.
//
//     lathe        time stamp, hal_host.in  ->  controller: cam_isr()
//     controller   hal_host.out, what plays ->  lathe: one period passes
//
// All inputs and outputs of the port are sent as they are in memory, so a new one in hal_host.h
// needs no change here. Both ends must be the same program, which the first packets check. Each
// waits for the other, so the bytes of a session depend on the commands of each tick and not on
// the computer's scheduling. The end of the partner is noticed at once; stopping it (SIGSTOP)
// stops the time of both.

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

// Controller and lathe

enum { sim_live_word_bytes = 80 }; ///< longest line on the lathe's stdin

/// The operator at the machine.
typedef enum {
    sim_live_waived,  ///< none; the controller needs no button
    sim_live_present, ///< presses the button when needed, and turns the key switch on for
                      ///< each commander
    sim_live_absent,  ///< none; the key switch is off
} sim_live_operator_t;

typedef struct {
    sim_cut_options_t cut; ///< session, wishes, rpm and feed are used
    int wire;              ///< descriptor of the socket to the partner
    double speed_up;       ///< times faster than the clock
    sim_live_operator_t people;
} sim_live_options_t;

typedef struct {
    sim_live_options_t options;
    sim_session_t session;
    size_t n_image; ///< [bytes] of the table image
    sim_port_t port;
    sim_wire_t wire;
    sim_pace_t pace;
    bool was_lost, has_rested; ///< already reported of a lost partner
    bool is_warned;            ///< the warning of a slow computer is printed
    uint32_t n_parts;          ///< parts cut or started
    bool is_foreign_cut;       ///< the present cut uses another table than that of the drawing
    bool was_in_cut;
    char word[sim_live_word_bytes];
    size_t n_word;
    sim_operator_t people; ///< at the lathe
} sim_live_t;

/// Read table and design, mount the blank and greet the partner.
/// @param l      16 MB: allocate it
/// @param image  of a table; copied
/// @param name   of the table file, for messages
/// @return       false and *e when the input is bad or there is no partner; then nothing to close
bool sim_live_open(sim_live_t *l, const sim_live_options_t *options, const void *image, size_t size,
                   const char *name, common_error_t *e);

/// Run the lathe until stdin ends. A line on stdin is a kind of sim_inject.h with its value, which
/// happens at once, or `release`, which clears estop, drive and bus. `acknowledge:SECONDS` presses
/// the button for that time, `key:1` and `key:0` turn the key switch.
void sim_live_lathe(sim_live_t *l);

/// Gauge the result of the last tick. Lobes and parts of several passes are not gauged: their gauge
/// needs more than the drawing.
void sim_live_gauge(sim_live_t *l);

/// Run the controller until stdin ends. @return false and *e when a parameter is refused
bool sim_live_controller(sim_live_t *l, common_error_t *e);

void sim_live_close(sim_live_t *l);

#endif
