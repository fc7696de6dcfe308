// SPDX-License-Identifier: Apache-2.0
/// lin_bus: all bus nodes of the machine.
///
///     received frames -> lin_bus_receive()       at the start of a tick
///     lin_bus_judge() -> inputs, readings        read by cam_isr()
///     set-points -> lin_bus_make() -> frames     sent at the end of the tick, SYNC last
///
/// A bus has one controller. At its start a controller listens for node_timeout_ms without sending,
/// and starts only if it heard no other one. A running controller that hears another continues
/// until its drives are disabled, then listens.
///
/// No system calls; used by the tick's thread only. Times are ns of one clock.
#ifndef LIN_BUS_H
#define LIN_BUS_H

#include "hal/hal.h"     // hal_setpoint_t, hal_can_frame_t
#include "lin_config.h"  // lin_config_t
#include "lin_drive.h"   // lin_drive_t
#include "lin_encoder.h" // lin_encoder_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int64_t, uint32_t

enum { lin_bus_spindle = hal_n_axes, lin_bus_n_drives }; ///< drives: the axes, then the spindle
enum { lin_bus_max_frames = 24, lin_bus_max_ids = 32 };

/// Cause of a loss.
typedef struct {
    lin_loss_t loss;
    uint32_t node;   ///< 0: the bus itself
    uint16_t detail; ///< error code of the emergency message
} lin_cause_t;

/// Commands of the firmware.
typedef struct {
    hal_setpoint_t axis[hal_n_axes];
    int32_t spindle_mrpm;
    uint32_t outputs; ///< hal_out_*
    bool is_stopping; ///< the program ends: remove voltage from the drives
} lin_commands_t;

typedef struct {
    lin_config_t config;
    lin_timeouts_t timeouts;
    lin_node_t encoder_node;
    lin_encoder_t encoder;
    lin_drive_t drive[lin_bus_n_drives];
    lin_loss_t link;  ///< lin_bus_link()
    lin_loss_t event; ///< lin_bus_event(), until the next lin_bus_judge()
    bool is_other_heard;
    int64_t other_ns;        ///< another controller was last heard
    bool is_duplicate_heard; ///< ... with the node number of this controller
    bool is_begun;           ///< lin_bus_make() was called
    int64_t begin_ns;        ///< its first call
    bool is_silent;          ///< listening: nothing is sent
    int64_t silent_ns;       ///< start of listening, or another controller was last heard
    bool has_duplicate;    ///< listening, and another node has or may have this node number: do not
                           ///< send with it
    lin_cause_t cause;     ///< of hal_in_bus_lost; latched with it
    lin_cause_t not_ready; ///< first drive that is not ready: node, error code
    uint32_t inputs;       ///< hal_in_drive_ready, hal_in_bus_lost
    uint32_t outputs;      ///< last command
    int64_t heartbeat_ns;  ///< own heartbeat was last sent
    bool is_started;
} lin_bus_t;

void lin_bus_init(lin_bus_t *b, const lin_config_t *config);

/// @param ids  [lin_bus_max_ids] result: frames for lin_bus_receive()
/// @return     their number
uint32_t lin_bus_ids(const lin_bus_t *b, uint32_t *ids);

/// Process a received frame; frames of unknown nodes are ignored.
void lin_bus_receive(lin_bus_t *b, const hal_can_frame_t *frame, int64_t ns);

/// Set the state of the interface: lin_loss_none, bus_off or interface_down.
void lin_bus_link(lin_bus_t *b, lin_loss_t link);

/// Report a single event: lin_loss_overflow or lin_loss_send.
void lin_bus_event(lin_bus_t *b, lin_loss_t event);

/// Update `inputs` and `cause`. hal_in_bus_lost stays set while the fault output is high.
void lin_bus_judge(lin_bus_t *b, int64_t now_ns);

/// @return [nm] measured position; without a drive the last set-point
int32_t lin_bus_actual_nm(const lin_bus_t *b, hal_axis_t axis, const lin_commands_t *commands);

/// Make the frames of this tick, in sending order.
/// @param frames  [lin_bus_max_frames] result
/// @return        their number, 0 while listening
uint32_t lin_bus_make(lin_bus_t *b, const lin_commands_t *commands, int64_t now_ns,
                      hal_can_frame_t *frames);

/// @return whether no drive of this controller follows set-points
bool lin_bus_is_at_rest(const lin_bus_t *b);

#endif
