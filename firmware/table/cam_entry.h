// SPDX-License-Identifier: Apache-2.0
/// cam_entry: one channel of an image, its entry in the directory and its knots, checked.
/// Context: slow side. Source: TABLE_FORMAT.md, Channel entry, Knots, The bound.
#ifndef CAM_ENTRY_H
#define CAM_ENTRY_H

#include "cam_err.h"     // cam_err_t
#include "cam_channel.h" // cam_channel_t
#include <stdint.h>      // uint32_t, int32_t

enum {
    cam_kind_u = 1,
    cam_kind_x = 2,
    cam_kind_speed = 3,
    cam_kind_swing = 4,
    cam_kind_contact = 5,
};

enum {
    cam_entry_align = 32,                 ///< [bytes] of channels in an image
    cam_entry_max_height_nm = 2000000000, ///< heights and their differences fit int32
};

/// A channel entry, in the order of the image.
typedef struct {
    uint32_t kind, offset, size, n_slices, log2_knots, log2_repeat, frac_bits;
    int32_t z_first_nm, z_last_nm;
    uint32_t slices_per_nm_q48;
    int32_t offset_nm, p_min, p_max;
    uint32_t v_max, a_max, path;
} cam_entry_t;
_Static_assert(sizeof(cam_entry_t) == cam_table_entry_size, "as in the format");

/// Where a channel lies.
typedef struct {
    const uint8_t *image; ///< aligned as cam_table_check() demands
    uint32_t image_size;  ///< [bytes]
    int32_t z_first_nm;   ///< [nm] heights that the channel has to serve
    int32_t z_last_nm;    ///< [nm]
} cam_entry_place_t;

/// @param used  [bytes] end of what lies before in the image, moved behind this channel
/// @return      cam_ok, or the first thing wrong: entry, layout, heights, knots
CAM_MUST_USE cam_err_t cam_entry_check(const cam_entry_t *e, const cam_entry_place_t *in,
                                       uint64_t *used);

/// @return the channel of a checked entry; its knots lie in the image
cam_channel_t cam_entry_channel(const cam_entry_t *e, const uint8_t *image);

#endif
