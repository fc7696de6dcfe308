// SPDX-License-Identifier: Apache-2.0
/// lin_report: what the port reports of itself, each a line for people, by hal_text(). Context:
/// main().
#ifndef LIN_REPORT_H
#define LIN_REPORT_H

#include "lin_config.h" // lin_config_t
#include "lin_words.h"  // lin_cause_t
#include <stddef.h>     // size_t
#include <stdint.h>     // uint32_t

/// Report the machine as it was set up, and what is doubtful about it.
/// @param n_room  [frames] that the queue of can.interface takes, 0: it has none
void lin_report_set_up(const lin_config_t *config, uint32_t n_room);

/// Makes a line of a cause: lin_words_bus, lin_words_drives.
typedef void lin_report_put_t(lin_cause_t cause, const lin_config_t *config, char *line,
                              size_t size);

/// Report a word of lin_words_pack() that changed since it was reported last.
void lin_report_change(uint32_t *told, uint32_t word, lin_report_put_t *put,
                       const lin_config_t *config);

/// Report the GPIO line that was lost, once.
void lin_report_lost_line(void);

/// Report the ticks that were left out since the last call.
/// @param n  since the start
void lin_report_overruns(uint32_t n);

#endif
