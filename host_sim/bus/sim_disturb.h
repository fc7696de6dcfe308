// SPDX-License-Identifier: Apache-2.0
/// sim_disturb: disturbs the frames of one identifier, like a bad bus.
///
///     sent      a b c d e f g
///     missing   a b     e f g    2 at c        the frame is not sent
///     repeated  a b b b e f g    2 at c        the last one again instead
///     swapped   a b d c e f g    1 at c        after its successor
///     late      a b  c d e f g   at c          once, by a time
///
/// Only one disturbance is active: a new one replaces the rest of the old one.
#ifndef SIM_DISTURB_H
#define SIM_DISTURB_H

#include "sim_frame.h" // sim_frames_t
#include <stdbool.h>   // bool
#include <stdint.h>    // uint32_t

typedef enum {
    sim_disturb_none,
    sim_disturb_missing,
    sim_disturb_repeated,
    sim_disturb_swapped,
    sim_disturb_late
} sim_disturb_kind_t;

typedef struct {
    sim_disturb_kind_t kind;
    uint32_t n_left;  ///< frames still to be disturbed
    double late_s;    ///< [s] delay of a late frame
    sim_frame_t last; ///< the last frame sent
    bool has_last;
    sim_frame_t held; ///< waits for its time or for its successor
    bool is_held;
    double held_until_s;
} sim_disturb_t;

/// Start with the next frame.
/// @param n       frames; swapped: pairs
/// @param late_s  [s] sim_disturb_late only
void sim_disturb_begin(sim_disturb_t *d, sim_disturb_kind_t kind, uint32_t n, double late_s);

/// Disturb the frame in the queue that has the identifier.
/// @param t_s  [s] now
void sim_disturb_pass(sim_disturb_t *d, sim_frames_t *queue, uint32_t id, double t_s);

/// Take the late frame if it is due before a time. @return false when there is none
bool sim_disturb_due(sim_disturb_t *d, double before_s, sim_frame_t *frame, double *at_s);

#endif
