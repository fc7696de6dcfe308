// SPDX-License-Identifier: Apache-2.0
/// cam_angle: binary angles and master positions, inline, for both sides.
///
/// An angle is `theta_q32`: uint32, 2^32 = one turn, so that it wraps by design; a quarter turn is
/// 0x40000000. A master position is `pos_q32`: int64, Q32.32 turns since the index was found,
/// rising while the spindle turns in the sense of cutting. It cannot overflow in practice: 2^31
/// turns at 3000 r/min last 497 days, and every homing restarts the count. Context of all
/// functions: ISR or slow side, constant time.
#ifndef CAM_ANGLE_H
#define CAM_ANGLE_H

#include <stdint.h> // int64_t, uint32_t

/// 2 pi * 2^24
#define CAM_TWO_PI_Q24 INT64_C(105414357)

/// One turn of a master position.
#define CAM_TURN_Q32 ((int64_t)1 << 32)

/// @return [turn / 2^32] the angle within the turn of a master position
static inline uint32_t cam_angle_of_pos(int64_t pos_q32)
{
    return (uint32_t)((uint64_t)pos_q32);
}

/// @return [turn, Q32.32] the first whole turn at or after pos_q32
static inline int64_t cam_angle_next_turn(int64_t pos_q32)
{
    return (int64_t)(((uint64_t)pos_q32 + (uint64_t)(CAM_TURN_Q32 - 1)) &
                     ~(uint64_t)(CAM_TURN_Q32 - 1));
}

#endif
