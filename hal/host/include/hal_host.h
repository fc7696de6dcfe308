// SPDX-License-Identifier: Apache-2.0
/// hal_host: the simulator's port. Tests and machine models set here what the firmware senses, read
/// what it writes, and cause every fault that a machine can have.
///
/// Time is virtual: hal_host_tick() advances it by one period and calls cam_isr(). A machine model
/// sets `in` before and reads `out` afterwards. Only one thread may use the port.
#ifndef HAL_HOST_H
#define HAL_HOST_H

#include "hal/hal.h" // hal_encoder_t, hal_setpoint_t
#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

enum { hal_host_can_frames = 16 };       ///< depth of the queues, a power of two
enum { hal_host_place_bytes = 1 << 20 }; ///< [bytes] of a place for a downloaded table
#ifdef __arm__                           // unit tests on an emulated board, which has 4 MiB in all
enum { hal_host_scope_words = 1 << 16 }; ///< memory for the recorder
#else
enum { hal_host_scope_words = 1 << 18 }; ///< memory for the recorder: 1 MiB
#endif
enum { hal_host_lines = 8 };            ///< lines of text that are kept, a power of two
enum { hal_host_line_bytes = 128 };     ///< [bytes] more than hal_text() allows, so a test sees it
enum { hal_host_clock_hz = 200000000 }; ///< [Hz] rate of the virtual time stamp: 5 ns

/// The machine's side of the port.
typedef struct {
    struct {
        hal_encoder_t encoder;       ///< true reading, before the faults distort it
        hal_encoder_t read;          ///< what the interrupt reads: distorted at the last advance
        int32_t axis_nm[hal_n_axes]; ///< [nm] measured positions
        int32_t swing_q32;           ///< [turn / 2^32] measured swing
        uint32_t inputs;             ///< hal_in_*
    } in;
    struct {
        hal_setpoint_t axis[hal_n_axes];
        int32_t spindle_mrpm; ///< [r/min / 1000] signed
        uint32_t outputs;     ///< hal_out_*
        hal_swing_t swing;
        uint32_t n_swing; ///< number of set-points of the swing so far
    } out;
    struct {                   ///< distortions, applied to every reading of the encoder
        uint32_t count_offset; ///< [counts] added to the counter and to its index latch
        bool is_encoder_stuck; ///< the counter stands still at stuck_counts
        uint32_t stuck_counts;
        bool is_index_dead;       ///< no further index edge arrives
        hal_encoder_t last_index; ///< last reading before the index died
    } fault;
    struct {               ///< what the functions of the slow side return and take
        hal_start_t start; ///< .why == NULL is returned as ""
        hal_image_t table;
        hal_load_t load;                               ///< as the test sets it
        hal_can_frame_t received[hal_host_can_frames]; ///< ring, hal_host_can_receive()
        hal_can_frame_t sent[hal_host_can_frames];     ///< ring, newest at n_sent - 1
        uint32_t n_received, n_read, n_sent;
        hal_image_t staged;  ///< place of the download; .bytes == NULL when none was begun
        uint32_t n_store;    ///< calls of hal_table_begin, _write, _commit and hal_params_keep that
                             ///< still succeed
        hal_params_t params; ///< kept parameters
        uint32_t n_room;     ///< frames for which the transmit queue still has room
        bool is_bus_off;     ///< nothing can be sent
        bool has_no_swing;   ///< the machine has no axis for the swing
        bool has_edge_time;  ///< `in.encoder.edge_clock` is kept up to date
        bool measures_u;     ///< `in.axis_nm[hal_axis_u]` is a measurement
        uint32_t n_kept;     ///< [words] of hal_scope_keep(), which a start finds again
        hal_axis_scale_t scale[hal_n_axes]; ///< what hal_axis_scale() says
        hal_operator_t people;              ///< what hal_operator() says
        hal_trust_t trust;                  ///< what hal_trust() says
    } slow;
    uint32_t tick_hz;     ///< [Hz] set before hal_init(), 20 000 when 0
    uint32_t clock;       ///< [1 / hal_host_clock_hz] virtual time stamp, wraps
    uint32_t late_clocks; ///< [1 / hal_host_clock_hz] delay of the next tick
    uint64_t n_ticks;     ///< periods so far
    char lines[hal_host_lines][hal_host_line_bytes]; ///< ring of hal_text(), newest at n_lines - 1
    uint32_t n_lines;
} hal_host_t;

/// The one machine of this process.
extern hal_host_t hal_host;

/// Return to the state after the start, with a new tick rate.
/// @param tick_hz  [Hz] 500 .. 100 000
void hal_host_reset(uint32_t tick_hz);

/// Advance virtual time by one period without a tick, for firmware that runs on an emulator.
void hal_host_advance(void);

/// Advance virtual time by one period and call cam_isr().
void hal_host_tick(void);

/// The encoder's counter gains counts once, or loses them when negative.
void hal_host_fault_counts(int32_t counts);

/// The encoder's counter stands still from now on (a cut cable), or moves again.
void hal_host_fault_encoder_stuck(bool is_stuck);

/// Index edges are no longer reported, or are reported again.
void hal_host_fault_index_dead(bool is_dead);

/// The next tick comes late.
/// @param percent  delay in per cent of a period
void hal_host_fault_late(uint32_t percent);

/// The emergency stop is pressed, or released.
void hal_host_fault_estop(bool is_pressed);

/// The drives are not ready, or ready again.
void hal_host_fault_drive(bool is_failed);

/// A node on the field bus is silent, or heard again.
void hal_host_fault_bus(bool is_lost);

/// The button acknowledge is pressed, or released.
void hal_host_press(bool is_pressed);

/// The key switch is turned on, or off.
void hal_host_turn_key(bool is_on);

/// A CAN frame arrives. @return false when the queue is full and the frame is dropped
bool hal_host_can_receive(const hal_can_frame_t *frame);

#endif
