// SPDX-License-Identifier: Apache-2.0
/// stm_tick: the interrupt around cam_isr(), its duration, and the port's own faults.
#ifndef STM_TICK_H
#define STM_TICK_H

#include <stdint.h> // uint32_t

/// Faults of the port. With any of them hal_inputs_read_isr() reports the drives as not ready until
/// the next reset, so the controller retracts and does not restart.
enum {
    stm_fault_clock = 1u << 0,   ///< the HSE did not start: rates are within 1 % only
    stm_fault_overrun = 1u << 1, ///< a tick had not ended when the next one was due
    stm_fault_late = 1u << 2,    ///< set-points were not yet sent when the outputs stepped
    stm_fault_dac = 1u << 3,     ///< a transfer to the AD5754R did not end within a period
    stm_fault_edges = 1u << 4,   ///< edges of the spindle were counted, but not stamped
};

/// The tick: handler of TIM4's interrupt. Context: ISR.
void stm_tick_isr(void);

/// Start the cycle counter. Context: slow side, once. Source: ARMv7-M ARM C1.8.
void stm_tick_init(void);

/// @return number of ticks since the start, wraps. Context: slow side.
uint32_t stm_tick_count(void);

/// Latch faults.
/// @param faults  bits stm_fault_*
/// Context: ISR, or the slow side before the tick runs.
void stm_tick_fault(uint32_t faults);

/// @return bits stm_fault_* of all faults since the start. Context: any.
uint32_t stm_tick_faults(void);

#endif
