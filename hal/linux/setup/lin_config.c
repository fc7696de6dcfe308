// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include "common_settings.h" // common_settings_read
#include <errno.h>           // errno
#include <stddef.h>          // offsetof
#include <stdio.h>           // snprintf
#include <string.h>          // strcmp

#define AT(member) offsetof(lin_config_t, member)
#define WHOLE(section, key, member, min, max)                                                      \
    {                                                                                              \
        section, key, common_setting_whole, AT(member), min, max, .choices = NULL                  \
    }
#define FLAG(section, key, member)                                                                 \
    {                                                                                              \
        section, key, common_setting_flag, AT(member), 0, 0, .choices = NULL                       \
    }
#define TEXT(section, key, member, max)                                                            \
    {                                                                                              \
        section, key, common_setting_text, AT(member), 0, max, .choices = NULL                     \
    }
#define DRIVE(section, i, least_node)                                                              \
    WHOLE(section, "node", drive[i].node, least_node, 127),                                        \
        WHOLE(section, "counts", drive[i].counts, 1, 1000000000),                                  \
        WHOLE(section, "nm", drive[i].nm, -1000000000, 1000000000)
#define NONE                                                                                       \
    {                                                                                              \
        "none", false                                                                              \
    }
#define OPERATOR_LINE(key, i)                                                                      \
    TEXT("operator", key, line[i].place, lin_name_max),                                            \
        FLAG("operator", key "_active_low", line[i].is_active_low)
#define LINE(key, i)                                                                               \
    TEXT("gpio", key, line[i].place, lin_name_max),                                                \
        FLAG("gpio", key "_active_low", line[i].is_active_low)

static const common_setting_t settings[] = {
    WHOLE("thread", "tick_hz", thread.tick_hz, 500, 4000),
    WHOLE("thread", "priority", thread.priority, 0, 99),
    WHOLE("thread", "cpu", thread.cpu, -1, 1023),
    TEXT("can", "interface", can.interface, lin_interface_max),
    TEXT("can", "remote", can.remote, lin_interface_max),
    WHOLE("can", "node", can.node, 1, 126),
    WHOLE("can", "bitrate", can.bitrate, 10000, 1000000),
    FLAG("can", "fd", can.is_fd),
    WHOLE("can", "data_bitrate", can.data_bitrate, 10000, 8000000),
    WHOLE("can", "heartbeat_ms", can.heartbeat_ms, 10, 1000),
    WHOLE("can", "node_timeout_ms", can.node_timeout_ms, 10, 10000),
    WHOLE("can", "pdo_timeout_ms", can.pdo_timeout_ms, 2, 1000),
    WHOLE("can", "enable_ms", can.enable_ms, 10, 60000),
    WHOLE("encoder", "node", encoder.node, 1, 127),
    WHOLE("encoder", "modulus_counts", encoder.modulus_counts, 0, UINT32_MAX),
    WHOLE("encoder", "counts_per_turn", encoder.counts_per_turn, 64, 16777216),
    {"encoder", "index", common_setting_choice, AT(encoder.index), 0, 0,
     .choices = "\"line\" \"position\""},
    WHOLE("encoder", "index_counts", encoder.index_counts, 0, 16777215),
    WHOLE("encoder", "delay_ns", encoder.delay_ns, 0, 100000000),
    WHOLE("encoder", "max_age_us", encoder.max_age_us, 0, 1000000),
    DRIVE("drive.u", hal_axis_u, 1), // U is required
    DRIVE("drive.x", hal_axis_x, 0),
    DRIVE("drive.z", hal_axis_z, 0),
    WHOLE("spindle", "node", spindle_node, 0, 127),
    TEXT("gpio", "chip", chip, lin_name_max),
    LINE("estop", lin_line_estop),
    LINE("ready", lin_line_ready),
    LINE("index", lin_line_index),
    LINE("home_u", lin_line_home_u + 0),
    LINE("home_x", lin_line_home_u + 1),
    LINE("home_z", lin_line_home_u + 2),
    LINE("index_u", lin_line_home_u + 3),
    LINE("index_x", lin_line_home_u + 4),
    LINE("index_z", lin_line_home_u + 5),
    LINE("enable", lin_line_enable),
    LINE("fault", lin_line_fault),
    LINE("in_cut", lin_line_in_cut),
    OPERATOR_LINE("acknowledge", lin_line_acknowledge),
    OPERATOR_LINE("key", lin_line_key),
    TEXT("table", "file", table_file, lin_path_max),
    WHOLE("table", "max_bytes", table_max_bytes, 1024, 67108864),
    TEXT("parameters", "file", params_file, lin_path_max),
};
enum { n_settings = sizeof settings / sizeof settings[0] };
_Static_assert((int)n_settings <= (int)common_settings_max, "one flag for each key");

lin_config_t lin_config_defaults(void)
{
    return (lin_config_t){
        .thread = {.tick_hz = 500, .priority = 80, .cpu = -1},
        .can = {.interface = "can0",
                .node = 64,
                .bitrate = 1000000,
                .data_bitrate = 5000000,
                .heartbeat_ms = 50,
                .node_timeout_ms = 100,
                .pdo_timeout_ms = 20,
                .enable_ms = 500},
        .encoder = {.node = 1, .counts_per_turn = 10000},
        .drive = {[hal_axis_u] = {2, 1, 1}, [hal_axis_x] = {3, 1, 1}, [hal_axis_z] = {4, 1, 1}},
        .spindle_node = 5,
        .chip = "gpiochip0",
        .line = {[lin_line_estop] = {"ESTOP", false},
                 [lin_line_ready] = {"READY", false},
                 [lin_line_index] = {"INDEX", false},
                 [lin_line_home_u] = NONE,
                 [lin_line_home_u + 1] = NONE,
                 [lin_line_home_u + 2] = NONE,
                 [lin_line_home_u + 3] = NONE,
                 [lin_line_home_u + 4] = NONE,
                 [lin_line_home_u + 5] = NONE,
                 [lin_line_acknowledge] = NONE,
                 [lin_line_key] = NONE,
                 [lin_line_enable] = {"ENABLE", false},
                 [lin_line_fault] = {"FAULT", false},
                 [lin_line_in_cut] = {"INCUT", false}},
        .table_file = "/var/lib/camturn/table.camtab",
        .table_max_bytes = 1048576,
        .params_file = "/var/lib/camturn/parameters.toml",
    };
}

const char *lin_line_name(lin_line_t line)
{
    static const char *const names[lin_n_lines] = {
        "gpio.estop",   "gpio.ready",   "gpio.index",   "gpio.home_u",  "gpio.home_x",
        "gpio.home_z",  "gpio.index_u", "gpio.index_x", "gpio.index_z", "operator.acknowledge",
        "operator.key", "gpio.enable",  "gpio.fault",   "gpio.in_cut"};
    return names[line];
}

bool lin_line_is_there(const lin_config_t *config, lin_line_t line)
{
    const bool is_waived = line == lin_line_acknowledge && lin_config_is_waived(config);
    return strcmp(config->line[line].place, "none") != 0 && !is_waived;
}

bool lin_config_is_waived(const lin_config_t *config)
{
    return strcmp(config->line[lin_line_acknowledge].place, "waived") == 0;
}

int64_t lin_config_age_us(const lin_encoder_config_t *config, int64_t tick_hz)
{
    enum { default_age_ticks = 3 };
    return config->max_age_us != 0 ? config->max_age_us
                                   : default_age_ticks * INT64_C(1000000) / tick_hz;
}

/// Ignore the lines of the position switches, which are retired; refuse all other keys.
static bool take_other(const common_settings_t *s, const char *section, const char *key,
                       const char *text)
{
    static const char retired[] = "switch_";
    (void)text;
    if (strcmp(section, "gpio") != 0 || strncmp(key, retired, sizeof retired - 1u) != 0) {
        return common_settings_refuse_key(s, section, key, "unknown key; correct or remove it");
    }
    ((lin_config_t *)s->into)->has_retired = true;
    return true;
}

bool lin_config_read(lin_config_t *config, const char *path, common_error_t *e)
{
    common_settings_t all = {.path = path,
                             .list = settings,
                             .n = n_settings,
                             .into = config,
                             .take_other = take_other,
                             .is_strict = true,
                             .value_width = 80,
                             .e = e};
    FILE *stream = fopen(path, "r");
    if (stream == NULL) {
        return common_error(e, "%s: cannot be opened: %s; check the path", path, strerror(errno));
    }
    const bool is_good = common_settings_read(&all, stream);
    (void)fclose(stream);
    if (is_good && config->can.remote[0] == '\0') {
        (void)snprintf(config->can.remote, sizeof config->can.remote, "%s", config->can.interface);
    }
    return is_good;
}
