// SPDX-License-Identifier: Apache-2.0
/// sim_node: a CANopen node of the machine: network management, heartbeat, PDOs, emergency.
///
///     NMT       0x000        start, stop, pre-operational, reset (CiA 301, 7.2.8)
///     SYNC      0x080        the contents of the RPDOs take effect
///     EMCY      0x080 + n    error code u16, error register u8, 0 (CiA 301, 7.2.7)
///     TPDO1     0x180 + n    encoder: 6004h position u32; others: 6041h status word u16,
///                            6064h position or 606Ch velocity actual value i32
///     RPDO1     0x200 + n    6040h control word u16, 607Ah target position or 60FFh target
///                            velocity i32; as an FD frame with 60B1h velocity offset i32 appended
///     RPDO2     0x300 + n    60B1h velocity offset i32
///     heartbeat 0x700 + n    state of the node; 0 once after a reset
///
/// PDOs are sent and accepted only in the state operational. A drive in operation fails when RPDO1
/// or SYNC is missing for longer than its guard time: it brakes within its limits, then enters
/// fault. Frames in, frames out; time is an argument.
#ifndef SIM_NODE_H
#define SIM_NODE_H

#include "canopen.h"    // canopen_operational
#include "sim_cia402.h" // sim_cia402_t
#include "sim_frame.h"  // sim_frame_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t

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

#endif
