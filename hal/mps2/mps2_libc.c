// SPDX-License-Identifier: Apache-2.0
/// mps2_libc: system calls of newlib, for test programs only: output, heap, exit.
#include "mps2_semihost.h"
#include <errno.h>    // errno
#include <stddef.h>   // ptrdiff_t
#include <stdint.h>   // uint8_t
#include <sys/stat.h> // struct stat

extern uint8_t mps2_heap_start, mps2_heap_end;

/// Exit status of abort(), as in a shell.
enum { status_abort = 134 };

int _write(int file, const char *bytes, int n);
void *_sbrk(ptrdiff_t n);
_Noreturn void _exit(int status);
int _close(int file);
int _fstat(int file, struct stat *status);
int _isatty(int file);
long _lseek(int file, long offset, int from);
int _read(int file, char *bytes, int n);
int _kill(int process, int signal);
int _getpid(void);

int _write(int file, const char *bytes, int n)
{
    (void)file;
    mps2_write(bytes, (size_t)n);
    return n;
}

void *_sbrk(ptrdiff_t n)
{
    static uint8_t *top = &mps2_heap_start;
    if (n > &mps2_heap_end - top) {
        errno = ENOMEM;
        return (void *)-1;
    }
    uint8_t *const begin = top;
    top += n;
    return begin;
}

void _exit(int status)
{
    mps2_exit(status);
}

int _close(int file)
{
    (void)file;
    return 0;
}

int _fstat(int file, struct stat *status)
{
    (void)file;
    status->st_mode = S_IFCHR;
    return 0;
}

int _isatty(int file)
{
    (void)file;
    return 1;
}

long _lseek(int file, long offset, int from)
{
    (void)file;
    (void)offset;
    (void)from;
    return 0;
}

int _read(int file, char *bytes, int n)
{
    (void)file;
    (void)bytes;
    (void)n;
    return 0;
}

int _kill(int process, int signal)
{
    (void)process;
    (void)signal;
    mps2_exit(status_abort);
}

int _getpid(void)
{
    return 1;
}
