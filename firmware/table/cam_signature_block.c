// SPDX-License-Identifier: Apache-2.0
#include "cam_signature_block.h"
#include <string.h> // memcmp

bool cam_signature_block_follows(const uint8_t *image, size_t image_size, size_t room)
{
    static const uint8_t magic[cam_signature_block_magic_size] = {0x43, 0x41, 0x4D, 0x53,
                                                                  0x49, 0x47, 0x1A, 0x0A};
    return image_size <= room && room - image_size >= (size_t)cam_signature_block_size &&
           memcmp(&image[image_size], magic, sizeof magic) == 0;
}

static uint32_t field_at(const uint8_t *block, uint32_t at)
{
    return (uint32_t)block[at] | (uint32_t)block[at + 1u] << 8 | (uint32_t)block[at + 2u] << 16 |
           (uint32_t)block[at + 3u] << 24;
}

bool cam_signature_block_is_sound(const uint8_t *block, size_t image_size)
{
    bool is_sound = field_at(block, cam_signature_block_at_version) == 1u &&
                    field_at(block, cam_signature_block_at_image_size) == image_size;
    for (size_t i = cam_signature_block_at_zeros; i < (size_t)cam_signature_block_signed_size;
         i++) {
        is_sound = is_sound && block[i] == 0u;
    }
    return is_sound;
}
