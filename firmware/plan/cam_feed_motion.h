// SPDX-License-Identifier: Apache-2.0
/// cam_feed_motion: how far the feed has come over the turns of a cut, with override and hold.
///
/// The rate of the feed, 1 as programmed, changes by 1 over `feed_ramp_turns`: from rest to the
/// override at the beginning, from one override to the next, and to rest at the end, for a hold and
/// for a stop. One ramp follows another and never lies over it, so that Z never accelerates more
/// than in the ramp of the plain cut, whatever the override. In the course a change of the rate
///
///     from .. to    rate -> to_rate     parabola of what is fed
///     .. brake      to_rate             straight line
///     brake .. end  to_rate -> 0        parabola
///
/// is laid ahead, onto master positions that no axis was commanded to, and what is fed at a
/// position is calculated from these numbers alone: exactly, wherever a plan or a lead reads it.
/// What is asked while a ramp runs waits for its end, which of the ramp to the end of the part is
/// the end of the cut. A feed that is to rest does so on a whole turn.
///
/// A ring-helix knows only rest and its own rate: it rests where a ring begins, for whole turns,
/// and goes on with that ring. Source: MATHS.md (175) .. (177). Context: ISR, constant time.
#ifndef CAM_FEED_MOTION_H
#define CAM_FEED_MOTION_H

#include "cam_config.h" // cam_play_config_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t

/// State, made by cam_feed_motion_begin_isr().
typedef struct {
    int64_t from_q32, to_q32;    ///< [turn] master positions of the change of the rate; rings lie
                                 ///< from the first on, and Z rests until the second
    int64_t fed_q32, fed_to_q32; ///< [turn] fed at these
    int64_t brake_q32, end_q32;  ///< [turn] master positions where the feed slows down and rests
    int64_t fed_end_q32;         ///< [turn] fed there
    int32_t rate_q30;            ///< [1] before the change
    int32_t to_rate_q30;         ///< [1] and after it
    int32_t requested_q30;       ///< [1] the rate that was carried out last
    bool is_held;                ///< the rest at the end is no end of the part
} cam_feed_motion_t;

/// Lay the course of a whole part, at the rate that the configuration asks for.
/// @param at_q32  [turn] master position where the feed begins, a whole turn
void cam_feed_motion_begin_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t at_q32);

/// @return [nm] Z above the first height at a master position, 0 .. height of the part
int32_t cam_feed_motion_fed_nm_isr(const cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                   int64_t pos_q32);

/// Carry out what the configuration asks for, if it differs from what is in force and no ramp runs.
/// @param now_q32   [turn] master position; nothing before it is read any more
/// @param next_q32  [turn] first whole turn that no axis was commanded to
void cam_feed_motion_request_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t now_q32, int64_t next_q32);

/// End the feed early. A feed in motion slows down, behind the ramp that runs; a ring-helix goes on
/// to the end of the next ring, and a feed that has not begun does not begin.
/// @param next_q32  as of cam_feed_motion_request_isr()
/// @return          [turn] where Z rests, at next_q32 or later
int64_t cam_feed_motion_stop_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t next_q32);

#endif
