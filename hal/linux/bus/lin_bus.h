// SPDX-License-Identifier: Apache-2.0
/// lin_bus: all nodes of the machine as one: frames in, readings and frames out.
///
///     received frames -> lin_bus_take()          while a tick begins
///     lin_bus_judge() -> inputs, readings        what cam_isr() senses
///     set-points -> lin_bus_make() -> frames     what the tick sends, SYNC at the end
///
/// There is one controller on a bus. A new one first listens for node_timeout_ms and sends nothing;
/// it begins when no other controller was heard in that time. A controller that works and hears
/// another goes on until its drives are disabled, then it listens, too.
///
/// Pure; the tick's thread only. Times are ns of one clock.
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

/// What is wrong, and with which node.
typedef struct {
    lin_loss_t loss;
    uint32_t node;   ///< 0: the bus itself
    uint16_t detail; ///< error code of an emergency message
} lin_cause_t;

/// What the firmware commands.
typedef struct {
    hal_setpoint_t axis[hal_n_axes];
    int32_t spindle_mrpm;
    uint32_t outputs; ///< hal_out_*
    bool is_stopping; ///< the program ends: the drives go to the state without voltage
} lin_wants_t;

typedef struct {
    lin_config_t config;
    lin_patience_t patience;
    lin_node_t encoder_node;
    lin_encoder_t encoder;
    lin_drive_t drive[lin_bus_n_drives];
    lin_loss_t link;  ///< lin_bus_link()
    lin_loss_t event; ///< lin_bus_event(), until the next judgement
    bool is_other_heard;
    int64_t other_ns;   ///< time at which another controller was heard
    bool is_twin_heard; ///< ... with the node number of this one
    bool is_begun;      ///< lin_bus_make() was called
    int64_t begin_ns;   ///< time of its first call
    bool is_silent;     ///< it listens: nothing is sent
    int64_t silent_ns;  ///< since when, or when another controller was heard last
    bool has_twin;      ///< it listens, and another node has its number or may have it: nothing may
                        ///< be sent under that number
    lin_cause_t cause;  ///< of the input hal_in_bus_lost; kept with it
    lin_cause_t not_ready; ///< first drive that is not ready: node, error code
    uint32_t inputs;       ///< hal_in_drive_ready, hal_in_bus_lost
    uint32_t outputs;      ///< commanded last
    int64_t heartbeat_ns;  ///< the own heartbeat was sent last
    bool is_started;
} lin_bus_t;

void lin_bus_init(lin_bus_t *b, const lin_config_t *config);

/// @param ids  [lin_bus_max_ids] of frames that lin_bus_take() wants
/// @return     their number
uint32_t lin_bus_ids(const lin_bus_t *b, uint32_t *ids);

/// Take a frame that arrived; frames of unknown nodes are ignored.
void lin_bus_take(lin_bus_t *b, const hal_can_frame_t *frame, int64_t ns);

/// Set the state of the interface from now on: lin_loss_none, bus_off or interface_down.
void lin_bus_link(lin_bus_t *b, lin_loss_t link);

/// Note an event that happened once: lin_loss_overflow or lin_loss_send.
void lin_bus_event(lin_bus_t *b, lin_loss_t event);

/// Make `inputs` and `cause`. hal_in_bus_lost stays while the fault output is high.
void lin_bus_judge(lin_bus_t *b, int64_t now_ns);

/// @return [nm] measured position; the last set-point of an axis without a drive
int32_t lin_bus_actual_nm(const lin_bus_t *b, hal_axis_t axis, const lin_wants_t *wants);

/// Make the frames of this tick, in the order in which they are to be sent.
/// @param frames  [lin_bus_max_frames]
/// @return        their number, 0 while it listens
uint32_t lin_bus_make(lin_bus_t *b, const lin_wants_t *wants, int64_t now_ns,
                      hal_can_frame_t *frames);

/// @return whether no drive of this controller is in operation: nothing moves by its set-points
bool lin_bus_is_at_rest(const lin_bus_t *b);

#endif
