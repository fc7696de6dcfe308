// SPDX-License-Identifier: Apache-2.0
/// stm_steps: set-points of U, X and Z as step and direction, by TIM8, TIM16 and TIM17.
///
/// A set-point is a whole number of steps. Each tick sends the difference between the set-point and
/// the steps sent so far as a train of equal periods: the timer runs in one-pulse mode, and its
/// repetition counter stops it after the last pulse. Steps that do not fit in a tick follow later,
/// so the sum of all pulses always reaches the set-point:
///
///     tick        |___________________________|___________________________|
///     step        ____,--,__,--,__,--,_____________,---,____,---,__________
///                     <---- 3/4 of a tick --->
///     direction   constant from a whole tick before the first step of a train to its end
///
/// - A train has at most stm_steps_most steps; the rest follow in the next ticks.
/// - A train still running when the next one is due continues, and the next tick sends the rest.
/// - A tick that reverses the direction sends only the new direction.
/// - While enable is low no steps are sent, and set-points count as sent: a disabled drive does not
///   count steps and must not move when it is enabled.
/// Source: RM0433 38.3, 41.3 (repetition counter, one-pulse mode), 41.4 (registers); ST AN4776,
/// "N-pulse waveform generation".
#ifndef STM_STEPS_H
#define STM_STEPS_H

#include "board_config.h" // BOARD_TICK_HZ, BOARD_STEP_HIGH_NS
#include "stm_clock.h"    // stm_timer_hz
#include <stdbool.h>      // bool
#include <stdint.h>       // int32_t

/// Axes with step outputs.
enum { stm_step_x, stm_step_z, stm_step_u, stm_n_steppers };

/// [1 / stm_timer_hz] length of a train, high time of a step, shortest period.
enum {
    stm_steps_train = stm_timer_hz / BOARD_TICK_HZ * 3 / 4,
    stm_steps_high = stm_timer_hz / 1000000 * BOARD_STEP_HIGH_NS / 1000,
    stm_steps_period = stm_timer_hz / 1000000 * (BOARD_STEP_HIGH_NS + BOARD_STEP_LOW_NS) / 1000,
};

/// Steps that fit in a train.
enum { stm_steps_most = stm_steps_train / stm_steps_period };

/// @return [um/s] highest speed of an output. Rounding to whole steps takes one step per tick in
/// addition to those of the motion.
/// @param step_pm  [pm] of a step
static inline int32_t stm_steps_um_per_s(int32_t step_pm)
{
    const int64_t pm_per_s = (int64_t)step_pm * (stm_steps_most - 1) * BOARD_TICK_HZ;
    return (int32_t)(pm_per_s / 1000000 < INT32_MAX ? pm_per_s / 1000000 : INT32_MAX);
}

/// Set the timers up with their outputs low. Context: slow side, once, before the pins.
void stm_steps_init(void);

/// Set the set-point of an axis. Context: ISR.
/// @param stepper  stm_step_x, stm_step_z, stm_step_u
/// @param steps    [steps] any
void stm_steps_set_isr(uint32_t stepper, int32_t steps);

/// @return [steps] commanded position: steps sent, or set-points while off. Context: ISR.
int32_t stm_steps_sent_isr(uint32_t stepper);

/// Set whether the drives are enabled. Context: ISR.
void stm_steps_enable_isr(bool is_enabled);

/// Start the trains of this tick. Context: ISR, after the last set-point.
void stm_steps_send_isr(void);

#endif
