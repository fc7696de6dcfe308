// SPDX-License-Identifier: Apache-2.0
/// lin_report: status lines of the port, by hal_text(). Context: main().
#ifndef LIN_REPORT_H
#define LIN_REPORT_H

#include "lin_config.h" // lin_config_t
#include "lin_cause.h"  // lin_cause_t
#include <stddef.h>     // size_t
#include <stdint.h>     // uint32_t

/// Report the configured machine and warnings about it.
/// @param n_room  [frames] length of the queue of can.interface, 0: no queue
void lin_report_set_up(const lin_config_t *config, uint32_t n_room);

/// Formats a cause: lin_cause_bus_text or lin_cause_drives_text.
typedef void lin_report_put_t(lin_cause_t cause, const lin_config_t *config, char *line,
                              size_t size);

/// Report a packed cause (lin_cause_pack()) if it differs from *last.
void lin_report_change(uint32_t *last, uint32_t word, lin_report_put_t *put,
                       const lin_config_t *config);

/// Report a lost GPIO line, once.
void lin_report_lost_line(void);

/// Report missed ticks since the last call.
/// @param n  missed ticks since the start
void lin_report_overruns(uint32_t n);

#endif
