// SPDX-License-Identifier: Apache-2.0
/// fuzz_file: an input as a file with a path, for readers that open one. It lies in memory.
#ifndef FUZZ_FILE_H
#define FUZZ_FILE_H

#include <stddef.h> // size_t
#include <stdint.h> // uint8_t

/// Replace the content of the file. @return its path, static
const char *fuzz_file(const uint8_t *data, size_t size);

#endif
