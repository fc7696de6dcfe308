// SPDX-License-Identifier: Apache-2.0
/// cam_ilc_update: what one turn tells, harmonic by harmonic; a part of cam_ilc that others do not
/// call. Context of all functions: slow side.
#ifndef CAM_ILC_UPDATE_H
#define CAM_ILC_UPDATE_H

#include "cam_ilc.h" // cam_ilc_t
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t

/// Times that the guard strikes before layer 1 is given up.
enum { cam_ilc_update_most_halved = 4 };

/// Enter a phase.
void cam_ilc_update_phase(cam_ilc_t *t, cam_ilc_phase_t phase);

/// @return whether a speed is not that at which was learned
bool cam_ilc_update_is_other_speed(const cam_ilc_t *t, int32_t speed_q32);

/// @return [nm / 64] the error of a harmonic below which the guard does not compare: 3 sigma, but
///         not less than a small part of what there was before anything was learned. In the cut the
///         work itself changes, and that part is larger.
uint32_t cam_ilc_update_guarded_q6(const cam_ilc_t *t);

/// @return [2^-16] share of an error that a step removes: that of the rehearsal, and in the cut as
///         long as the feed changes and some turns more, else that of the cut
int32_t cam_ilc_update_gain_q16(const cam_ilc_t *t, const cam_ilc_setup_t *s);

/// @return whether a turn tells of the drive: the harmonics that are learned hold most of the
/// motion of
///         U, and it is large for its scale. Constants from less would move what nobody watches
bool cam_ilc_update_is_for_drive(const cam_ilc_t *t);

/// Decide what the turn in t->bin tells, and turn its sums into means.
void cam_ilc_update_begin(cam_ilc_t *t, const cam_ilc_setup_t *s, const cam_turn_t *turn);

/// Learn from harmonic t->k.
void cam_ilc_update_harmonic(cam_ilc_t *t, const cam_ilc_setup_t *s);

#endif
