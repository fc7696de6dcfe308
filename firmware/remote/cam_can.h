// SPDX-License-Identifier: Apache-2.0
/// cam_can: remote control of a stand-alone controller: commands, status and downloads over CAN,
/// and lines of text for people.
///
/// The messages are those of can/camturn.dbc, packed and unpacked by functions that cantools
/// generates from it; can/README.md describes their interplay. What this module adds:
///
/// Every frame with the id of commands is answered. `done` means that the command was accepted; the
/// status shows the outcome. A frame whose length is not 8 is answered with cam_err_frame (missing
/// bytes are echoed as 0), one whose sender does not command with cam_err_not_commander
/// (cam_rights.h), an unknown command with cam_err_command. A value out of its range is answered
/// three times: refusal, minimum, maximum. Frames with other ids are ignored. read_scope is
/// answered behind the piece that it asks for (cam_reading.h); a command or a block that comes
/// before ends the piece, without an answer; strobe alone, which is renewed all the time, does not.
/// Answers that find no room in the transmit queue are kept, and
/// nothing is read before they have been sent. When the bus falls silent, the
/// heartbeats of the commander do, too: a second later the cut ends as by stop.
///
/// A table that cannot be used does not keep the controller from starting. Enable is then refused
/// with the error of its last check, which the status and a line of text report until a good table
/// is selected.
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

/// A value out of its range gets the most answers.
enum { cam_can_max_answers = 3 };

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
    uint32_t n_answers;                           ///< how many there are
    uint32_t n_answered;                          ///< how many have been sent
    bool is_wave;                                 ///< blocks are of a wave, not of a table
    uint8_t download_session; ///< that has begun the last download, of either kind
    cam_reading_t reading;    ///< piece of the recording that is being sent
    uint32_t strobe_tick;     ///< when the last message Strobe was sent
} cam_can_t;

/// Take the table of hal_table_image() into use if it is good, and report in lines of text why the
/// controller started and whether the table is in use.
/// @param machine  initialised, in state off; kept and used by cam_can_poll()
/// Context: main(), before hal_tick_start(); lasts as long as cam_table_store_select().
void cam_can_init(cam_can_t *r, cam_machine_t *machine);

/// Carry out at most one command or store at most one block, send the status when it is due, and
/// report at most one change of state, fault or table as a line of text.
/// Context: main loop. Lasts as long as the command that is carried out (cam_table_store.h); a
/// watchdog must allow for the check of a whole table.
void cam_can_poll(cam_can_t *r);

#endif
