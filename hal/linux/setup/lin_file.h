// SPDX-License-Identifier: Apache-2.0
/// lin_file: reads and atomically replaces whole files.
///
/// New content is written to a second file, flushed to disk and renamed over the old one, so that a
/// power failure leaves either the old or the new content. Context: main().
#ifndef LIN_FILE_H
#define LIN_FILE_H

#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // uint8_t, uint32_t
#include <sys/types.h>    // ssize_t

/// Read the rest of a file.
/// @return [bytes] number of bytes read, at most `room`; -1 and errno on error
ssize_t lin_file_read(int fd, uint8_t *bytes, uint32_t room);

/// Replace a file and wait for the disk. The rename makes the new content valid, even if flushing
/// the directory fails.
/// @param e  error, text "" if none
/// @return   false and *e: the file cannot be written and the old one remains. True and *e: a power
///           failure may restore the old one
bool lin_file_replace(const char *path, const uint8_t *bytes, uint32_t n, common_error_t *e);

#endif
