// SPDX-License-Identifier: Apache-2.0
#define _XOPEN_SOURCE 700 // NOLINT(bugprone-reserved-identifier): mkstemp, realpath
#include "camsim_out.h"
#include <errno.h>    // errno
#include <math.h>     // floor
#include <signal.h>   // sigaction
#include <stdlib.h>   // mkstemp, realpath
#include <string.h>   // strlen
#include <sys/stat.h> // stat
#include <unistd.h>   // fsync, unlink

enum { max_pending = 5 };

/// Temporaries for the signal handler, which can reach nothing else.
static const char *volatile pending[max_pending];

static void on_signal(int number)
{
    for (int i = 0; i < max_pending; i++) {
        const char *path = pending[i];
        if (path != NULL) {
            (void)unlink(path);
        }
    }
    (void)signal(number, SIG_DFL);
    (void)raise(number);
}

void camsim_out_watch_signals(void)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    struct sigaction action = {.sa_handler = on_signal};
    (void)sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        (void)sigaction(numbers[i], &action, NULL);
    }
    (void)signal(SIGXFSZ, SIG_IGN); // a file-size limit becomes a write error
}

static void set_pending(const char *old, const char *path)
{
    for (int i = 0; i < max_pending; i++) {
        if (pending[i] == old) {
            pending[i] = path;
            return;
        }
    }
}

static bool cannot(const camsim_out_t *o, int number, sim_error_t *e)
{
    return sim_error(e, "%s: cannot be written: %s; make room or give another path", o->name,
                     strerror(number));
}

static bool open_temporary(camsim_out_t *o)
{
    (void)snprintf(o->temporary, sizeof o->temporary, "%s.XXXXXX", o->final);
    const mode_t mask = umask(0);
    (void)umask(mask);
    const int fd = mkstemp(o->temporary);
    if (fd < 0) {
        o->temporary[0] = '\0';
        return false;
    }
    set_pending(NULL, o->temporary);
    (void)fchmod(fd, (mode_t)(0666u & ~mask));
    o->stream = fdopen(fd, "wb");
    if (o->stream == NULL) {
        (void)close(fd);
    }
    return o->stream != NULL;
}

/// Resolve links, so that a link to a file stays a link.
static bool find_target(camsim_out_t *o, bool *is_regular)
{
    struct stat about;
    *is_regular = true;
    if (stat(o->name, &about) == 0) {
        *is_regular = S_ISREG(about.st_mode);
        if (S_ISDIR(about.st_mode)) {
            errno = EISDIR;
            return false;
        }
        if (*is_regular) {
            char *real = realpath(o->name, NULL);
            const bool fits = real != NULL && strlen(real) < sizeof o->final;
            (void)snprintf(o->final, sizeof o->final, "%s", fits ? real : "");
            free(real);
            return fits && access(o->final, W_OK) == 0;
        }
    }
    errno = ENAMETOOLONG;
    return (size_t)snprintf(o->final, sizeof o->final, "%s", o->name) < sizeof o->final;
}

bool camsim_out_open(camsim_out_t *o, const char *name, const char *option, sim_error_t *e)
{
    o->name = name;
    o->stream = NULL;
    o->temporary[0] = '\0';
    o->error = 0;
    o->n = 0;
    if (name == NULL) {
        return true;
    }
    bool is_regular;
    errno = 0;
    bool is_open = find_target(o, &is_regular);
    if (is_open && is_regular) {
        is_open = open_temporary(o);
    } else if (is_open) {
        o->stream = fopen(o->final, "wb");
        is_open = o->stream != NULL;
    }
    if (!is_open) {
        const int number = errno;
        camsim_out_drop(o);
        return sim_error(e, "%s %s: cannot be written: %s; give a path in a writable folder",
                         option, name, strerror(number));
    }
    return true;
}

static void flush(camsim_out_t *o)
{
    if (o->stream != NULL && o->error == 0 && o->n > 0u &&
        fwrite(o->buffer, 1, o->n, o->stream) != o->n) {
        o->error = errno;
    }
    o->n = 0;
}

bool camsim_out_finish(camsim_out_t *o, sim_error_t *e)
{
    if (o->name == NULL) {
        return true;
    }
    flush(o);
    if (o->error == 0 && fflush(o->stream) != 0) {
        o->error = errno;
    }
    if (o->error == 0 && o->temporary[0] != '\0' && fsync(fileno(o->stream)) != 0) {
        o->error = errno;
    }
    if (fclose(o->stream) != 0 && o->error == 0) {
        o->error = errno;
    }
    o->stream = NULL;
    return o->error == 0 || cannot(o, o->error, e);
}

bool camsim_out_publish(camsim_out_t *o, sim_error_t *e)
{
    if (o->name == NULL || o->temporary[0] == '\0') {
        return true;
    }
    if (rename(o->temporary, o->final) != 0) {
        return cannot(o, errno, e);
    }
    set_pending(o->temporary, NULL);
    o->temporary[0] = '\0';
    return true;
}

void camsim_out_drop(camsim_out_t *o)
{
    if (o->stream != NULL) {
        (void)fclose(o->stream);
        o->stream = NULL;
    }
    if (o->temporary[0] != '\0') {
        (void)unlink(o->temporary);
        set_pending(o->temporary, NULL);
        o->temporary[0] = '\0';
    }
}

void camsim_out_char(camsim_out_t *o, char c)
{
    if (o->n == camsim_out_buffer) {
        flush(o);
    }
    o->buffer[o->n++] = c;
}

void camsim_out_text(camsim_out_t *o, const char *text)
{
    for (; *text != '\0'; text++) {
        camsim_out_char(o, *text);
    }
}

void camsim_out_decimal(camsim_out_t *o, int64_t value, int decimals)
{
    char digits[40];
    int n = 0;
    uint64_t rest = value < 0 ? -(uint64_t)value : (uint64_t)value;
    do {
        digits[n++] = (char)('0' + rest % 10u);
        rest /= 10u;
    } while (rest > 0u || n <= decimals);
    if (value < 0) {
        camsim_out_char(o, '-');
    }
    while (n > 0) {
        camsim_out_char(o, digits[--n]);
        if (n == decimals && n > 0) {
            camsim_out_char(o, '.');
        }
    }
}

void camsim_out_integer(camsim_out_t *o, int64_t value)
{
    camsim_out_decimal(o, value, 0);
}

void camsim_out_real(camsim_out_t *o, double value, int decimals)
{
    static const double power[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
    camsim_out_decimal(o, (int64_t)floor(value * power[decimals] + 0.5), decimals);
}
