// SPDX-License-Identifier: Apache-2.0
/// fuzz_orders: what the operator, the machine and bad luck do to the rig in a session, for every
/// target whose input is one.
#ifndef FUZZ_ORDERS_H
#define FUZZ_ORDERS_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t

/// Of fuzz_disturb().
enum {
    fuzz_disturb_estop,
    fuzz_disturb_drive,
    fuzz_disturb_bus,
    fuzz_disturb_button = 11, ///< as it comes
    fuzz_disturb_press,       ///< as it is meant
    fuzz_disturb_key,
    fuzz_disturb_mend, ///< all is mended
};

/// A session begins, of so many ticks at most.
void fuzz_orders_begin(uint32_t most_ticks);

/// @return whether ticks are left
bool fuzz_orders_has_time(void);

/// Let n ticks pass, or as many as are left.
void fuzz_let_pass(uint32_t n);

/// A command of the operator.
/// @param what   which, and of which axis
/// @param value  [um/s] of a jog, [nm / 128] of a step, [nm / 256] of a place
void fuzz_command(uint8_t what, int32_t value);

/// The command that a good operator gives most often in the present state.
void fuzz_usual(int32_t value);

/// A fault of the machine, a press, or the end of all faults.
void fuzz_disturb(uint8_t what, uint16_t code);

#endif
