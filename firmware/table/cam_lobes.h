// SPDX-License-Identifier: Apache-2.0
/// cam_lobes: the lobes of a shaft, each of which plays a pattern that several may share.
///
/// In such a table a slice is the pattern of a profile, not a height. At any height the nearest
/// lobe is played: its pattern, turned by its phase. From 20 um beyond a lobe's edge its lift falls
/// by a smooth step; it is 0 in the middle of the gap, where the next lobe takes over. Source:
/// TABLE_FORMAT.md, "Lobes". Context: the checks: slow side; all others: ISR or slow side, constant
/// time, cannot fail.
#ifndef CAM_LOBES_H
#define CAM_LOBES_H

#include "cam_channel.h" // cam_table_t
#include "cam_entry.h"   // cam_entry_t
#include "cam_eval.h"    // cam_height_t
#include <stdint.h>      // int32_t, uint32_t

enum {
    cam_lobes_least_gap_nm = 200000, ///< [nm] between two lobes
    cam_lobes_kept_off_nm = 20000,   ///< [nm] the full lift extends this far beyond a lobe
};

/// Check the entry and the directory of lobes, and fill in lobes, n_lobes and least_change_nm.
/// @param used  as of cam_entry_check()
CAM_MUST_USE cam_err_t cam_lobes_check(const cam_entry_t *e, uint64_t *used, cam_table_t *table);

/// Check, once all channels are known, that every channel over angle has all patterns.
CAM_MUST_USE cam_err_t cam_lobes_check_patterns(const cam_table_t *table);

/// @param t     with lobes
/// @param z_nm  [nm] any value
/// @return      index of the lobe that is played there
uint32_t cam_lobes_find(const cam_table_t *t, int32_t z_nm);

/// @param i     a lobe
/// @param z_nm  [nm] any value
/// @return      [1 / 2^31] progress of the change to the neighbouring lobe: 0 on lobe i,
///              2^31 - 1 in the middle of the gap and beyond
int32_t cam_lobes_change_q31(const cam_table_t *t, uint32_t i, int32_t z_nm);

/// @param n_slices  of a channel over angle, at least 2
/// @param pattern   0 .. n_slices - 1
/// @return          the slice of that pattern, not blended with another
/*@ requires slices: 2 <= n_slices <= 4096;
    assigns \result \from indirect: n_slices, indirect: pattern;
    ensures slice: \result.i <= n_slices - 2;
    ensures most: \result.i <= 4094;
    ensures weight: 0 <= \result.w_q31;
*/
static inline cam_height_t cam_lobes_slice(uint32_t n_slices, uint32_t pattern)
{
    const uint32_t last = n_slices - 1u;
    return (cam_height_t){.i = pattern < last ? pattern : last - 1u,
                          .w_q31 = pattern < last ? 0 : INT32_MAX};
}

#endif
