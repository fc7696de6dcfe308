// SPDX-License-Identifier: Apache-2.0
/// sim_bus: the nodes of a CANopen bus in front of the lathe: encoder, drives of U, X and Z,
/// spindle. Frames become set-points of the lathe; its positions become frames.
///
/// The controller is another process. It sends set-points and SYNC at every tick; the nodes speak
/// half a period before the tick. One step covers the time from one such moment to the next, in
/// which the lathe makes two steps of half a period:
///
///     nodes speak   tick: SYNC    nodes speak   tick: SYNC
///     ----|------------|-------------|------------|----
///         |--- half ---|--- half ----|
///         |  old target   new target |
///         |<-------- one step ------>|
///
/// Targets are held from SYNC to SYNC (60C2h: no interpolation). sim_node.h describes the frames.
/// Sockets, lines and clock are in sim_link.h.
#ifndef SIM_BUS_H
#define SIM_BUS_H

#include "sim_disturb.h" // sim_disturb_t
#include "sim_frame.h"   // sim_frames_t
#include "sim_inject.h"  // sim_inject_t
#include "sim_lathe.h"   // sim_lathe_t
#include "sim_node.h"    // sim_node_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t, uint64_t

/// Nodes; the axes in the order of hal_axis_t.
typedef enum {
    sim_bus_encoder,
    sim_bus_u,
    sim_bus_x,
    sim_bus_z,
    sim_bus_spindle,
    sim_bus_n_nodes
} sim_bus_node_t;

enum { sim_bus_controller_id = 64 };

typedef struct {
    sim_lathe_config_t lathe;
    double guard_s;                   ///< [s] silence after which a drive stops on its own
    double heartbeat_s;               ///< [s] period of the nodes' heartbeats
    uint32_t encoder_modulus;         ///< [counts] the position wraps at this count; 0: at 2^32
    bool is_foreign[sim_bus_n_nodes]; ///< another process provides this node: only received here
    uint64_t seed;
} sim_bus_config_t;

/// Lines: outputs and inputs of the controller.
typedef struct {
    bool is_enabled, is_fault, is_in_cut;
} sim_bus_outputs_t;

typedef struct {
    bool is_estop; ///< emergency-stop chain open
    bool is_ready; ///< no drive has failed
} sim_bus_inputs_t;

typedef struct {
    sim_bus_config_t config;
    double period_s, time_s; ///< end of the last step
    uint64_t n_steps;
    sim_lathe_t lathe;
    sim_node_t node[sim_bus_n_nodes];
    uint32_t encoder_counts; ///< position in the last frame of the encoder
    bool has_sync;           ///< a SYNC arrived since the last step
    uint64_t n_syncs;
    double sync_s;       ///< of the last SYNC
    sim_sample_t sample; ///< truth at the instant of the last SYNC
    // from the controller's status frame 0x1C0
    bool has_status;
    uint32_t reported_state, reported_faults;
    // injected faults
    sim_disturb_t disturb; ///< of the encoder's frames
    sim_bus_inputs_t inputs;
    bool is_ready_broken;
    // to be sent after the step
    sim_frames_t out;
    double index_s; ///< [s] from now to the index edge, < 0: none within the period
} sim_bus_t;

/// Start with the lathe at rest and the nodes powered on.
/// @param b  43 KB
void sim_bus_init(sim_bus_t *b, const sim_bus_config_t *config, double x_nm, double z_nm);

/// Process a frame from the bus.
void sim_bus_receive(sim_bus_t *b, const sim_frame_t *frame);

/// Advance by one period: the lathe moves, and the nodes queue their frames in `out`.
void sim_bus_step(sim_bus_t *b);

/// Apply an injection to nodes, frames or lathe.
/// @param direction  +1 or -1: sense of cutting
void sim_bus_inject(sim_bus_t *b, const sim_inject_t *inject, int direction);

/// @return true when neither the spindle nor an axis moves
bool sim_bus_is_at_rest(const sim_bus_t *b);

#endif
