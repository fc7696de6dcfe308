// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): nanosleep
#include "lcn_reload.h"
#include "lcn_record.h" // lcn_record_serve
#include <pthread.h>    // pthread_create, pthread_join
#include <errno.h>      // errno
#include <stdatomic.h>  // atomic_int, atomic_bool
#include <stdio.h>      // fopen, snprintf
#include <stdlib.h>     // malloc, free
#include <string.h>     // strerror
#include <time.h>       // nanosleep

enum { look_ns = 50000000 };

static struct {
    const char *path;
    pthread_t thread;
    bool has_thread;
    atomic_bool is_over;
    atomic_int phase;  ///< lcn_reload_phase_t
    lcn_table_t table; ///< written by the thread while asked, otherwise read by the slow thread
    void *kept;        ///< in use
    void *spare;       ///< no longer in use
} reload;

static bool refuse(lcn_table_t *table, const char *path, const char *why, const char *remedy)
{
    (void)snprintf(table->error, sizeof table->error, "table=%.120s: %s; %s", path, why, remedy);
    return false;
}

/// @return [bytes] size of an open file, negative on error
static long size_of(FILE *file)
{
    const long size = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    return fseek(file, 0, SEEK_SET) == 0 ? size : -1;
}

static bool read_whole(FILE *file, const char *path, lcn_table_t *table)
{
    const long size = size_of(file);
    if (size <= 0 || size > (long)lcn_table_most_bytes) {
        return refuse(table, path, "wrong size for a table", "make it with tools/mktables");
    }
    void *bytes = malloc((size_t)size);
    if (bytes == NULL || fread(bytes, 1, (size_t)size, file) != (size_t)size) {
        free(bytes);
        return refuse(table, path, "cannot be read completely", "check disk and memory");
    }
    table->bytes = bytes;
    table->size = (size_t)size;
    return true;
}

bool lcn_table_read(const char *path, lcn_table_t *table)
{
    *table = (lcn_table_t){0};
    if (path[0] == '\0') {
        return refuse(table, path, "no table is given",
                      "loadrt camturn table=/absolute/path/NAME.camtab");
    }
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return refuse(table, path, strerror(errno),
                      "give the absolute path of a .camtab file of tools/mktables");
    }
    const bool is_read = read_whole(file, path, table);
    (void)fclose(file);
    return is_read;
}

/// Context: the thread, phase asked.
static void read_again(void)
{
    free(reload.spare);
    reload.spare = NULL;
    const bool is_read = lcn_table_read(reload.path, &reload.table);
    atomic_store(&reload.phase, is_read ? (int)lcn_reload_read : (int)lcn_reload_failed);
}

static void *run(void *nothing)
{
    const struct timespec pause = {.tv_nsec = look_ns};
    while (!atomic_load(&reload.is_over)) {
        if (atomic_load(&reload.phase) == (int)lcn_reload_asked) {
            read_again();
        }
        lcn_record_serve();
        (void)nanosleep(&pause, NULL);
    }
    return nothing;
}

bool lcn_reload_begin(const char *path)
{
    reload.path = path;
    atomic_store(&reload.is_over, false);
    atomic_store(&reload.phase, (int)lcn_reload_idle);
    reload.has_thread = pthread_create(&reload.thread, NULL, run, NULL) == 0;
    return reload.has_thread;
}

void lcn_reload_end(void)
{
    if (reload.has_thread) {
        atomic_store(&reload.is_over, true);
        (void)pthread_join(reload.thread, NULL);
        reload.has_thread = false;
    }
}

void lcn_reload_ask(void)
{
    atomic_store(&reload.phase, (int)lcn_reload_asked);
}

lcn_reload_phase_t lcn_reload_phase(void)
{
    return (lcn_reload_phase_t)atomic_load(&reload.phase);
}

const lcn_table_t *lcn_reload_table(void)
{
    return &reload.table;
}

void lcn_reload_settle(bool is_kept)
{
    if (is_kept) {
        reload.spare = reload.kept;
        reload.kept = reload.table.bytes;
    } else {
        reload.spare = reload.table.bytes; // NULL if nothing was read
    }
    reload.table.bytes = NULL;
    atomic_store(&reload.phase, (int)lcn_reload_idle);
}
