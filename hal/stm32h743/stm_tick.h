// SPDX-License-Identifier: Apache-2.0
/// stm_tick: the interrupt around cam_isr(), and its duration.
#ifndef STM_TICK_H
#define STM_TICK_H

#include <stdint.h> // uint32_t

/// The tick: handler of TIM4's interrupt. Context: ISR.
void stm_tick_isr(void);

/// Start the cycle counter. Context: slow side, once. Source: ARMv7-M ARM C1.8.
void stm_tick_init(void);

/// @return number of ticks since the start, wraps. Context: slow side.
uint32_t stm_tick_count(void);

#endif
