// SPDX-License-Identifier: Apache-2.0
/// lin_cause: text of bus and drive failures. Pure.
#ifndef LIN_CAUSE_H
#define LIN_CAUSE_H

#include "lin_bus.h" // lin_cause_t
#include <stddef.h>  // size_t
#include <stdint.h>  // uint32_t

enum { lin_line_bytes = 120 }; ///< [bytes] limit of hal_text(), with the terminator

/// Pack a cause into one word, for one atomic store; 0: no failure.
uint32_t lin_cause_pack(lin_cause_t cause);
lin_cause_t lin_cause_unpack(uint32_t word);

/// "bus: node 3 (drive x): no heartbeat", "bus: bus-off", "bus: all nodes are heard".
/// @param line  [size]
void lin_cause_bus_text(lin_cause_t cause, const lin_config_t *config, char *line, size_t size);

/// "drives: node 3 (drive x) is not ready: error code 8611h", "drives: ready".
void lin_cause_drives_text(lin_cause_t cause, const lin_config_t *config, char *line, size_t size);

#endif
