// SPDX-License-Identifier: Apache-2.0
#include "camsim_bus.h"
#include <string.h> // strcmp

#define AT(member) offsetof(camsim_bus_options_t, watch.member)

enum { default_max_s = 60 };

static bool take_without(void *options, const char *text, common_error_t *e)
{
    static const char *const node[sim_bus_n_nodes] = {"encoder", "u", "x", "z", "spindle"};
    camsim_bus_options_t *o = options;
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        if (strcmp(text, node[i]) == 0) {
            o->watch.is_foreign[i] = true;
            return true;
        }
    }
    return common_error(e, "--without %.60s: no such node; give encoder, u, x, z or spindle", text);
}

static const camsim_option_t own[] = {
    CAMSIM_TEXT("can", "IFACE", AT(interface), "interface with the controller on it, e.g. vcan0"),
    CAMSIM_TEXT("gpiochip", "CHIP", AT(chip),
                "simulated GPIO chip with lines ESTOP READY INDEX ENABLE FAULT INCUT (default: "
                "none; the controller's status is read from 0x1C0)"),
    CAMSIM_NUMBER("tick-hz", "N", AT(tick_hz), 100.0, 4000.0, "ticks per second",
                  "rate of the controller's ticks (default: 1000)"),
    CAMSIM_NUMBER("guard-ms", "T", AT(guard_ms), 1.0, 10000.0, "milliseconds",
                  "silence after which a drive stops on its own (default: 20)"),
    CAMSIM_NUMBER("heartbeat-ms", "T", AT(heartbeat_ms), 1.0, 10000.0, "milliseconds",
                  "period of the nodes' heartbeats (default: 50)"),
    CAMSIM_WHOLE("encoder-modulus", "N", AT(encoder_modulus), 64.0, 4294967295.0,
                 "position of the encoder wraps at N counts (default: 2^32)"),
    CAMSIM_TAKEN("without", "NODE", take_without,
                 "another process provides encoder, u, x, z or spindle; repeatable"),
    CAMSIM_SWITCH("stay", AT(is_staying),
                  "continue after the end of the cut, until SIGINT or SIGTERM"),
};

static const char help[] =
    "The machine as nodes on a CAN bus (Linux).\v"
    "As in camsim run: --machine --design --tolerance-um --trace --surface\n"
    "--summary --seed --max-seconds (default: 60) --inject KIND@SECONDS[:VALUE];\n"
    "--inject is repeatable; seconds of cutting, or KIND@tSECONDS since the start:\n"
    "  estop  drive  lost-counts:N  encoder-jump:N  encoder-stuck  index-dead\n"
    "  encoder-rate:PERCENT  encoder-dither:N\n"
    "  reverse  spindle-speed:RPM  spindle-stop  u-block  encoder-late:US\n"
    "  encoder-missing:N  encoder-repeated:N  encoder-swapped:N\n"
    "  heartbeat-lost:NODE  node-dead:NODE  node-fault:NODE\n"
    "Nodes: encoder 1, u 2, x 3, z 4, spindle 5; the wire is described in\n"
    "host_sim/bus/sim_bus.h.\n"
    "\n"
    "Exit status: 0 done, 1 fault, controller lost, time-out or out of tolerance, 2 wrong usage or "
    "bad input.";

void camsim_bus_options_help(void)
{
    const camsim_set_t set = {own, sizeof own / sizeof own[0], NULL};
    camsim_help("camsim bus", "TABLE --can IFACE", help, set);
}

/// Refuse options that belong to the controller, which is another process.
static bool check_foreign(const camsim_bus_options_t *o, common_error_t *e)
{
    const sim_cut_options_t *cut = &o->common.cut;
    bool is_clean = cut->rpm == 0.0 && cut->feed_mm == 0.0 && !cut->is_without_feed_forward &&
                    !cut->is_without_lead && !cut->is_without_learning && cut->max_turns == 0.0 &&
                    cut->slice_s == 0.0 && o->common.out_path[sim_table_removal] == NULL &&
                    o->common.out_path[sim_table_scallop] == NULL && !cut->has_sections &&
                    !o->common.is_progress_shown;
    for (int i = 0; i < cam_n_params; i++) {
        is_clean = is_clean && !cut->wishes.is_given[i];
    }
    return is_clean ||
           common_error(e, "bus: an option of camsim run only (speed, feed, parameters, "
                           "removal, scallop, sections); set it in the controller");
}

bool camsim_bus_options_read(camsim_bus_options_t *o, int argc, char **argv, common_error_t *e)
{
    *o = (camsim_bus_options_t){
        .watch = {.tick_hz = 1000.0, .guard_ms = 20.0, .heartbeat_ms = 50.0}};
    const camsim_set_t set = {own, sizeof own / sizeof own[0], o};
    if (!camsim_options_read_with(&o->common, set, argc, argv, e)) {
        return false;
    }
    if (o->common.is_help) {
        return true;
    }
    if (o->watch.interface == NULL) {
        return common_error(e, "bus: no --can; give the CAN interface of the controller");
    }
    o->watch.session = o->common.cut.session;
    if (o->watch.session.config.lathe.drive[hal_axis_u].kind == sim_drive_force) {
        return common_error(e,
                            "bus: %s: the drives on the bus take positions; give a machine with "
                            "[u] kind = \"position\"",
                            o->common.machine_path);
    }
    if (o->watch.session.max_s == 0.0) {
        o->watch.session.max_s = default_max_s;
    }
    return check_foreign(o, e);
}
