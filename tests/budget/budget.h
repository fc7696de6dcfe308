// SPDX-License-Identifier: Apache-2.0
/// budget: how many instructions a tick may take, whole interrupt, HAL of the host port included.
///
/// Exact counts on the emulated core (hal/mps2/README.md). They are what the compiler makes of the
/// firmware today; a change that needs more must raise a number here, in sight of the reviewer.
#ifndef BUDGET_H
#define BUDGET_H

#ifdef __ARM_ARCH_7EM__
#if __ARM_FP & 8 // a double-precision unit: Cortex-M7
enum { budget_uniform = 2450, budget_modulated = 2810, budget_idle = 1540 };
#else // Cortex-M4
enum { budget_uniform = 2500, budget_modulated = 2870, budget_idle = 1580 };
#endif
#endif

/// Largest spread of a tick in the state cutting, per cent of the largest.
enum { budget_spread_percent = 25 };

#endif
