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
#include <stdbool.h>     // bool
#include <stddef.h>      // size_t
#include <stdint.h>      // uint8_t, uint32_t

/// Check an image and describe it.
/// @param image  bytes of an image, any content; must stay unchanged while *table is used
/// @param size   [bytes] of the image and of the signature that may follow it
/// @param table  filled on success, zeroed otherwise
/// @return       cam_ok, or the first error in the order of TABLE_FORMAT.md
/// Context: slow side; a few passes over the image, whose cost TABLE_FORMAT.md gives per byte.
CAM_MUST_USE cam_err_t cam_table_check(const void *image, size_t size, cam_table_t *table);

/// The block after an image that holds its signature, TABLE_FORMAT.md, "Signature"; the room
/// signature verifies it (cam_signature_check.h).
enum {
    cam_signature_block_size = 128,       ///< [bytes] a multiple of hal_table_grain
    cam_signature_block_signed_size = 64, ///< [bytes] of the block that are signed with the image
    cam_signature_block_id_size = 8,      ///< [bytes] of the hash of the public key
    // Offsets of the fields
    cam_signature_block_at_version = 8,
    cam_signature_block_at_image_size = 12,
    cam_signature_block_at_id = 16,
    cam_signature_block_at_zeros = 24,
    cam_signature_block_at_signature = cam_signature_block_signed_size,
};

/// @param image       `room` bytes of any content
/// @param image_size  [bytes] of the image as its header says; any number
/// @return            whether a whole block, with its magic, follows the image
bool cam_signature_block_follows(const uint8_t *image, size_t image_size, size_t room);

/// @return whether the block has this format and is for an image of this size
bool cam_signature_block_is_sound(const uint8_t *block, size_t image_size);

/// Compute a CRC-32 piece by piece.
/// @param crc   result of the previous piece; 0 for the first
/// @param data  n bytes
/// @return      CRC-32 of all pieces so far
/// Context: slow side. Source: reflected polynomial 0xEDB88320 (ISO-HDLC, as in zlib).
uint32_t cam_crc32(uint32_t crc, const void *data, size_t n);

#endif
