// SPDX-License-Identifier: Apache-2.0
/// lin_node: supervises a bus node by its heartbeat and emergency messages.
/// Pure. Source: CiA 301, "Heartbeat", "NMT", "EMCY".
#ifndef LIN_NODE_H
#define LIN_NODE_H

#include "canopen.h" // canopen_id_heartbeat
#include "hal/hal.h" // hal_can_frame_t
#include <stdbool.h> // bool
#include <stdint.h>  // int64_t, uint8_t, uint16_t, uint32_t

/// Failure of the bus or a node, highest priority first.
typedef enum {
    lin_loss_none,
    lin_loss_bus_off,
    lin_loss_interface_down,
    lin_loss_overflow,         ///< the kernel dropped received frames
    lin_loss_send,             ///< a frame could not be queued
    lin_loss_other_controller, ///< another node sends frames reserved for the controller
    lin_loss_listening,        ///< not yet known whether there is another controller
    lin_loss_heartbeat,
    lin_loss_restarted, ///< the node rebooted
    lin_loss_not_operational,
    lin_loss_pdo,     ///< measured values are missing
    lin_loss_emcy,    ///< the encoder or spindle reports an error
    lin_loss_spindle, ///< the spindle drive does not follow
} lin_loss_t;

/// @return one English clause, static
const char *lin_loss_text(lin_loss_t loss);

typedef struct {
    uint32_t id; ///< 0: no node
    bool is_heard;
    int64_t heard_ns;
    uint8_t nmt;
    uint16_t emcy;     ///< error code, 0: none
    bool is_restarted; ///< since the last lin_node_judge()
    int64_t start_ns;  ///< NMT start was last sent
} lin_node_t;

/// @return whether the frame is this node's heartbeat or emergency message
bool lin_node_receive(lin_node_t *n, const hal_can_frame_t *frame, int64_t ns);

/// @return lin_loss_none, heartbeat, restarted or not_operational
lin_loss_t lin_node_judge(lin_node_t *n, int64_t now_ns, int64_t timeout_ns);

/// Make an NMT start, ten times a second while the node is alive but not operational.
/// @return whether to send *frame
bool lin_node_start(lin_node_t *n, int64_t now_ns, hal_can_frame_t *frame);

#endif
