// SPDX-License-Identifier: Apache-2.0
/// sim_link: what ties the simulated nodes to this computer: a CAN interface, simulated GPIO
/// lines, the clock. Linux only; elsewhere sim_link_open() says so.
///
/// The nodes speak at absolute times of CLOCK_MONOTONIC, a period apart, half a period before the
/// SYNC that is due next: the first SYNC seen (or the first after 0.1 s without one) sets the
/// phase. Lines of the chip, found by name, moved by the simulator's files in sysfs: ESTOP (high:
/// chain closed), READY (high: drives ready), INDEX (rises at the index, at its exact time) are
/// inputs of the controller; ENABLE, FAULT, INCUT (high: true) are its outputs.
#ifndef SIM_LINK_H
#define SIM_LINK_H

#include "sim_bus.h"      // sim_bus_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t

enum { sim_link_inputs = 3, sim_link_outputs = 3 };

typedef struct {
    int can;
    bool has_lines;
    int pull[sim_link_inputs];   ///< ESTOP, READY, INDEX
    int value[sim_link_outputs]; ///< ENABLE, FAULT, INCUT
    bool is_high[sim_link_inputs];
    bool is_locked; ///< to the SYNC
    int64_t period_ns, wake_ns;
    int64_t index_ns; ///< instant of the index edge to come, 0: none
    int64_t drop_ns;  ///< INDEX falls then, 0: it is low
    sim_frame_t late; ///< to be sent at late_ns, 0: none
    int64_t late_ns;
    uint64_t n_unsent; ///< frames that the interface did not take
} sim_link_t;

/// @return a link that is not open, for which closing does nothing
static inline sim_link_t sim_link_closed(void)
{
    return (sim_link_t){.can = -1, .pull = {-1, -1, -1}, .value = {-1, -1, -1}};
}

/// @param interface  of CAN, up
/// @param chip       e.g. gpiochip0, NULL: without lines
/// @param period_s   between two ticks of the controller
/// @return           false and *e when something is missing; nothing to close then
bool sim_link_open(sim_link_t *l, const char *interface, const char *chip, double period_s,
                   common_error_t *e);

/// Sleep until the nodes' next moment, hand over the frames that came.
void sim_link_wait(sim_link_t *l, sim_bus_t *bus);

/// @return what the lines of the controller say; all false without lines
sim_bus_outputs_t sim_link_read(const sim_link_t *l);

/// After a step: send its frames, move the lines.
void sim_link_speak(sim_link_t *l, sim_bus_t *bus);

/// May be closed already.
void sim_link_close(sim_link_t *l);

/// SIGINT and SIGTERM end the run in good order from now on.
void sim_link_watch_signals(void);

/// @return true when one of them came
bool sim_link_is_stopped(void);

#endif
