// SPDX-License-Identifier: Apache-2.0
/// budget: how many instructions a tick may take, whole interrupt, HAL of the host port included.
///
/// Exact counts on the emulated core (hal/mps2/README.md). The limits protect the period: a tick of
/// 50 us on a core of 480 MHz. The tests print every count, and budget.figures prints how far the
/// largest ones moved from the recorded figures, so that growth is seen in review.
#ifndef BUDGET_H
#define BUDGET_H

enum {
    budget_tick_in_cut = 600,      ///< U plays the table, without the plan
    budget_tick_with_force = 980,  ///< ... with the position loop of U and its supervision
    budget_sense_with_force = 490, ///< from the latch of U's scale to the end of its supervision
    budget_tick = 2600,            ///< any tick, with its plan
};

/// The slow side: a piece of learning, which a main loop waits for, all of a turn, 2 ms of a core
/// of 480 MHz, and a feasibility check. Without a unit for doubles software calculates.
enum { budget_learn_piece = 75000 };
#if defined(__ARM_FP) && (__ARM_FP & 8)
enum { budget_learn_turn = 1050000, budget_feasibility_check = 6000 };
#else
enum { budget_learn_turn = 1250000, budget_feasibility_check = 80000 };
#endif

/// A step of the position loop of a force drive.
enum { budget_servo_step = 174 };

/// Largest spread of a tick without the plan in the state cutting, per cent of the largest.
enum { budget_spread_percent = 25 };

#endif
