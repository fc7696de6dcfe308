// SPDX-License-Identifier: Apache-2.0
/// cam_log_text: lines of text for people: why the controller started, whether the table is in use,
/// what the scales resolve, every change of state, every fault, who commands, who was refused. They
/// go to hal_text(). All functions: slow side, main() only.
#ifndef CAM_LOG_TEXT_H
#define CAM_LOG_TEXT_H

#include "cam_table_store.h" // cam_table_store_t
#include "cam_tick.h"        // cam_status_t
#include "hal/hal.h"         // hal_start_t
#include <stdbool.h>         // bool
#include <stdint.h>          // uint32_t

/// What has been reported; zero-initialised when nothing has.
typedef struct {
    bool has_table;    ///< whether the last line about the table said that there is one
    cam_state_t state; ///< state of the last line about a state
    uint32_t faults;   ///< mask of the reported faults that still last
    uint32_t commander, n_take_overs, n_losses; ///< of the last line about command
    cam_level_t level;                          ///< of the last line about it
    uint32_t n_refused;     ///< senders without the right to it, not all of them reported
    uint32_t refused_tick;  ///< [ticks] of the last line about one
    uint32_t refused_ticks; ///< [ticks] between two of these lines at least
} cam_log_text_t;

/// Report why the controller started, for example "start: watchdog reset".
void cam_log_text_start(const hal_start_t *start);

/// Report which parameters the controller begins with, for example "params: version 12 in use", and
/// what of the kept ones this image does not know.
void cam_log_text_params(const cam_machine_t *machine);

/// Report what the outputs and scales of the axes resolve, how fast the outputs are, and the form
/// error that their steps cost, as far as the port names them: for example "scales: U 30.5 nm, read
/// to 100.0 nm; X 50.0 nm up to 36000 um/s" and "form error by the steps of the outputs: 0.040 um;
/// a count of the encoder is 94.2 nm of U". The last is for the table in use.
void cam_log_text_scales(const cam_machine_t *machine);

/// Report the result of the last check of the table, for example "table: perkins240 in use, signed
/// by key 0123456789abcdef", or ".. in
/// use, not signed" where there are keys.
void cam_log_text_table(cam_log_text_t *l, const cam_table_store_t *store);

/// Report that a command was refused since its sender may not give it, at most once a second.
void cam_log_text_refused(cam_log_text_t *l, uint32_t sender, uint32_t command, cam_err_t err,
                          uint32_t tick);

/// Report at most one change of state, fault, table, commander or level, so that a slow serial line
/// does not hold up the main loop. When the background check has found the table damaged, the
/// store's error is set as well.
void cam_log_text_change(cam_log_text_t *l, cam_table_store_t *store, const cam_status_t *status);

#endif
