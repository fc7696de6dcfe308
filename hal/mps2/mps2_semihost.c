// SPDX-License-Identifier: Apache-2.0
#include "mps2_semihost.h"
#include <string.h> // strlen

/// Operations.
enum { sys_open = 0x01, sys_write = 0x05, sys_read = 0x06, sys_exit_extended = 0x20 };

/// Modes of sys_open: "w", "rb" and "wb".
enum { open_for_writing = 4, open_bytes_for_reading = 1, open_bytes_for_writing = 5 };

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

int32_t mps2_file_open(const char *path, bool is_written)
{
    const uintptr_t mode = is_written ? open_bytes_for_writing : open_bytes_for_reading;
    const uintptr_t arguments[] = {(uintptr_t)path, mode, strlen(path)};
    return call_host(sys_open, arguments);
}

/// Read or write n bytes. An operation returns the number of bytes not transferred; all of them
/// means end of file.
static bool transfer(uint32_t operation, int32_t file, uintptr_t bytes, size_t n)
{
    while (n > 0u) {
        const uintptr_t arguments[] = {(uintptr_t)file, bytes, n};
        const int32_t left = call_host(operation, arguments);
        if (left < 0 || (size_t)left >= n) {
            return false;
        }
        bytes += n - (size_t)left;
        n = (size_t)left;
    }
    return true;
}

bool mps2_file_read(int32_t file, void *bytes, size_t n)
{
    return transfer(sys_read, file, (uintptr_t)bytes, n);
}

bool mps2_file_write(int32_t file, const void *bytes, size_t n)
{
    return transfer(sys_write, file, (uintptr_t)bytes, n);
}

void mps2_exit(int status)
{
    const uintptr_t arguments[] = {application_exit, (uintptr_t)status};
    (void)call_host(sys_exit_extended, arguments);
    for (;;) {
    }
}
