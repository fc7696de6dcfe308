// SPDX-License-Identifier: Apache-2.0
/// mps2_semihost: what an emulated image asks of the machine that emulates it.
///
/// Source: ARM "Semihosting for AArch32 and AArch64", operations 0x04, 0x05, 0x20.
#ifndef MPS2_SEMIHOST_H
#define MPS2_SEMIHOST_H

#include <stddef.h> // size_t

/// Write bytes to the emulator's standard output.
void mps2_write(const char *bytes, size_t n);

/// End the emulation with an exit status.
_Noreturn void mps2_exit(int status);

#endif
