// SPDX-License-Identifier: Apache-2.0
/// cam_log_text: lines of text for people, written by hal_text(). All functions: slow side, main()
/// only.
#ifndef CAM_LOG_TEXT_H
#define CAM_LOG_TEXT_H

#include "cam_table_store.h" // cam_table_store_t
#include "cam_status.h"      // cam_status_t
#include "hal/hal.h"         // hal_start_t
#include <stdbool.h>         // bool
#include <stdint.h>          // uint32_t

/// The last reported values; starts with zeros.
typedef struct {
    bool has_table;    ///< a table was in use in the last line about it
    cam_state_t state; ///< state of the last line about a state
    bool is_unsteady;  ///< the end of a start without a steady spindle was reported
    uint32_t faults;   ///< mask of the reported faults that are still latched
    uint32_t commander, n_take_overs, n_losses; ///< of the last line about command
    cam_level_t level;                          ///< of the last line about it
    uint32_t n_refused;     ///< commands refused for lack of rights, not all of them reported
    uint32_t refused_tick;  ///< [ticks] of the last line about one
    uint32_t refused_ticks; ///< [ticks] least time between two of these lines
} cam_log_text_t;

/// Report why the controller started, for example "start: watchdog reset".
void cam_log_text_start(const hal_start_t *start);

/// Report the initial parameters, for example "params: version 12 in use", and the stored ones that
/// this image does not use.
void cam_log_text_params(const cam_machine_t *machine);

/// Report resolution and highest speed of the axes that the port names, and the resulting form
/// error of the table in use: "scales: U 30.5 nm, read to 100.0 nm; X 50.0 nm up to 36000 um/s" and
/// "form error by the steps of the outputs: 0.040 um; a count of the encoder is 94.2 nm of U".
void cam_log_text_scales(const cam_machine_t *machine);

/// Report the result of the last check of the table, for example "table: perkins240 in use". A
/// second line names a speed at which the encoder's counts do not average, and a better one.
void cam_log_text_table(cam_log_text_t *l, const cam_table_store_t *store);

/// Report a command that its sender may not give, at most once a second.
void cam_log_text_refused(cam_log_text_t *l, uint32_t sender, uint32_t command, cam_err_t err,
                          uint32_t tick);

/// Report at most one change of table, state, fault, commander or level, or the end of a start
/// without a steady spindle, so that a slow serial line does not hold up the main loop. If the
/// background check found the table damaged, this also sets the store's error.
void cam_log_text_change(cam_log_text_t *l, cam_table_store_t *store, const cam_status_t *status);

#endif
