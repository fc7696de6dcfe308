// SPDX-License-Identifier: Apache-2.0
/// mps2_port: the port of the emulated boards, on mps2_machine. Time is separate: mps2_timer.c, or
/// a program that calls cam_isr() itself.
#include "hal/hal.h"
#include "mps2_machine.h"
#include "mps2_semihost.h"
#include <string.h> // strlen

/// Exit status after hal_halt(); a real machine would restart.
enum { status_halt = 98 };

mps2_machine_t mps2_machine;

int hal_init(void)
{
    for (int i = 0; i < hal_n_axes; i++) {
        mps2_machine.out.axis[i] = (hal_setpoint_t){0};
    }
    mps2_machine.out.force_q6 = 0;
    mps2_machine.out.spindle_mrpm = 0;
    mps2_machine.out.outputs = 0;
    mps2_machine.out.swing = (hal_swing_t){0};
    mps2_machine.out.n_swing = 0;
    return 0;
}

bool hal_has_swing(void)
{
    return true;
}

bool hal_has_edge_time(void)
{
    return false;
}

bool hal_measures_u(void)
{
    return false;
}

hal_force_t hal_force(void)
{
    return (hal_force_t){0};
}

/// No acknowledge: an emulated machine cannot hurt anybody.
hal_operator_t hal_operator(void)
{
    return (hal_operator_t){.is_acknowledge_waived = true, .has_key = true};
}

/// 0: the simulated machine has its own resolution.
hal_axis_scale_t hal_axis_scale(hal_axis_t axis)
{
    (void)axis;
    return (hal_axis_scale_t){0};
}

hal_memory_t hal_scope_memory(void)
{
    static int32_t words[mps2_scope_words];
    return (hal_memory_t){.words = words, .n_words = mps2_scope_words};
}

void hal_scope_keep(const int32_t *words, uint32_t n)
{
    (void)words;
    (void)n;
}

void hal_text(const char *line)
{
    mps2_write(line, strlen(line));
    mps2_write("\n", 1);
}

void hal_halt(const char *why)
{
    mps2_machine.out.spindle_mrpm = 0;
    mps2_machine.out.outputs = 0;
    mps2_write("firmware halted: ", sizeof "firmware halted: " - 1u);
    hal_text(why);
    mps2_exit(status_halt);
}

hal_start_t hal_start(void)
{
    return (hal_start_t){.reset = hal_reset_power_on, .why = ""};
}

hal_image_t hal_table_image(void)
{
    return (hal_image_t){0};
}

// Images call cam_machine.h and read no bus: nothing is downloaded or kept.

bool hal_table_begin(uint32_t size)
{
    (void)size;
    return false;
}

bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n)
{
    (void)offset;
    (void)bytes;
    (void)n;
    return false;
}

hal_image_t hal_table_staged(void)
{
    return (hal_image_t){0};
}

bool hal_table_commit(void)
{
    return false;
}

hal_params_t hal_params_kept(void)
{
    return (hal_params_t){0};
}

bool hal_params_keep(const void *bytes, uint32_t size)
{
    (void)bytes;
    (void)size;
    return false;
}

bool hal_can_read(hal_can_frame_t *frame)
{
    (void)frame;
    return false;
}

bool hal_can_write(const hal_can_frame_t *frame)
{
    (void)frame;
    return true;
}

void hal_encoder_read_isr(hal_encoder_t *reading)
{
    *reading = mps2_machine.in.encoder;
}

int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    return mps2_machine.in.axis_nm[axis];
}

int32_t hal_swing_read_q32_isr(void)
{
    return mps2_machine.in.swing_q32;
}

uint32_t hal_inputs_read_isr(void)
{
    return mps2_machine.in.inputs;
}

void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    mps2_machine.out.axis[axis] = *setpoint;
}

void hal_swing_write_isr(const hal_swing_t *setpoint)
{
    mps2_machine.out.swing = *setpoint;
    mps2_machine.out.n_swing++;
}

void hal_force_write_isr(int32_t force_q6)
{
    mps2_machine.out.force_q6 = force_q6;
}

void hal_spindle_write_isr(int32_t speed_mrpm)
{
    mps2_machine.out.spindle_mrpm = speed_mrpm;
}

void hal_outputs_write_isr(uint32_t bits)
{
    mps2_machine.out.outputs = bits;
}
