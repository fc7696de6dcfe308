// SPDX-License-Identifier: Apache-2.0
/// lin_lines: the lines of the controller by their meaning, and the safe reaction when one is lost.
///
/// A line that cannot be read or written any more (its chip was unplugged) is lost for good: from
/// then on the inputs say emergency stop and not ready, until the program is started anew.
#ifndef LIN_LINES_H
#define LIN_LINES_H

#include "lin_config.h"   // lin_config_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t, uint32_t

/// Take all lines that are wired; outputs inactive.
/// @return false and *e on the first one that cannot be taken. Context: main(), once.
bool lin_lines_open(const lin_config_t *config, common_error_t *e);

/// @return hal_in_estop, hal_in_drive_ready, the bits of homes, indices, button and key; lines that
///         are not wired are good, or off. Context: tick.
uint32_t lin_lines_read(void);

/// Take the oldest edge of the index line. @return whether there was one. Context: tick.
bool lin_lines_edge(int64_t *ns, bool *is_rising);

/// Write hal_out_*. Only lines that changed, and lines that could not be written the last time,
/// cost a system call: a low enable is repeated until it is written. Context: tick.
void lin_lines_write(uint32_t bits);

/// Switch enable off and fault on, whatever was written last. Context: any, a signal handler too.
void lin_lines_safe(void);

/// @return version of the library, static
const char *lin_lines_library(void);

/// @return the line that was lost first, lin_n_lines while there is none. Context: any.
lin_line_t lin_lines_lost(void);

#endif
