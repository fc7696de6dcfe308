// SPDX-License-Identifier: Apache-2.0
// One whole tick of any controller, with anything that the sensors can tell. What lies behind it
// must be a controller within the same ranges. Tables with and without a way, and with and without
// angles, are analysed one by one, because each of them comes with parts of the plan.
#include "hal/hal.h"
#include "world.h"

void Frama_C_show_each_leaves(const char *name, long long value);

/// Tell what may lie outside of its range: prove.py takes each for an alarm.
#define VISIT(name, member, low, high)                                                             \
    if ((long long)(member) < (low) || (long long)(member) > (high)) {                             \
        Frama_C_show_each_leaves(name, member);                                                    \
    }
#include "ranges_walk.h"

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

void hal_swing_write_isr(const hal_swing_t *setpoint) {}

void hal_spindle_write_isr(int32_t speed_mrpm) {}

void hal_outputs_write_isr(uint32_t bits) {}

void main(void)
{
    //@ loop unroll 4;
    for (uint32_t channels = 0; channels < 4; channels++) {
        make_world();
        if ((channels & 1u) == 0) {
            cfg->table.way.knots = NULL;
            cfg->table.has_stations = false; // cam_way_check()
        }
        if ((channels & 2u) == 0) {
            cfg->table.angle.knots = NULL;
            cfg->table.n_lobes = 0; // cam_lobes_check_patterns()
            cfg->play.swing.is_swung = false;
        }
        cam_tick_isr(&c);
        walk_state(&c);
    }
}
