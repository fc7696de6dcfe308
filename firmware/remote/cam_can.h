// SPDX-License-Identifier: Apache-2.0
/// cam_can: remote control of a stand-alone controller: commands, status and downloads over CAN,
/// and lines of text for people.
///
/// can/camturn.dbc defines the messages, cantools generates their pack and unpack functions from
/// it, and can/README.md describes the protocol. In addition:
///
/// - Every command frame is answered: with cam_err_frame if its length is not 8 (missing bytes are
///   echoed as 0), with cam_err_not_commander if the command needs the right to command and its
///   sender does not have it (cam_rights.h), with cam_err_command if it is unknown. Frames with
///   other ids are ignored.
/// - read_scope alone is answered later, when its data has been sent (cam_reading.h). A block, or
///   any command but strobe and heartbeat, aborts it unanswered.
/// - Answers that do not fit the transmit queue are kept, and nothing is read until they are sent.
/// - A silent bus also stops the commander's heartbeats: a second later the cut ends as by stop.
/// - A table that fails its check does not keep the controller from starting. Until one is
///   selected, enable is refused with the error of the check, which the status and a text report.
///
/// All functions: slow side, main() only.
#ifndef CAM_CAN_H
#define CAM_CAN_H

#include "cam_isotp.h"       // cam_isotp_t
#include "cam_log_text.h"    // cam_log_text_t
#include "cam_machine.h"     // cam_machine_t
#include "cam_reading.h"     // cam_reading_t
#include "cam_report.h"      // cam_report_t
#include "cam_table_store.h" // cam_table_store_t
#include "hal/hal.h"         // hal_can_frame_t
#include <stdbool.h>         // bool
#include <stdint.h>          // uint8_t, uint32_t

enum { cam_can_max_answers = 3 }; ///< to a value out of its range: refusal, minimum, maximum

/// State; made by cam_can_init().
typedef struct {
    cam_machine_t *machine;
    cam_table_store_t store;
    cam_report_t report;
    cam_log_text_t lines;
    cam_isotp_t isotp;
    uint8_t block[cam_table_store_block_header +
                  cam_table_store_block_bytes];   ///< message being received
    hal_can_frame_t answers[cam_can_max_answers]; ///< to the last command
    uint32_t n_answers, n_answered;               ///< queued, and sent of these
    bool is_wave;                                 ///< blocks are of a wave, not of a table
    uint8_t download_session;                     ///< that began the last download, of either kind
    cam_reading_t reading;                        ///< piece of the recording that is being sent
    uint32_t strobe_tick;                         ///< when the last message Strobe was sent
} cam_can_t;

/// Put the table of hal_table_image() into use if it is good, and report start and table as text.
/// @param machine  initialised, in state off; kept and used by cam_can_poll()
/// Context: main(), before hal_tick_start(); lasts as long as cam_table_store_select().
void cam_can_init(cam_can_t *r, cam_machine_t *machine);

/// Execute at most one command or store at most one block, send the status when due, and report at
/// most one change as a line of text.
/// Context: main loop. A command may last as long as the check of a whole table
/// (cam_table_store.h), for which a watchdog must allow.
void cam_can_poll(cam_can_t *r);

#endif
