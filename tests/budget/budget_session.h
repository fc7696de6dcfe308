// SPDX-License-Identifier: Apache-2.0
/// budget_session: what is counted: cuts and faults in the cut, and the spread of their ticks.
///
/// The same calls make the same ticks, whichever program counts them.
#ifndef BUDGET_SESSION_H
#define BUDGET_SESSION_H

#include "fixture_rig.h" // fixture_rig_t, fixture_part_t, cam_n_states
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t

/// Instructions of n ticks; min and max have no meaning while n is 0.
typedef struct {
    uint32_t min, max, n;
    uint64_t sum;
} budget_spread_t;

void budget_spread_add(budget_spread_t *s, uint32_t n_instructions);

/// @return mean, rounded; 0 of no ticks
uint32_t budget_spread_mean(const budget_spread_t *s);

/// A line per state that has ticks.
/// @param what  of the ticks
void budget_spread_print(const char *session, const char *what,
                         const budget_spread_t ticks[cam_n_states]);

/// Set a machine up for a part, off.
/// @param isr  called instead of cam_isr()
/// @return true when all parameters were taken
bool budget_session_open(fixture_rig_t *rig, void (*isr)(void), const fixture_part_t *part);

/// The same with a part that swings the tool, at 2000 r/min, with all of the swing's parameters.
bool budget_session_swung(fixture_rig_t *rig, void (*isr)(void), const fixture_part_t *part);

/// The same part with a feed against the height and two passes: all that a skirt can hold.
bool budget_session_way(fixture_rig_t *rig, void (*isr)(void));

/// Open the session of a shaft: three patterns, with the speed ratio and a tool that swings.
bool budget_session_shaft(fixture_rig_t *rig, void (*isr)(void));

/// From off through the cut to ready. @return true when it ended without a fault
bool budget_session_cut(fixture_rig_t *rig, void (*isr)(void), const fixture_part_t *part);

/// The same where U takes forces.
bool budget_session_force(fixture_rig_t *rig, void (*isr)(void), const fixture_part_t *part);

/// From off through a rehearsal and the cut behind it to ready. @return true when it ended so
bool budget_session_rehearse(fixture_rig_t *rig, void (*isr)(void));

/// From off into a cut that is held, goes on and is stopped, to ready. @return true when it ended
/// so
bool budget_session_hold(fixture_rig_t *rig, void (*isr)(void));

/// Every fault that the host port can cause, in modulated cuts, with the retract behind it.
/// @return true when each led to the fault state
bool budget_session_faults(fixture_rig_t *rig, void (*isr)(void));

/// From off through an excitation of U to ready. @return true when it was played to its end
bool budget_session_identify(fixture_rig_t *rig, void (*isr)(void));

/// From off to manual: axes are jogged and stepped, U, X and Z homed, then off again. @return true
/// when all homes were found
bool budget_session_hand(fixture_rig_t *rig, void (*isr)(void));

#endif
