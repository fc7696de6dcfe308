// SPDX-License-Identifier: Apache-2.0
/// cam_lesson: what one turn tells, harmonic by harmonic; a part of cam_teach that others do not
/// call. Context of all functions: slow side.
#ifndef CAM_LESSON_H
#define CAM_LESSON_H

#include "cam_teach.h" // cam_teach_t
#include <stdbool.h>   // bool
#include <stdint.h>    // int32_t

/// Times that the guard strikes before layer 1 is given up.
enum { cam_lesson_most_halved = 4 };

/// Enter a phase.
void cam_lesson_phase(cam_teach_t *t, cam_teach_phase_t phase);

/// @return whether a speed is not that at which was learned
bool cam_lesson_is_other_speed(const cam_teach_t *t, int32_t speed_q32);

/// @return [nm / 64] the error of a harmonic below which the guard does not compare: 3 sigma, but
///         not less than a small part of what there was before anything was learned. In the cut the
///         work itself changes, and that part is larger.
uint32_t cam_lesson_guarded_q6(const cam_teach_t *t);

/// @return [2^-16] share of an error that a step removes: that of the rehearsal, and in the cut as
///         long as the feed changes and some turns more, else that of the cut
int32_t cam_lesson_gain_q16(const cam_teach_t *t, const cam_teach_setup_t *s);

/// @return whether a turn tells of the drive: the harmonics that are learned hold most of the
/// motion of
///         U, and it is large for its scale. Constants from less would move what nobody watches
bool cam_lesson_tells_drive(const cam_teach_t *t);

/// Decide what the turn in t->bin tells, and turn its sums into means.
void cam_lesson_open(cam_teach_t *t, const cam_teach_setup_t *s, const cam_turn_t *turn);

/// Learn from harmonic t->k.
void cam_lesson_harmonic(cam_teach_t *t, const cam_teach_setup_t *s);

#endif
