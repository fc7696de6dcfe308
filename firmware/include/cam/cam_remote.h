// SPDX-License-Identifier: Apache-2.0
/// cam_remote: the stand-alone controller's ear and mouth: commands and status over CAN, lines for
/// people.
///
/// Classic frames with 11-bit ids, numbers little-endian two's complement.
///
///     id     bytes  content
///     0x640  0      command, cam_remote_command_t                              to the controller
///            1      parameter, in the order of CAM_PARAMS from 0; other commands: any, echoed
///            2..3   0
///            4..7   int32, value to set; other commands: any
///     0x5C0  0..1   as in the command                                          its answer
///            2..3   int16 result, 0 or a cam_err_t
///            4..7   set, get: the value in force; enable, start refused as infeasible: the highest
///                   feasible speed in r/min / 1000, 0 when no speed helps; otherwise 0
///     0x180  0      cam_state_t                                                every 10 ms
///            1      hal_reset_t of the last start
///            2..3   int16, result of the last check of the table
///            4..7   fault mask, CAM_FAULT_BIT()
///     0x280  0..3   int32 spindle speed in r/min / 1000, signed as cutting sees it
///            4..7   int32 Z in nm
///     0x380  0..3   uint32 longest tick in cycles of hal_load()
///            4..7   uint32 late ticks since start
///
/// Every frame with the id of commands is answered; 0 means accepted, and the status tells the
/// outcome. A frame of another length than 8 or with reserved bytes set gets cam_err_frame (bytes
/// that did not come are echoed as 0), an unknown command cam_err_command. Other ids are ignored.
/// An answer that finds no room is kept, and no command is read before it is sent; a status frame
/// that finds no room is lost. Ten milliseconds are counted in ticks: no tick, no status. A silent
/// bus stops nothing.
///
/// A table that cannot be used does not keep the controller from starting: enable is refused with
/// the error of its last check, which the status and a line repeat until a good table is selected.
/// All functions: slow side, main() only.
#ifndef CAM_REMOTE_H
#define CAM_REMOTE_H

#include "cam/cam_err.h"     // cam_err_t
#include "cam/cam_machine.h" // cam_machine_t
#include "cam/cam_state.h"   // cam_state_t
#include "hal/hal.h"         // hal_start_t, hal_can_frame_t
#include <stdbool.h>         // bool
#include <stdint.h>          // uint32_t

/// Identifiers.
enum {
    cam_remote_id_state = 0x180,
    cam_remote_id_motion = 0x280,
    cam_remote_id_load = 0x380,
    cam_remote_id_answer = 0x5C0,
    cam_remote_id_command = 0x640,
};

/// Byte 0 of a command.
typedef enum {
    cam_remote_enable = 1,
    cam_remote_disable = 2,
    cam_remote_start = 3,
    cam_remote_stop = 4,
    cam_remote_reset = 5,
    cam_remote_set = 6,    ///< parameter
    cam_remote_get = 7,    ///< parameter
    cam_remote_select = 8, ///< check the table at its place anew and take it into use
} cam_remote_command_t;

/// State.
typedef struct {
    cam_machine_t *machine;
    hal_start_t start;
    cam_err_t table_err; ///< of the last check of the table
    bool has_table;      ///< the machine's, as told last
    bool has_answer;     ///< answer waits for room
    hal_can_frame_t answer;
    uint32_t status_tick; ///< [ticks] when the last status was due
    cam_state_t state;    ///< told last
    uint32_t faults;      ///< told
} cam_remote_t;

/// Take the table of hal_table_image() into use if it is good, say why the controller started and
/// what became of the table.
/// @param machine  initialised, state off; used by cam_remote_poll() too
/// Context: main(), before hal_tick_start(); lasts as long as cam_table_check(), on a Cortex-M7
/// about 26 instructions per byte of the image, 65 with a speed channel.
void cam_remote_init(cam_remote_t *r, cam_machine_t *machine);

/// Carry out one command at most, send status when it is due, say at most one change of state,
/// fault or table. Lasts as long as cam_table_check() when the command is select: a watchdog must
/// allow for that.
/// Context: main loop.
void cam_remote_poll(cam_remote_t *r);

#endif
