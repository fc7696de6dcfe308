// SPDX-License-Identifier: Apache-2.0
/// lin_file: files that are read whole and replaced whole.
///
/// New bytes are written beside the file, brought to the disk and renamed over it, so that a loss
/// of power leaves the old ones or the new ones. Context: main().
#ifndef LIN_FILE_H
#define LIN_FILE_H

#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // uint8_t, uint32_t
#include <sys/types.h>    // ssize_t

/// Read what is left of a file.
/// @return [bytes] that were read, at most `room`; -1 and errno when that fails
ssize_t lin_file_read(int fd, uint8_t *bytes, uint32_t room);

/// Replace a file and wait for the disk. The renaming decides: before it the old bytes stay, behind
/// it the new ones are there, also when the disk does not confirm the folder.
/// @param e  text "" when all is well
/// @return   false and *e: the file cannot be written, the old one stays. True and *e: a loss of
///           power may bring the old one back
bool lin_file_replace(const char *path, const uint8_t *bytes, uint32_t n, common_error_t *e);

#endif
