// SPDX-License-Identifier: Apache-2.0
#include "sim_watch.h"
#include "cam_state.h" // cam_state_name
#include "sim_units.h" // SIM_NM_PER_MM
#include <string.h>    // memcpy

/// [s] that the end must last: a controller that only restarts continues sooner.
#define QUIET_S 0.25

/// [s] without SYNC after which the controller counts as lost.
#define LOST_S 0.1

bool sim_watch_open(sim_watch_t *w, const sim_watch_options_t *options, const void *image,
                    size_t size, const char *name, common_error_t *e)
{
    w->options = *options;
    w->link = sim_link_closed();
    sim_session_t *s = &w->session;
    bool is_good = sim_session_open(s, &options->session, image, size, name, e);
    if (is_good && s->table.angle.knots != NULL) {
        is_good =
            common_error(e, "%s: table of a cam, which the bus cannot gauge; use camsim run", name);
    }
    if (is_good && s->table.n_passes > 1u) {
        is_good = common_error(
            e, "%s: table with several passes, which the bus cannot gauge; use camsim run", name);
    }
    if (!is_good || !sim_session_load_design(s, e)) {
        sim_session_close(s);
        return false;
    }
    sim_bus_config_t config = {
        .lathe = options->session.config.lathe,
        .guard_s = options->guard_ms * 1e-3,
        .heartbeat_s = options->heartbeat_ms * 1e-3,
        .encoder_modulus = (uint32_t)options->encoder_modulus,
        .seed = options->session.seed,
    };
    config.lathe.tick_hz = options->tick_hz;
    memcpy(config.is_foreign, options->is_foreign, sizeof config.is_foreign);
    double x_nm;
    double z_nm;
    sim_session_place(s, &x_nm, &z_nm);
    sim_bus_init(&w->bus, &config, x_nm, z_nm);
    w->quiet_s = -1.0;
    w->fault_s = -1.0;
    w->stopped_s = -1.0;
    return true;
}

bool sim_watch_connect(sim_watch_t *w, common_error_t *e)
{
    return sim_link_open(&w->link, w->options.interface, w->options.chip, w->bus.period_s, e);
}

/// Without lines use the controller's status frame.
static sim_bus_outputs_t outputs_of(const sim_watch_t *w)
{
    const sim_bus_t *bus = &w->bus;
    if (w->link.has_lines) {
        return sim_link_read(&w->link);
    }
    return (sim_bus_outputs_t){
        .is_enabled = sim_cia402_is_following(&bus->node[sim_bus_u].power),
        .is_fault = bus->reported_faults != 0u,
        .is_in_cut = bus->has_status && bus->reported_state == cam_state_cutting,
    };
}

static bool is_gone(const sim_watch_t *w)
{
    return w->bus.n_syncs > 0u && w->bus.time_s - w->bus.sync_s > LOST_S;
}

/// @return the end that the cut reaches if nothing else happens
static sim_watch_end_t end_in_sight(const sim_watch_t *w)
{
    const sim_bus_t *bus = &w->bus;
    const bool is_at_rest = sim_bus_is_at_rest(bus);
    if (is_gone(w)) {
        return is_at_rest ? sim_watch_lost : sim_watch_running;
    }
    if (w->outputs.is_fault) {
        return is_at_rest && !w->outputs.is_enabled ? sim_watch_fault : sim_watch_running;
    }
    const bool is_ready = !bus->has_status || bus->reported_state == cam_state_ready;
    const bool is_cut = w->session.cut_at_s >= 0.0 && !w->outputs.is_in_cut && is_ready;
    return is_cut ? sim_watch_done : sim_watch_running;
}

static void note_faults(sim_watch_t *w)
{
    w->faults |= w->bus.reported_faults;
    if (w->outputs.is_fault && w->fault_s < 0.0) {
        w->fault_s = w->bus.sample.t_s;
    }
    const bool is_over = is_gone(w) || w->outputs.is_fault;
    if (is_over && sim_bus_is_at_rest(&w->bus)) {
        w->stopped_s = w->stopped_s < 0.0 ? w->bus.time_s : w->stopped_s;
    } else {
        w->stopped_s = -1.0;
    }
}

static void look_for_end(sim_watch_t *w)
{
    const sim_watch_end_t end = end_in_sight(w);
    if (end != w->quiet_end || w->quiet_s < 0.0) {
        w->quiet_end = end;
        w->quiet_s = w->bus.time_s;
    }
    if (!w->options.is_staying && w->bus.time_s - w->quiet_s >= QUIET_S) {
        w->end = end;
    }
    if (w->bus.time_s > w->session.options.max_s) {
        w->end = sim_watch_timeout;
    }
    if (sim_link_is_stopped()) {
        w->end = sim_watch_stopped;
    }
}

void sim_watch_tick(sim_watch_t *w)
{
    sim_session_t *s = &w->session;
    const sim_inject_t *what;
    sim_link_wait(&w->link, &w->bus);
    w->outputs = outputs_of(w);
    while ((what = sim_session_next_inject(s, w->bus.time_s)) != NULL) {
        sim_bus_inject(&w->bus, what, s->table.direction);
    }
    sim_bus_step(&w->bus);
    sim_link_send(&w->link, &w->bus);
    const double wanted_nm = w->bus.node[sim_bus_u].active.target;
    sim_session_touch(s, &w->bus.sample, w->outputs.is_in_cut, w->bus.sample.u_nm - wanted_nm);
    sim_lathe_bite(&w->bus.lathe, sim_session_depth_mm(s));
    note_faults(w);
    look_for_end(w);
}

void sim_watch_close(sim_watch_t *w)
{
    sim_link_close(&w->link);
    sim_session_close(&w->session);
}

bool sim_watch_is_good(const sim_watch_t *w)
{
    return w->end == sim_watch_stopped ||
           (w->end == sim_watch_done && sim_session_is_within(&w->session));
}

const char *sim_watch_state(const sim_watch_t *w)
{
    return w->bus.has_status && w->bus.reported_state < cam_n_states
               ? cam_state_name((cam_state_t)w->bus.reported_state)
               : "-";
}

const char *sim_watch_end_name(const sim_watch_t *w)
{
    static const char *const name[] = {"running", "done", "fault", "lost", "timeout", "stopped"};
    return name[w->end];
}
