// SPDX-License-Identifier: Apache-2.0
// The process of the Linux port dies at every system call by which it keeps a table, parameters or
// a black box, before it is done, behind it and, for a write, in the middle of it. A child does the
// keeping with functions in front of those of the library; the parent then reads the files as the
// next start does: the old content or the new one, whole.
//
// A process that dies leaves what it gave to the kernel. What a disk does with it when the supply
// falls is a matter of fsync() before rename(), whose order is checked here, too.
//
// Prints one JSON object; exits 1 where a start finds something else.
#include "lin_setup.h"
#include <fcntl.h>       // O_CREAT
#include <stdarg.h>      // va_arg
#include <stdio.h>       // printf
#include <stdlib.h>      // mkdtemp
#include <string.h>      // memset
#include <sys/syscall.h> // SYS_write
#include <sys/wait.h>    // waitpid
#include <unistd.h>      // fork, syscall

enum { old_bytes = 5000, new_bytes = 7000, died = 99 };
typedef enum { before_call, in_call, behind_call, n_moments } moment_t;
typedef enum { keeps_table, keeps_params, keeps_box, n_keepers } keeper_t;

static char folder[] = "/tmp/campaign_power.XXXXXX";
static char table_path[64], params_path[64], box_path[80];
static uint8_t content[2][new_bytes];
static int n_left; // calls until the process dies in one, 0: it lives
static moment_t moment;
static int n_unsynced; // writes behind which no fsync() was
static struct {
    unsigned n_falls, n_old, n_new, n_wrong, n_unordered;
} sum;

/// @return whether this call is the last one
static bool is_last(void)
{
    n_left--;
    if (n_left == 0 && moment == before_call) {
        _exit(died);
    }
    return n_left == 0;
}

static long ended(bool is_the_last, long result)
{
    if (is_the_last) {
        _exit(died);
    }
    return result;
}

ssize_t write(int fd, const void *bytes, size_t n)
{
    const bool is = is_last();
    n_unsynced++;
    return ended(is, syscall(SYS_write, fd, bytes, is && moment == in_call ? n / 2u : n));
}

int fsync(int fd)
{
    const bool is = is_last();
    n_unsynced = 0;
    return (int)ended(is, syscall(SYS_fsync, fd));
}

int rename(const char *from, const char *to)
{
    if (n_unsynced > 0) {
        _exit(died + 1); // the disk may have the new name before the bytes
    }
    const bool is = is_last();
    return (int)ended(is, syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

int close(int fd)
{
    const bool is = is_last();
    return (int)ended(is, syscall(SYS_close, fd));
}

int open(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    const int mode = (flags & O_CREAT) != 0 ? va_arg(rest, int) : 0;
    va_end(rest);
    const bool is = is_last();
    return (int)ended(is, syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

static uint32_t size_of(int version)
{
    return version == 0 ? old_bytes : new_bytes;
}

/// Keep a version as the firmware does. @return whether it was reported as kept
static bool keep(keeper_t keeper, int version)
{
    common_error_t e = {0};
    switch (keeper) {
    case keeps_table:
        return lin_table_begin(size_of(version)) &&
               lin_table_write(0, content[version], size_of(version)) && lin_table_commit(&e);
    case keeps_params:
        return lin_params_keep(content[version], size_of(version), &e);
    default:
        lin_blackbox_keep((const int32_t *)(const void *)content[version], size_of(version) / 4u,
                          &e);
        return e.text[0] == '\0';
    }
}

/// What a start finds.
static bool is_found(const void *bytes, uint32_t size, int version)
{
    return size == size_of(version) && memcmp(bytes, content[version], size) == 0;
}

/// Start anew and look. @return 0 or 1: the version, 2: something else
static int start(keeper_t keeper)
{
    common_error_t e = {0};
    const void *bytes;
    uint32_t size;
    if (keeper == keeps_table) {
        if (!lin_table_open(table_path, 1 << 16, &e)) {
            return 2;
        }
        bytes = lin_table_image().bytes;
        size = lin_table_image().size;
    } else if (keeper == keeps_params) {
        lin_params_open(params_path, &e);
        bytes = lin_params_kept().bytes;
        size = lin_params_kept().size;
    } else {
        lin_blackbox_open(table_path, &e);
        bytes = lin_blackbox_memory().words;
        size = lin_blackbox_memory().n_kept * 4u;
    }
    const bool is_well = e.text[0] == '\0';
    return is_well && is_found(bytes, size, 0) ? 0 : is_well && is_found(bytes, size, 1) ? 1 : 2;
}

/// Let a child keep the new version and die in its n-th call.
/// @return its exit status
static int die(keeper_t keeper, int n)
{
    const pid_t child = fork();
    if (child == 0) {
        n_unsynced = 0;
        n_left = n;
        _exit(keep(keeper, 1) ? 0 : died + 2);
    }
    int status = 0;
    (void)waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : died + 3;
}

/// @return whether the child died, so that there may be further calls
static bool fall(keeper_t keeper, int n)
{
    n_left = 0;
    (void)start(keeper);
    if (!keep(keeper, 0)) {
        sum.n_wrong++;
        return false;
    }
    const int status = die(keeper, n);
    const int version = start(keeper);
    if (status != died) {
        sum.n_unordered += status == died + 1 ? 1u : 0u;
        sum.n_wrong += status == 0 && version == 1 ? 0u : 1u;
        return false;
    }
    sum.n_falls++;
    sum.n_old += version == 0 ? 1u : 0u;
    sum.n_new += version == 1 ? 1u : 0u;
    sum.n_wrong += version == 2 ? 1u : 0u;
    // And behind any fall it can be kept again.
    sum.n_wrong += keep(keeper, 1) && start(keeper) == 1 ? 0u : 1u;
    return true;
}

int main(void)
{
    if (mkdtemp(folder) == NULL) {
        return 2;
    }
    (void)snprintf(table_path, sizeof table_path, "%s/table", folder);
    (void)snprintf(params_path, sizeof params_path, "%s/parameters", folder);
    (void)snprintf(box_path, sizeof box_path, "%s.blackbox", table_path);
    memset(content[0], 0x11, sizeof content[0]);
    memset(content[1], 0x22, sizeof content[1]);
    for (int keeper = 0; keeper < (int)n_keepers; keeper++) {
        for (moment = before_call; moment < n_moments; moment++) {
            for (int n = 1; fall((keeper_t)keeper, n); n++) {
            }
        }
    }
    const char *const paths[] = {table_path, params_path, box_path};
    for (int i = 0; i < 3; i++) {
        char fresh[90];
        (void)snprintf(fresh, sizeof fresh, "%s.new", paths[i]);
        (void)unlink(fresh);
        (void)unlink(paths[i]);
    }
    (void)rmdir(folder);
    (void)printf("{\"falls\": %u, \"old\": %u, \"new\": %u, \"wrong\": %u, \"unordered\": %u}\n",
                 sum.n_falls, sum.n_old, sum.n_new, sum.n_wrong, sum.n_unordered);
    return sum.n_wrong > 0u || sum.n_unordered > 0u || sum.n_falls == 0u ? 1 : 0;
}
