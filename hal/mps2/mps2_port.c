// SPDX-License-Identifier: Apache-2.0
/// mps2_port: the port of the emulated boards, on mps2_machine. Images call cam_machine.h and read
/// no bus: nothing is downloaded or kept. Time is separate: mps2_timer.c, or a program that calls
/// cam_isr() itself.
#include "hal/hal.h"
#include "mps2_machine.h"
#include "mps2_semihost.h"
#include <string.h> // strlen

/// Exit status after hal_halt(); a real machine would restart.
enum { status_halt = 98 };

mps2_machine_t mps2_machine;

int hal_init(void)
{
    mps2_machine = (mps2_machine_t){.in = mps2_machine.in};
    return 0;
}

/// No acknowledge: an emulated machine cannot hurt anybody.
hal_operator_t hal_operator(void)
{
    return (hal_operator_t){.is_acknowledge_waived = true, .has_key = true};
}

hal_memory_t hal_scope_memory(void)
{
    static int32_t words[mps2_scope_words];
    return (hal_memory_t){.words = words, .n_words = mps2_scope_words};
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

void hal_encoder_read_isr(hal_encoder_t *reading)
{
    *reading = mps2_machine.in.encoder;
}

int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    return mps2_machine.in.axis_nm[axis];
}

uint32_t hal_inputs_read_isr(void)
{
    return mps2_machine.in.inputs;
}

void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    mps2_machine.out.axis[axis] = *setpoint;
}

void hal_spindle_write_isr(int32_t speed_mrpm)
{
    mps2_machine.out.spindle_mrpm = speed_mrpm;
}

void hal_outputs_write_isr(uint32_t bits)
{
    mps2_machine.out.outputs = bits;
}
