// SPDX-License-Identifier: Apache-2.0
/// sim_watch: a whole cut on a CAN bus. The lathe consists of nodes, the controller is another
/// process; its work is watched, not commanded.
///
///     open -> connect -> tick, tick, ... until end is not sim_watch_running -> close
///
/// A tick is one period of the controller in real time.
#ifndef SIM_WATCH_H
#define SIM_WATCH_H

#include "sim_bus.h"     // sim_bus_t
#include "sim_link.h"    // sim_link_t
#include "sim_session.h" // sim_session_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t

typedef struct {
    sim_session_options_t session;
    const char *interface, *chip; ///< arguments of sim_link_open()
    double tick_hz;               ///< rate of the controller
    double guard_ms, heartbeat_ms;
    double encoder_modulus; ///< [counts]
    bool is_foreign[sim_bus_n_nodes];
    bool is_staying; ///< the nodes continue after the cut until a signal
} sim_watch_options_t;

/// How the cut ended.
typedef enum {
    sim_watch_running,
    sim_watch_done,    ///< cut done, the controller is ready again
    sim_watch_fault,   ///< fault, enable low, all at rest
    sim_watch_lost,    ///< the controller is lost, all at rest
    sim_watch_timeout, ///< max_s has passed
    sim_watch_stopped, ///< by a signal
} sim_watch_end_t;

typedef struct {
    sim_watch_options_t options; ///< those of the session are in force there
    sim_session_t session;
    sim_bus_t bus;
    sim_link_t link;
    sim_bus_outputs_t outputs;
    sim_watch_end_t end;
    double quiet_s; ///< start of the end's conditions; below 0: not met
    sim_watch_end_t quiet_end;
    double fault_s;   ///< time of the first fault, below 0: none
    double stopped_s; ///< start of rest after the last SYNC or fault; below 0: none
    uint32_t faults;  ///< all faults reported by the controller
} sim_watch_t;

/// @param w      16 MB, zero-initialised
/// @param image  image of a table; copied
/// @param name   name of the table file, for messages
/// @return       false and *e when the input is bad; then nothing to close
bool sim_watch_open(sim_watch_t *w, const sim_watch_options_t *options, const void *image,
                    size_t size, const char *name, common_error_t *e);

/// Connect the nodes to the bus. @return false and *e when it is missing
bool sim_watch_connect(sim_watch_t *w, common_error_t *e);

/// Run one period: wait for its end, move, send, gauge. The last one sets w->end.
void sim_watch_tick(sim_watch_t *w);

void sim_watch_close(sim_watch_t *w);

/// @return true when the cut ended well and within the tolerance, or a signal ended it
bool sim_watch_is_good(const sim_watch_t *w);

/// @return state last reported by the controller, "-" before
const char *sim_watch_state(const sim_watch_t *w);

/// @return "running", "done", "fault", "lost", "timeout" or "stopped"
const char *sim_watch_end_name(const sim_watch_t *w);

#endif
