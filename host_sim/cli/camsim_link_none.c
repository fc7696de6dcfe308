// SPDX-License-Identifier: Apache-2.0
#include "camsim_link.h"

bool camsim_link_open(camsim_link_t *l, const char *interface, const char *chip, double period_s,
                      sim_error_t *e)
{
    (void)l;
    (void)chip;
    (void)period_s;
    return sim_error(e, "--can %.40s: no SocketCAN on this system; run on Linux", interface);
}

void camsim_link_wait(camsim_link_t *l, sim_bus_t *bus)
{
    (void)l;
    (void)bus;
}

sim_bus_outputs_t camsim_link_read(const camsim_link_t *l)
{
    (void)l;
    return (sim_bus_outputs_t){0};
}

void camsim_link_speak(camsim_link_t *l, sim_bus_t *bus)
{
    (void)l;
    (void)bus;
}

void camsim_link_close(camsim_link_t *l)
{
    (void)l;
}

void camsim_link_watch_signals(void) {}

bool camsim_link_is_stopped(void)
{
    return true;
}
