// SPDX-License-Identifier: Apache-2.0
#include "image_machine.h"
#include "hal/hal.h"
#include "mps2_machine.h"

image_machine_t image_machine;

enum { ramp_mrpm = 2000 }; ///< per period: 2500 r/min in 62 ms at 20 kHz

void image_machine_init(int32_t x_nm, int32_t z_nm)
{
    image_machine = (image_machine_t){.turns_q32 = UINT64_C(3) << 30}; // 3/4: the index is ahead
    mps2_machine.in.inputs = hal_in_drive_ready;
    mps2_machine.in.axis_nm[hal_axis_u] = 0;
    mps2_machine.in.axis_nm[hal_axis_x] = x_nm;
    mps2_machine.in.axis_nm[hal_axis_z] = z_nm;
}

static void turn_spindle(void)
{
    const int32_t left = mps2_machine.out.spindle_mrpm - image_machine.speed_mrpm;
    const int32_t rise = left < ramp_mrpm ? left : ramp_mrpm;
    image_machine.speed_mrpm += rise > -ramp_mrpm ? rise : -ramp_mrpm;
    // r/min / 1000 -> turns / 2^32 per period; the spindle of these cuts turns in one sense only
    const uint64_t per_minute = UINT64_C(60000) * hal_tick_hz();
    image_machine.turns_q32 += ((uint64_t)image_machine.speed_mrpm << 32) / per_minute;
}

/// The index edge lies at every whole turn.
static void read_encoder(void)
{
    hal_encoder_t *encoder = &mps2_machine.in.encoder;
    const uint32_t n_index = (uint32_t)(image_machine.turns_q32 >> 32);
    encoder->counts = (uint32_t)(image_machine.turns_q32 * image_counts_per_turn >> 32);
    if (n_index != encoder->n_index) {
        encoder->n_index = n_index;
        encoder->index_counts = n_index * image_counts_per_turn;
    }
}

static void move_axes(void)
{
    if ((mps2_machine.out.outputs & hal_out_enable) == 0u) {
        return;
    }
    for (int i = 0; i < hal_n_axes; i++) {
        if (i != hal_axis_u || !image_machine.is_u_stuck) {
            mps2_machine.in.axis_nm[i] = mps2_machine.out.axis[i].pos_nm;
        }
    }
}

void image_machine_step_isr(void)
{
    turn_spindle();
    read_encoder();
    move_axes();
    image_machine.n_periods++;
}
