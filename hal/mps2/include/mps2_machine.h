// SPDX-License-Identifier: Apache-2.0
/// mps2_machine: the machine of the emulated boards: a structure in RAM.
///
/// The machine model sets `in` and `slow` and reads `out`; it is part of the image, stepped once a
/// period in mps2_machine_step_isr(). (Similar to hal_host_t, but a port must not include headers
/// of another one.)
#ifndef MPS2_MACHINE_H
#define MPS2_MACHINE_H

#include "hal/hal.h" // hal_encoder_t, hal_setpoint_t
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

enum { mps2_can_frames = 16 }; ///< depth of the queues, a power of two

enum { mps2_scope_words = 1 << 14 }; ///< memory for the recorder: 64 KiB

enum { mps2_place_bytes = 1 << 19 }; ///< [bytes] of a table slot

/// The machine's side of the port.
typedef struct {
    struct {
        hal_encoder_t encoder;       ///< reading of the spindle encoder
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
    struct {                                       ///< data of the slow-side functions
        hal_image_t table;                         ///< bytes == NULL: no table
        hal_can_frame_t received[mps2_can_frames]; ///< ring, newest at n_received - 1
        hal_can_frame_t sent[mps2_can_frames];     ///< ring, newest at n_sent - 1
        uint32_t n_received, n_read, n_sent;
        hal_force_t force;  ///< returned by hal_force()
        bool has_edge_time; ///< `in.encoder.edge_clock` is kept up to date
        bool measures_u;    ///< `in.axis_nm[hal_axis_u]` is a measurement
    } slow;
} mps2_machine_t;

/// The machine; one per image.
extern mps2_machine_t mps2_machine;

/// Receive a CAN frame. @return false if the queue is full and the frame is lost
/// Context: machine model.
bool mps2_machine_can_receive(const hal_can_frame_t *frame);

// Image provides

/// Simulate one period: compute `in` from `out`.
/// Context: the tick's interrupt, after cam_isr().
void mps2_machine_step_isr(void);

#endif
