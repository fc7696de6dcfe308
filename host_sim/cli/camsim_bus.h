// SPDX-License-Identifier: Apache-2.0
/// camsim_bus: the options of `camsim bus`.
#ifndef CAMSIM_BUS_H
#define CAMSIM_BUS_H

#include "camsim.h"    // camsim_options_t
#include "sim_watch.h" // sim_watch_options_t

typedef struct {
    camsim_options_t common; ///< those shared with camsim run
    sim_watch_options_t watch;
} camsim_bus_options_t;

/// @return false and *e when something is wrong
bool camsim_bus_options_read(camsim_bus_options_t *o, int argc, char **argv, common_error_t *e);
void camsim_bus_options_help(void);

#endif
