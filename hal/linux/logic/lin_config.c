// SPDX-License-Identifier: Apache-2.0
#include "lin_config.h"
#include "lin_settings.h"
#include <stddef.h> // offsetof
#include <stdio.h>  // snprintf
#include <string.h> // strcmp

#define AT(member) offsetof(lin_config_t, member)
#define WHOLE(section, key, member, min, max)                                                      \
    {                                                                                              \
        section, key, lin_setting_whole, AT(member), min, max, NULL                                \
    }
#define FLAG(section, key, member)                                                                 \
    {                                                                                              \
        section, key, lin_setting_flag, AT(member), 0, 0, NULL                                     \
    }
#define TEXT(section, key, member, max)                                                            \
    {                                                                                              \
        section, key, lin_setting_text, AT(member), 0, max, NULL                                   \
    }
#define DRIVE(section, i)                                                                          \
    WHOLE(section, "node", drive[i].node, 0, 127),                                                 \
        WHOLE(section, "counts", drive[i].counts, 1, 1000000000),                                  \
        WHOLE(section, "nm", drive[i].nm, -1000000000, 1000000000)
#define LINE(key, i)                                                                               \
    TEXT("gpio", key, line[i].place, lin_name_max),                                                \
        FLAG("gpio", key "_active_low", line[i].is_active_low)

static const lin_setting_t settings[] = {
    WHOLE("thread", "tick_hz", thread.tick_hz, 500, 4000),
    WHOLE("thread", "priority", thread.priority, 0, 99),
    WHOLE("thread", "cpu", thread.cpu, -1, 1023),
    TEXT("can", "interface", can.interface, lin_interface_max),
    TEXT("can", "remote", can.remote, lin_interface_max),
    WHOLE("can", "node", can.node, 1, 126),
    FLAG("can", "fd", can.is_fd),
    WHOLE("can", "heartbeat_ms", can.heartbeat_ms, 10, 1000),
    WHOLE("can", "node_timeout_ms", can.node_timeout_ms, 10, 10000),
    WHOLE("can", "pdo_timeout_ms", can.pdo_timeout_ms, 2, 1000),
    WHOLE("can", "enable_ms", can.enable_ms, 10, 60000),
    WHOLE("encoder", "node", encoder.node, 1, 127),
    WHOLE("encoder", "modulus_counts", encoder.modulus_counts, 0, UINT32_MAX),
    WHOLE("encoder", "counts_per_turn", encoder.counts_per_turn, 64, 16777216),
    {"encoder", "index", lin_setting_choice, AT(encoder.index), 0, 0, "\"line\" \"position\""},
    WHOLE("encoder", "index_counts", encoder.index_counts, 0, 16777215),
    WHOLE("encoder", "delay_ns", encoder.delay_ns, 0, 100000000),
    WHOLE("encoder", "max_age_us", encoder.max_age_us, 0, 1000000),
    DRIVE("drive.u", hal_axis_u),
    DRIVE("drive.x", hal_axis_x),
    DRIVE("drive.z", hal_axis_z),
    WHOLE("spindle", "node", spindle_node, 0, 127),
    TEXT("gpio", "chip", chip, lin_name_max),
    LINE("estop", lin_line_estop),
    LINE("ready", lin_line_ready),
    LINE("index", lin_line_index),
    LINE("enable", lin_line_enable),
    LINE("fault", lin_line_fault),
    LINE("in_cut", lin_line_in_cut),
    TEXT("table", "file", table_file, lin_path_max),
    WHOLE("table", "max_bytes", table_max_bytes, 1024, 67108864),
};
enum { n_settings = sizeof settings / sizeof settings[0] };
_Static_assert((int)n_settings <= (int)lin_settings_max, "one flag for each key");

lin_config_t lin_config_defaults(void)
{
    return (lin_config_t){
        .thread = {.tick_hz = 1000, .priority = 80, .cpu = -1},
        .can = {.interface = "can0",
                .node = 64,
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
                 [lin_line_enable] = {"ENABLE", false},
                 [lin_line_fault] = {"FAULT", false},
                 [lin_line_in_cut] = {"INCUT", false}},
        .table_file = "/var/lib/camturn/table.camtab",
        .table_max_bytes = 1048576,
    };
}

const char *lin_line_name(lin_line_t line)
{
    static const char *const names[lin_n_lines] = {"estop",  "ready", "index",
                                                   "enable", "fault", "in_cut"};
    return names[line];
}

bool lin_line_is_there(const lin_config_t *config, lin_line_t line)
{
    return strcmp(config->line[line].place, "none") != 0;
}

static bool check_nodes(const lin_config_t *c, const char *path, lin_error_t *e)
{
    static const char *const keys[] = {"can.node",     "encoder.node", "drive.u.node",
                                       "drive.x.node", "drive.z.node", "spindle.node"};
    enum { n_nodes = sizeof keys / sizeof keys[0] };
    const int64_t nodes[n_nodes] = {c->can.node,
                                    c->encoder.node,
                                    c->drive[hal_axis_u].node,
                                    c->drive[hal_axis_x].node,
                                    c->drive[hal_axis_z].node,
                                    c->spindle_node};
    for (int i = 0; i < n_nodes; i++) {
        for (int k = 0; k < i; k++) {
            if (nodes[i] != 0 && nodes[i] == nodes[k]) {
                return lin_error(e, "%s: %s = %d: taken by %s; give each node a number of its own",
                                 path, keys[i], (int)nodes[i], keys[k]);
            }
        }
    }
    return true;
}

static bool check_encoder(const lin_config_t *c, const char *path, lin_error_t *e)
{
    const lin_encoder_config_t *enc = &c->encoder;
    if (enc->index_counts >= enc->counts_per_turn) {
        return lin_error(e, "%s: encoder.index_counts = %lld: give less than counts_per_turn", path,
                         (long long)enc->index_counts);
    }
    if (enc->modulus_counts != 0 && enc->modulus_counts % enc->counts_per_turn != 0) {
        return lin_error(e,
                         "%s: encoder.modulus_counts = %lld: not a multiple of counts_per_turn = "
                         "%lld; correct one of them",
                         path, (long long)enc->modulus_counts, (long long)enc->counts_per_turn);
    }
    if (enc->index == lin_index_line && !lin_line_is_there(c, lin_line_index)) {
        return lin_error(e,
                         "%s: encoder.index = \"line\": gpio.index is \"none\"; give the line or "
                         "take \"position\"",
                         path);
    }
    return true;
}

static bool check_texts(const lin_config_t *c, const char *path, lin_error_t *e)
{
    if (c->can.interface[0] == '\0' || c->table_file[0] == '\0' || c->chip[0] == '\0') {
        return lin_error(e, "%s: can.interface, gpio.chip or table.file is empty; give a name",
                         path);
    }
    for (int i = 0; i < lin_n_lines; i++) {
        if (c->line[i].place[0] == '\0') {
            return lin_error(e, "%s: gpio.%s is empty; give a name, CHIP:OFFSET or \"none\"", path,
                             lin_line_name((lin_line_t)i));
        }
    }
    return true;
}

static bool check_drives(const lin_config_t *c, const char *path, lin_error_t *e)
{
    static const char axis[hal_n_axes] = "uxz";
    for (int i = 0; i < hal_n_axes; i++) {
        if (c->drive[i].nm == 0) {
            return lin_error(e, "%s: drive.%c.nm = 0: give the length of drive.%c.counts", path,
                             axis[i], axis[i]);
        }
    }
    return true;
}

bool lin_config_load(lin_config_t *config, const char *path, lin_error_t *e)
{
    if (!lin_settings_read(path, settings, n_settings, config, e)) {
        return false;
    }
    if (config->can.remote[0] == '\0') {
        (void)snprintf(config->can.remote, sizeof config->can.remote, "%s", config->can.interface);
    }
    return check_texts(config, path, e) && check_nodes(config, path, e) &&
           check_encoder(config, path, e) && check_drives(config, path, e);
}
