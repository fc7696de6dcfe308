// SPDX-License-Identifier: Apache-2.0
/// cam_feed_profile: the feed as a function of height: the lead of Z over a plain helix.
///
///     Z = z + way(z),  z the height of the plain helix after the same number of turns
///
/// way is 0 at both ends of the table, and 1 + dway/dz, the feed over its mean, is positive, so
/// that Z never reverses. With stations z counts the turns, Z stands at each lobe while X feeds in,
/// and Z ends at the last lobe. Source: TABLE_FORMAT.md, "Way" and "Stations"; MATHS.md (103),
/// (104). Context: cam_feed_profile_at(): ISR or slow side, constant time; all others: slow side.
#ifndef CAM_FEED_PROFILE_H
#define CAM_FEED_PROFILE_H

#include "cam_channel.h" // cam_table_t
#include "cam_err.h"     // cam_err_t
#include "cam_eval.h"    // cam_eval_profile
#include "cam_fix.h"     // cam_wrap_add
#include <stdint.h>      // int32_t

/// Position and feed on the profile.
typedef struct {
    int32_t z_nm;      ///< [nm] height of Z
    int32_t slope_q16; ///< [1 / 2^16] feed over its mean
} cam_feed_profile_t;

/// @param table  with a way
/// @param z_nm   [nm] height of the plain helix
/// @return       Z with an error below 1 nm; its feed is below 2^14 times the mean
static inline cam_feed_profile_t cam_feed_profile_at(const cam_table_t *table, int32_t z_nm)
{
    const cam_channel_t *way = &table->way;
    const cam_value_t ahead = cam_eval_profile(way, z_nm);
    const int32_t half = (int32_t)((UINT32_C(1) << way->frac_bits) >> 1);
    const int64_t slope_q16 =
        ((int64_t)ahead.d1 * way->slices_per_nm_q48) >> (32u + way->frac_bits);
    return (cam_feed_profile_t){
        .z_nm = cam_wrap_add(z_nm, ((ahead.y + half) >> way->frac_bits) + way->value_offset),
        .slope_q16 = cam_sat_i32(slope_q16 + 65536),
    };
}

/// @return [nm] Z at the end of the table
static inline int32_t cam_feed_profile_z_last_nm(const cam_table_t *t)
{
    return t->has_stations ? cam_feed_profile_at(t, t->z_last_nm).z_nm : t->z_last_nm;
}

/// Check that a way begins and ends with 0 and that Z rises everywhere (with stations: never
/// falls), and fill in way_slope_ppm and way_bend_ppm_per_m, those of a plain helix without a way.
/// Four evaluations per knot.
/// @return cam_ok or cam_err_image_channel
CAM_MUST_USE cam_err_t cam_feed_profile_check(cam_table_t *table);

#endif
