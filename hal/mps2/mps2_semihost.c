// SPDX-License-Identifier: Apache-2.0
#include "mps2_semihost.h"
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t

/// Operations.
enum { sys_open = 0x01, sys_write = 0x05, sys_exit_extended = 0x20 };

/// Mode of sys_open: "w".
enum { open_for_writing = 4 };

/// Exit reason of a normal end: ADP_Stopped_ApplicationExit.
enum { application_exit = 0x20026 };

/// Execute a semihosting operation, by its reserved breakpoint. @return its result
static int32_t call_host(uint32_t operation, const void *arguments)
{
    register uint32_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = arguments;
    __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return (int32_t)r0;
}

/// @return handle of the standard output: the console ":tt", opened for writing
static int32_t console(void)
{
    static bool is_open;
    static int32_t handle;
    if (!is_open) {
        static const char name[] = ":tt";
        const uintptr_t arguments[] = {(uintptr_t)name, open_for_writing, sizeof name - 1u};
        handle = call_host(sys_open, arguments);
        is_open = true;
    }
    return handle;
}

void mps2_write(const char *bytes, size_t n)
{
    const uintptr_t arguments[] = {(uintptr_t)console(), (uintptr_t)bytes, n};
    (void)call_host(sys_write, arguments);
}

void mps2_exit(int status)
{
    const uintptr_t arguments[] = {application_exit, (uintptr_t)status};
    (void)call_host(sys_exit_extended, arguments);
    for (;;) {
    }
}
