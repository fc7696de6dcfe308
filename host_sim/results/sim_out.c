// SPDX-License-Identifier: Apache-2.0
#define _XOPEN_SOURCE 700 // NOLINT(bugprone-reserved-identifier): mkstemp, realpath
#include "sim_out.h"
#include "cam_state.h" // cam_state_name
#include <errno.h>     // errno
#include <inttypes.h>  // PRIx32
#include <signal.h>    // sigaction
#include <stdlib.h>    // mkstemp, realpath
#include <string.h>    // memcpy, strlen
#include <sys/stat.h>  // stat
#include <unistd.h>    // fsync, unlink

enum { max_pending = 6 };

/// Temporary files, for the signal handler.
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

void sim_out_watch_signals(void)
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

static bool cannot(const sim_out_t *o, int number, common_error_t *e)
{
    return common_error(e, "%s: cannot be written: %s; make room or give another path", o->name,
                        strerror(number));
}

static bool open_temporary(sim_out_t *o)
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
static bool find_target(sim_out_t *o, bool *is_regular)
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

/// In a folder writable by others, a link with the name of a result could make this program
/// overwrite any file of its user. Links of root or of the user are followed.
static bool is_planted(const char *name)
{
    struct stat about;
    return lstat(name, &about) == 0 && S_ISLNK(about.st_mode) && about.st_uid != geteuid() &&
           about.st_uid != 0u;
}

static void drop(sim_out_t *o)
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

bool sim_out_open(sim_out_t *o, const char *name, const char *option, common_error_t *e)
{
    o->name = name;
    o->stream = NULL;
    o->temporary[0] = '\0';
    o->error = 0;
    o->n = 0;
    if (name == NULL) {
        return true;
    }
    if (is_planted(name)) {
        return common_error(e,
                            "%s %s: a link of another user, which is not followed; remove it, "
                            "or give another path",
                            option, name);
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
        drop(o);
        return common_error(e, "%s %s: cannot be written: %s; give a path in a writable folder",
                            option, name, strerror(number));
    }
    return true;
}

static void flush(sim_out_t *o)
{
    if (o->stream != NULL && o->error == 0 && o->n > 0u &&
        fwrite(o->buffer, 1, o->n, o->stream) != o->n) {
        o->error = errno;
    }
    o->n = 0;
}

static bool finish(sim_out_t *o, common_error_t *e)
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

static bool publish(sim_out_t *o, common_error_t *e)
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

bool sim_out_open_all(sim_out_t *outs, const char *const *names, const char *const *options, int n,
                      common_error_t *e)
{
    bool is_good = true;
    for (int i = 0; i < n && is_good; i++) {
        is_good = sim_out_open(&outs[i], names[i], options[i], e);
    }
    return is_good;
}

bool sim_out_publish_all(sim_out_t *outs, int n, common_error_t *e)
{
    bool is_good = true;
    for (int i = 0; i < n && is_good; i++) {
        is_good = finish(&outs[i], e);
    }
    for (int i = 0; i < n && is_good; i++) {
        is_good = publish(&outs[i], e);
    }
    return is_good;
}

void sim_out_drop_all(sim_out_t *outs, int n)
{
    for (int i = 0; i < n; i++) {
        drop(&outs[i]);
    }
}

/// Append n <= 40 bytes to the buffer.
static void append(sim_out_t *o, const char *bytes, size_t n)
{
    if (o->n + n > sim_out_buffer) {
        flush(o);
    }
    memcpy(o->buffer + o->n, bytes, n);
    o->n += n;
}

static void put(sim_out_t *o, char c)
{
    if (o->n == sim_out_buffer) {
        flush(o);
    }
    o->buffer[o->n++] = c;
}

void sim_out_text(sim_out_t *o, const char *text)
{
    for (; *text != '\0'; text++) {
        put(o, *text);
    }
}

/// Write value * 10^-decimals.
static void write_decimal(sim_out_t *o, int64_t value, int decimals)
{
    char text[40]; // filled from its end
    char *first = text + sizeof text;
    uint64_t rest = value < 0 ? -(uint64_t)value : (uint64_t)value;
    for (int i = 0; i < decimals; i++) {
        *--first = (char)('0' + rest % 10u);
        rest /= 10u;
    }
    if (decimals > 0) {
        *--first = '.';
    }
    do {
        *--first = (char)('0' + rest % 10u);
        rest /= 10u;
    } while (rest > 0u);
    if (value < 0) {
        *--first = '-';
    }
    append(o, first, (size_t)(text + sizeof text - first));
}

/// Write 0x and n_digits digits, or 8 where they are too few.
static void write_hex(sim_out_t *o, uint32_t value, int n_digits)
{
    char text[16];
    const int n = n_digits < 8 && value >> (4 * n_digits) != 0u ? 8 : n_digits;
    append(o, text, (size_t)snprintf(text, sizeof text, "0x%0*" PRIx32, n, value));
}

static void write_number(sim_out_t *o, const char *format, int64_t number)
{
    if (format[0] == 'x') {
        write_hex(o, (uint32_t)number, format[1] - '0');
    } else if (format[0] == 's') { // none before a controller has reported one
        const bool is_known = number >= 0 && number < cam_n_states;
        sim_out_text(o, is_known ? cam_state_name((cam_state_t)number) : "-");
    } else {
        write_decimal(o, number, format[0] - '0');
    }
}

void sim_out_header(sim_out_t *o, const sim_rows_t *t)
{
    const char *c = t->columns;
    while (*c != '\0') {
        append(o, c, strcspn(c, ":"));
        c += strcspn(c, ",");
        put(o, *c == '\0' ? '\n' : ',');
        c += *c != '\0' ? 1 : 0;
    }
}

void sim_out_rows(sim_out_t *o, sim_rows_t *t)
{
    const size_t n_columns = (size_t)t->n_columns;
    for (size_t i = 0; i < t->n; i++) {
        write_number(o, t->format[i % n_columns], t->number[i]);
        put(o, i % n_columns + 1u < n_columns ? ',' : '\n');
    }
    if (t->is_lost && o->error == 0) {
        o->error = ENOMEM;
    }
    sim_rows_drop(t);
}
