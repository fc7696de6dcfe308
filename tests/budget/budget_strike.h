// SPDX-License-Identifier: Apache-2.0
/// budget_strike: the faults that the host port can cause, by number. `bus` is judged with `drive`
/// by the same instructions.
#ifndef BUDGET_STRIKE_H
#define BUDGET_STRIKE_H

#include "hal_host.h" // hal_host_fault_estop

enum { budget_n_strikes = 6 };

/// @param fault  0 .. budget_n_strikes - 1
static inline void budget_strike(int fault)
{
    switch (fault) {
    case 0:
        hal_host_fault_estop(true);
        break;
    case 1:
        hal_host_fault_drive(true);
        break;
    case 2:
        hal_host_fault_counts(500);
        break;
    case 3:
        hal_host_fault_encoder_stuck(true);
        break;
    case 4:
        hal_host_fault_index_dead(true);
        break;
    default:
        hal_host_fault_late(300);
        break;
    }
}

#endif
