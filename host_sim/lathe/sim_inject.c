// SPDX-License-Identifier: Apache-2.0
#include "sim_inject.h"
#include "common_number.h" // common_number_parse
#include "sim_units.h"     // SIM_TWO_PI
#include <stdio.h>         // snprintf
#include <string.h>        // strchr

typedef struct {
    const char *name;
    const char *value; ///< what the value is, NULL: none
    double min, max;
    bool is_whole;
    unsigned places; ///< sim_inject_place_t; 0: both
} kind_t;

static const kind_t kinds[sim_n_injects] = {
    [sim_inject_estop] = {.name = "estop"},
    [sim_inject_drive] = {.name = "drive"},
    [sim_inject_bus] = {.name = "bus", .places = sim_inject_in_run},
    [sim_inject_lost_counts] = {"lost-counts", "counts", 1.0, 1e9, true, 0},
    [sim_inject_encoder_jump] = {"encoder-jump", "counts", -1e9, 1e9, true, 0},
    [sim_inject_encoder_stuck] = {.name = "encoder-stuck"},
    [sim_inject_encoder_rate] = {"encoder-rate", "percent", -100.0, 900.0, false, 0},
    [sim_inject_encoder_dither] = {"encoder-dither", "counts", 1.0, 1000.0, true, 0},
    [sim_inject_index_dead] = {.name = "index-dead"},
    [sim_inject_late_tick] = {"late-tick", "percent", 1.0, 10000.0, true, sim_inject_in_run},
    [sim_inject_clock_drift] = {"clock-drift", "ppm", -100000.0, 100000.0, false,
                                sim_inject_in_run},
    [sim_inject_tick_jitter] = {"tick-jitter", "percent", 0.0, 99.0, false, sim_inject_in_run},
    [sim_inject_tick_burst] = {"tick-burst", "percent", 0.0, 99.0, false, sim_inject_in_run},
    [sim_inject_tick_twice] = {"tick-twice", "percent", 1.0, 99.0, false, sim_inject_in_run},
    [sim_inject_reverse] = {.name = "reverse"},
    [sim_inject_spindle_speed] = {"spindle-speed", "r/min", 0.0, 60000.0, false, 0},
    [sim_inject_spindle_stop] = {.name = "spindle-stop"},
    [sim_inject_z_offset] = {"z-offset", "mm", -1000.0, 1000.0, false, sim_inject_in_run},
    [sim_inject_u_block] = {.name = "u-block"},
    [sim_inject_u_scale_stuck] = {.name = "u-scale-stuck"},
    [sim_inject_u_reversed] = {.name = "u-reversed", .places = sim_inject_in_run},
    [sim_inject_u_push] = {"u-push", "newton", -10000.0, 10000.0, false, sim_inject_in_run},
    [sim_inject_u_limit] = {"u-limit", "-1, 0 or 1", -1.0, 1.0, true, sim_inject_in_run},
    [sim_inject_swing_block] = {.name = "swing-block", .places = sim_inject_in_run},
    [sim_inject_table_flip] = {"table-flip", "byte", 0.0, 4294967295.0, true, sim_inject_in_run},
    [sim_inject_stop] = {.name = "stop", .places = sim_inject_in_run},
    [sim_inject_hold] = {.name = "hold", .places = sim_inject_in_run},
    [sim_inject_resume] = {.name = "resume", .places = sim_inject_in_run},
    [sim_inject_feed_override] = {"feed-override", "percent", 0.0, 150.0, false, sim_inject_in_run},
    [sim_inject_spindle_override] = {"spindle-override", "percent", 50.0, 120.0, false,
                                     sim_inject_in_run},
    [sim_inject_trim] = {"trim", "um", -1000.0, 1000.0, false, sim_inject_in_run},
    [sim_inject_acknowledge] = {"acknowledge", "seconds", 0.0, 1000.0, false, sim_inject_at_button},
    [sim_inject_key] = {"key", "0 or 1", 0.0, 1.0, true, sim_inject_at_button},
    [sim_inject_encoder_late] = {"encoder-late", "us", 1.0, 1e6, false, sim_inject_on_bus},
    [sim_inject_encoder_missing] = {"encoder-missing", "frames", 1.0, 1e9, true, sim_inject_on_bus},
    [sim_inject_encoder_repeated] = {"encoder-repeated", "frames", 1.0, 1e9, true,
                                     sim_inject_on_bus},
    [sim_inject_encoder_swapped] = {"encoder-swapped", "pairs", 1.0, 1e9, true, sim_inject_on_bus},
    [sim_inject_heartbeat_lost] = {"heartbeat-lost", "a node", 1.0, 5.0, true, sim_inject_on_bus},
    [sim_inject_node_dead] = {"node-dead", "a node", 1.0, 5.0, true, sim_inject_on_bus},
    [sim_inject_node_fault] = {"node-fault", "a drive", 2.0, 5.0, true, sim_inject_on_bus},
};

const char *sim_inject_name(sim_inject_kind_t kind)
{
    return kinds[kind].name;
}

static bool parse_value(sim_inject_t *inject, const char *value, const char *text,
                        common_error_t *e)
{
    const kind_t *k = &kinds[inject->kind];
    if (k->value == NULL) {
        return value == NULL ||
               common_error(e, "--inject %.60s: %s takes no value; remove it", text, k->name);
    }
    if (value == NULL || !common_number_parse(value, &inject->value) || inject->value < k->min ||
        inject->value > k->max ||
        (k->is_whole && inject->value != (double)(int64_t)inject->value)) {
        return common_error(e,
                            "--inject %.60s: %s takes %s, %.12g .. %.12g; write %s@SECONDS:VALUE",
                            text, k->name, k->value, k->min, k->max, k->name);
    }
    return true;
}

bool sim_inject_parse(sim_inject_t *inject, const char *text, sim_inject_place_t place,
                      common_error_t *e)
{
    char copy[128];
    *inject = (sim_inject_t){0};
    if ((size_t)snprintf(copy, sizeof copy, "%s", text) >= sizeof copy) {
        return common_error(e, "--inject %.60s...: too long; write KIND@SECONDS[:VALUE]", text);
    }
    char *at = strchr(copy, '@');
    if (at == NULL) {
        return common_error(e, "--inject %.60s: no @SECONDS; write KIND@SECONDS[:VALUE]", text);
    }
    *at++ = '\0';
    char *value = strchr(at, ':');
    if (value != NULL) {
        *value++ = '\0';
    }
    const char *command = place == sim_inject_on_bus    ? "bus"
                          : place == sim_inject_in_live ? "live"
                                                        : "run";
    int kind = 0;
    while (kind < sim_n_injects && strcmp(kinds[kind].name, copy) != 0) {
        kind++;
    }
    if (kind == sim_n_injects) {
        return common_error(e, "--inject %.60s: no such kind; camsim %s --help lists them", text,
                            command);
    }
    inject->kind = (sim_inject_kind_t)kind;
    if (kinds[kind].places != 0u && (kinds[kind].places & (unsigned)place) == 0u) {
        return common_error(e,
                            "--inject %.60s: cannot happen here; camsim %s --help lists what can",
                            text, command);
    }
    inject->is_absolute = at[0] == 't';
    if (!common_number_parse(at + (inject->is_absolute ? 1 : 0), &inject->at_s) ||
        inject->at_s < 0.0) {
        return common_error(e, "--inject %.60s: no time; write KIND@SECONDS with 0 or more seconds",
                            text);
    }
    return parse_value(inject, value, text, e);
}

static void force_speed(sim_lathe_t *l, double rad_per_s)
{
    l->is_speed_forced = true;
    l->forced_rad_per_s = rad_per_s;
}

void sim_inject_apply(const sim_inject_t *inject, sim_lathe_t *l, int direction)
{
    switch (inject->kind) {
    case sim_inject_lost_counts:
        l->count_offset -= (uint32_t)inject->value;
        break;
    case sim_inject_encoder_jump:
        l->count_offset += (uint32_t)(int32_t)inject->value;
        break;
    case sim_inject_encoder_stuck:
        sim_lathe_stick_encoder(l);
        break;
    case sim_inject_encoder_rate:
        l->count_rate = inject->value / 100.0;
        break;
    case sim_inject_encoder_dither:
        sim_lathe_stick_encoder(l);
        l->dither_counts = (uint32_t)inject->value;
        break;
    case sim_inject_index_dead:
        sim_lathe_kill_index(l);
        break;
    case sim_inject_reverse:
        l->is_reversed = true;
        break;
    case sim_inject_spindle_speed:
        force_speed(l, direction * inject->value * (SIM_TWO_PI / 60.0));
        break;
    case sim_inject_spindle_stop:
        force_speed(l, 0.0);
        break;
    case sim_inject_u_block:
        l->drive[hal_axis_u].is_blocked = true;
        break;
    case sim_inject_u_scale_stuck:
        l->stuck_micro = sim_lathe_measured_micro(l, hal_axis_u);
        l->is_scale_stuck = true;
        break;
    case sim_inject_u_reversed:
        l->is_force_reversed = true;
        break;
    case sim_inject_u_push:
        l->push_n = inject->value; // acts from the next sim_lathe_bite() on
        break;
    case sim_inject_swing_block:
        l->drive[sim_lathe_swing].is_blocked = true;
        break;
    default:
        break;
    }
}
