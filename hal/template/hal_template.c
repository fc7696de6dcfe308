// SPDX-License-Identifier: Apache-2.0
/// hal_template: an empty port: the functions that every port has. Copy the folder and implement
/// each as its comment says. Add the functions with a default for what the machine has besides:
/// table, parameters, CAN, recorder, measured U, edge times, force, swing.
/// Contract, times and contexts: hal/hal.h. Order of work and checks: hal/PORTING.md.
#include "hal/hal.h"

/// First make the outputs safe: enable low, spindle set-point 0. Then initialise clocks, counters,
/// lines and drives. On an error return a negative number; the firmware then halts with safe
/// outputs.
int hal_init(void)
{
    return 0;
}

/// Return the rate of the timer that calls cam_isr().
uint32_t hal_tick_hz(void)
{
    return 20000;
}

/// Return the operator controls: acknowledge button (hal_in_acknowledge), key switch (hal_in_key).
/// All zero is safe: nothing can be enabled. Waive the button only if the machine has its own
/// button, which switches the drives.
hal_operator_t hal_operator(void)
{
    return (hal_operator_t){0};
}

/// Return the rate of the free-running counter that hal_clock_isr() reads.
uint32_t hal_clock_hz(void)
{
    return 1000000;
}

/// Start the timer. Its interrupt must have the highest priority and must not nest.
void hal_tick_start(void) {}

/// Wait for an interrupt and feed the watchdog. The watchdog's time must be longer than the check
/// of a whole table, cam_table_check().
void hal_idle(void) {}

/// Set enable low, by hardware if possible, store `why` where a reset does not clear it, and reset.
void hal_halt(const char *why)
{
    (void)why;
    for (;;) {
    }
}

/// Return the cause from the processor's reset flags, and the text stored by hal_halt(). Clear the
/// flags in hal_init().
hal_start_t hal_start(void)
{
    return (hal_start_t){.reset = hal_reset_power_on, .why = ""};
}

/// Write to a serial line. It may wait for space, but never as long as the watchdog's time.
void hal_text(const char *line)
{
    (void)line;
}

/// Return a free-running 32-bit counter. It must not stop or jump while the tick runs.
uint32_t hal_clock_isr(void)
{
    return 0;
}

/// Return counter, index latch and number of index edges, sampled at the same instant. In both
/// directions of rotation the latch holds the counter at the edge of the index pulse that comes
/// first in positive rotation.
void hal_encoder_read_isr(hal_encoder_t *reading)
{
    *reading = (hal_encoder_t){0};
}

/// Return the newest measured position of the axis.
int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    (void)axis;
    return 0;
}

/// Return the states of the emergency-stop chain and the drive-ready line, and the limit switches
/// of a U that takes forces. A cut wire must read as "stop", "not ready" and "at the limit".
uint32_t hal_inputs_read_isr(void)
{
    return hal_in_estop;
}

/// Pass the set-point to the drive before the next tick, with a constant delay. The parameter
/// lead_ns includes this delay.
void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    (void)axis;
    (void)setpoint;
}

/// Pass the signed speed set-point to the spindle drive.
void hal_spindle_write_isr(int32_t speed_mrpm)
{
    (void)speed_mrpm;
}

/// Write enable, fault and "in cut". Enable low must stop the drives without help from firmware.
void hal_outputs_write_isr(uint32_t bits)
{
    (void)bits;
}
