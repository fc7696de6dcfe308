// SPDX-License-Identifier: Apache-2.0
/// sim_live: a controller and a lathe that stay, each a process of its own, in the time of a clock.
///
///     CAN frames <-> stdin, stdout of the controller <-> sim_wire <-> lathe <- words on its stdin
///
/// The controller is the firmware with the loop of its main(), on the host port; what it is told
/// over CAN is its only operator. A frame on stdin or stdout is a hal_can_frame_t as it lies in
/// memory. The lathe is that of a run (sim_port.h). What happens when one of them is gone:
///
/// - the lathe: the controller finds its drives not ready and its bus lost, from the next tick on,
///   and goes on alone; encoder and axes stay where they were read last.
/// - the controller: the drives are disabled and brake to rest within their limits, the spindle,
///   too, and the lathe reports where everything stands.
/// - whoever holds the other end of stdin: both end, with status 0.
///
/// The lathe gauges each part that is cut by the table which it was started with, and says how good
/// it is; then the next blank is in the chuck.
///
/// POSIX; it needs neither rights nor a kernel with CAN.
#ifndef SIM_LIVE_H
#define SIM_LIVE_H

#include "common_error.h" // common_error_t
#include "sim_cut.h"      // sim_cut_options_t
#include "sim_operator.h" // sim_operator_t
#include "sim_pace.h"     // sim_pace_t
#include "sim_port.h"     // sim_port_t
#include "sim_session.h"  // sim_session_t
#include "sim_wire.h"     // sim_wire_t
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t

enum { sim_live_word_bytes = 80 }; ///< longest line on the lathe's stdin

/// Who stands at the machine.
typedef enum {
    sim_live_waived,  ///< nobody, and the controller needs no button
    sim_live_present, ///< somebody presses the button when it is needed, and turns
                      ///< the key switch on for each commander
    sim_live_absent,  ///< nobody; the key switch is off
} sim_live_operator_t;

typedef struct {
    sim_cut_options_t cut; ///< session, wishes, rpm and feed are used
    int wire;              ///< descriptor of the socket to the partner
    double speed_up;       ///< how many times faster than the clock
    sim_live_operator_t people;
    uint8_t secret[64]; ///< of the challenge that unlocks
    uint32_t n_secret;  ///< [bytes] of it, 0: none
} sim_live_options_t;

typedef struct {
    sim_live_options_t options;
    sim_session_t session;
    size_t n_image; ///< [bytes] of the table image
    sim_port_t port;
    sim_wire_t wire;
    sim_pace_t pace;
    bool was_lost, has_rested; ///< what was reported of a partner that is gone
    bool is_warned;            ///< that the computer is too slow
    uint32_t n_parts;          ///< that were cut, or begun
    bool is_foreign_cut;       ///< in the cut that runs: by another table than that of the drawing
    bool was_in_cut;
    char word[sim_live_word_bytes];
    size_t n_word;
    sim_operator_t people; ///< of the lathe
} sim_live_t;

/// Read table and design, place the blank and greet the partner.
/// @param l      16 MB: allocate it
/// @param image  of a table; copied
/// @param name   of the table file, for messages
/// @return       false and *e when the input is no good or there is no partner; nothing to close
bool sim_live_open(sim_live_t *l, const sim_live_options_t *options, const void *image, size_t size,
                   const char *name, common_error_t *e);

/// Be the lathe until stdin ends. A line on stdin is a kind of sim_inject.h with its value, which
/// happens at once, or `release`, which takes back estop, drive and bus. `acknowledge:SECONDS`
/// presses the button for so long, `key:1` and `key:0` turn the key switch.
void sim_live_lathe(sim_live_t *l);

/// Gauge what the last tick has done to the part. A part of lobes or of several passes is not
/// gauged, since its gauge must know more than the drawing.
void sim_live_gauge(sim_live_t *l);

/// Be the controller until stdin ends. @return false and *e when a parameter is refused
bool sim_live_controller(sim_live_t *l, common_error_t *e);

void sim_live_close(sim_live_t *l);

#endif
