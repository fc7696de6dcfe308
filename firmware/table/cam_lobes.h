// SPDX-License-Identifier: Apache-2.0
/// cam_lobes: the lobes of a shaft, each of which plays a pattern that it may share with others.
///
/// In such a table a slice is no height but the pattern of a profile, in a frame of its own. At a
/// height there is one lobe, the nearest: its pattern is played, turned by its phase. From 20 um
/// behind the edge of a lobe on the lift falls by a smooth step and is 0 in the middle of the gap,
/// where the next lobe takes over. Source: TABLE_FORMAT.md, "Lobes". Context: ISR or slow side
/// unless noted, constant time, cannot fail.
#ifndef CAM_LOBES_H
#define CAM_LOBES_H

#include "cam_channel.h" // cam_table_t, cam_lobe_t
#include "cam_entry.h"   // cam_entry_t
#include "cam_eval.h"    // cam_height_t
#include <stdint.h>      // int32_t, uint32_t

enum {
    cam_lobes_least_gap_nm = 200000, ///< [nm] between two lobes
    cam_lobes_kept_off_nm = 20000,   ///< [nm] beside a lobe its lift is whole
    cam_lobes_search_steps = 6,      ///< halvings that find one of 64
};

/// Check the entry and the directory, and describe it in the table: lobes, n_lobes,
/// least_change_nm. The patterns that it names are checked by cam_lobes_check_patterns(), when all
/// channels are known.
/// @param used  [bytes] end of what lies before in the image; moved behind this channel
/// Context: slow side.
CAM_MUST_USE cam_err_t cam_lobes_check(const cam_entry_t *e, const cam_entry_place_t *in,
                                       uint64_t *used, cam_table_t *table);

/// Check that every pattern is there, in all channels over angle alike.
/// Context: slow side.
CAM_MUST_USE cam_err_t cam_lobes_check_patterns(const cam_table_t *table);

/// @param t     with lobes
/// @param z_nm  [nm] any value
/// @return      the lobe that is played there
uint32_t cam_lobes_find(const cam_table_t *t, int32_t z_nm);

/// @param i     a lobe
/// @param z_nm  [nm] any value
/// @return      [1 / 2^31] how far the change to the next lobe, or from the one before, has come: 0
///              on the lobe, 2^31 - 1 from the middle of the gap on
int32_t cam_lobes_change_q31(const cam_table_t *t, uint32_t i, int32_t z_nm);

/// @param n_slices  of a channel over angle, at least 2
/// @param pattern   0 .. n_slices - 1
/// @return          the pattern alone
/*@ requires slices: 2 <= n_slices <= 4096;
    assigns \result \from indirect: n_slices, indirect: pattern;
    ensures slice: \result.i <= n_slices - 2;
    ensures most: \result.i <= 4094;
    ensures weight: 0 <= \result.w_q31;
    ensures flag: \result.is_clamped == 0 || \result.is_clamped == 1;
*/
static inline cam_height_t cam_lobes_slice(uint32_t n_slices, uint32_t pattern)
{
    const uint32_t last = n_slices - 1u;
    return (cam_height_t){.i = pattern < last ? pattern : last - 1u,
                          .w_q31 = pattern < last ? 0 : INT32_MAX};
}

#endif
