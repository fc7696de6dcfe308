// SPDX-License-Identifier: Apache-2.0
/// mps2_machine: the machine of the emulated boards: a structure in RAM.
///
/// The machine model sets `in` and reads `out`; it is part of the image, stepped once a period in
/// mps2_machine_step_isr(). (Similar to hal_host_t, but a port must not include headers
/// of another one.)
#ifndef MPS2_MACHINE_H
#define MPS2_MACHINE_H

#include "hal/hal.h" // hal_encoder_t, hal_setpoint_t
#include <stdint.h>  // int32_t, uint32_t

enum { mps2_scope_words = 1 << 14 }; ///< memory for the recorder: 64 KiB

/// The machine's side of the port.
typedef struct {
    struct {
        hal_encoder_t encoder;       ///< reading of the spindle encoder
        int32_t axis_nm[hal_n_axes]; ///< [nm] measured positions
        uint32_t inputs;             ///< hal_in_*
    } in;
    struct {
        hal_setpoint_t axis[hal_n_axes];
        int32_t spindle_mrpm; ///< [r/min / 1000] signed
        uint32_t outputs;     ///< hal_out_*
    } out;
} mps2_machine_t;

/// The machine; one per image.
extern mps2_machine_t mps2_machine;

// Image provides

/// Simulate one period: compute `in` from `out`.
/// Context: the tick's interrupt, after cam_isr().
void mps2_machine_step_isr(void);

#endif
