// SPDX-License-Identifier: Apache-2.0
/// lin_lines: the GPIO lines of the controller by function.
///
/// A line that can no longer be read or written (its chip was unplugged) is lost: the inputs then
/// report emergency stop and not ready until the program is restarted.
#ifndef LIN_LINES_H
#define LIN_LINES_H

#include "lin_config.h"   // lin_config_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t, uint32_t

/// Request all wired lines; outputs are inactive.
/// @return false and *e for the first line that fails. Context: main(), once.
bool lin_lines_open(const lin_config_t *config, common_error_t *e);

/// @return hal_in_* of all lines; an unwired estop or ready line reads as closed or ready, all
///         others as off. Context: tick.
uint32_t lin_lines_read(void);

/// Read the oldest edge of the index line. @return false if there is none. Context: tick.
bool lin_lines_edge(int64_t *ns, bool *is_rising);

/// Write hal_out_*. Only lines that changed or whose last write failed are written, each with one
/// system call; so enable low is retried until it succeeds. Context: tick.
void lin_lines_write(uint32_t bits);

/// Switch enable off and fault on unconditionally. Context: any, including signal handlers.
void lin_lines_safe(void);

/// @return version of the library, static
const char *lin_lines_library(void);

/// @return the first line that was lost, lin_n_lines: none. Context: any.
lin_line_t lin_lines_lost(void);

#endif
