// SPDX-License-Identifier: Apache-2.0
#include "common_settings.h"
#include "common_number.h" // common_number_parse
#include <ctype.h>         // isspace
#include <errno.h>         // errno
#include <ini.h>           // ini_parse_stream
#include <stdarg.h>        // va_list
#include <stdlib.h>        // strtoll
#include <string.h>        // strcmp

typedef struct {
    common_settings_t *s;
    FILE *stream;
    bool is_seen[common_settings_max];
    bool is_wrong;
} reader_t;

/// Report an error in the current line.
__attribute__((format(printf, 2, 3))) static bool refuse_line(const common_settings_t *s,
                                                              const char *format, ...)
{
    common_error_t what;
    va_list args;
    va_start(args, format);
    (void)vsnprintf(what.text, sizeof what.text, format, args);
    va_end(args);
    return common_error(s->e, "%s:%s%d: %s", s->path, s->has_line_word ? " line " : "", s->line,
                        what.text);
}

bool common_settings_refuse(const common_settings_t *s, const char *section, const char *key,
                            const char *text, const char *why)
{
    return refuse_line(s, "%.40s.%.40s = %.*s: %s", section, key, s->value_width, text, why);
}

bool common_settings_refuse_key(const common_settings_t *s, const char *section, const char *key,
                                const char *why)
{
    return refuse_line(s, "%.40s.%.40s: %s", section, key, why);
}

/// @return [characters] before the first of the characters `ends` outside quotes
static size_t before(const char *text, const char *ends)
{
    bool is_quoted = false;
    size_t n = 0;
    while (text[n] != '\0' && (is_quoted || strchr(ends, text[n]) == NULL)) {
        is_quoted = text[n] == '"' ? !is_quoted : is_quoted;
        n++;
    }
    return n;
}

/// Check that a section header is alone on its line and in the list.
static bool check_section(const common_settings_t *s, const char *line)
{
    const size_t n = strcspn(line + 1, "]#");
    const char *rest = line + 1 + n;
    rest += *rest == ']' ? 1u + strspn(rest + 1, " \t\r") : 0u;
    if (line[1 + n] != ']' || (*rest != '\0' && *rest != '#')) {
        return refuse_line(s, "[%.*s: not a section; write [section] alone on its line", (int)n,
                           line + 1);
    }
    for (size_t i = 0; i < s->n; i++) {
        if (strlen(s->list[i].section) == n && strncmp(s->list[i].section, line + 1, n) == 0) {
            return true;
        }
    }
    return refuse_line(s, "[%.*s]: unknown section; correct or remove it", (int)n, line + 1);
}

/// inih accepts more than TOML: ":" for "=", ";" for "#", unknown empty sections. Refuse these.
static bool check_line(const common_settings_t *s, const char *line)
{
    if (line[0] == '[') {
        return check_section(s, line);
    }
    if (strchr("#\r", line[0]) != NULL) { // comment or empty line
        return true;
    }
    if (line[strcspn(line, "=:;#")] != '=') {
        return refuse_line(s, "not [section] or key = value; correct it; comments begin with #");
    }
    return line[before(line, "#;")] != ';' ||
           refuse_line(s, "\";\" after the value; begin comments with #");
}

/// Line reader for inih. It refuses NUL bytes, which would end the string, and removes indentation,
/// which inih but not TOML reads as the continuation of a value.
static char *read_line(char *line, int size, void *user)
{
    reader_t *r = user;
    common_settings_t *s = r->s;
    const int longest = size - 2;
    int n = 0;
    int n_blanks = 0; // indentation
    bool has_nul = false;
    int c = r->is_wrong ? EOF : getc(r->stream);
    if (c == EOF) {
        return NULL;
    }
    s->line++;
    for (; c != EOF && c != '\n'; c = getc(r->stream), n++) {
        const bool is_blank = (c == ' ' || c == '\t') && n == n_blanks;
        n_blanks += is_blank ? 1 : 0;
        has_nul = has_nul || c == '\0';
        if (!is_blank && n < longest) {
            line[n - n_blanks] = (char)c;
        }
    }
    bool is_good = true;
    if (has_nul) {
        is_good = refuse_line(s, "contains a NUL byte; give a text file");
    } else if (n > longest) {
        is_good = refuse_line(s, "longer than %d characters; shorten it", longest);
    } else {
        line[n - n_blanks] = '\0';
        is_good = !s->is_strict || check_line(s, line);
    }
    r->is_wrong = !is_good;
    return is_good ? line : NULL;
}

/// Read a decimal integer, exact to 64 bits.
static bool take_whole(const common_settings_t *s, const common_setting_t *f, const char *text)
{
    char *end = NULL;
    errno = 0;
    const long long value = strtoll(text, &end, 10);
    const long long min = (long long)f->min;
    const long long max = (long long)f->max;
    if (end == text || *end != '\0' || errno != 0 || value < min || value > max) {
        char why[100];
        (void)snprintf(why, sizeof why, "give a whole number, %lld .. %lld", min, max);
        return common_settings_refuse(s, f->section, f->key, text, why);
    }
    *(int64_t *)((char *)s->into + f->offset) = value;
    return true;
}

static bool take_flag(const common_settings_t *s, const common_setting_t *f, const char *text)
{
    const bool is_true = strcmp(text, "true") == 0;
    if (!is_true && strcmp(text, "false") != 0) {
        return common_settings_refuse(s, f->section, f->key, text, "give true or false");
    }
    *(bool *)((char *)s->into + f->offset) = is_true;
    return true;
}

static bool take_text(const common_settings_t *s, const common_setting_t *f, const char *text)
{
    const int max = (int)f->max;
    if (strchr(text, '\\') != NULL ||
        !common_settings_text(text, (char *)s->into + f->offset, (size_t)max)) {
        char why[100];
        (void)snprintf(why, sizeof why, "give one \"text\" of at most %d characters", max);
        return common_settings_refuse(s, f->section, f->key, text, why);
    }
    return true;
}

/// Read one of the listed words, compared including the quotation marks.
static bool take_choice(const common_settings_t *s, const common_setting_t *f, const char *text)
{
    uint32_t i = 0;
    for (const char *c = f->choices; *c != '\0'; i++) {
        const size_t length = strcspn(c, " ");
        if (strlen(text) == length && strncmp(c, text, length) == 0) {
            *(uint32_t *)((char *)s->into + f->offset) = i;
            return true;
        }
        c += length + strspn(c + length, " ");
    }
    char why[100];
    (void)snprintf(why, sizeof why, "give one of %s", f->choices);
    return common_settings_refuse(s, f->section, f->key, text, why);
}

/// Read a number. One message covers range, whole numbers and nonzero numbers.
static bool take_real(const common_settings_t *s, const common_setting_t *f, const char *text)
{
    const bool is_whole = f->kind != common_setting_real;
    const bool is_sign = f->kind == common_setting_sign;
    double value;
    if (!common_settings_number(text, &value)) {
        return common_settings_refuse(s, f->section, f->key, text, "not a finite number; give one");
    }
    const bool is_inside = value >= f->min && value <= f->max;
    const bool is_odd =
        is_inside && ((is_whole && value != (double)(int64_t)value) || (is_sign && value == 0.0));
    if (!is_inside || is_odd) {
        char why[120];
        (void)snprintf(why, sizeof why, "out of range; give a%s number %.12g .. %.12g%s",
                       is_whole ? " whole" : "", f->min, f->max, is_sign ? ", not 0" : "");
        return common_settings_refuse(s, f->section, f->key, text, why);
    }
    *(double *)((char *)s->into + f->offset) = value;
    return true;
}

/// Find a key in the list and read its value; refuse duplicate keys.
static bool take(reader_t *r, const char *section, const char *key, const char *text)
{
    static bool (*const takers[])(const common_settings_t *, const common_setting_t *,
                                  const char *) = {
        [common_setting_whole] = take_whole, [common_setting_flag] = take_flag,
        [common_setting_text] = take_text,   [common_setting_choice] = take_choice,
        [common_setting_real] = take_real,   [common_setting_count] = take_real,
        [common_setting_sign] = take_real,
    };
    const common_settings_t *s = r->s;
    for (size_t i = 0; i < s->n; i++) {
        const common_setting_t *f = &s->list[i];
        if (strcmp(section, f->section) != 0 || strcmp(key, f->key) != 0) {
            continue;
        }
        if (r->is_seen[i]) {
            return common_settings_refuse(s, section, key, text, "given twice; remove one");
        }
        r->is_seen[i] = true;
        return takers[f->kind](s, f, text);
    }
    return s->take_other(s, section, key, text);
}

/// Callback of inih. Cuts off a trailing comment and blanks; # inside quotes is part of the value.
static int on_value(void *user, const char *section, const char *key, const char *value)
{
    reader_t *r = user;
    char text[256];
    (void)snprintf(text, sizeof text, "%s", value);
    size_t n = before(text, "#");
    while (n > 0u && isspace((unsigned char)text[n - 1u]) != 0) {
        n--;
    }
    text[n] = '\0';
    r->is_wrong = r->is_wrong || !take(r, section, key, text);
    return r->is_wrong ? 0 : 1;
}

bool common_settings_read(common_settings_t *s, FILE *stream)
{
    reader_t r = {.s = s, .stream = stream};
    s->line = 0;
    const int result = ini_parse_stream(read_line, &r, on_value, &r);
    if (r.is_wrong) {
        return false;
    }
    if (ferror(stream) != 0) {
        return common_error(s->e, "%s: cannot be read; give a readable file", s->path);
    }
    s->line = result;
    return result == 0 || refuse_line(s, "not [section] or key = value; correct it");
}

bool common_settings_number(const char *text, double *value)
{
    if (strcmp(text, "true") == 0 || strcmp(text, "false") == 0) {
        *value = text[0] == 't' ? 1.0 : 0.0;
        return true;
    }
    return common_number_parse(text, value);
}

bool common_settings_text(const char *text, char *into, size_t max)
{
    const size_t length = strlen(text);
    if (length < 2u || length - 2u > max || text[0] != '"' ||
        strchr(text + 1, '"') != text + length - 1u) {
        return false;
    }
    memcpy(into, text + 1, length - 2u);
    into[length - 2u] = '\0';
    return true;
}
