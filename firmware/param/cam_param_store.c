// SPDX-License-Identifier: Apache-2.0
#include "cam_param.h"
#include "cam_table.h" // cam_crc32
#include <stddef.h>    // NULL
#include <string.h>    // memcpy, memset, strlen, strncmp

_Static_assert((int)cam_param_store_most_bytes <= (int)hal_params_most_bytes,
               "ports store all of it");

static const char version_name[] = "version";
static const char crc_name[] = "crc32";
static const char equals[] = " = ";

/// [characters] longest number, with its sign
enum { most_digits = 11 };

typedef struct {
    char *text;
    uint32_t n;
} writer_t;

static void put(writer_t *w, const char *text)
{
    const size_t n = strlen(text);
    (void)memcpy(&w->text[w->n], text, n);
    w->n += (uint32_t)n;
}

static void put_line(writer_t *w, const char *name, int64_t value)
{
    char number[cam_text_number_bytes];
    put(w, name);
    put(w, equals);
    put(w, cam_text_number(number, value));
    put(w, "\n");
}

static void put_param(writer_t *w, const cam_params_t *params, uint32_t id)
{
    put_line(w, cam_param_info((cam_param_id_t)id)->name,
             cam_param_get(params, (cam_param_id_t)id));
}

uint32_t cam_param_store_checksum(const cam_params_t *params)
{
    uint32_t crc = 0;
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        char line[cam_param_store_line_bytes];
        writer_t w = {.text = line};
        put_param(&w, params, id);
        crc = cam_crc32(crc, line, w.n);
    }
    return crc;
}

uint32_t cam_param_store_write(char *text, const cam_params_t *params, uint32_t version)
{
    writer_t w = {.text = text};
    put(&w, "# camturn parameters, kept by the controller; tools/camctl params changes them\n");
    put_line(&w, version_name, version);
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        put_param(&w, params, id);
    }
    put_line(&w, crc_name, cam_crc32(0, text, w.n));
    return w.n;
}

/// A line of a text.
typedef struct {
    const char *text;
    uint32_t n;      ///< [bytes] without the end of the line
    uint32_t n_name; ///< [bytes] before " = "; 0: not a line `name = value`
    int64_t value;
} kept_line_t;

/// @return whether n characters are a decimal integer of at most most_digits
static bool is_number(const char *text, uint32_t n, int64_t *value)
{
    const bool is_negative = n > 0u && text[0] == '-';
    uint32_t from = 0;
    if (is_negative) {
        from = 1;
    }
    bool is_good = n > from && n <= (uint32_t)most_digits;
    int64_t size = 0;
    for (uint32_t i = from; i < n && is_good; i++) {
        is_good = text[i] >= '0' && text[i] <= '9';
        size = size * 10 + (text[i] - '0');
    }
    *value = is_negative ? -size : size;
    return is_good;
}

static kept_line_t line_at(const char *text, uint32_t n)
{
    kept_line_t line = {.text = text};
    while (line.n < n && text[line.n] != '\n') {
        line.n++;
    }
    const uint32_t n_equals = (uint32_t)sizeof equals - 1u;
    for (uint32_t i = 1; i + n_equals < line.n && line.n_name == 0u; i++) {
        const bool is_there = strncmp(&text[i], equals, n_equals) == 0 &&
                              is_number(&text[i + n_equals], line.n - i - n_equals, &line.value);
        line.n_name = is_there ? i : 0u;
    }
    return line;
}

static bool is_called(const kept_line_t *line, const char *name)
{
    return line->n_name == strlen(name) && strncmp(line->text, name, line->n_name) == 0;
}

/// @return [bytes] before the line of the checksum if the checksum is correct; else 0
static uint32_t checked(const char *text, uint32_t n)
{
    uint32_t at = 0;
    while (at < n) {
        const kept_line_t line = line_at(&text[at], n - at);
        if (is_called(&line, crc_name)) {
            return cam_crc32(0, text, at) == (uint32_t)(uint64_t)line.value ? at : 0u;
        }
        at += line.n + 1u;
    }
    return 0;
}

/// Set a parameter from its line, or count the line as retired, unknown or unfit.
/// @param is_there  for each parameter: set when it has a line
static void take_line(cam_param_store_found_t *found, const kept_line_t *line, cam_params_t *params,
                      bool *is_there)
{
    uint32_t id = 0;
    while (id < (uint32_t)cam_n_params &&
           !is_called(line, cam_param_info((cam_param_id_t)id)->name)) {
        id++;
    }
    if (id == (uint32_t)cam_n_params && cam_param_is_retired(line->text)) {
        found->n_retired++;
        return;
    }
    if (id == (uint32_t)cam_n_params) {
        const uint32_t most = (uint32_t)sizeof found->unknown - 1u;
        if (found->n_unknown == 0u) {
            (void)memcpy(found->unknown, line->text, line->n_name < most ? line->n_name : most);
        }
        found->n_unknown++;
        return;
    }
    is_there[id] = true;
    const bool is_word = line->value >= INT32_MIN && line->value <= INT32_MAX;
    if (!is_word || cam_param_set(params, (cam_param_id_t)id, (int32_t)line->value) != cam_ok) {
        found->unfit = found->n_unfit == 0u ? (cam_param_id_t)id : found->unfit;
        found->n_unfit++;
    }
}

cam_param_store_found_t cam_param_store_read(const hal_params_t *kept, cam_params_t *params)
{
    cam_param_store_found_t found = {
        .is_torn = kept->is_damaged, .unfit = cam_n_params, .missing = cam_n_params};
    const char *text = kept->bytes;
    const uint32_t n = kept->size > 0u ? checked(text, kept->size) : 0u;
    if (n == 0u) {
        found.err =
            kept->size > 0u || kept->is_damaged ? cam_err_params_damaged : cam_err_params_none;
        return found;
    }
    bool is_there[cam_n_params];
    (void)memset(is_there, 0, sizeof is_there);
    uint32_t at = 0;
    while (at < n) {
        const kept_line_t line = line_at(&text[at], n - at);
        if (is_called(&line, version_name)) {
            found.version = (uint32_t)(uint64_t)line.value;
        } else if (line.n_name > 0u) {
            take_line(&found, &line, params, is_there);
        }
        at += line.n + 1u;
    }
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        if (!is_there[id]) {
            found.missing = found.n_missing == 0u ? (cam_param_id_t)id : found.missing;
            found.n_missing++;
        }
    }
    return found;
}
