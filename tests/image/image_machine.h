// SPDX-License-Identifier: Apache-2.0
/// image_machine: a little machine in integers around the port of the emulated boards: the spindle
/// follows its set-point on a ramp, axes reach their set-points within one period.
#ifndef IMAGE_MACHINE_H
#define IMAGE_MACHINE_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

enum { image_counts_per_turn = 4096 };

typedef struct {
    int32_t speed_mrpm; ///< [r/min / 1000] of the spindle
    uint64_t turns_q32; ///< [turn, Q32.32] that it has turned
    bool is_u_stuck;    ///< U stands still from now on
    uint32_t n_periods; ///< since start
} image_machine_t;

extern image_machine_t image_machine;

/// Before hal_tick_start(): axes at rest off the work, drives ready.
/// @param x_nm, z_nm  places at the start
void image_machine_init(int32_t x_nm, int32_t z_nm);

/// One period passes. Context: mps2_machine_step_isr().
void image_machine_step_isr(void);

#endif
