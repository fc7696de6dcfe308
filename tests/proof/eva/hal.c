// SPDX-License-Identifier: Apache-2.0
// A port whose sensors report any numbers.
#include "hal/hal.h"
#include "world.h"

uint32_t hal_clock_isr(void)
{
    return any(0, UINT32_MAX);
}

void hal_encoder_read_isr(hal_encoder_t *reading)
{
    reading->counts = any(0, UINT32_MAX);
    reading->index_counts = any(0, UINT32_MAX);
    reading->n_index = any(0, UINT32_MAX);
    reading->edge_clock = any(0, UINT32_MAX);
}

int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    return any(INT32_MIN, INT32_MAX);
}

int32_t hal_swing_read_q32_isr(void)
{
    return any(INT32_MIN, INT32_MAX);
}

uint32_t hal_inputs_read_isr(void)
{
    return any(0, UINT32_MAX);
}

void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint) {}

void hal_force_write_isr(int32_t force_q6) {}

void hal_swing_write_isr(const hal_swing_t *setpoint) {}

void hal_spindle_write_isr(int32_t speed_mrpm) {}

void hal_outputs_write_isr(uint32_t bits) {}
