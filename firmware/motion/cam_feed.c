// SPDX-License-Identifier: Apache-2.0
#include "cam_motion.h"
#include "cam_fix.h" // CAM_TURN_Q32, cam_greater_u64, cam_root_u64

/// [1 / 2^32] one.
#define ONE_Q32 (UINT64_C(1) << 32)

/// [turn / 2^32] shortest ramp: a degree and a half.
#define LEAST_RAMP_Q32 (UINT32_C(1) << 24)

/// 1 mm/s2 in the unit of feed_speed2(): 10^6 nm/mm (60000 (r/min / 1000) per turn/s)^2 10^-4.
#define ONE_MM_PER_S2 UINT64_C(360000000000)

static uint64_t section_nm(uint32_t feed_nm)
{
    return cam_greater_u64(feed_nm, cam_feed_least_nm);
}

/// @return [nm * 10^4 (r/min / 1000)^2] feed n^2, rounded up, below 2^62
static uint64_t feed_speed2(uint32_t feed_nm, uint32_t speed_mrpm)
{
    const uint64_t speed2 = ((uint64_t)speed_mrpm * speed_mrpm + 9999u) / 10000u;
    return section_nm(feed_nm) * speed2;
}

/// r = (1 - sqrt(1 - 4 feed n^2 / a)) / 2; both sides of the quotient are scaled to 31 bits.
uint32_t cam_feed_ramp_q32(uint32_t feed_nm, uint32_t speed_mrpm, uint32_t acceleration_mm_per_s2)
{
    uint64_t part = feed_speed2(feed_nm, speed_mrpm);
    uint64_t whole = ONE_MM_PER_S2 * acceleration_mm_per_s2;
    while (whole >> 31 != 0u) {
        whole >>= 1;
        part = (part + 1u) >> 1;
    }
    if (4u * part >= whole) {
        return (uint32_t)(ONE_Q32 / 2u);
    }
    const uint64_t inner_q32 = ((whole - cam_greater_u64(4u * part, 1u)) << 32) / whole;
    const uint64_t ramp_q32 = (ONE_Q32 - cam_root_u64(inner_q32 << 32) + 1u) / 2u;
    return (uint32_t)cam_greater_u64(ramp_q32, LEAST_RAMP_Q32);
}

uint64_t cam_feed_speed_um_per_s(uint32_t feed_nm, uint32_t speed_mrpm, uint32_t ramp_q32)
{
    const uint64_t mean_nm_per_s = (section_nm(feed_nm) * speed_mrpm + 59999u) / 60000u;
    const uint64_t rest_q24 = (ONE_Q32 - ramp_q32) >> 8;
    return ((mean_nm_per_s << 24) / rest_q24 + 1000u) / 1000u;
}

uint64_t cam_feed_least_acceleration(uint32_t feed_nm, uint32_t speed_mrpm)
{
    const uint64_t per = ONE_MM_PER_S2 / 4u;
    return (feed_speed2(feed_nm, speed_mrpm) + per - 1u) / per;
}

cam_rings_t cam_feed_rings(uint32_t feed_nm, int32_t span_nm, uint32_t speed_mrpm,
                           uint32_t acceleration_mm_per_s2)
{
    const uint32_t ramp_q32 = cam_feed_ramp_q32(feed_nm, speed_mrpm, acceleration_mm_per_s2);
    return (cam_rings_t){
        .is_on = true,
        .ramp_q32 = ramp_q32,
        .per_ramp_q24 = (uint32_t)(((UINT64_C(1) << 56) - 1u) / ramp_q32),
        .per_rest_q30 = (uint32_t)((UINT64_C(1) << 62) / (ONE_Q32 - ramp_q32)),
        .feed_nm = (int32_t)section_nm(feed_nm),
        .span_nm = span_nm,
    };
}

int64_t cam_feed_turns_q32(const cam_rings_t *rings)
{
    const int64_t steps = ((int64_t)rings->span_nm + rings->feed_nm - 1) / rings->feed_nm;
    return (2 * steps + 1) * CAM_TURN_Q32;
}

/// Both halves of a helix turn are symmetric, so it is evaluated from the nearer end.
/// @return [1 / 2^30] completed share of the step to the next ring, 0 on a ring
static uint32_t risen_q30_of(const cam_rings_t *rings, int64_t done_q32)
{
    if (((uint64_t)done_q32 & ONE_Q32) == 0u) {
        return 0;
    }
    const uint32_t share_q32 = (uint32_t)(uint64_t)done_q32;
    const bool is_first_half = share_q32 <= UINT32_C(1) << 31;
    const uint32_t near_q32 = is_first_half ? share_q32 : 0u - share_q32;
    uint32_t eased_q32 = near_q32 - rings->ramp_q32 / 2u;
    if (near_q32 < rings->ramp_q32) {
        const uint32_t part_q32 = (uint32_t)(((uint64_t)near_q32 * rings->per_ramp_q24) >> 24);
        eased_q32 = cam_mulhi_u32(near_q32, part_q32) / 2u;
    }
    const uint32_t fed_q30 = cam_mulhi_u32(eased_q32, rings->per_rest_q30);
    return is_first_half ? fed_q30 : (UINT32_C(1) << 30) - fed_q30;
}

int32_t cam_feed_height_nm_isr(const cam_rings_t *rings, int64_t done_q32)
{
    const int64_t fed_nm = (done_q32 >> 33) * rings->feed_nm;
    const int32_t ring_nm = (int32_t)cam_clamp_i64(fed_nm, 0, rings->span_nm);
    const int32_t step_nm = cam_clamp_i32(rings->span_nm - ring_nm, 0, rings->feed_nm);
    const uint64_t fed_q30 =
        (uint64_t)risen_q30_of(rings, done_q32) * (uint32_t)step_nm + (UINT32_C(1) << 29);
    return ring_nm + (int32_t)(fed_q30 >> 30);
}
