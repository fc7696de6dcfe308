// SPDX-License-Identifier: Apache-2.0
/// lcn_record: the recorder (cam_machine.h) with files in place of a bus. The black box of
/// every fault, and every recording by command, is written to the next free NAME-1.csv, NAME-2.csv,
/// .. : tick, seconds from the trigger on, signals in the controller's numbers.
#ifndef LCN_RECORD_H
#define LCN_RECORD_H

#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool

/// Choose the files. Context: while the component is loaded, after cam_machine_init().
/// @param name  start of their names, valid until the component is unloaded; "": no recorder
void lcn_record_begin(cam_machine_t *m, const char *name);

/// Start and end recordings, and have finished ones written. Context: slow thread, every round.
/// @param records  rising: record until it falls or the memory is full
/// @return         whether a recording by command, or the writing of any, is not yet finished
bool lcn_record_poll(cam_machine_t *m, bool records);

/// Write a finished recording if there is one. Context: the thread of lcn_reload.h.
void lcn_record_serve(void);

#endif
