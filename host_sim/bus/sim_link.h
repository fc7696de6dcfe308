// SPDX-License-Identifier: Apache-2.0
/// sim_link: connects the simulated nodes to a CAN interface, simulated GPIO lines and the clock of
/// this computer. Linux only; elsewhere sim_link_open() refuses.
///
/// The nodes send at absolute times of CLOCK_MONOTONIC, once per period, half a period before the
/// next SYNC: the first SYNC seen (or the first after 0.1 s without one) sets the phase. The chip's
/// lines are found by name and driven through the sysfs files of gpio-sim: ESTOP (high: chain
/// closed), READY (high: drives ready) and INDEX (rises at the index, at its exact time) are inputs
/// of the controller; ENABLE, FAULT and INCUT (high: true) are its outputs.
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
    bool is_locked; ///< the phase is locked to the SYNC
    int64_t period_ns, wake_ns;
    int64_t index_ns; ///< time of the next index edge, 0: none
    int64_t drop_ns;  ///< INDEX falls then, 0: already low
    sim_frame_t late; ///< to send at late_ns, 0: none
    int64_t late_ns;
    uint64_t n_unsent; ///< frames that the interface did not accept
} sim_link_t;

/// @return a link that is not open; closing it does nothing
static inline sim_link_t sim_link_closed(void)
{
    return (sim_link_t){.can = -1, .pull = {-1, -1, -1}, .value = {-1, -1, -1}};
}

/// @param interface  CAN interface, which is up
/// @param chip       e.g. gpiochip0, NULL: without lines
/// @param period_s   between two ticks of the controller
/// @return           false and *e when something is missing; then there is nothing to close
bool sim_link_open(sim_link_t *l, const char *interface, const char *chip, double period_s,
                   common_error_t *e);

/// Sleep until the nodes send next, and hand over the frames that arrived.
void sim_link_wait(sim_link_t *l, sim_bus_t *bus);

/// @return the levels of the controller's lines; all false without lines
sim_bus_outputs_t sim_link_read(const sim_link_t *l);

/// After a step: send the nodes' frames and set the lines.
void sim_link_send(sim_link_t *l, sim_bus_t *bus);

/// Close lines and interface. The link may be closed already.
void sim_link_close(sim_link_t *l);

/// Make SIGINT and SIGTERM end the cut with complete outputs.
void sim_link_watch_signals(void);

/// @return true when one of them arrived
bool sim_link_is_stopped(void);

#endif
