// SPDX-License-Identifier: Apache-2.0
#include "sim_link.h"

bool sim_link_open(sim_link_t *l, const char *interface, const char *chip, double period_s,
                   common_error_t *e)
{
    (void)l;
    (void)chip;
    (void)period_s;
    return common_error(e, "--can %.40s: no SocketCAN on this system; run on Linux", interface);
}

void sim_link_wait(sim_link_t *l, sim_bus_t *bus)
{
    (void)l;
    (void)bus;
}

sim_bus_outputs_t sim_link_read(const sim_link_t *l)
{
    (void)l;
    return (sim_bus_outputs_t){0};
}

void sim_link_send(sim_link_t *l, sim_bus_t *bus)
{
    (void)l;
    (void)bus;
}

void sim_link_close(sim_link_t *l)
{
    (void)l;
}

void sim_link_watch_signals(void) {}

bool sim_link_is_stopped(void)
{
    return true;
}
