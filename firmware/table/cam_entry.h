// SPDX-License-Identifier: Apache-2.0
/// cam_entry: check of one channel of an image: its entry in the directory, and its data.
///
/// Context of all functions: slow side. Source: TABLE_FORMAT.md, "Channel entry", "Knots",
/// "Passes", "The bound that makes overflow impossible".
#ifndef CAM_ENTRY_H
#define CAM_ENTRY_H

#include "cam_err.h"     // cam_err_t
#include "cam_bounds.h"  // cam_extent_t
#include "cam_channel.h" // cam_table_t
#include <stdbool.h>     // bool
#include <stddef.h>      // size_t
#include <stdint.h>      // uint32_t, int32_t

/// Kind of a channel, as stored in its entry.
enum {
    cam_kind_u = 1,       ///< radius reduction over angle and height
    cam_kind_x = 2,       ///< semi-major axis over height
    cam_kind_speed = 3,   ///< speed ratio of the spindle over angle and height
    cam_kind_swing = 4,   ///< lobe: swing angle of the tool over angle and height
    cam_kind_contact = 5, ///< lobe: angle of the contact on the wheel, reported, not played
    cam_kind_lobes = 6,   ///< position of each lobe on the shaft and the slice it plays
    cam_kind_way = 7,     ///< Z in advance of a plain helix, over the helix's height
    cam_kind_passes = 8,  ///< records of the passes in which the part is cut
    cam_kind_newer = 6,   ///< kinds from here on need version 1.1
};

enum {
    cam_entry_align = 32,                 ///< [bytes] alignment of a channel in the image
    cam_entry_max_height_nm = 2000000000, ///< [nm] heights and their differences fit int32
};

/// A channel entry, in the order of the image.
typedef struct {
    uint32_t kind;       ///< cam_kind_*
    uint32_t offset;     ///< [bytes] of the first knot from the start of the image
    uint32_t size;       ///< [bytes] of all knots
    uint32_t n_slices;   ///< 2 .. 4096
    uint32_t log2_knots; ///< over angle: 2 .. 12; x and way: 0
    uint32_t log2_repeat, frac_bits;
    int32_t z_first_nm, z_last_nm;
    uint32_t slices_per_nm_q48;
    int32_t value_offset;        ///< [unit of the channel] value at p = 0
    int32_t p_min, p_max;        ///< [LSB] bounds of p of all knots
    uint32_t v_max, a_max, path; ///< [LSB] bounds of |v| and |a|; path: TABLE_FORMAT.md
} cam_entry_t;
_Static_assert(sizeof(cam_entry_t) == cam_table_entry_size, "as in the format");

/// Check an entry and all its knots.
/// @param t     its image, range of heights and lobes
/// @param used  [bytes] end of the preceding data in the image; advanced past this channel
/// @return      cam_ok, or the first error in the order entry, layout, heights, knots
CAM_MUST_USE cam_err_t cam_entry_check(const cam_entry_t *e, const cam_table_t *t, uint64_t *used);

/// Check an entry of records: 0 in all fields that describe knots, and the heights of the table.
/// @param most  largest count of records
/// @param size  [bytes] of a record
/// @param used  as of cam_entry_check()
CAM_MUST_USE cam_err_t cam_entry_check_records(const cam_entry_t *e, uint32_t most, size_t size,
                                               const cam_table_t *t, uint64_t *used);

/// Check the entry of the passes and its records, and put them into the table.
/// @param used  as of cam_entry_check()
/// @return      cam_ok, cam_err_image_channel or cam_err_image_layout
CAM_MUST_USE cam_err_t cam_entry_check_passes(const cam_entry_t *e, uint64_t *used, cam_table_t *t);

/// @return whether values are valid for the entry's kind: a speed ratio between 1/16 and 4, an
///         angle within a quarter turn to either side; lengths are not limited here
bool cam_entry_is_in_unit(const cam_entry_t *e, cam_extent_t values);

/// @return whether a channel is a function of angle and height, not of height alone
bool cam_entry_is_over_angle(const cam_entry_t *e);

/// @return the knots or records of an entry whose layout has been checked
const void *cam_entry_data(const cam_entry_t *e, const cam_table_t *t);

/// @return the channel of an entry whose layout has been checked
cam_channel_t cam_entry_channel(const cam_entry_t *e, const cam_table_t *t);

#endif
