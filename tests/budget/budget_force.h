// SPDX-License-Identifier: Apache-2.0
/// budget_force: ticks that are tried by force from where a session stands: with and without a plan
/// and an index edge, and with every cause of a fault. The session then goes on as if nothing had
/// been tried.
#ifndef BUDGET_FORCE_H
#define BUDGET_FORCE_H

#include "fixture_rig.h" // fixture_rig_t
#include <stdbool.h>     // bool

/// @return whether the tick that is being tried is several rare things at once
bool budget_force_is_combined(void);

/// Open a session for every state, bring it there, and try all ticks many times, also in the first
/// ticks of the fault state.
/// @param open  opens the session of the rig, off
/// @return      whether every state was reached
bool budget_force_states(fixture_rig_t *rig, void (*open)(void));

#endif
