// SPDX-License-Identifier: Apache-2.0
/// cam_can: the stand-alone controller's ear and mouth: commands, status and downloads over CAN,
/// lines for people.
///
/// The messages are those of can/camturn.dbc, packed and unpacked by functions that cantools makes
/// of it; can/README.md tells how they play together. What this module adds:
///
/// Every frame with the id of commands is answered; `done` means accepted, and the status tells the
/// outcome. A frame of another length than 8 or with reserved bytes set gets cam_err_frame (bytes
/// that did not come are echoed as 0), an unknown command cam_err_command. A value out of its range
/// is answered three times: refusal, minimum, maximum. Other ids are ignored. Answers that find no
/// room are kept, and nothing is read before they are sent. A silent bus stops nothing.
///
/// A table that cannot be used does not keep the controller from starting: enable is refused with
/// the error of its last check, which the status and a line repeat until a good table is selected.
/// All functions: slow side, main() only.
#ifndef CAM_CAN_H
#define CAM_CAN_H

#include "cam_isotp.h"   // cam_isotp_t
#include "cam_lines.h"   // cam_lines_t
#include "cam_machine.h" // cam_machine_t
#include "cam_report.h"  // cam_report_t
#include "cam_store.h"   // cam_store_t
#include "hal/hal.h"     // hal_can_frame_t
#include <stdint.h>      // uint8_t, uint32_t

enum { cam_can_max_answers = 3 };

/// State.
typedef struct {
    cam_machine_t *machine;
    cam_store_t store;
    cam_report_t report;
    cam_lines_t lines;
    cam_isotp_t isotp;
    uint8_t block[cam_store_block_header + cam_store_block_bytes];
    hal_can_frame_t answers[cam_can_max_answers]; ///< that wait for room
    uint32_t n_answers, n_answered;
} cam_can_t;

/// Take the table of hal_table_image() into use if it is good, say why the controller started and
/// what became of the table.
/// @param machine  initialised, state off; used by cam_can_poll() too
/// Context: main(), before hal_tick_start(); lasts as long as cam_store_select().
void cam_can_init(cam_can_t *r, cam_machine_t *machine);

/// Carry out one command or store one block at most, send status when it is due, say at most one
/// change of state, fault or table. Lasts as long as what is carried out, cam_store.h: a watchdog
/// must allow for the check of a table.
/// Context: main loop.
void cam_can_poll(cam_can_t *r);

#endif
