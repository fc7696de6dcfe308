// SPDX-License-Identifier: Apache-2.0
/// fuzz_orders: what the operator, the machine and bad luck do to the rig in a session, for every
/// target whose input is one.
#ifndef FUZZ_ORDERS_H
#define FUZZ_ORDERS_H

#include "fuzz_bytes.h" // fuzz_bytes_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t

/// An order of a session, four bytes of the input, so that what the mutator adds or takes away
/// leaves the others what they were.
typedef struct {
    uint8_t what; ///< modulo 8 the kind; bits 3 and 4: ticks behind it
    uint8_t which;
    uint16_t code;
} fuzz_order_t;

enum { fuzz_order_bytes = 4 };

/// Kinds of orders that are the same in every session: ticks pass; by hand somebody lives.
enum { fuzz_order_pause, fuzz_order_alive = 7 };

/// Of fuzz_disturb().
enum {
    fuzz_disturb_estop,
    fuzz_disturb_drive,
    fuzz_disturb_bus,
    fuzz_disturb_late,
    fuzz_disturb_counts, ///< of the encoder jump
    fuzz_disturb_stuck,  ///< the encoder stands
    fuzz_disturb_no_index,
    fuzz_disturb_held,        ///< the spindle keeps its speed
    fuzz_disturb_speed,       ///< of the spindle is held
    fuzz_disturb_button = 11, ///< as it comes
    fuzz_disturb_press,       ///< as it is meant
    fuzz_disturb_key,
    fuzz_disturb_mend, ///< all is mended
};

/// Play the orders of an input, in so many ticks at most.
/// @param other  carries out the kinds that are the target's own
void fuzz_orders_play(fuzz_bytes_t *b, uint32_t most_ticks, void (*other)(fuzz_order_t));

/// @return whether ticks of the session are left
bool fuzz_orders_has_time(void);

/// Let n ticks of the session pass, or as many as are left.
void fuzz_let_pass(uint32_t n);

/// Let n ticks pass, with rare rounds of the main loop.
void fuzz_ticks(uint32_t n);

/// A command of the operator.
/// @param what   which, and of which axis
/// @param value  [um/s] of a jog, [nm / 128] of a step, [nm / 256] of a place
void fuzz_command(uint8_t what, int32_t value);

/// The command that a good operator gives most often in the present state.
void fuzz_usual(int32_t value);

/// A fault of the machine, a press, or the end of all faults.
void fuzz_disturb(uint8_t what, uint16_t code);

#endif
