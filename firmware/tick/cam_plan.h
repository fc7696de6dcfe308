// SPDX-License-Identifier: Apache-2.0
/// cam_plan: what changes slowly in a cut, planned ahead by one task per tick.
///
/// A round of 21 ticks, 43 where the spindle is modulated: heights and envelopes, then the ways of
/// all axes to the planned instant, then the speed of the spindle, the state, and the place of Z.
/// The instant is the end of those ways, so between two rounds envelope, X and Z move linearly and
/// arrive exactly. In between they are off the true course by at most its second derivative times
/// (round)^2 / 8. Context: ISR.
#ifndef CAM_PLAN_H
#define CAM_PLAN_H

#include "cam_play.h"    // cam_play_t, cam_play_config_t
#include "cam_spindle.h" // cam_angle_t
#include "cam_state.h"   // cam_sense_t
#include <stdint.h>      // int32_t, int64_t

/// The task of this tick.
/// @return fault z_range or none
/// Constant time in each task.
CAM_STAGE uint32_t cam_plan_task_isr(cam_play_t *p, const cam_play_config_t *cfg,
                                     const cam_sense_t *in, const cam_angle_t *angle);

/// @param value  [LSB] of the channel x
/// @return       [nm / 1024] X where the tool tip lies on the long half axis
static inline int64_t cam_plan_profile_q10(const cam_channel_t *x, int32_t value)
{
    return ((int64_t)value * 1024 >> x->frac_bits) + (int64_t)x->offset_nm * 1024;
}

/// Nobody asks in the work whether a height was clamped.
static inline void cam_plan_keep_height(cam_height_t *kept, cam_height_t at)
{
    kept->i = at.i;
    kept->w_q31 = at.w_q31;
}

/// Quintic smooth step 10 s^3 - 15 s^4 + 6 s^5.
/// @param s_q31  [1 / 2^31] 0 .. 2^31 - 1
/// @return       [1 / 2^30] 0 .. 2^30, error below 2^-24
int32_t cam_plan_smooth_q30(int32_t s_q31);

#endif
