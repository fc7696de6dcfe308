// SPDX-License-Identifier: Apache-2.0
/// mps2_semihost: services of the emulator: output, files, exit.
/// Source: ARM "Semihosting for AArch32 and AArch64", operations 0x01, 0x05, 0x06, 0x20.
#ifndef MPS2_SEMIHOST_H
#define MPS2_SEMIHOST_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t
#include <stdint.h>  // int32_t

/// Write n bytes to the standard output of the emulator.
void mps2_write(const char *bytes, size_t n);

/// End the emulation with an exit status. Does not return.
_Noreturn void mps2_exit(int status);

/// Open a file of the host in binary mode.
/// @param is_written  true: for writing, false: for reading
/// @return            handle, negative if the file cannot be opened
int32_t mps2_file_open(const char *path, bool is_written);

/// Read exactly n bytes. Blocks with emulated time stopped.
/// @return false at end of file or on error
bool mps2_file_read(int32_t file, void *bytes, size_t n);

/// Write exactly n bytes. Blocks with emulated time stopped.
/// @return false on error
bool mps2_file_write(int32_t file, const void *bytes, size_t n);

#endif
