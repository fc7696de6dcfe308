// SPDX-License-Identifier: Apache-2.0
/// cam_table: the image of a part, checked once on the slow side, then read in place.
///
/// cam_table_check() treats the image as untrusted bytes and fills a cam_table_t that points into
/// it; the image must stay unchanged while the table is in use. The format is TABLE_FORMAT.md.
#ifndef CAM_TABLE_H
#define CAM_TABLE_H

#include "cam_channel.h" // cam_table_t
#include "cam_err.h"     // cam_err_t
#include <stddef.h>      // size_t
#include <stdint.h>      // uint32_t

/// Check an image and describe it.
/// @param image  bytes of an image, any content; must stay unchanged while *table is used
/// @param size   [bytes] that may be read
/// @param table  filled on success, zeroed otherwise
/// @return       cam_ok, or the first thing wrong in the order of TABLE_FORMAT.md
/// Context: slow side; reads each byte of the image twice. Source: TABLE_FORMAT.md.
CAM_MUST_USE cam_err_t cam_table_check(const void *image, size_t size, cam_table_t *table);

/// CRC-32 as used by the image, in pieces: start with 0 and feed the result back.
/// @param crc   result of the previous piece, 0 at the start
/// @param data  n bytes
/// Context: slow side. Source: reflected polynomial 0xEDB88320 (ISO-HDLC, as zlib).
uint32_t cam_crc32(uint32_t crc, const void *data, size_t n);

#endif
