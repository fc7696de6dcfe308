// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): fmemopen
#include "sim_config.h"
#include "common_settings.h" // common_settings_read
#include "sim_file.h"        // sim_file_read
#include <stddef.h>          // offsetof
#include <stdio.h>           // fmemopen, snprintf
#include <string.h>          // strcmp

enum { max_bytes = 1 << 20 };

#define MEMBER(kind, section, key, member, min, max)                                               \
    {                                                                                              \
        section, key, kind, offsetof(sim_lathe_config_t, member), min, max, NULL                   \
    }
#define REAL(section, key, member, min, max)                                                       \
    MEMBER(common_setting_real, section, key, member, min, max)
#define WHOLE(section, key, member, min, max)                                                      \
    MEMBER(common_setting_count, section, key, member, min, max)
#define DRIVE(section, i)                                                                          \
    REAL(section, "bandwidth_hz", drive[i].bandwidth_hz, 1.0, 10000.0),                            \
        REAL(section, "damping", drive[i].damping, 0.05, 10.0),                                    \
        REAL(section, "delay_us", drive[i].delay_us, 0.0, 10000.0),                                \
        REAL(section, "quantum_nm", drive[i].quantum_micro, 0.0, 100000.0),                        \
        REAL(section, "speed_mm_per_s", drive[i].speed_units_per_s, 0.1, 10000.0),                 \
        REAL(section, "acceleration_mm_per_s2", drive[i].acceleration_units_per_s2, 10.0, 1e7)

static const common_setting_t fields[] = {
    WHOLE("machine", "tick_hz", tick_hz, 500.0, 100000.0),
    REAL("spindle", "inertia_kgm2", spindle.inertia_kgm2, 1e-6, 1e4),
    REAL("spindle", "torque_Nm", spindle.torque_Nm, 1e-3, 1e6),
    REAL("spindle", "bandwidth_rad_per_s", spindle.bandwidth_rad_per_s, 0.1, 1000.0),
    REAL("spindle", "ripple", spindle.ripple, 0.0, 0.5),
    REAL("spindle", "ripple_per_turn", spindle.ripple_per_turn, 0.01, 1000.0),
    REAL("spindle", "start_turn", spindle.start_turn, -1000.0, 1000.0),
    REAL("spindle", "limit_rpm", spindle_limit_rpm, 1.0, 60000.0),
    WHOLE("encoder", "counts_per_turn", encoder.counts_per_turn, 64.0, 16777216.0),
    MEMBER(common_setting_sign, "encoder", "sign", encoder.sign, -1.0, 1.0),
    REAL("encoder", "index_turn", encoder.index_turn, 0.0, 1.0),
    REAL("encoder", "eccentricity_counts", encoder.eccentricity_counts, 0.0, 100000.0),
    REAL("encoder", "eccentricity_turn", encoder.eccentricity_turn, 0.0, 1.0),
    REAL("encoder", "jitter_counts", encoder.jitter_counts, 0.0, 1000.0),
    WHOLE("encoder", "start_counts", encoder.start_counts, 0.0, 4294967295.0),
    DRIVE("u", hal_axis_u),
    REAL("u", "stroke_mm", u_stroke_mm, 0.001, 30.0),
    DRIVE("x", hal_axis_x),
    REAL("x", "start_mm", x_start_mm, 0.0, 1000.0),
    DRIVE("z", hal_axis_z),
    REAL("z", "start_mm", z_start_mm, -2000.0, 2000.0),
    REAL("swing", "bandwidth_hz", drive[sim_lathe_swing].bandwidth_hz, 1.0, 10000.0),
    REAL("swing", "damping", drive[sim_lathe_swing].damping, 0.05, 10.0),
    REAL("swing", "delay_us", drive[sim_lathe_swing].delay_us, 0.0, 10000.0),
    REAL("swing", "quantum_udeg", drive[sim_lathe_swing].quantum_micro, 0.0, 1e6),
    REAL("swing", "speed_deg_per_s", drive[sim_lathe_swing].speed_units_per_s, 0.0, 100000.0),
    REAL("swing", "acceleration_deg_per_s2", drive[sim_lathe_swing].acceleration_units_per_s2, 10.0,
         1e8),
    REAL("swing", "range_deg", swing_range_deg, 0.1, 90.0),
    REAL("tool", "nose_mm", tool_nose_mm, -1.0, 100.0),
    REAL("tool", "wear_um", tool_wear_um, 0.0, 1000.0),
    REAL("wheel", "wear_um_per_lobe", wheel_wear_um, 0.0, 1000.0),
};
enum { n_fields = sizeof fields / sizeof fields[0] };
_Static_assert((int)n_fields <= (int)common_settings_max, "one flag for each key");

/// The settings that are not in the list of numbers.
typedef struct {
    sim_config_t *config;
    bool is_name_seen;
} others_t;

sim_config_t sim_config_defaults(void)
{
    return (sim_config_t){.name = "default", .lathe = sim_lathe_defaults()};
}

static bool take_parameter(const common_settings_t *s, const char *key, const char *text)
{
    sim_wishes_t *wishes = &((others_t *)s->user)->config->controller;
    double value;
    if (!common_settings_number(text, &value)) {
        return common_settings_refuse(s, "controller", key, text, "no finite number; give one");
    }
    const cam_param_id_t id = cam_param_find(key);
    if (id < cam_n_params && wishes->is_given[id]) {
        return common_settings_refuse(s, "controller", key, text, "given twice; remove one");
    }
    char origin[300];
    (void)snprintf(origin, sizeof origin, "%.200s: line %d: controller", s->path, s->line);
    return sim_wishes_add(wishes, key, value, origin, s->e);
}

static bool take_other(const common_settings_t *s, const char *section, const char *key,
                       const char *text)
{
    if (strcmp(section, "controller") == 0) {
        return take_parameter(s, key, text);
    }
    if (strcmp(section, "machine") == 0 && strcmp(key, "name") == 0) {
        others_t *others = s->user;
        char *name = others->config->name;
        if (others->is_name_seen ||
            !common_settings_text(text, name, sizeof others->config->name - 1u)) {
            return common_settings_refuse(s, section, key, text,
                                          "give one \"text\" of at most 63 characters, once");
        }
        others->is_name_seen = true;
        return true;
    }
    return common_settings_refuse(s, section, key, text,
                                  "unknown; see host_sim/machines/default.toml for all keys");
}

bool sim_config_read(sim_config_t *config, const char *text, size_t size, const char *name,
                     common_error_t *e)
{
    others_t others = {.config = config};
    common_settings_t all = {.path = name,
                             .list = fields,
                             .n = n_fields,
                             .into = &config->lathe,
                             .take_other = take_other,
                             .user = &others,
                             .has_line_word = true,
                             .value_width = 60,
                             .e = e};
    if (size == 0u) { // fmemopen() may refuse an empty text
        return true;
    }
    FILE *stream = fmemopen((void *)text, size, "r"); // read only: the text stays as it is
    if (stream == NULL) {
        return common_error(e, "%s: not enough memory; free some", name);
    }
    const bool is_good = common_settings_read(&all, stream);
    (void)fclose(stream);
    return is_good;
}

bool sim_config_load(sim_config_t *config, const char *path, common_error_t *e)
{
    sim_file_t file;
    if (!sim_file_read(&file, path, max_bytes, e)) {
        return false;
    }
    const bool is_good = sim_config_read(config, (const char *)file.bytes, file.size, path, e);
    sim_file_free(&file);
    return is_good;
}
