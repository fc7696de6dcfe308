// SPDX-License-Identifier: Apache-2.0
/// cam_signature_block: the block after an image that holds its signature.
///
/// Its position and fields only; cam_signature_check.h verifies the signature. Context of all
/// functions: slow side. Source: TABLE_FORMAT.md, "Signature".
#ifndef CAM_SIGNATURE_BLOCK_H
#define CAM_SIGNATURE_BLOCK_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t
#include <stdint.h>  // uint8_t

enum {
    cam_signature_block_size = 128,       ///< [bytes] a multiple of hal_table_grain
    cam_signature_block_signed_size = 64, ///< [bytes] of the block that are signed with the image
    cam_signature_block_id_size = 8,      ///< [bytes] of the hash of the public key
    cam_signature_block_magic_size = 8,   ///< [bytes]
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

#endif
