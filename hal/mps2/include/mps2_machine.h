// SPDX-License-Identifier: Apache-2.0
/// mps2_machine: what stands behind the port of the emulated boards: a structure in RAM.
///
/// Whoever plays the machine sets `in` and `slow`, and reads `out`: the image's own machine once a
/// period (mps2_machine_step_isr()), or a program that calls cam_isr() itself and never starts the
/// tick.
#ifndef MPS2_MACHINE_H
#define MPS2_MACHINE_H

#include "hal/hal.h" // hal_encoder_t, hal_setpoint_t
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

enum { mps2_can_frames = 16 }; ///< depth of the queues, a power of two

enum { mps2_place_bytes = 1 << 19 }; ///< of a downloaded table

typedef struct {
    struct {
        hal_encoder_t encoder;
        int32_t axis_nm[hal_n_axes]; ///< [nm] measured positions
        int32_t swing_q32;           ///< [turn / 2^32] measured swing
        uint32_t inputs;             ///< hal_in_*
    } in;
    struct {
        hal_setpoint_t axis[hal_n_axes];
        int32_t spindle_mrpm; ///< [r/min / 1000] signed
        uint32_t outputs;     ///< hal_out_*
        hal_swing_t swing;
        uint32_t n_swing; ///< set-points of the swing so far
    } out;
    struct {                                       ///< what the slow side asks for
        hal_image_t table;                         ///< bytes == NULL: no table is kept
        hal_can_frame_t received[mps2_can_frames]; ///< ring, newest at n_received - 1
        hal_can_frame_t sent[mps2_can_frames];     ///< ring, newest at n_sent - 1
        uint32_t n_received, n_read, n_sent;
    } slow;
} mps2_machine_t;

/// The one machine of the image.
extern mps2_machine_t mps2_machine;

/// A frame arrives. @return false when the queue is full; the frame is lost
/// Context: whoever plays the machine.
bool mps2_machine_can_receive(const hal_can_frame_t *frame);

// Image provides, when it starts the tick

/// One period passes: out -> in. Context: the tick's interrupt, after cam_isr().
void mps2_machine_step_isr(void);

#endif
