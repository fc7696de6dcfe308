// SPDX-License-Identifier: Apache-2.0
/// stm_timers: tick, encoders and clock: TIM1 to TIM5.
///
/// Hardware latches the spindle's counter at both edges of the index pulse. The port uses the place
/// at which a positive rotation enters the pulse, which is the rising edge. In the negative sense
/// the pulse is left at that very place, so the falling edge is used. The direction bit of the
/// counter decides, as it is when the tick reads it.
///
/// TIM5 is the clock of the time stamps, and captures itself at every edge of A and of B on
/// channels 1 and 4, so the later of the two captures is the time of the edge that the counter
/// counted last.
#ifndef STM_TIMERS_H
#define STM_TIMERS_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t

/// Set all five timers up. Encoders and clock run afterwards, the tick does not.
/// Context: slow side, once.
/// Source: RM0433 38.3, 39.3 (encoder interface, input capture, PWM), 39.4 (registers).
void stm_timers_init(void);

/// Start TIM4 and its interrupt. Context: slow side.
void stm_timers_start_tick(void);

/// Acknowledge the tick. Context: ISR, at its begin.
void stm_timers_tick_begin_isr(void);

/// @return whether the next tick is due already. Context: ISR, at its end.
bool stm_timers_is_overrun_isr(void);

/// @return whether a transfer that starts now would end after the outputs have stepped. Context:
/// ISR.
bool stm_timers_is_late_isr(void);

/// @return [counts] position of the U scale since start. Context: ISR, every tick.
int32_t stm_timers_u_counts_isr(void);

/// @return [counts] position of the Z scale since start. Context: ISR, every tick.
int32_t stm_timers_z_counts_isr(void);

#endif
