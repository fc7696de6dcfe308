// SPDX-License-Identifier: Apache-2.0
/// hal_template: an empty port. Copy the folder and implement each function as its comment says.
/// Contract, times and contexts: hal/hal.h. Order of work and checks: hal/PORTING.md.
#include "hal/hal.h"
#include <stddef.h> // NULL

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

/// Return whether a drive swings the tool. If so, implement both functions of the swing.
bool hal_has_swing(void)
{
    return false;
}

/// Return whether hardware stamps the encoder's edges; then hal_encoder_read_isr() fills
/// edge_clock.
bool hal_has_edge_time(void)
{
    return false;
}

/// Return whether hal_axis_read_nm_isr() measures U; false if it returns the last set-point.
bool hal_measures_u(void)
{
    return false;
}

/// Return the resolution of the output (a DAC code or a step) and of the measurement (a count of
/// the scale) in picometres, and the speed at the highest step rate.
hal_axis_scale_t hal_axis_scale(hal_axis_t axis)
{
    (void)axis;
    return (hal_axis_scale_t){0};
}

/// Return the step of the force where an amplifier takes the force of U, and the time from the
/// latch of U's scale to the change of the output. Such an output must be 0 V by hardware, in every
/// reset and while enable is low: wire the clear input of the DAC to the enable. PORTING.md, "Force
/// of U".
hal_force_t hal_force(void)
{
    return (hal_force_t){0};
}

/// Return the operator controls: acknowledge button (hal_in_acknowledge), key switch (hal_in_key),
/// secret for the challenge of remote tools. All zero is safe: nothing can be enabled. Waive the
/// button only if the machine has its own button, which switches the drives.
hal_operator_t hal_operator(void)
{
    return (hal_operator_t){0};
}

/// Return all RAM that is free, as 32-bit words: 64 KiB record a fifth of a second. Fill memory
/// with error correction in hal_init() first.
hal_memory_t hal_scope_memory(void)
{
    return (hal_memory_t){.words = NULL, .n_words = 0};
}

/// Store words of that memory across a restart and return their number in n_kept after it; or do
/// nothing. Called rarely, after a fault.
void hal_scope_keep(const int32_t *words, uint32_t n)
{
    (void)words;
    (void)n;
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

/// Return a separate flash sector, so that a new part needs no new firmware.
hal_image_t hal_table_image(void)
{
    return (hal_image_t){.bytes = NULL, .size = 0};
}

/// Erase the other sector, feeding the watchdog while ticks continue. The table in use may be
/// unreadable during the erase, because no tick reads it in state off.
bool hal_table_begin(uint32_t size)
{
    (void)size;
    return false;
}

/// Program the piece, invalidate the caches for it, and compare.
bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n)
{
    (void)offset;
    (void)bytes;
    (void)n;
    return false;
}

/// Return the other sector after hal_table_begin().
hal_image_t hal_table_staged(void)
{
    return (hal_image_t){.bytes = NULL, .size = 0};
}

/// Write a record that names the sector in use, in one operation. A torn record must be ignored and
/// must not cause an exception when read.
bool hal_table_commit(void)
{
    return false;
}

/// Return the parameters stored last. Called before the tick starts.
hal_params_t hal_params_kept(void)
{
    return (hal_params_t){.bytes = NULL};
}

/// Append a record with a checksum to a log in separate flash. Never erase the sector with the
/// newest record. A torn record must be ignored and must not cause an exception when read.
bool hal_params_keep(const void *bytes, uint32_t size)
{
    (void)bytes;
    (void)size;
    return false;
}

/// Return the durations measured in the timer's interrupt, with a cycle counter read before and
/// after cam_isr().
hal_load_t hal_load(void)
{
    return (hal_load_t){0};
}

/// Write to a serial line. It may wait for space, but never as long as the watchdog's time.
void hal_text(const char *line)
{
    (void)line;
}

/// Return frames in order of arrival. A full queue drops the newest.
bool hal_can_read(hal_can_frame_t *frame)
{
    (void)frame;
    return false;
}

/// Queue the frame without waiting for the bus.
bool hal_can_write(const hal_can_frame_t *frame)
{
    (void)frame;
    return false;
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

/// Return the newest measured swing of the tool; 0 without the axis.
int32_t hal_swing_read_q32_isr(void)
{
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

/// Write the force at once, rounded to its step and clamped, without waiting for the outputs that
/// step later; do nothing where U takes positions. With a force hal_axis_write_isr() must not write
/// the output of U.
void hal_force_write_isr(int32_t force_q6)
{
    (void)force_q6;
}

/// Pass the set-point to the drive, which continues at the given velocity until the next one.
void hal_swing_write_isr(const hal_swing_t *setpoint)
{
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
