// SPDX-License-Identifier: Apache-2.0
/// cam_report: the status that the controller sends unasked: messages State, Spindle, AxisU and
/// Detail of can/camturn.dbc, every 10 ms.
///
/// The 10 ms are counted in ticks, so without ticks there is no status. Of Detail, page 0 is sent
/// every time and one of the other pages in turn. A frame that finds no room is lost; the next one
/// has the newer values. All functions: slow side, main() only.
#ifndef CAM_REPORT_H
#define CAM_REPORT_H

#include "cam_table_store.h" // cam_table_store_t
#include "cam_tick.h"        // cam_status_t
#include "hal/hal.h"         // hal_start_t
#include <stdint.h>          // uint32_t, uint64_t

/// State; zero-initialised except for start.
typedef struct {
    hal_start_t start;    ///< why the controller started
    uint32_t status_tick; ///< [ticks] when the last status was due
    uint32_t i_page;      ///< of the pages of Detail, the last one that was sent in turn
    uint64_t load_cycles; ///< of the interrupts that were looked at since page 24 was sent
    uint32_t n_loads;     ///< how many these were
} cam_report_t;

/// Send the status if it is due.
void cam_report_send(cam_report_t *r, const cam_table_store_t *store, const cam_status_t *status);

#endif
