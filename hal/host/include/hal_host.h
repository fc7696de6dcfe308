// SPDX-License-Identifier: Apache-2.0
/// hal_host: the simulator's port. Tests and machine models set the inputs of the firmware, read
/// its outputs and inject faults.
///
/// Time is virtual: hal_host_tick() advances it by one period and calls cam_isr(). A machine model
/// sets `in` before each tick and reads `out` after it. Not thread-safe.
#ifndef HAL_HOST_H
#define HAL_HOST_H

#include "hal/hal.h" // hal_encoder_t, hal_setpoint_t
#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

enum { hal_host_can_frames = 16 };       ///< depth of the queues, a power of two
enum { hal_host_place_bytes = 1 << 20 }; ///< [bytes] of a table slot
#ifdef __arm__                           // unit tests on an emulated board with 4 MiB of RAM
enum { hal_host_scope_words = 1 << 16 }; ///< memory for the recorder
#else
enum { hal_host_scope_words = 1 << 18 }; ///< memory for the recorder: 1 MiB
#endif
enum { hal_host_lines = 8 }; ///< stored lines of text, a power of two
enum {
    hal_host_line_bytes = 128
}; ///< [bytes] above the limit of hal_text(), so that tests detect longer lines
enum { hal_host_clock_hz = 200000000 }; ///< [Hz] rate of the virtual time stamp: 5 ns

/// The machine's side of the port.
typedef struct {
    struct {
        hal_encoder_t encoder; ///< true reading, without faults
        hal_encoder_t read;    ///< reading of the interrupt, with faults, updated at each advance
        int32_t axis_nm[hal_n_axes]; ///< [nm] measured positions
        int32_t swing_q32;           ///< [turn / 2^32] measured swing
        uint32_t inputs;             ///< hal_in_*
    } in;
    struct {
        hal_setpoint_t axis[hal_n_axes];
        int32_t force_q6;     ///< [mN / 64] of U
        int32_t spindle_mrpm; ///< [r/min / 1000] signed
        uint32_t outputs;     ///< hal_out_*
        hal_swing_t swing;
        uint32_t n_swing; ///< number of set-points of the swing so far
    } out;
    struct {                   ///< injected faults of the encoder
        uint32_t count_offset; ///< [counts] added to the counter and the index latch
        bool is_encoder_stuck; ///< the counter is frozen at stuck_counts
        uint32_t stuck_counts;
        bool is_index_dead;       ///< no further index edges
        hal_encoder_t last_index; ///< last reading before the index failed
    } fault;
    struct {               ///< data of the slow-side functions
        hal_start_t start; ///< .why == NULL is returned as ""
        hal_image_t table;
        hal_load_t load;                               ///< set by the test
        hal_can_frame_t received[hal_host_can_frames]; ///< ring, hal_host_can_receive()
        hal_can_frame_t sent[hal_host_can_frames];     ///< ring, newest at n_sent - 1
        uint32_t n_received, n_read, n_sent;
        hal_image_t staged;  ///< slot of the download; .bytes == NULL: none begun
        uint32_t n_store;    ///< number of calls of hal_table_begin, _write, _commit and
                             ///< hal_params_keep that will still succeed
        hal_params_t params; ///< stored parameters
        bool forgets_params; ///< hal_params_keep() succeeds, but stores nothing
        uint32_t n_room;     ///< free frames in the transmit queue
        bool is_bus_off;     ///< nothing can be sent
        bool has_no_swing;   ///< the machine has no axis for the swing
        bool has_edge_time;  ///< `in.encoder.edge_clock` is kept up to date
        bool measures_u;     ///< `in.axis_nm[hal_axis_u]` is a measurement
        uint32_t n_kept;     ///< [words] stored by hal_scope_keep()
        hal_force_t force;   ///< returned by hal_force()
        hal_axis_scale_t scale[hal_n_axes]; ///< returned by hal_axis_scale()
        hal_operator_t people;              ///< returned by hal_operator()
    } slow;
    uint32_t tick_hz;     ///< [Hz] set before hal_init(), 20 000 when 0
    uint32_t clock;       ///< [1 / hal_host_clock_hz] virtual time stamp, wraps
    uint32_t late_clocks; ///< [1 / hal_host_clock_hz] delay of the next tick
    uint64_t n_ticks;     ///< periods so far
    char lines[hal_host_lines][hal_host_line_bytes]; ///< ring of hal_text(), newest at n_lines - 1
    uint32_t n_lines;
} hal_host_t;

/// The machine; one per process.
extern hal_host_t hal_host;

/// Reset to the initial state, with a new tick rate.
/// @param tick_hz  [Hz] 500 .. 100 000
void hal_host_reset(uint32_t tick_hz);

/// Advance virtual time by one period without a tick, for firmware in an emulator.
void hal_host_advance(void);

/// Advance virtual time by one period and call cam_isr().
void hal_host_tick(void);

/// Add counts to the encoder's counter once; negative: lose counts.
void hal_host_fault_counts(int32_t counts);

/// Freeze the encoder's counter (a cut cable), or release it.
void hal_host_fault_encoder_stuck(bool is_stuck);

/// Suppress index edges, or stop suppressing them.
void hal_host_fault_index_dead(bool is_dead);

/// Delay the next tick.
/// @param percent  [% of the period]
void hal_host_fault_late(uint32_t percent);

/// Press or release the emergency stop.
void hal_host_fault_estop(bool is_pressed);

/// Make the drives not ready, or ready again.
void hal_host_fault_drive(bool is_failed);

/// Lose a field-bus node, or restore it.
void hal_host_fault_bus(bool is_lost);

/// Switch the limit switches of U on or off.
void hal_host_u_limits(bool is_low, bool is_high);

/// Press or release the acknowledge button.
void hal_host_press(bool is_pressed);

/// Turn the key switch on or off.
void hal_host_turn_key(bool is_on);

/// Receive a CAN frame. @return false if the queue is full and the frame is dropped
bool hal_host_can_receive(const hal_can_frame_t *frame);

#endif
