// SPDX-License-Identifier: Apache-2.0
/// mps2_semihost: services of the emulator: output and exit.
/// Source: ARM "Semihosting for AArch32 and AArch64", operations 0x01, 0x05, 0x20.
#ifndef MPS2_SEMIHOST_H
#define MPS2_SEMIHOST_H

#include <stddef.h> // size_t

/// Write n bytes to the standard output of the emulator.
void mps2_write(const char *bytes, size_t n);

/// End the emulation with an exit status. Does not return.
_Noreturn void mps2_exit(int status);

#endif
