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

#include "canopen.h"   // canopen_id_heartbeat, cia402_state_t
#include "hal/hal.h"   // hal_can_frame_t, hal_encoder_t, hal_setpoint_t
#include "lin_setup.h" // lin_encoder_config_t, lin_config_t
#include <stdbool.h>   // bool
#include <stddef.h>    // size_t
#include <stdint.h>    // int32_t, int64_t, uint8_t, uint16_t, uint32_t

// Clamping and rounding division of integers.

static inline int32_t lin_clamp_i32(int64_t value)
{
    return value < INT32_MIN ? INT32_MIN : value > INT32_MAX ? INT32_MAX : (int32_t)value;
}

/// @param b  not 0
/// @return   a / b, rounded to nearest, halves away from 0
static inline int64_t lin_div_round(int64_t a, int64_t b)
{
    const int64_t half = (b < 0 ? -b : b) / 2;
    return (a < 0 ? a - half : a + half) / b;
}

/// @param b  above 0
/// @return   a / b, rounded down
static inline int64_t lin_div_floor(int64_t a, int64_t b)
{
    return a / b - (a % b < 0 ? 1 : 0);
}

// Supervises a bus node by its heartbeat and emergency messages.
// Pure. Source: CiA 301, "Heartbeat", "NMT", "EMCY".

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

// Controller side of the drive state machine: status word in, control word out.
// Pure. Source: CiA 402-2 (IEC 61800-7-201), "Finite state automaton", 6040h, 6041h.

/// Control words (6040h).
enum {
    lin_cia402_disable_voltage = 0x00,
    lin_cia402_quick_stop = cia402_bit_enable_voltage,
    lin_cia402_shutdown = cia402_bit_enable_voltage | cia402_bit_no_quick_stop,
    lin_cia402_switch_on = lin_cia402_shutdown | cia402_bit_switch_on,
    lin_cia402_enable_operation = lin_cia402_switch_on | cia402_bit_enable_operation,
    lin_cia402_fault_reset = cia402_bit_fault_reset,
};

/// Target state of a drive.
typedef enum {
    lin_cia402_rest,    ///< ready to switch on, no torque; a moving drive makes a quick stop first
    lin_cia402_enabled, ///< following its set-point
    lin_cia402_off,     ///< no voltage; a moving drive makes a quick stop first
    lin_cia402_reset,   ///< fault reset if in fault; otherwise as rest
} lin_cia402_goal_t;

/// @param status  6041h
cia402_state_t lin_cia402_state(uint16_t status);

/// @return control word of the next step to the goal. In quick stop active it remains quick stop;
/// the drive leaves that state on its own at standstill.
uint16_t lin_cia402_control(cia402_state_t state, lin_cia402_goal_t goal);

// One CiA 402 drive: process data and state.
//
//     TPDO1  6041h status word u16, measured i32 (6064h position or 606Ch velocity)
//     RPDO1  6040h control word u16, target i32 (607Ah position or 60FFh velocity)
//     RPDO2  60B1h velocity offset i32; with FD it follows the position in RPDO1
//
// Pure. Source: CiA 402-2, 402-3; the mapping is specific to this port (README.md).

/// Timeouts of the configuration.
typedef struct {
    int64_t node_ns, pdo_ns, enable_ns;
} lin_timeouts_t;

typedef struct {
    lin_node_t node;
    int64_t counts, nm; ///< drive units = nm * counts / nm
    bool has_status;
    int64_t status_ns;
    cia402_state_t state;
    int32_t actual; ///< [drive units]
    lin_loss_t loss;
    bool is_ready;         ///< can follow its set-point; false if lost
    bool is_enabled;       ///< commanded
    int64_t enabled_ns;    ///< time of the enable command
    bool has_followed;     ///< has reached operation enabled since then
    int64_t reset_ns;      ///< time of the last fault reset
    int64_t quick_stop_ns; ///< start of quick stop, 0: not active
} lin_drive_t;

/// @param node  0: no drive; it is then always ready and never lost
void lin_drive_init(lin_drive_t *d, int64_t node, int64_t counts, int64_t nm);

/// @return whether the frame is from this drive
bool lin_drive_receive(lin_drive_t *d, const hal_can_frame_t *frame, int64_t ns);

/// Update `loss` and `is_ready`. A drive is ready if it is not lost and has no error, fault or "not
/// ready to switch on"; an enabled drive must also reach operation enabled within enable_ns.
void lin_drive_judge(lin_drive_t *d, int64_t now_ns, const lin_timeouts_t *timeouts);

/// Command the drive to be enabled or disabled.
void lin_drive_enable(lin_drive_t *d, bool is_enabled, int64_t now_ns);

/// Clear reported errors, on the operator's reset.
void lin_drive_forget(lin_drive_t *d);

/// @return the control word of this tick
/// @param may_reset    send a fault reset once a second while the drive is in fault
/// @param is_stopping  remove voltage for good
uint16_t lin_drive_control(lin_drive_t *d, int64_t now_ns, bool may_reset, bool is_stopping);

/// @return [drive units] position or velocity, rounded to nearest, clamped
/// @param nm  [nm] or [nm/s]
int32_t lin_drive_units(const lin_drive_t *d, int64_t nm);

/// @return [nm] measured position, rounded to nearest, clamped
int32_t lin_drive_actual_nm(const lin_drive_t *d);

/// @return [pm] one drive unit, rounded to nearest; 0 without a drive
uint32_t lin_drive_unit_pm(const lin_drive_t *d);

// Turns encoder positions from frames into a counter that can be read at any instant.
//
//     frame   before        last                  tick
//     -----------+------------+---------------------+----> time        counts(tick) =
//             b counts     c counts            extrapolated            c + (c - b) / dt * age
//
// Positions are unwrapped to 64 bits. The index is either an edge on a GPIO line, whose time stamp
// is interpolated between the two adjacent frames, or a fixed value of the position. Pure; not
// thread-safe. Times are ns of one clock.

typedef struct {
    lin_encoder_config_t config;
    int64_t least_ns; ///< least time between two frames for a speed measurement
    bool has_frame;
    uint32_t raw;              ///< last received position
    int64_t counts, ns;        ///< newest position and its time
    int64_t before, before_ns; ///< base of the speed, at least least_ns earlier; initially the same
    int64_t mark, mark_ns;     ///< the next `before`, once it is least_ns old
    int64_t index_counts;
    uint32_t n_index;
    int64_t edge_ns;
    bool is_edge_open; ///< the edge waits for the next frame
} lin_encoder_t;

/// @param tick_hz  [Hz] expected rate of frames
void lin_encoder_init(lin_encoder_t *e, const lin_encoder_config_t *config, int64_t tick_hz);

/// Process a received position.
/// @param raw  below config.modulus_counts; any value if that is 0
/// @param ns   arrival of the frame; delay_ns is subtracted here
void lin_encoder_receive(lin_encoder_t *e, uint32_t raw, int64_t ns);

/// Process an edge of the index line. The index is the edge of the pulse that comes first in
/// positive rotation: rising in positive, falling in negative rotation. Ignored with
/// lin_index_position.
void lin_encoder_edge(lin_encoder_t *e, int64_t ns, bool is_rising);

/// @return the counter at an instant, extrapolated by at most max_age_us
hal_encoder_t lin_encoder_at(const lin_encoder_t *e, int64_t ns);

/// @return whether the newest frame is not older than max_age_us
bool lin_encoder_is_fresh(const lin_encoder_t *e, int64_t ns);

// All nodes of the machine

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

// Text of bus and drive failures. Pure.

enum { lin_line_bytes = 120 }; ///< [bytes] limit of hal_text(), with the terminator

/// Pack a cause into one word, for one atomic store; 0: no failure.
uint32_t lin_cause_pack(lin_cause_t cause);
lin_cause_t lin_cause_unpack(uint32_t word);

/// "bus: node 3 (drive x): no heartbeat", "bus: bus-off", "bus: all nodes are heard".
/// @param line  [size]
void lin_cause_bus_text(lin_cause_t cause, const lin_config_t *config, char *line, size_t size);

/// "drives: node 3 (drive x) is not ready: error code 8611h", "drives: ready".
void lin_cause_drives_text(lin_cause_t cause, const lin_config_t *config, char *line, size_t size);

#endif
