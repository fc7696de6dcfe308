// SPDX-License-Identifier: Apache-2.0
/// stm_timers: tick, encoders and clock: TIM1 to TIM5.
///
/// Hardware latches the spindle's counter at both edges of the index pulse. The port uses the
/// position at which positive rotation enters the pulse: its rising edge. Negative rotation leaves
/// the pulse at the same position, so the falling edge is used. The counter's direction bit, as
/// read in the tick, selects the edge.
///
/// TIM5 is the timestamp clock. Its channels 1 and 4 capture it at every edge of A and B, so the
/// later capture is the time of the last counted edge.
#ifndef STM_TIMERS_H
#define STM_TIMERS_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// Faults of the port. With any of them hal_inputs_read_isr() reports the drives as not ready until
/// the next reset, so the controller retracts and does not restart.
enum {
    stm_fault_clock = 1u << 0,   ///< the HSE did not start: rates are within 1 % only
    stm_fault_overrun = 1u << 1, ///< a tick had not ended when the next one was due
    stm_fault_late = 1u << 2,    ///< set-points were not yet sent when the outputs stepped
    stm_fault_dac = 1u << 3,     ///< a transfer to the AD5754R did not end within a period
    stm_fault_edges = 1u << 4,   ///< edges of the spindle were counted, but not stamped
};

/// All faults since the start. Written by the tick, and by the slow side before the tick runs.
extern volatile uint32_t stm_faults;

/// Set all five timers up. Encoders and clock run afterwards, the tick does not.
/// Context: slow side, once.
/// Source: RM0433 38.3, 39.3 (encoder interface, input capture, PWM), 39.4 (registers).
void stm_timers_init(void);

/// Start TIM4 and its interrupt. Context: slow side.
void stm_timers_start_tick(void);

/// Acknowledge the tick. Context: ISR, at its start.
void stm_timers_tick_begin_isr(void);

/// @return whether the next tick is already due. Context: ISR, at its end.
bool stm_timers_is_overrun_isr(void);

/// @return whether a transfer started now would end after the outputs step. Context: ISR.
bool stm_timers_is_late_isr(void);

/// Pull /LDAC low at once instead of BOARD_UPDATE_NS after the start of the tick, or undo that.
/// Context: ISR, before that time.
void stm_timers_ldac_isr(bool is_low);

/// @return [counts] position of the U scale since start. Context: ISR, every tick.
int32_t stm_timers_u_counts_isr(void);

/// @return [counts] position of the Z scale since start. Context: ISR, every tick.
int32_t stm_timers_z_counts_isr(void);

#endif
