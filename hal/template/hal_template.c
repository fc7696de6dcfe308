// SPDX-License-Identifier: Apache-2.0
/// hal_template: a port with every function and nothing behind it. Copy the folder, give each
/// function what its comment asks for. The contract with times and contexts is hal/hal.h, the order
/// of work and the checks are in hal/PORTING.md.
#include "hal/hal.h"
#include <stddef.h> // NULL

/// Outputs safe first: enable low, spindle set-point 0. Then clocks, counters, lines, drives.
/// Return a negative number when something is missing; the firmware then halts with safe outputs.
int hal_init(void)
{
    return 0;
}

/// The rate of the timer that calls cam_isr().
uint32_t hal_tick_hz(void)
{
    return 20000;
}

/// Whether a drive swings the tool. A port that says so implements both functions of the swing.
bool hal_has_swing(void)
{
    return false;
}

/// The rate of the free-running counter that hal_clock_isr() reads.
uint32_t hal_clock_hz(void)
{
    return 1000000;
}

/// Let the timer run. Its interrupt must have the highest priority and must not nest.
void hal_tick_start(void) {}

/// Wait for an interrupt, feed the watchdog; it must allow for a check of the whole table
/// (cam_table_check(), tens of instructions per byte) between two calls.
void hal_idle(void) {}

/// Enable low by hardware if possible, keep `why` where a reset does not clear it, reset.
void hal_halt(const char *why)
{
    (void)why;
    for (;;) {
    }
}

/// The reset flags of the processor, and what hal_halt() kept. Clear the flags in hal_init().
hal_start_t hal_start(void)
{
    return (hal_start_t){.reset = hal_reset_power_on, .why = ""};
}

/// A flash sector of its own, so that a new part needs no new firmware.
hal_image_t hal_table_image(void)
{
    return (hal_image_t){.bytes = NULL, .size = 0};
}

/// Erase the other sector, feeding the watchdog as long as ticks go on. The table in use must stay
/// readable, or not be read: no tick does in state off.
bool hal_table_begin(uint32_t size)
{
    (void)size;
    return false;
}

/// Program, make the caches forget the place, compare.
bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n)
{
    (void)offset;
    (void)bytes;
    (void)n;
    return false;
}

/// The other sector.
hal_image_t hal_table_staged(void)
{
    return (hal_image_t){.bytes = NULL, .size = 0};
}

/// One record, written at once, tells which sector is in use; a torn one must not count, nor fault.
bool hal_table_commit(void)
{
    return false;
}

/// Read a cycle counter before and behind cam_isr() in the timer's interrupt.
hal_load_t hal_load(void)
{
    return (hal_load_t){0};
}

/// A serial line; may wait for room, never longer than the watchdog allows.
void hal_text(const char *line)
{
    (void)line;
}

/// Frames in the order of their arrival; a full queue drops the newest.
bool hal_can_read(hal_can_frame_t *frame)
{
    (void)frame;
    return false;
}

/// Never wait for the bus.
bool hal_can_write(const hal_can_frame_t *frame)
{
    (void)frame;
    return false;
}

/// A free-running 32-bit counter; must not stop or jump while the tick runs.
uint32_t hal_clock_isr(void)
{
    return 0;
}

/// Counter, index latch and number of index edges of the same instant. The latch holds the counter
/// at the edge of the index pulse that is passed first in the positive sense, for both senses.
void hal_encoder_read_isr(hal_encoder_t *reading)
{
    *reading = (hal_encoder_t){0};
}

/// Newest measured position of an axis.
int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    (void)axis;
    return 0;
}

/// Newest measured swing of the tool; 0 without the axis.
int32_t hal_swing_read_q32_isr(void)
{
    return 0;
}

/// Emergency-stop chain and drive-ready line; a cut wire must read as "stop" and "not ready".
uint32_t hal_inputs_read_isr(void)
{
    return hal_in_estop;
}

/// Must reach the drive before the next tick, always after the same delay: the parameter lead_ns.
void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    (void)axis;
    (void)setpoint;
}

/// Every 8 or 10 ticks; in between the drive goes on at the speed of the last one.
void hal_swing_write_isr(const hal_swing_t *setpoint)
{
    (void)setpoint;
}

/// Speed set-point of the spindle, signed.
void hal_spindle_write_isr(int32_t speed_mrpm)
{
    (void)speed_mrpm;
}

/// Enable, fault lamp, in cut. Enable low must stop the drives without the firmware's help.
void hal_outputs_write_isr(uint32_t bits)
{
    (void)bits;
}
