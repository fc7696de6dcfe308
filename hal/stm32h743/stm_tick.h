// SPDX-License-Identifier: Apache-2.0
/// stm_tick: the interrupt around cam_isr(), its duration, and what goes wrong in it.
#ifndef STM_TICK_H
#define STM_TICK_H

#include <stdint.h> // uint32_t

/// Faults of the port. Any of them makes hal_inputs_read_isr() report the drives as not ready,
/// until the next reset: the controller retracts, and does not start again.
enum {
    stm_fault_clock = 1u << 0,   ///< no HSE: rates are within 1 % only
    stm_fault_overrun = 1u << 1, ///< a tick was not over when the next was due
    stm_fault_late = 1u << 2,    ///< set-points were not sent when the outputs stepped
    stm_fault_dac = 1u << 3,     ///< a transfer to the AD5754R did not end within a period
};

/// Vector of TIM4. Context: ISR.
void stm_tick_isr(void);

/// Count cycles from now on. Context: slow side, once. Source: ARMv7-M ARM C1.8.
void stm_tick_init(void);

/// @return ticks since start, wraps. Context: slow side.
uint32_t stm_tick_count(void);

/// Latch a fault. Context: ISR, or the slow side before the tick runs.
void stm_tick_fault(uint32_t faults);

/// @return all faults since start. Context: any.
uint32_t stm_tick_faults(void);

#endif
