// SPDX-License-Identifier: Apache-2.0
/// cam_feed_motion: feed over the turns of a cut, with override and hold.
///
/// The feed rate, 1 as programmed, ramps by 1 per `feed_ramp_turns` turns: from rest to the
/// override, from one override to the next, and to rest for the end, a hold or a stop. Ramps never
/// overlap, so Z never accelerates more than in the plain cut, whatever the override; only a stop
/// brakes within `stop_ramp_q32`. A change of the rate
///
///     from .. to    rate -> to_rate     parabola of what is fed
///     .. brake      to_rate             straight line
///     brake .. end  to_rate -> 0        parabola
///
/// is scheduled at master positions that are not yet commanded. The feed at any position follows
/// exactly from these numbers alone. A new rate waits until a ramp has ended, but a hold is
/// scheduled at once and brakes after the ramp; the ramp at the end of the part is final. The feed
/// comes to rest at a whole turn.
///
/// A ring-helix has no other rate than its own: it rests at the begin of a ring, for whole turns,
/// and continues with that ring. Source: MATHS.md (175) .. (177). Context: ISR, constant time.
#ifndef CAM_FEED_MOTION_H
#define CAM_FEED_MOTION_H

#include "cam_config.h" // cam_play_config_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t

/// State, made by cam_feed_motion_begin_isr().
typedef struct {
    int64_t from_q32, to_q32;    ///< [turn] master positions of the change of rate; rings: begin of
                                 ///< the first ring, and end of the rest
    int64_t fed_q32, fed_to_q32; ///< [turn] feed at these
    int64_t brake_q32, end_q32;  ///< [turn] master positions at which the feed brakes and rests
    int64_t fed_end_q32;         ///< [turn] feed at the end
    int32_t rate_q30;            ///< [1] before the change
    int32_t to_rate_q30;         ///< [1] after it
    uint32_t per_brake_q31;      ///< [1/turn] fall of the rate in the brake
    int32_t requested_q30;       ///< [1] last request carried out
    bool is_held;                ///< the rest is a hold, not the end of the part
} cam_feed_motion_t;

/// Schedule the feed of a whole part at the rate of the configuration, or at a lower one if the
/// part is too short for its ramps.
/// @param at_q32  [turn] master position where the feed begins, a whole turn
void cam_feed_motion_begin_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t at_q32);

/// @return [nm] Z above the first height at a master position, 0 .. height of the part
int32_t cam_feed_motion_fed_nm_isr(const cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                   int64_t pos_q32);

/// Apply the rate of the configuration if it has changed. Called in every plan: during a ramp a new
/// rate stays pending.
/// @param now_q32   [turn] master position; earlier positions are never read again
/// @param next_q32  [turn] first whole turn that is not yet commanded
void cam_feed_motion_request_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t now_q32, int64_t next_q32);

/// End the feed early. A moving feed ends its present ramp and brakes as steeply as Z and X can; a
/// ring-helix continues to the end of the next ring; a feed that has not begun never begins.
/// @param next_q32  as for cam_feed_motion_request_isr()
/// @return          [turn] where Z rests, at next_q32 or later
int64_t cam_feed_motion_stop_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t next_q32);

#endif
