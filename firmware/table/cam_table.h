// SPDX-License-Identifier: Apache-2.0
/// cam_table: the image of a part's table, checked once on the slow side, then read in place.
///
/// An image is a file of mktables: a header and one channel for each function of the spindle angle
/// and the height, stored as knots. cam_table_check() treats it as untrusted bytes and fills a
/// cam_table_t that points into it; the image must stay unchanged while the table is in use. The
/// format is TABLE_FORMAT.md.
#ifndef CAM_TABLE_H
#define CAM_TABLE_H

#include "cam_channel.h" // cam_table_t
#include "cam_err.h"     // cam_err_t
#include <stddef.h>      // size_t
#include <stdint.h>      // uint32_t

/// Check an image and describe it.
/// @param image  bytes of an image, any content; must stay unchanged while *table is used
/// @param size   [bytes] that may be read from image on: those of the image, and of the signature
///               behind it, if there is one (cam_signature_block.h)
/// @param table  filled on success, zeroed otherwise
/// @return       cam_ok, or the first thing wrong in the order of TABLE_FORMAT.md
/// Context: slow side; a few passes over the image. Source: TABLE_FORMAT.md, which counts the
/// instructions per byte.
CAM_MUST_USE cam_err_t cam_table_check(const void *image, size_t size, cam_table_t *table);

/// Compute the CRC-32 of an image piece by piece: begin with 0 and pass each result on.
/// @param crc   result of the previous piece, 0 for the first
/// @param data  n bytes
/// @return      CRC-32 of all pieces so far
/// Context: slow side. Source: reflected polynomial 0xEDB88320 (ISO-HDLC, as in zlib).
uint32_t cam_crc32(uint32_t crc, const void *data, size_t n);

#endif
