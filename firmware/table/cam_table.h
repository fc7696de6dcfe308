// SPDX-License-Identifier: Apache-2.0
/// cam_table: check of a table image, which the interrupt then reads in place.
///
/// An image (TABLE_FORMAT.md) is made by mktables: a header and one channel of knots for each
/// function of spindle angle and height. The check treats it as untrusted bytes and fills a
/// cam_table_t that points into it.
#ifndef CAM_TABLE_H
#define CAM_TABLE_H

#include "cam_channel.h" // cam_table_t
#include "cam_err.h"     // cam_err_t
#include <stddef.h>      // size_t
#include <stdint.h>      // uint8_t, uint32_t

/// Check an image and describe it.
/// @param image  bytes of an image, any content; must stay unchanged while *table is used
/// @param size   [bytes] of the image
/// @param table  filled on success, zeroed otherwise
/// @return       cam_ok, or the first error in the order of TABLE_FORMAT.md
/// Context: slow side; a few passes over the image, whose cost TABLE_FORMAT.md gives per byte.
CAM_MUST_USE cam_err_t cam_table_check(const void *image, size_t size, cam_table_t *table);

/// Compute a CRC-32 piece by piece.
/// @param crc   result of the previous piece; 0 for the first
/// @param data  n bytes
/// @return      CRC-32 of all pieces so far
/// Context: slow side. Source: reflected polynomial 0xEDB88320 (ISO-HDLC, as in zlib).
uint32_t cam_crc32(uint32_t crc, const void *data, size_t n);

#endif
