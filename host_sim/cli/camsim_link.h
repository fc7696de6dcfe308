// SPDX-License-Identifier: Apache-2.0
/// camsim_link: what ties the simulated nodes to this computer: a CAN interface, simulated GPIO
/// lines, the clock. Linux only; elsewhere camsim_link_open() says so.
///
/// The nodes speak at absolute times of CLOCK_MONOTONIC, a period apart, half a period before the
/// SYNC that is due next: the first SYNC seen (or the first after 0.1 s without one) sets the
/// phase. Lines of the chip, found by name, moved by the simulator's files in sysfs: ESTOP (high:
/// chain closed), READY (high: drives ready), INDEX (rises at the index, at its exact time) are
/// told to the controller; ENABLE, FAULT, INCUT (high: true) are what it tells.
#ifndef CAMSIM_LINK_H
#define CAMSIM_LINK_H

#include "sim_bus.h"   // sim_bus_t
#include "sim_error.h" // sim_error_t
#include <stdbool.h>   // bool
#include <stdint.h>    // int64_t

enum { camsim_link_inputs = 3, camsim_link_outputs = 3 };

typedef struct {
    int can;
    bool has_lines;
    int pull[camsim_link_inputs];   ///< ESTOP, READY, INDEX
    int value[camsim_link_outputs]; ///< ENABLE, FAULT, INCUT
    bool is_high[camsim_link_inputs];
    bool is_locked; ///< to the SYNC
    int64_t period_ns, wake_ns;
    int64_t index_ns; ///< instant of the index edge to come, 0: none
    int64_t drop_ns;  ///< INDEX falls then, 0: it is low
    sim_frame_t late; ///< to be sent at late_ns, 0: none
    int64_t late_ns;
    uint64_t n_unsent; ///< frames that the interface did not take
} camsim_link_t;

/// @param interface  of CAN, up
/// @param chip       e.g. gpiochip0, NULL: without lines
/// @param period_s   between two ticks of the controller
/// @return           false and *e when something is missing; nothing to close then
bool camsim_link_open(camsim_link_t *l, const char *interface, const char *chip, double period_s,
                      sim_error_t *e);

/// Sleep until the nodes' next moment, hand over the frames that came.
void camsim_link_wait(camsim_link_t *l, sim_bus_t *bus);

/// @return what the lines of the controller say; all false without lines
sim_bus_outputs_t camsim_link_read(const camsim_link_t *l);

/// After a step: send its frames, move the lines.
void camsim_link_speak(camsim_link_t *l, sim_bus_t *bus);

void camsim_link_close(camsim_link_t *l);

/// SIGINT and SIGTERM end the run in good order from now on.
void camsim_link_watch_signals(void);

/// @return true when one of them came
bool camsim_link_is_stopped(void);

#endif
