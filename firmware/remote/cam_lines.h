// SPDX-License-Identifier: Apache-2.0
/// cam_lines: lines for people: why the controller started, what became of the table, every change
/// of state, every fault. All functions: slow side, main() only.
#ifndef CAM_LINES_H
#define CAM_LINES_H

#include "cam_store.h" // cam_store_t
#include "cam_tick.h"  // cam_status_t
#include "hal/hal.h"   // hal_start_t
#include <stdbool.h>   // bool
#include <stdint.h>    // uint32_t

/// What was told last; zero-initialised is: nothing.
typedef struct {
    bool has_table; ///< the machine's
    cam_state_t state;
    uint32_t faults;
} cam_lines_t;

/// Why the controller started.
void cam_lines_start(const hal_start_t *start);

/// The result of a check of the table.
void cam_lines_table(cam_lines_t *l, const cam_store_t *store);

/// Say at most one change of state, fault or table, so that a slow serial line does not hold up the
/// rest. A table that is gone, found damaged in the background, is noted in the store too.
void cam_lines_change(cam_lines_t *l, cam_store_t *store, const cam_status_t *status);

#endif
