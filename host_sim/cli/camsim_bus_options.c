// SPDX-License-Identifier: Apache-2.0
#include "camsim_bus.h"
#include "common_number.h" // common_number_parse
#include <stdio.h>         // puts
#include <stdlib.h>        // calloc, free
#include <string.h>        // strcmp

static const char help[] =
    "camsim bus TABLE --can IFACE [options]     the machine as nodes on a CAN bus (Linux)\n"
    "\n"
    "  --can IFACE           interface with the controller on it, e.g. vcan0\n"
    "  --gpiochip CHIP       simulated GPIO chip with lines ESTOP READY INDEX ENABLE FAULT INCUT\n"
    "                        (default: none; the controller's status is read from 0x1C0)\n"
    "  --tick-hz N           rate of the controller's ticks (default: 1000)\n"
    "  --guard-ms T          silence after which a drive stops on its own (default: 20)\n"
    "  --heartbeat-ms T      period of the nodes' heartbeats (default: 50)\n"
    "  --encoder-modulus N   position of the encoder wraps at N counts (default: 2^32)\n"
    "  --without NODE        another process provides encoder, u, x, z or spindle; repeatable\n"
    "  --stay                continue after the end of the cut, until SIGINT or SIGTERM\n"
    "\n"
    "as in camsim run: --machine --design --tolerance-um --trace --surface --summary --seed\n"
    "  --max-seconds S       give up after S of machine time (default: 60)\n"
    "  --inject KIND@SECONDS[:VALUE]   repeatable; seconds of cutting, or KIND@tSECONDS since the "
    "start:\n"
    "      estop  drive  lost-counts:N  encoder-jump:N  encoder-stuck  index-dead  reverse\n"
    "      spindle-speed:RPM  spindle-stop  u-block  encoder-late:US  encoder-missing:N\n"
    "      encoder-repeated:N  encoder-swapped:N  heartbeat-lost:NODE  node-dead:NODE  "
    "node-fault:NODE\n"
    "Nodes: encoder 1, u 2, x 3, z 4, spindle 5; the wire is described in "
    "host_sim/bus/sim_node.h.\n"
    "\n"
    "Exit status: 0 done, 1 fault, controller lost, time-out or out of tolerance, 2 wrong usage or "
    "bad input.";

enum { default_max_s = 60 };

void camsim_bus_options_help(void)
{
    (void)puts(help);
}

static bool take_number(double *value, const char *option, const char *text, double min, double max,
                        common_error_t *e)
{
    if (!common_number_parse(text, value) || *value < min || *value > max) {
        return common_error(e, "--%s %.60s: give a number %.12g .. %.12g", option, text, min, max);
    }
    return true;
}

static bool take_value(sim_watch_options_t *o, const char *name, const char *text,
                       common_error_t *e)
{
    static const char *const node[sim_bus_n_nodes] = {"encoder", "u", "x", "z", "spindle"};
    if (strcmp(name, "tick-hz") == 0) {
        return take_number(&o->tick_hz, name, text, 100.0, 4000.0, e);
    }
    if (strcmp(name, "guard-ms") == 0) {
        return take_number(&o->guard_ms, name, text, 1.0, 10000.0, e);
    }
    if (strcmp(name, "heartbeat-ms") == 0) {
        return take_number(&o->heartbeat_ms, name, text, 1.0, 10000.0, e);
    }
    if (strcmp(name, "encoder-modulus") == 0) {
        return take_number(&o->encoder_modulus, name, text, 64.0, 4294967295.0, e) &&
               (o->encoder_modulus == (double)(uint32_t)o->encoder_modulus ||
                common_error(e, "--encoder-modulus %.60s: not whole; give a whole number", text));
    }
    if (strcmp(name, "without") != 0) {
        *(strcmp(name, "can") == 0 ? &o->interface : &o->chip) = text;
        return true;
    }
    for (int i = 0; i < sim_bus_n_nodes; i++) {
        if (strcmp(text, node[i]) == 0) {
            o->is_foreign[i] = true;
            return true;
        }
    }
    return common_error(e, "--without %.60s: no such node; give encoder, u, x, z or spindle", text);
}

/// Parse an option of the bus with its value; the others are options of a run.
/// @return words used; 0: an option of a run; below 0 and *e: wrong usage
static int take_own(sim_watch_options_t *o, int n_left, char **words, common_error_t *e)
{
    static const char *const own[] = {"can",          "gpiochip",        "tick-hz", "guard-ms",
                                      "heartbeat-ms", "encoder-modulus", "without"};
    char name[24] = "";
    if (strncmp(words[0], "--", 2) != 0) {
        return 0;
    }
    if (strcmp(words[0], "--stay") == 0) {
        o->is_staying = true;
        return 1;
    }
    const char *equals = strchr(words[0], '=');
    const size_t length = equals != NULL ? (size_t)(equals - words[0]) - 2u : strlen(words[0]) - 2u;
    if (length >= sizeof name) {
        return 0;
    }
    memcpy(name, words[0] + 2, length);
    bool is_own = false;
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++) {
        is_own = is_own || strcmp(name, own[i]) == 0;
    }
    if (!is_own) {
        return 0;
    }
    if (equals == NULL && n_left < 2) {
        (void)common_error(e, "bus: --%s: value missing; see camsim bus --help", name);
        return -1;
    }
    const char *value = equals != NULL ? equals + 1 : words[1];
    if (!take_value(o, name, value, e)) {
        return -1;
    }
    return equals != NULL ? 1 : 2;
}

/// Refuse options that belong to the controller, which is another process.
static bool check_foreign(const camsim_bus_options_t *o, common_error_t *e)
{
    const sim_cut_options_t *cut = &o->common.cut;
    bool is_clean = cut->rpm == 0.0 && cut->feed_mm == 0.0 && !cut->is_without_feed_forward &&
                    !cut->is_without_lead && cut->max_turns == 0.0 && cut->target == NULL &&
                    cut->slice_s == 0.0 && o->common.out_path[camsim_removal] == NULL &&
                    !cut->has_sections && !o->common.is_progress_shown;
    for (int i = 0; i < cam_n_params; i++) {
        is_clean = is_clean && !cut->wishes.is_given[i];
    }
    return is_clean ||
           common_error(e, "bus: an option of camsim run only (speed, feed, parameters, "
                           "removal, sections, target); set it in the controller");
}

bool camsim_bus_options_read(camsim_bus_options_t *o, int argc, char **argv, common_error_t *e)
{
    *o = (camsim_bus_options_t){
        .watch = {.tick_hz = 1000.0, .guard_ms = 20.0, .heartbeat_ms = 50.0}};
    char **rest = calloc((size_t)argc + 1u, sizeof *rest);
    if (rest == NULL) {
        return common_error(e, "bus: not enough memory; free some");
    }
    int n_rest = 0;
    int taken = 1;
    for (int i = 0; i < argc && taken >= 0; i += taken > 0 ? taken : 1) {
        taken = i > 0 ? take_own(&o->watch, argc - i, argv + i, e) : 0;
        if (taken == 0) {
            rest[n_rest++] = argv[i];
        }
    }
    const bool is_good = taken >= 0 && camsim_options_read(&o->common, n_rest, rest, e);
    free(rest);
    if (!is_good || o->common.is_help) {
        return is_good;
    }
    if (o->watch.interface == NULL) {
        return common_error(e, "bus: no --can; give the CAN interface of the controller");
    }
    o->watch.session = o->common.cut.session;
    if (o->watch.session.max_s == 0.0) {
        o->watch.session.max_s = default_max_s;
    }
    return check_foreign(o, e);
}
