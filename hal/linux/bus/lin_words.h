// SPDX-License-Identifier: Apache-2.0
/// lin_words: what happened on the bus, for people. Pure.
#ifndef LIN_WORDS_H
#define LIN_WORDS_H

#include "lin_bus.h" // lin_cause_t
#include <stddef.h>  // size_t
#include <stdint.h>  // uint32_t

enum { lin_line_bytes = 120 }; ///< the most that hal_text() takes, with the end

/// Pack a cause into one word, for a hand-over by one atomic store; 0: nothing is wrong.
uint32_t lin_words_pack(lin_cause_t cause);
lin_cause_t lin_words_unpack(uint32_t word);

/// "bus: node 3 (drive x): no heartbeat", "bus: bus-off", "bus: all nodes are heard".
/// @param line  [size]
void lin_words_bus(lin_cause_t cause, const lin_config_t *config, char *line, size_t size);

/// "drives: node 3 (drive x) is not ready: error code 8611h", "drives: ready".
void lin_words_drives(lin_cause_t cause, const lin_config_t *config, char *line, size_t size);

#endif
