// SPDX-License-Identifier: Apache-2.0
/// sim_file: reads a whole file into memory.
#ifndef SIM_FILE_H
#define SIM_FILE_H

#include "common_error.h" // common_error_t
#include <stddef.h>       // size_t
#include <stdint.h>       // uint8_t

typedef struct {
    uint8_t *bytes; ///< aligned to 32 bytes, as a table image must be
    size_t size;
} sim_file_t;

/// Read a regular file. Pipes and devices are refused, because they may never end.
/// @param max_bytes  a larger file is refused
/// @return           false and *e when it is not a regular file, cannot be read or is too large
bool sim_file_read(sim_file_t *f, const char *path, size_t max_bytes, common_error_t *e);

void sim_file_free(sim_file_t *f);

#endif
