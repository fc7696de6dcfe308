// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include <stdio.h>  // snprintf
#include <string.h> // strcmp

enum { most_percent = 100, full_percent = 90, least_tick_hz = 500 };
#define SECOND_NS INT64_C(1000000000)

static bool check_nodes(const lin_config_t *c, const char *path, common_error_t *e)
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
                return common_error(e,
                                    "%s: %s = %d: also used by %s; give each node its own number",
                                    path, keys[i], (int)nodes[i], keys[k]);
            }
        }
    }
    return true;
}

/// One frame arrives per tick. At the next tick its age is one period plus the encoder's delay; a
/// shorter limit would reject every frame.
static bool check_age(const lin_config_t *c, const char *path, common_error_t *e)
{
    const int64_t age_ns = lin_config_age_us(&c->encoder, c->thread.tick_hz) * 1000;
    const int64_t least_ns = SECOND_NS / c->thread.tick_hz + c->encoder.delay_ns;
    return age_ns >= least_ns ||
           common_error(
               e,
               "%s: encoder.max_age_us = %lld: with delay_ns = %lld every frame is older than "
               "this at the next tick; give at least %lld",
               path, (long long)c->encoder.max_age_us, (long long)c->encoder.delay_ns,
               (long long)(least_ns + 999) / 1000);
}

static bool check_encoder(const lin_config_t *c, const char *path, common_error_t *e)
{
    const lin_encoder_config_t *enc = &c->encoder;
    if (enc->index_counts >= enc->counts_per_turn) {
        return common_error(e, "%s: encoder.index_counts = %lld: give less than counts_per_turn",
                            path, (long long)enc->index_counts);
    }
    if (enc->modulus_counts != 0 && enc->modulus_counts % enc->counts_per_turn != 0) {
        return common_error(
            e,
            "%s: encoder.modulus_counts = %lld: not a multiple of counts_per_turn = "
            "%lld; correct one of them",
            path, (long long)enc->modulus_counts, (long long)enc->counts_per_turn);
    }
    if (enc->index == lin_index_line && !lin_line_is_there(c, lin_line_index)) {
        return common_error(
            e,
            "%s: encoder.index = \"line\": gpio.index is \"none\"; give the line or "
            "use \"position\"",
            path);
    }
    return true;
}

static bool check_place(const lin_config_t *c, lin_line_t i, lin_place_t *at, const char *path,
                        common_error_t *e)
{
    const char *place = c->line[i].place;
    common_error_t why;
    if (place[0] == '\0') {
        return common_error(e, "%s: %s is empty; give a name, CHIP:OFFSET or \"none\"", path,
                            lin_line_name(i));
    }
    return lin_place_parse(at, c->chip, place, &why) ||
           common_error(e, "%s: %s = %s", path, lin_line_name(i), why.text);
}

static bool check_lines(const lin_config_t *c, const char *path, common_error_t *e)
{
    lin_place_t at[lin_n_lines];
    for (int i = 0; i < lin_n_lines; i++) {
        if (!check_place(c, (lin_line_t)i, &at[i], path, e)) {
            return false;
        }
        for (int k = 0; k < i && lin_line_is_there(c, (lin_line_t)i); k++) {
            if (lin_place_is_same(&at[i], &at[k])) {
                return common_error(e, "%s: %s = \"%s\": also used by %s; give each its own line",
                                    path, lin_line_name((lin_line_t)i), c->line[i].place,
                                    lin_line_name((lin_line_t)k));
            }
        }
    }
    return true;
}

static bool check_drives(const lin_config_t *c, const char *path, common_error_t *e)
{
    static const char axis[hal_n_axes] = "uxz";
    for (int i = 0; i < hal_n_axes; i++) {
        if (c->drive[i].nm == 0) {
            return common_error(e, "%s: drive.%c.nm = 0: give the length of drive.%c.counts", path,
                                axis[i], axis[i]);
        }
    }
    return true;
}

static bool check_times(const lin_config_t *c, const char *path, common_error_t *e)
{
    const int64_t hz = c->thread.tick_hz;
    return c->can.pdo_timeout_ms * hz >= 2000 ||
           common_error(e,
                        "%s: can.pdo_timeout_ms = %lld: shorter than two ticks of thread.tick_hz = "
                        "%lld; give at least %lld",
                        path, (long long)c->can.pdo_timeout_ms, (long long)hz,
                        (long long)(2000 + hz - 1) / hz);
}

/// Format the bus load and the highest possible tick rate.
static void put_load(const lin_config_t *c, const lin_load_t *load, common_error_t *e)
{
    const int64_t most_hz = lin_load_most_hz(load);
    char highest[80];
    if (most_hz < least_tick_hz) {
        (void)snprintf(highest, sizeof highest, "no rate of %d or more is possible", least_tick_hz);
    } else {
        (void)snprintf(highest, sizeof highest, "the highest possible rate is %lld; lower it",
                       (long long)most_hz);
    }
    (void)common_error(
        e,
        "thread.tick_hz = %lld: takes up to %lld %% of a bus with can.bitrate = %lld%s: "
        "%lld us a tick and %lld ms a second for heartbeats and status; %s, %s",
        (long long)c->thread.tick_hz, (long long)lin_load_percent(load, c->thread.tick_hz),
        (long long)c->can.bitrate, c->can.is_fd ? " (FD)" : "", (long long)load->tick_ns / 1000,
        (long long)load->second_ns / 1000000, highest,
        c->can.is_fd ? "or use fewer drives" : "set can.fd or use fewer drives");
}

static bool check_load(const lin_config_t *c, const char *path, common_error_t *e)
{
    const lin_load_t load = lin_load_of(c);
    const bool is_virtual = strncmp(c->can.interface, "vcan", 4) == 0; // has no bit rate
    if (lin_load_percent(&load, c->thread.tick_hz) <= most_percent || is_virtual) {
        return true;
    }
    common_error_t why;
    put_load(c, &load, &why);
    return common_error(e, "%s: %s", path, why.text);
}

bool lin_check_load(lin_config_t *config, const char *path, common_error_t *e)
{
    const lin_config_t *c = config;
    if (!lin_config_read(config, path, e)) {
        return false;
    }
    if (c->can.interface[0] == '\0' || c->table_file[0] == '\0' || c->chip[0] == '\0') {
        return common_error(e, "%s: can.interface, gpio.chip or table.file is empty; give a name",
                            path);
    }
    if (strcmp(c->params_file, c->table_file) == 0) {
        return common_error(e, "%s: parameters.file is table.file; give each a path of its own",
                            path);
    }
    return check_lines(c, path, e) && check_nodes(c, path, e) && check_encoder(c, path, e) &&
           check_age(c, path, e) && check_drives(c, path, e) && check_times(c, path, e) &&
           check_load(c, path, e);
}

void lin_check_warn(const lin_config_t *c, lin_check_report_t *report)
{
    const lin_load_t load = lin_load_of(c);
    if (c->has_retired) {
        report("warning: gpio.switch_1 .. switch_8: retired and ignored; remove them");
    }
    if (!lin_line_is_there(c, lin_line_estop)) {
        report(
            "warning: gpio.estop = \"none\": the emergency stop is not detected; for trials only");
    }
    if (!lin_line_is_there(c, lin_line_enable)) {
        report("warning: gpio.enable = \"none\": drives are disabled over the bus only; for trials "
               "only");
    }
    if (lin_load_percent(&load, c->thread.tick_hz) > full_percent) {
        common_error_t why, line;
        put_load(c, &load, &why);
        (void)common_error(&line, "warning: %s", why.text);
        report(line.text);
    }
    if (lin_config_is_waived(c)) {
        report(
            "warning: operator.acknowledge = \"waived\": anyone on the bus can start the machine");
    } else if (!lin_line_is_there(c, lin_line_acknowledge)) {
        report("warning: operator.acknowledge = \"none\": nothing can be enabled; give its line");
    } else { // an acknowledge button is wired
    }
}
