// SPDX-License-Identifier: Apache-2.0
#include "sim_config.h"
#include "sim_file.h" // sim_file_read
#include <ctype.h>    // isspace
#include <ini.h>      // ini_parse_stream
#include <stddef.h>   // offsetof
#include <stdio.h>    // snprintf
#include <string.h>   // memchr, strchr, strcmp

enum { max_bytes = 1 << 20 };

typedef struct {
    const char *section, *key;
    size_t offset; ///< of a double in sim_machine_config_t
    double min, max;
    bool is_whole;
} field_t;

#define MEMBER(section, key, member, min, max, is_whole)                                           \
    {                                                                                              \
        section, key, offsetof(sim_machine_config_t, member), min, max, is_whole                   \
    }
#define REAL(section, key, member, min, max) MEMBER(section, key, member, min, max, false)
#define WHOLE(section, key, member, min, max) MEMBER(section, key, member, min, max, true)
#define DRIVE(section, i)                                                                          \
    REAL(section, "bandwidth_hz", axis[i].bandwidth_hz, 1.0, 10000.0),                             \
        REAL(section, "damping", axis[i].damping, 0.05, 10.0),                                     \
        REAL(section, "delay_us", axis[i].delay_us, 0.0, 10000.0),                                 \
        REAL(section, "quantum_nm", axis[i].quantum_nm, 0.0, 100000.0),                            \
        REAL(section, "speed_mm_per_s", axis[i].speed_mm_per_s, 0.1, 10000.0),                     \
        REAL(section, "acceleration_mm_per_s2", axis[i].acceleration_mm_per_s2, 10.0, 1e7)

static const field_t fields[] = {
    WHOLE("machine", "tick_hz", tick_hz, 500.0, 100000.0),
    REAL("spindle", "inertia_kgm2", spindle.inertia_kgm2, 1e-6, 1e4),
    REAL("spindle", "torque_Nm", spindle.torque_Nm, 1e-3, 1e6),
    REAL("spindle", "bandwidth_rad_per_s", spindle.bandwidth_rad_per_s, 0.1, 1000.0),
    REAL("spindle", "ripple", spindle.ripple, 0.0, 0.5),
    REAL("spindle", "ripple_per_turn", spindle.ripple_per_turn, 0.01, 1000.0),
    REAL("spindle", "start_turn", spindle.start_turn, -1000.0, 1000.0),
    REAL("spindle", "limit_rpm", spindle_limit_rpm, 1.0, 60000.0),
    WHOLE("encoder", "counts_per_turn", encoder.counts_per_turn, 64.0, 16777216.0),
    WHOLE("encoder", "sign", encoder.sign, -1.0, 1.0),
    REAL("encoder", "index_turn", encoder.index_turn, 0.0, 1.0),
    REAL("encoder", "eccentricity_counts", encoder.eccentricity_counts, 0.0, 100000.0),
    REAL("encoder", "eccentricity_turn", encoder.eccentricity_turn, 0.0, 1.0),
    REAL("encoder", "jitter_counts", encoder.jitter_counts, 0.0, 1000.0),
    WHOLE("encoder", "start_counts", encoder.start_counts, 0.0, 4294967295.0),
    DRIVE("u", 0),
    REAL("u", "stroke_mm", u_stroke_mm, 0.001, 30.0),
    DRIVE("x", 1),
    REAL("x", "start_mm", x_start_mm, 0.0, 1000.0),
    DRIVE("z", 2),
    REAL("z", "start_mm", z_start_mm, -2000.0, 2000.0),
    REAL("swing", "bandwidth_hz", swing.bandwidth_hz, 1.0, 10000.0),
    REAL("swing", "damping", swing.damping, 0.05, 10.0),
    REAL("swing", "delay_us", swing.delay_us, 0.0, 10000.0),
    REAL("swing", "quantum_udeg", swing.quantum_nm, 0.0, 1e6),
    REAL("swing", "speed_deg_per_s", swing.speed_mm_per_s, 0.0, 100000.0),
    REAL("swing", "acceleration_deg_per_s2", swing.acceleration_mm_per_s2, 10.0, 1e8),
    REAL("swing", "range_deg", swing_range_deg, 0.1, 90.0),
};
enum { n_fields = sizeof fields / sizeof fields[0] };

typedef struct {
    sim_config_t *config;
    const char *path;
    sim_file_t file;
    size_t at; ///< byte at which the next line begins
    int line;
    bool is_seen[n_fields], is_name_seen;
    bool is_wrong;
    sim_error_t *e;
} reader_t;

sim_config_t sim_config_defaults(void)
{
    return (sim_config_t){.name = "default", .machine = sim_machine_defaults()};
}

/// Cut a comment behind the value and the blanks before it; # inside quotes stays.
static void strip(char *text)
{
    bool is_quoted = false;
    char *c = text;
    while (*c != '\0' && (is_quoted || *c != '#')) {
        is_quoted = *c == '"' ? !is_quoted : is_quoted;
        c++;
    }
    while (c > text && isspace((unsigned char)c[-1]) != 0) {
        c--;
    }
    *c = '\0';
}

/// inih takes strings, which would end at a NUL byte.
static bool check_line(reader_t *r, const char *text, size_t length, size_t max_length)
{
    if (memchr(text, '\0', length) != NULL) {
        r->is_wrong = true;
        (void)sim_error(r->e, "%s: line %d: has a NUL byte; give a text file", r->path, r->line);
    } else if (length > max_length) {
        r->is_wrong = true;
        (void)sim_error(r->e, "%s: line %d: longer than %zu characters; shorten it", r->path,
                        r->line, max_length);
    }
    return !r->is_wrong;
}

/// inih takes an indented line for more of the value before; TOML does not, so lines come
/// unindented.
static char *read_line(char *line, int size, void *user)
{
    reader_t *r = user;
    const size_t left = r->file.size - r->at;
    if (r->is_wrong || left == 0u) {
        return NULL;
    }
    const char *text = (const char *)r->file.bytes + r->at;
    const char *end = memchr(text, '\n', left);
    const size_t length = end != NULL ? (size_t)(end - text) : left;
    r->at += end != NULL ? length + 1u : length;
    r->line++;
    if (!check_line(r, text, length, (size_t)size - 2u)) {
        return NULL;
    }
    memcpy(line, text, length);
    line[length] = '\0';
    const size_t n_blanks = strspn(line, " \t");
    memmove(line, line + n_blanks, length - n_blanks + 1u);
    return line;
}

static bool refuse(reader_t *r, const char *section, const char *key, const char *value,
                   const char *why)
{
    return sim_error(r->e, "%s: line %d: %.40s.%.40s = %.60s: %s", r->path, r->line, section, key,
                     value, why);
}

/// A number as TOML writes it: bools count as 1 and 0, underscores between digits are not taken.
static bool number_of(const char *text, double *value)
{
    if (strcmp(text, "true") == 0 || strcmp(text, "false") == 0) {
        *value = text[0] == 't' ? 1.0 : 0.0;
        return true;
    }
    return sim_parse_number(text, value);
}

static bool take_field(reader_t *r, size_t i, const char *text)
{
    const field_t *f = &fields[i];
    double value;
    if (!number_of(text, &value)) {
        return refuse(r, f->section, f->key, text, "no finite number; give one");
    }
    const bool is_sign = strcmp(f->key, "sign") == 0;
    const bool is_odd =
        (f->is_whole && value != (double)(int64_t)value) || (is_sign && value == 0.0);
    if (!(value >= f->min && value <= f->max) || is_odd) {
        char why[120];
        (void)snprintf(why, sizeof why, "out of range; give a%s number %.12g .. %.12g%s",
                       f->is_whole ? " whole" : "", f->min, f->max, is_sign ? ", not 0" : "");
        return refuse(r, f->section, f->key, text, why);
    }
    if (r->is_seen[i]) {
        return refuse(r, f->section, f->key, text, "given twice; remove one");
    }
    r->is_seen[i] = true;
    *(double *)((char *)&r->config->machine + f->offset) = value;
    return true;
}

static bool take_name(reader_t *r, const char *text)
{
    const size_t length = strlen(text);
    const bool is_string = length >= 2u && text[0] == '"' && text[length - 1u] == '"' &&
                           strchr(text + 1, '"') == text + length - 1u;
    if (!is_string || length - 2u >= sizeof r->config->name || r->is_name_seen) {
        return refuse(r, "machine", "name", text,
                      "give one \"text\" of at most 63 characters, once");
    }
    r->is_name_seen = true;
    memcpy(r->config->name, text + 1, length - 2u);
    r->config->name[length - 2u] = '\0';
    return true;
}

static bool take_parameter(reader_t *r, const char *key, const char *text)
{
    double value;
    if (!number_of(text, &value)) {
        return refuse(r, "controller", key, text, "no finite number; give one");
    }
    const cam_param_id_t id = cam_param_find(key);
    if (id < cam_n_params && r->config->controller.is_given[id]) {
        return refuse(r, "controller", key, text, "given twice; remove one");
    }
    char origin[300];
    (void)snprintf(origin, sizeof origin, "%.200s: line %d: controller", r->path, r->line);
    return sim_wishes_add(&r->config->controller, key, value, origin, r->e);
}

static bool take(reader_t *r, const char *section, const char *key, const char *text)
{
    if (strcmp(section, "controller") == 0) {
        return take_parameter(r, key, text);
    }
    if (strcmp(section, "machine") == 0 && strcmp(key, "name") == 0) {
        return take_name(r, text);
    }
    for (size_t i = 0; i < n_fields; i++) {
        if (strcmp(section, fields[i].section) == 0 && strcmp(key, fields[i].key) == 0) {
            return take_field(r, i, text);
        }
    }
    return refuse(r, section, key, text,
                  "unknown; see host_sim/machines/default.toml for all keys");
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

bool sim_config_load(sim_config_t *config, const char *path, sim_error_t *e)
{
    reader_t r = {.config = config, .path = path, .e = e};
    if (!sim_file_read(&r.file, path, max_bytes, e)) {
        return false;
    }
    const int result = ini_parse_stream(read_line, &r, on_value, &r);
    sim_file_free(&r.file);
    if (r.is_wrong) {
        return false;
    }
    if (result != 0) {
        return sim_error(e, "%s: line %d: neither [section] nor key = value; correct it", path,
                         result);
    }
    return true;
}
