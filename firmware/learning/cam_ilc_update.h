// SPDX-License-Identifier: Apache-2.0
/// cam_ilc_update: learning update of one revolution, harmonic by harmonic. Private to cam_ilc.
/// Context of all functions: slow side.
#ifndef CAM_ILC_UPDATE_H
#define CAM_ILC_UPDATE_H

#include "cam_ilc.h" // cam_ilc_t
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t

enum {
    cam_ilc_update_most_halved = 4, ///< halvings of the gain after which layer 1 stops
    cam_ilc_words_per_bin = sizeof(cam_turn_bin_t) / sizeof(int32_t),
};

#define CAM_ILC_TURNS UINT32_C(0xFFFFFF) ///< turns are numbered modulo 2^24

/// Enter a phase.
void cam_ilc_update_phase(cam_ilc_t *t, cam_ilc_phase_t phase);

/// Restart the guards of both layers.
void cam_ilc_update_restart_guards(cam_ilc_t *t);

/// @return whether a speed differs from that of the learning by more than 2 %
bool cam_ilc_update_is_other_speed(const cam_ilc_t *t, int32_t speed_q32);

/// @return [nm / 64] error of a harmonic below which the guard does not compare: 3 sigma, or 1/1024
///         of the initial error, in the cut 1/16, where the cutting conditions drift
uint32_t cam_ilc_update_guarded_q6(const cam_ilc_t *t);

/// @return [2^-16] learning gain: the rehearsal's, also in the cut until some turns after the feed
///         has changed; then the cut's
int32_t cam_ilc_update_gain_q16(const cam_ilc_t *t, const cam_ilc_setup_t *s);

/// @return whether the turn is cut with a chip while its feed changes, or soon after
bool cam_ilc_update_is_rough(const cam_ilc_t *t);

/// @return whether layer 1 may learn from a turn: the learned harmonics hold most of U's motion, so
///         that the rest stays observed, and the motion is large for the scale
bool cam_ilc_update_is_for_drive(const cam_ilc_t *t);

/// Begin the update from the turn in t->bin: classify it and convert its sums to means.
void cam_ilc_update_begin(cam_ilc_t *t, const cam_ilc_setup_t *s, const cam_turn_t *turn);

/// Learn from harmonic t->k.
void cam_ilc_update_harmonic(cam_ilc_t *t, const cam_ilc_setup_t *s);

#endif
