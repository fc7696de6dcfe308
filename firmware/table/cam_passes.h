// SPDX-License-Identifier: Apache-2.0
/// cam_passes: the passes of a table, in which a part is cut one after the other.
///
/// A pass leaves stock on the radius for the next one, and has a feed and a speed of its own. Used
/// by cam_table_check(). Context: slow side. Source: TABLE_FORMAT.md, "Passes".
#ifndef CAM_PASSES_H
#define CAM_PASSES_H

#include "cam_channel.h" // cam_table_t
#include "cam_entry.h"   // cam_entry_t
#include "cam_err.h"     // cam_err_t
#include <stdint.h>      // uint64_t

enum {
    cam_passes_most_nm = 10000000, ///< [nm] largest allowance of a pass
};

/// Check the entry of the passes and its records, and take them into the table.
/// @param used  [bytes] end of what lies before in the image; moved behind the records
/// @return      cam_ok, cam_err_image_channel or cam_err_image_layout
CAM_MUST_USE cam_err_t cam_passes_check(const cam_entry_t *e, const cam_entry_place_t *in,
                                        uint64_t *used, cam_table_t *table);

#endif
