// SPDX-License-Identifier: Apache-2.0
/// cam_report: the cyclic status: messages State, Spindle, AxisU and Detail of can/camturn.dbc.
///
/// Sent every 10 ms, counted in ticks, so without ticks there is no status. Of Detail, page 0 is
/// sent each time, and the other pages in turn. A frame that does not fit the transmit queue is
/// dropped. All functions: slow side, main() only.
#ifndef CAM_REPORT_H
#define CAM_REPORT_H

#include "cam_table_store.h" // cam_table_store_t
#include "cam_status.h"      // cam_status_t
#include "hal/hal.h"         // hal_start_t
#include <stdint.h>          // uint32_t, uint64_t

/// State; zero-initialised except for start.
typedef struct {
    hal_start_t start;    ///< why the controller started
    uint32_t status_tick; ///< [ticks] when the last status was due
    uint32_t i_page;      ///< last page of Detail that was sent in turn
    uint64_t load_cycles; ///< of the interrupts sampled since page 24 was sent
    uint32_t n_loads;     ///< how many were sampled
} cam_report_t;

/// Send the status if it is due.
void cam_report_send(cam_report_t *r, const cam_table_store_t *store, const cam_status_t *status);

#endif
