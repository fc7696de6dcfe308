// SPDX-License-Identifier: Apache-2.0
/// stm_timers: tick, encoders and clock: TIM1 to TIM5.
///
/// The spindle's counter is latched by hardware at both edges of the index pulse. The edge wanted
/// is the one that a positive rotation passes first: there the rising edge, and in the negative
/// sense, where the pulse is left at that very place, the falling one. The direction bit of the
/// counter chooses, as it stands when the tick reads it.
#ifndef STM_TIMERS_H
#define STM_TIMERS_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t

/// Set all five up; encoders and clock run, the tick does not. Context: slow side, once.
/// Source: RM0433 38.3, 39.3 (encoder interface, input capture, PWM), 39.4 (registers).
void stm_timers_init(void);

/// Let TIM4 run and interrupt. Context: slow side.
void stm_timers_start_tick(void);

/// Acknowledge the tick. Context: ISR, first thing.
void stm_timers_tick_begin_isr(void);

/// @return true when the next tick is due already. Context: ISR, last thing.
bool stm_timers_is_overrun_isr(void);

/// @return true when a transfer that starts now ends after the outputs' step. Context: ISR.
bool stm_timers_is_late_isr(void);

/// @return [counts] position of the U scale since start. Context: ISR, every tick.
int32_t stm_timers_u_counts_isr(void);

/// @return [counts] position of the Z scale since start. Context: ISR, every tick.
int32_t stm_timers_z_counts_isr(void);

#endif
