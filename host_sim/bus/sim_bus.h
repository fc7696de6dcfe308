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
/// Targets are held from SYNC to SYNC (60C2h: no interpolation). The frames are described with the
/// node. Sockets, lines and clock are in sim_link.h.
#ifndef SIM_BUS_H
#define SIM_BUS_H

#include "canopen.h"    // canopen_operational, cia402_state_t
#include "sim_inject.h" // sim_inject_t
#include "sim_lathe.h"  // sim_lathe_t
#include <stdbool.h>    // bool
#include <stdint.h>     // uint8_t, uint32_t, int32_t, uint64_t

// A CAN frame and a queue of frames, for the simulated nodes.
//
// Numbers are little-endian two's complement; canopen.h reads them.

enum { sim_frame_max_bytes = 64, sim_frame_queue = 32 };

/// A classic (n <= 8) or FD frame with an 11-bit identifier.
typedef struct {
    uint32_t id;
    uint32_t n; ///< [bytes]
    uint8_t data[sim_frame_max_bytes];
} sim_frame_t;

/// Frames to send, the oldest first.
typedef struct {
    sim_frame_t frame[sim_frame_queue];
    uint32_t n;
} sim_frames_t;

/// Append a number of 1, 2 or 4 bytes.
static inline void sim_frame_put(sim_frame_t *f, uint32_t value, uint32_t n_bytes)
{
    for (uint32_t i = 0; i < n_bytes; i++) {
        f->data[f->n] = (uint8_t)(value >> (8u * i) & 0xFFu);
        f->n++;
    }
}

/// @return an empty frame at the end of the queue; the last one again when the queue is full
static inline sim_frame_t *sim_frames_add(sim_frames_t *q, uint32_t id)
{
    const uint32_t i = q->n < sim_frame_queue ? q->n++ : sim_frame_queue - 1u;
    q->frame[i] = (sim_frame_t){.id = id};
    return &q->frame[i];
}

// The power state machine of a drive, CiA 402-2, "Finite state automaton".
//
//     not ready -1-> switch on disabled -2-> ready to switch on -3-> switched on -4-> operation
//     enabled any -13-> fault reaction active -14 at rest-> fault -15 reset-> switch on disabled
//     operation enabled -11-> quick stop active -12 at rest-> switch on disabled
//
// and the transitions back: 5 (disable operation), 6 and 8 (shutdown), 7, 9, 10 and 12 (disable
// voltage; 7 and 10 by quick stop too), 16 (operation again out of a quick stop). A control word
// takes one step; the master repeats it until the status word follows. Numbers are those of the
// standard's figure.

typedef struct {
    cia402_state_t state;
    bool is_reset_held; ///< bit 7 of the last control word: only a rising edge resets
} sim_cia402_t;

/// Switch the power on.
void sim_cia402_init(sim_cia402_t *d);

/// End the self-test: transition 1.
void sim_cia402_boot(sim_cia402_t *d);

/// Process a control word (6040h).
void sim_cia402_control(sim_cia402_t *d, uint32_t control_word);

/// The drive fails: transition 13. It brakes, then enters fault.
void sim_cia402_fail(sim_cia402_t *d);

/// The axis has come to rest: transitions 12 and 14.
void sim_cia402_rest(sim_cia402_t *d);

/// @return object 6041h: the state, voltage enabled (bit 4), remote (bit 9), and in operation
/// enabled "follows the command value" (bit 12)
uint32_t sim_cia402_status(const sim_cia402_t *d);

/// @return true when the axis follows its target
static inline bool sim_cia402_is_following(const sim_cia402_t *d)
{
    return d->state == cia402_operation_enabled;
}

/// @return true in fault and in the fault reaction before it
static inline bool sim_cia402_is_failed(const sim_cia402_t *d)
{
    return d->state == cia402_fault_reaction_active || d->state == cia402_fault;
}

// A CANopen node of the machine: network management, heartbeat, PDOs, emergency.
//
//     NMT       0x000        start, stop, pre-operational, reset (CiA 301, 7.2.8)
//     SYNC      0x080        the contents of the RPDOs take effect
//     EMCY      0x080 + n    error code u16, error register u8, 0 (CiA 301, 7.2.7)
//     TPDO1     0x180 + n    encoder: 6004h position u32; others: 6041h status word u16,
//                            6064h position or 606Ch velocity actual value i32
//     RPDO1     0x200 + n    6040h control word u16, 607Ah target position or 60FFh target
//                            velocity i32; as an FD frame with 60B1h velocity offset i32 appended
//     RPDO2     0x300 + n    60B1h velocity offset i32
//     heartbeat 0x700 + n    state of the node; 0 once after a reset
//
// PDOs are sent and accepted only in the state operational. A drive in operation fails when RPDO1
// or SYNC is missing for longer than its guard time: it brakes within its limits, then enters
// fault. Frames in, frames out; time is an argument.

/// Emergency error codes.
enum {
    sim_emcy_none = 0x0000,
    sim_emcy_internal = 0x5000, ///< device hardware
    sim_emcy_pdo_length = 0x8210,
    sim_emcy_rpdo_timeout = 0x8250,
    sim_emcy_sync_lost = 0x8700,
};

/// A master's command to a drive.
typedef struct {
    uint32_t control_word;
    int32_t target;          ///< 607Ah or 60FFh
    int32_t velocity_offset; ///< 60B1h
} sim_wish_t;

typedef struct {
    uint32_t id; ///< 1 .. 127
    bool is_drive;
    bool is_dead;             ///< neither receives nor sends
    bool is_heartbeat_broken; ///< sends no heartbeat but works otherwise
    uint32_t nmt;
    bool has_booted;
    double heartbeat_s, heartbeat_due_s;
    sim_cia402_t power; ///< drives only
    sim_wish_t heard;   ///< from the last RPDOs
    sim_wish_t active;  ///< in force since the last SYNC
    bool has_rpdo;      ///< RPDO1 arrived since the last SYNC
    double rpdo_s, sync_s;
    uint32_t emcy; ///< error code to send
} sim_node_t;

/// @param id           of the node
/// @param is_drive     false: it only sends
/// @param heartbeat_s  [s] period
void sim_node_init(sim_node_t *n, uint32_t id, bool is_drive, double heartbeat_s);

/// Process a frame other than SYNC.
/// @param t_s  [s] now
void sim_node_receive(sim_node_t *n, const sim_frame_t *frame, double t_s);

/// Process a SYNC: target and control word of the RPDOs take effect.
void sim_node_sync(sim_node_t *n, double t_s);

/// Fail a drive whose master is silent. @param guard_s  [s] longest silence
void sim_node_guard(sim_node_t *n, double t_s, double guard_s);

/// Fail the drive.
void sim_node_fail(sim_node_t *n, uint32_t emcy);

/// Queue the frames due now.
/// @param actual  position or velocity, two's complement
void sim_node_send(sim_node_t *n, sim_frames_t *out, uint32_t actual, double t_s);

// Disturbs the frames of one identifier, like a bad bus.
//
//     sent      a b c d e f g
//     missing   a b     e f g    2 at c        the frame is not sent
//     repeated  a b b b e f g    2 at c        the last one again instead
//     swapped   a b d c e f g    1 at c        after its successor
//     late      a b  c d e f g   at c          once, by a time
//
// Only one disturbance is active: a new one replaces the rest of the old one.

typedef enum {
    sim_disturb_none,
    sim_disturb_missing,
    sim_disturb_repeated,
    sim_disturb_swapped,
    sim_disturb_late
} sim_disturb_kind_t;

typedef struct {
    sim_disturb_kind_t kind;
    uint32_t n_left;  ///< frames still to be disturbed
    double late_s;    ///< [s] delay of a late frame
    sim_frame_t last; ///< the last frame sent
    bool has_last;
    sim_frame_t held; ///< waits for its time or for its successor
    bool is_held;
    double held_until_s;
} sim_disturb_t;

/// Start with the next frame.
/// @param n       frames; swapped: pairs
/// @param late_s  [s] sim_disturb_late only
void sim_disturb_begin(sim_disturb_t *d, sim_disturb_kind_t kind, uint32_t n, double late_s);

/// Disturb the frame in the queue that has the identifier.
/// @param t_s  [s] now
void sim_disturb_pass(sim_disturb_t *d, sim_frames_t *queue, uint32_t id, double t_s);

/// Take the late frame if it is due before a time. @return false when there is none
bool sim_disturb_due(sim_disturb_t *d, double before_s, sim_frame_t *frame, double *at_s);

// The bus

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
