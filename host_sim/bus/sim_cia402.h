// SPDX-License-Identifier: Apache-2.0
/// sim_cia402: the power state machine of a drive, CiA 402-2, "Finite state automaton".
///
///     not ready -1-> switch on disabled -2-> ready to switch on -3-> switched on -4-> operation
///     enabled any -13-> fault reaction active -14 at rest-> fault -15 reset-> switch on disabled
///     operation enabled -11-> quick stop active -12 at rest-> switch on disabled
///
/// and the transitions back: 5 (disable operation), 6 and 8 (shutdown), 7, 9, 10 and 12 (disable
/// voltage; 7 and 10 by quick stop too), 16 (operation again out of a quick stop). A control word
/// takes one step; the master repeats it until the status word follows. Numbers are those of the
/// standard's figure.
#ifndef SIM_CIA402_H
#define SIM_CIA402_H

#include "cia402.h"  // cia402_state_t
#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

typedef struct {
    cia402_state_t state;
    bool is_reset_held; ///< bit 7 of the last control word: only a rising edge resets
} sim_cia402_t;

/// Switch the power on.
void sim_cia402_init(sim_cia402_t *d);

/// End the self-test: transition 1.
void sim_cia402_boot(sim_cia402_t *d);

/// Process a control word (6040h).
void sim_cia402_control(sim_cia402_t *d, uint32_t control_word);

/// The drive fails: transition 13. It brakes, then enters fault.
void sim_cia402_fail(sim_cia402_t *d);

/// The axis has come to rest: transitions 12 and 14.
void sim_cia402_rest(sim_cia402_t *d);

/// @return object 6041h: the state, voltage enabled (bit 4), remote (bit 9), and in operation
/// enabled "follows the command value" (bit 12)
uint32_t sim_cia402_status(const sim_cia402_t *d);

/// @return true when the axis follows its target
static inline bool sim_cia402_is_following(const sim_cia402_t *d)
{
    return d->state == cia402_operation_enabled;
}

/// @return true in fault and in the fault reaction before it
static inline bool sim_cia402_is_failed(const sim_cia402_t *d)
{
    return d->state == cia402_fault_reaction_active || d->state == cia402_fault;
}

#endif
