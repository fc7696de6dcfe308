// SPDX-License-Identifier: Apache-2.0
#include "sim_live.h"
#include <string.h> // memset

bool sim_live_open(sim_live_t *l, const sim_live_options_t *options, const void *image, size_t size,
                   const char *name, common_error_t *e)
{
    memset(l, 0, sizeof *l);
    l->options = *options;
    l->n_image = size;
    sim_session_t *s = &l->session;
    const sim_session_options_t *o = &options->cut.session;
    const double tick_hz = o->config.lathe.tick_hz;
    double x_nm;
    double z_nm;
    if (!sim_session_open(s, o, image, size, name, e) || !sim_session_load_design(s, e)) {
        sim_session_close(s);
        return false;
    }
    sim_session_place(s, &x_nm, &z_nm);
    sim_port_init(&l->port, &o->config.lathe, x_nm, z_nm, o->seed);
    if (!sim_wire_open(&l->wire, options->wire, (uint32_t)tick_hz, e)) {
        sim_session_close(s);
        return false;
    }
    sim_pace_init(&l->pace, tick_hz, options->speed_up);
    return true;
}

void sim_live_close(sim_live_t *l)
{
    sim_session_close(&l->session);
}
