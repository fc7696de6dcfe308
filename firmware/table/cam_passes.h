// SPDX-License-Identifier: Apache-2.0
/// cam_passes: check of a table's passes, each with its own stock, feed and speed.
///
/// Used by cam_table_check(). Context: slow side. Source: TABLE_FORMAT.md, "Passes".
#ifndef CAM_PASSES_H
#define CAM_PASSES_H

#include "cam_channel.h" // cam_table_t
#include "cam_entry.h"   // cam_entry_t
#include "cam_err.h"     // cam_err_t
#include <stdint.h>      // uint64_t

enum { cam_passes_most_nm = 10000000 }; ///< [nm] largest allowance of a pass

/// Check the entry of the passes and its records, and put them into the table.
/// @param used  as of cam_entry_check()
/// @return      cam_ok, cam_err_image_channel or cam_err_image_layout
CAM_MUST_USE cam_err_t cam_passes_check(const cam_entry_t *e, const cam_entry_place_t *in,
                                        uint64_t *used, cam_table_t *table);

#endif
