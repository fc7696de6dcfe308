// SPDX-License-Identifier: Apache-2.0
#include "lin_settings.h"
#include <ctype.h>  // isspace
#include <errno.h>  // errno
#include <ini.h>    // ini_parse_stream
#include <stdio.h>  // fopen
#include <stdlib.h> // strtoll
#include <string.h> // strcmp

typedef struct {
    const char *path;
    FILE *stream;
    int line;
    const lin_setting_t *list;
    size_t n;
    void *into;
    bool is_seen[lin_settings_max];
    bool is_wrong;
    lin_error_t *e;
} reader_t;

/// @return [characters] of a text before the first of some that is not inside quotes
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

/// Cut a comment behind the value and the blanks before it; # inside quotes stays.
static void strip(char *text)
{
    char *c = text + before(text, "#");
    while (c > text && isspace((unsigned char)c[-1]) != 0) {
        c--;
    }
    *c = '\0';
}

static bool check_section(const reader_t *r, const char *line)
{
    const size_t n = strcspn(line + 1, "]#\n");
    const char *rest = line + 1 + n;
    rest += *rest == ']' ? 1u + strspn(rest + 1, " \t\r") : 0u;
    if (line[1 + n] != ']' || (*rest != '\0' && *rest != '\n' && *rest != '#')) {
        return lin_error(r->e, "%s:%d: [%.*s: no section; write [section] alone on its line",
                         r->path, r->line, (int)n, line + 1);
    }
    for (size_t i = 0; i < r->n; i++) {
        if (strlen(r->list[i].section) == n && strncmp(r->list[i].section, line + 1, n) == 0) {
            return true;
        }
    }
    return lin_error(r->e, "%s:%d: [%.*s]: there is no such section; correct or remove it", r->path,
                     r->line, (int)n, line + 1);
}

/// inih takes more than TOML: ":" for "=", comments behind ";", sections that nothing is in.
static bool check_line(const reader_t *r, const char *line)
{
    if (line[0] == '[') {
        return check_section(r, line);
    }
    if (strchr("#\r\n", line[0]) != NULL) { // the end of the line, too
        return true;
    }
    if (line[strcspn(line, "=:;#")] != '=') {
        return lin_error(
            r->e, "%s:%d: neither [section] nor key = value; correct it, comments begin with #",
            r->path, r->line);
    }
    return line[before(line, "#;")] != ';' ||
           lin_error(r->e, "%s:%d: \";\" behind the value; begin comments with #", r->path,
                     r->line);
}

/// inih takes an indented line for more of the value before; TOML does not, so lines come
/// unindented.
static char *read_line(char *line, int size, void *user)
{
    reader_t *r = user;
    if (r->is_wrong || fgets(line, size, r->stream) == NULL) {
        return NULL;
    }
    r->line++;
    const size_t length = strlen(line);
    if (length + 1u == (size_t)size && line[length - 1u] != '\n') {
        r->is_wrong = true;
        (void)lin_error(r->e, "%s:%d: longer than %d characters; shorten it", r->path, r->line,
                        size - 2);
        return NULL;
    }
    const size_t n_blanks = strspn(line, " \t");
    memmove(line, line + n_blanks, length - n_blanks + 1u);
    r->is_wrong = !check_line(r, line);
    return r->is_wrong ? NULL : line;
}

static bool refuse(const reader_t *r, const lin_setting_t *s, const char *text, const char *why)
{
    return lin_error(r->e, "%s:%d: %s.%s = %.80s: %s", r->path, r->line, s->section, s->key, text,
                     why);
}

static bool take_whole(const reader_t *r, const lin_setting_t *s, const char *text)
{
    char *end = NULL;
    errno = 0;
    const long long value = strtoll(text, &end, 10);
    if (end == text || *end != '\0' || errno != 0 || value < s->min || value > s->max) {
        char why[100];
        (void)snprintf(why, sizeof why, "give a whole number, %lld .. %lld", (long long)s->min,
                       (long long)s->max);
        return refuse(r, s, text, why);
    }
    *(int64_t *)((char *)r->into + s->offset) = value;
    return true;
}

static bool take_flag(const reader_t *r, const lin_setting_t *s, const char *text)
{
    const bool is_true = strcmp(text, "true") == 0;
    if (!is_true && strcmp(text, "false") != 0) {
        return refuse(r, s, text, "give true or false");
    }
    *(bool *)((char *)r->into + s->offset) = is_true;
    return true;
}

static bool take_text(const reader_t *r, const lin_setting_t *s, const char *text)
{
    const size_t length = strlen(text);
    const bool is_string = length >= 2u && text[0] == '"' &&
                           strchr(text + 1, '"') == text + length - 1u &&
                           strchr(text, '\\') == NULL;
    if (!is_string || length - 2u > (size_t)s->max) {
        char why[100];
        (void)snprintf(why, sizeof why, "give one \"text\" of at most %d characters", (int)s->max);
        return refuse(r, s, text, why);
    }
    char *into = (char *)r->into + s->offset;
    memcpy(into, text + 1, length - 2u);
    into[length - 2u] = '\0';
    return true;
}

static bool take_choice(const reader_t *r, const lin_setting_t *s, const char *text)
{
    uint32_t i = 0;
    for (const char *c = s->choices; *c != '\0'; i++) {
        const size_t length = strcspn(c, " ");
        if (strlen(text) == length && strncmp(c, text, length) == 0) {
            *(uint32_t *)((char *)r->into + s->offset) = i;
            return true;
        }
        c += length + strspn(c + length, " ");
    }
    char why[100];
    (void)snprintf(why, sizeof why, "give one of %s", s->choices);
    return refuse(r, s, text, why);
}

static bool take(reader_t *r, const char *section, const char *key, const char *text)
{
    static bool (*const takers[])(const reader_t *, const lin_setting_t *, const char *) = {
        [lin_setting_whole] = take_whole,
        [lin_setting_flag] = take_flag,
        [lin_setting_text] = take_text,
        [lin_setting_choice] = take_choice,
    };
    for (size_t i = 0; i < r->n; i++) {
        const lin_setting_t *s = &r->list[i];
        if (strcmp(section, s->section) != 0 || strcmp(key, s->key) != 0) {
            continue;
        }
        if (r->is_seen[i]) {
            return refuse(r, s, text, "given twice; remove one");
        }
        r->is_seen[i] = true;
        return takers[s->kind](r, s, text);
    }
    return lin_error(r->e, "%s:%d: [%.40s] %.40s: there is no such key; correct or remove it",
                     r->path, r->line, section, key);
}

static int on_value(void *user, const char *section, const char *key, const char *value)
{
    reader_t *r = user;
    char text[256];
    (void)snprintf(text, sizeof text, "%s", value);
    strip(text);
    if (!r->is_wrong && !take(r, section, key, text)) {
        r->is_wrong = true;
    }
    return r->is_wrong ? 0 : 1;
}

bool lin_settings_read(const char *path, const lin_setting_t *list, size_t n, void *into,
                       lin_error_t *e)
{
    reader_t r = {.path = path, .list = list, .n = n, .into = into, .e = e};
    r.stream = fopen(path, "r");
    if (r.stream == NULL) {
        return lin_error(e, "%s: cannot be opened: %s; check the path", path, strerror(errno));
    }
    const int result = ini_parse_stream(read_line, &r, on_value, &r);
    const bool is_unreadable = ferror(r.stream) != 0;
    (void)fclose(r.stream);
    if (r.is_wrong) {
        return false;
    }
    if (is_unreadable) {
        return lin_error(e, "%s: cannot be read; give a readable file", path);
    }
    if (result != 0) {
        return lin_error(e, "%s:%d: neither [section] nor key = value; correct it", path, result);
    }
    return true;
}
