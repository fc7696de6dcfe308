// SPDX-License-Identifier: Apache-2.0
/// hal_template: a port whose functions do nothing. Copy the folder and give each function what its
/// comment asks for. The contract with times and contexts is hal/hal.h; the order of work and the
/// checks are in hal/PORTING.md.
#include "hal/hal.h"
#include <stddef.h> // NULL

/// Make the outputs safe first: enable low, spindle set-point 0. Then bring up clocks, counters,
/// lines and drives. Return a negative number when something is missing; the firmware then halts
/// with safe outputs.
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

/// Return whether hal_axis_read_nm_isr() measures U. Where it returns the last set-point, say
/// false.
bool hal_measures_u(void)
{
    return false;
}

/// Return the public keys whose tables this machine takes, and whether a signature is required.
/// They are for its builder to set, beyond the reach of every command.
hal_trust_t hal_trust(void)
{
    return (hal_trust_t){.keys = NULL, .n_keys = 0, .is_required = false};
}

/// Return what the outputs and the scales of an axis resolve, and how fast its output is: a code of
/// the converter or a step in picometres, a count of the scale, the highest rate of steps.
hal_axis_scale_t hal_axis_scale(hal_axis_t axis)
{
    (void)axis;
    return (hal_axis_scale_t){0};
}

/// Return what the machine has for the people at it: a button by which somebody lets it move again
/// (hal_in_acknowledge), a key switch (hal_in_key), a secret for the challenge of remote tools.
/// All zero is the safe answer: then nothing is ever enabled. Waive the button only where the
/// machine has one of its own, which switches the drives.
hal_operator_t hal_operator(void)
{
    return (hal_operator_t){0};
}

/// Return RAM that nothing else uses, 32-bit words that only the main loop touches, as much as
/// there is: 64 KiB record a fifth of a second. Memory with error correction is filled by
/// hal_init() first.
hal_memory_t hal_scope_memory(void)
{
    return (hal_memory_t){.words = NULL, .n_words = 0};
}

/// Keep words of that memory where a restart does not reach them, and return them with n_kept from
/// then on, or do nothing. Seldom called, behind a fault.
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

/// Wait for an interrupt and feed the watchdog. Between two calls it must allow for a check of the
/// whole table, cam_table_check().
void hal_idle(void) {}

/// Set enable low, by hardware if possible, keep `why` where a reset does not clear it, and reset.
void hal_halt(const char *why)
{
    (void)why;
    for (;;) {
    }
}

/// Return what the reset flags of the processor say and what hal_halt() kept. Clear the flags in
/// hal_init().
hal_start_t hal_start(void)
{
    return (hal_start_t){.reset = hal_reset_power_on, .why = ""};
}

/// Return a flash sector of its own, so that a new part needs no new firmware.
hal_image_t hal_table_image(void)
{
    return (hal_image_t){.bytes = NULL, .size = 0};
}

/// Erase the other sector, and feed the watchdog meanwhile as long as ticks go on. The table in use
/// may be unreadable during the erase, because no tick reads it in state off.
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

/// Return the other sector once a download has begun.
hal_image_t hal_table_staged(void)
{
    return (hal_image_t){.bytes = NULL, .size = 0};
}

/// Write one record that says which sector is in use. It must be written at once; a torn record
/// must neither count nor cause an exception when it is read.
bool hal_table_commit(void)
{
    return false;
}

/// Return what hal_params_keep() kept last. It is called before the tick starts.
hal_params_t hal_params_kept(void)
{
    return (hal_params_t){.bytes = NULL};
}

/// Append a record with a checksum to a log in flash of its own. Before a full sector is erased,
/// the newest record must stand in another one, and a torn record must neither count nor cause an
/// exception when it is read.
bool hal_params_keep(const void *bytes, uint32_t size)
{
    (void)bytes;
    (void)size;
    return false;
}

/// Return the durations that the timer's interrupt measures: read a cycle counter before and after
/// cam_isr().
hal_load_t hal_load(void)
{
    return (hal_load_t){0};
}

/// Write to a serial line. It may wait for room, but never longer than the watchdog allows.
void hal_text(const char *line)
{
    (void)line;
}

/// Return frames in the order of their arrival. A full queue drops the newest.
bool hal_can_read(hal_can_frame_t *frame)
{
    (void)frame;
    return false;
}

/// Queue the frame, and never wait for the bus.
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

/// Return counter, index latch and number of index edges of the same instant. In both senses of
/// rotation the latch holds the counter at that edge of the index pulse which a positive rotation
/// passes first.
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

/// Return the emergency-stop chain and the drive-ready line. A cut wire must read as "stop" and as
/// "not ready".
uint32_t hal_inputs_read_isr(void)
{
    return hal_in_estop;
}

/// Pass the set-point to the drive before the next tick, and always after the same delay, which is
/// a part of the parameter lead_ns.
void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    (void)axis;
    (void)setpoint;
}

/// Pass the set-point to the drive. Until the next one the drive continues at the velocity given.
void hal_swing_write_isr(const hal_swing_t *setpoint)
{
    (void)setpoint;
}

/// Pass the signed speed set-point to the spindle's drive.
void hal_spindle_write_isr(int32_t speed_mrpm)
{
    (void)speed_mrpm;
}

/// Write enable, fault lamp and "in cut". Enable low must stop the drives without the firmware's
/// help.
void hal_outputs_write_isr(uint32_t bits)
{
    (void)bits;
}
