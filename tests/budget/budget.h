// SPDX-License-Identifier: Apache-2.0
/// budget: how many instructions a tick may take, whole interrupt, HAL of the host port included.
///
/// Exact counts on the emulated core (hal/mps2/README.md). They are what the compiler makes of the
/// firmware today; a change that needs more must raise a number here, in sight of the reviewer.
///
/// 12 instructions of each tick see pointers of which a bit has flipped before anything is written:
/// whether the last tick ended, whether configuration, controller and record are still those of
/// this one. Without them four times as many flips of a register move an axis wrongly
/// (tests/flips/README.md).
#ifndef BUDGET_H
#define BUDGET_H

/// Both cores: the compiler makes nearly the same of the firmware for either.
enum {
    budget_tick = 600,       ///< U plays the table: cutting, disengaging, holding; without the plan
    budget_moved = 792,      ///< U moves by time, within its jerk, or begins to: all other states,
                             ///< every fault, every request, without the plan
    budget_plan_tick = 2840, ///< ... with it
    budget_combined = 818,   ///< ... without it, a tick off its time, with a request and a fault
    budget_switched = 962,   ///< ... without it, with eight position switches that change
};

/// The slow side of learning: a piece of it, which a main loop waits for, and all of a turn, 2 ms
/// of a core of 480 MHz.
enum { budget_learn_piece = 60000, budget_learn_turn = 960000 };

/// Largest spread of a tick without the plan in the state cutting, per cent of the largest.
enum { budget_spread_percent = 25 };

#endif
