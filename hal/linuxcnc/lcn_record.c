// SPDX-License-Identifier: Apache-2.0
#include "lcn_record.h"
#include "cam_recorder.h" // CAM_BLACKBOX_SIGNALS
#include "cam_machine.h"  // cam_machine_scope_start
#include "lcn_port.h"     // lcn_port_print
#include <errno.h>        // errno
#include <stdatomic.h>    // atomic_int
#include <stdio.h>        // fopen, snprintf
#include <string.h>       // memcpy, strerror

enum { n_words = 1 << 20, most_files = 999, name_bytes = 256, line_bytes = 384 };

typedef enum { idle, asked, ended } phase_t;

static int32_t words[n_words];

static struct {
    const char *name;
    bool is_due;      ///< a recording is requested and not yet started
    bool last;        ///< the command of the last round
    atomic_int phase; ///< phase_t; asked: the other thread reads scope and writes line
    const cam_scope_t *scope;
    char line[line_bytes]; ///< result
} record;

hal_memory_t hal_scope_memory(void)
{
    return (hal_memory_t){.words = words, .n_words = n_words};
}

// The file

/// @return the next free file, or NULL with errno
static FILE *open_next(char name[name_bytes])
{
    FILE *file = NULL;
    errno = EEXIST;
    for (int i = 1; i <= (int)most_files && file == NULL && errno == EEXIST; i++) {
        (void)snprintf(name, name_bytes, "%.200s-%d.csv", record.name, i);
        file = fopen(name, "wx");
    }
    return file;
}

static void write_row(FILE *file, const cam_scope_t *s, uint32_t i)
{
    const uint32_t bytes = s->n_signals * (uint32_t)sizeof(int32_t);
    const uint32_t tick = s->ring.first_tick + i * s->plan.every;
    const double t_s = (double)(int32_t)(tick - s->ring.trigger_tick) / s->tick_hz;
    int32_t row[cam_scope_n_signals];
    memcpy(row, cam_scope_span(s, i * bytes, bytes).bytes, bytes);
    (void)fprintf(file, "%u,%.9f", (unsigned)tick, t_s);
    for (uint32_t k = 0; k < s->n_signals; k++) {
        (void)fprintf(file, ",%d", (int)row[k]);
    }
    (void)fputc('\n', file);
}

static void write_rows(FILE *file, const cam_scope_t *s)
{
    (void)fputs("tick,t_s", file);
    for (uint32_t k = 0; k < s->n_signals; k++) {
        (void)fprintf(file, ",%s", cam_scope_signal_name(s->order[k]));
    }
    (void)fputc('\n', file);
    for (uint32_t i = 0; i < s->ring.n_rows; i++) {
        write_row(file, s, i);
    }
}

static void write_file(const cam_scope_t *s)
{
    char name[name_bytes];
    FILE *file = open_next(name);
    bool is_written = file != NULL;
    if (is_written) {
        write_rows(file, s);
        is_written = ferror(file) == 0;
        is_written = fclose(file) == 0 && is_written;
    }
    if (!is_written) {
        (void)snprintf(record.line, sizeof record.line,
                       "recordings: %s: %s; make room there, or load camturn with "
                       "recordings=/absolute/path/NAME",
                       name, strerror(errno));
    } else if (s->ring.n_lost != 0u) {
        (void)snprintf(record.line, sizeof record.line,
                       "%s: %u rows, then %u ticks were lost: call camturn.poll more often", name,
                       (unsigned)s->ring.n_rows, (unsigned)s->ring.n_lost);
    } else {
        (void)snprintf(record.line, sizeof record.line, "%s: %u rows", name,
                       (unsigned)s->ring.n_rows);
    }
}

void lcn_record_serve(void)
{
    if (atomic_load(&record.phase) == (int)asked) {
        write_file(record.scope);
        atomic_store(&record.phase, (int)ended);
    }
}

// The commands

void lcn_record_begin(cam_machine_t *m, const char *name)
{
    record.name = name;
    record.is_due = false;
    record.last = false;
    record.scope = &m->scope;
    atomic_store(&record.phase, (int)idle);
    if (name[0] != '\0') {
        cam_machine_blackbox(m);
    }
}

/// @return cam_ok; cam_err_scope_unread while the black box of a fault is to be written first
static cam_err_t start(cam_machine_t *m)
{
    const uint32_t signals = CAM_BLACKBOX_SIGNALS;
    const cam_err_t err = cam_machine_scope_set(m, cam_scope_field_signals, (int32_t)signals);
    return err == cam_ok ? cam_machine_scope_start(m) : err;
}

static void report_refusal(cam_err_t err)
{
    char line[line_bytes];
    (void)snprintf(line, sizeof line, "record: refused: %s (error %d)", cam_err_text(err),
                   (int)err);
    lcn_port_print(line);
}

static void start_or_explain(cam_machine_t *m)
{
    if (record.name[0] == '\0') {
        record.is_due = false;
        lcn_port_print("record: no file is given; load camturn with "
                       "recordings=/absolute/path/NAME");
        return;
    }
    const cam_err_t err = start(m);
    record.is_due = err == cam_err_scope_unread;
    if (err != cam_ok && !record.is_due) {
        report_refusal(err);
    }
}

static void finish(cam_machine_t *m)
{
    lcn_port_print(record.line);
    if (cam_machine_release(m) == cam_ok) {
        atomic_store(&record.phase, (int)idle);
    }
}

bool lcn_record_poll(cam_machine_t *m, bool records)
{
    record.is_due = records && (record.is_due || !record.last);
    record.last = records;
    const phase_t phase = (phase_t)atomic_load(&record.phase);
    const bool is_by_command = m->scope.use == cam_scope_user;
    if (phase == ended) {
        finish(m);
    } else if (phase == idle && m->scope.phase == cam_scope_done) {
        atomic_store(&record.phase, (int)asked);
    } else if (phase == idle && record.is_due && !is_by_command) {
        start_or_explain(m);
    } else if (!records && is_by_command) {
        cam_machine_scope_stop(m);
    } else {
        // nothing to start or end: recording, or the file is being written
    }
    return m->scope.use == cam_scope_user || atomic_load(&record.phase) != (int)idle;
}
