// SPDX-License-Identifier: Apache-2.0
/// cam_feed: Z over the turns of a ring-helix.
///
/// One closed ring per section of the drawing, then one turn of helix to the next section. Sections
/// are one feed apart; the last step is the remainder of the height. m rings take 2 m - 1 turns. In
/// a helix turn Z's speed is a trapezoid: it rises over the share r of the turn, stays at
/// feed n / (1 - r) at n turns per second, and falls over r, with acceleration
/// feed n^2 / (r (1 - r)). r is the smallest value that the acceleration allows, at least 1/256.
/// Source: MATHS.md (40) .. (42); the generator's path.py has the same law. Context: ISR for
/// cam_feed_ring_end_q32() and the functions ending in _isr, slow side for all others.
#ifndef CAM_FEED_H
#define CAM_FEED_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, int64_t, uint32_t

enum {
    cam_feed_least_nm = 4, ///< [nm] least distance of sections: the turns of any part fit 30 bits
};

/// A ring-helix, made by cam_feed_rings().
typedef struct {
    bool is_on;            ///< false: Z follows a plain helix, or is measured
    uint32_t ramp_q32;     ///< [turn] r, 1/256 .. 1/2
    uint32_t per_ramp_q24; ///< [1/turn] its reciprocal
    uint32_t per_rest_q30; ///< [1] 1 / (1 - r)
    int32_t feed_nm;       ///< [nm] distance of the sections
    int32_t span_nm;       ///< [nm] from the first ring to the last
} cam_rings_t;

/// @param feed_nm                 [nm] 1 .. 10^7, at least cam_feed_least_nm is taken
/// @param speed_mrpm              [r/min / 1000] up to 6 * 10^7
/// @param acceleration_mm_per_s2  [mm/s2] of Z, 10 .. 10^6
/// @return  [turn / 2^32] shortest ramp, at most 2^-28 turn too long below 0.49, at most 1/2
uint32_t cam_feed_ramp_q32(uint32_t feed_nm, uint32_t speed_mrpm, uint32_t acceleration_mm_per_s2);

/// @return [um/s] highest speed of Z with that ramp, rounded up
uint64_t cam_feed_speed_um_per_s(uint32_t feed_nm, uint32_t speed_mrpm, uint32_t ramp_q32);

/// @return [mm/s2] least that any ramp needs, 4 feed n^2, rounded up
uint64_t cam_feed_least_acceleration(uint32_t feed_nm, uint32_t speed_mrpm);

/// @param span_nm  [nm] height of the part, 1 .. 2 * 10^9
/// @return a ring-helix; other parameters as of cam_feed_ramp_q32()
cam_rings_t cam_feed_rings(uint32_t feed_nm, int32_t span_nm, uint32_t speed_mrpm,
                           uint32_t acceleration_mm_per_s2);

/// @return [turn / 2^32] length: 2 m - 1 turns, below 2^62
int64_t cam_feed_turns_q32(const cam_rings_t *rings);

/// Completed share of the step to the next ring.
/// @param done_q32  [turn / 2^32] since the first ring began, 0 .. the length
/// @return          [1 / 2^30] 0 .. 2^30, 0 on a ring; error below 2^-26
uint32_t cam_feed_risen_q30_isr(const cam_rings_t *rings, int64_t done_q32);

/// @param risen_q30  of the same instant
/// @return           [nm] Z above the first ring, 0 .. span, rounded to nearest
int32_t cam_feed_height_nm_isr(const cam_rings_t *rings, int64_t done_q32, uint32_t risen_q30);

/// A path that ends early still ends with a closed ring: the present one, or that after the helix.
/// @param done_q32  [turn / 2^32] whole turns, above 0
/// @return          [turn / 2^32] length of such a path, at most a turn more
static inline int64_t cam_feed_ring_end_q32(int64_t done_q32)
{
    return (int64_t)((uint64_t)done_q32 | UINT64_C(1) << 32);
}

#endif
