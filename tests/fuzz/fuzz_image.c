// SPDX-License-Identifier: Apache-2.0
#include "fuzz_image.h"
#include "cam_table.h"     // cam_crc32
#include "fixture_image.h" // fixture_at_crc
#include "fuzz_mutate.h"   // LLVMFuzzerMutate
#include <stdint.h>

enum { first_checked = 24, least = 128 };

static void put(uint8_t *at, uint32_t value)
{
    for (uint32_t i = 0; i < 4u; i++) {
        at[i] = (uint8_t)(value >> (8u * i));
    }
}

static uint32_t get(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

/// Write size and CRC of an image.
static void repair(uint8_t *image, size_t size)
{
    if (size < (size_t)least) {
        return;
    }
    put(image + fixture_at_image_size, (uint32_t)size);
    put(image + fixture_at_crc, cam_crc32(0, image + first_checked, size - first_checked));
}

/// A word becomes another number near it, an end of a range, or its negative.
static void change_word(uint8_t *image, size_t size, uint32_t dice)
{
    const size_t n_head = size < 512u ? size : 512u;
    const size_t room = (dice & 1u) != 0u ? n_head : size; // half of them in header and directory
    uint8_t *const at = image + (dice >> 3) % (room / 4u) * 4u;
    const uint32_t value = get(at);
    const uint32_t by = 1u << ((dice >> 20) % 31u);
    switch ((dice >> 25) % 5u) {
    case 0:
        put(at, value + by);
        break;
    case 1:
        put(at, value - by);
        break;
    case 2:
        put(at, 0u - value);
        break;
    case 3:
        put(at, by - 1u);
        break;
    default:
        put(at, value ^ by);
        break;
    }
}

size_t fuzz_image_mutate(uint8_t *data, size_t size, size_t max_size, unsigned seed, size_t head)
{
    uint32_t dice = seed * 2654435761u;
    if (size < head + (size_t)least || (dice >> 28) < 4u) {
        size = LLVMFuzzerMutate(data, size, max_size);
    } else {
        for (uint32_t n = (dice >> 28) % 3u + 1u; n > 0u; n--) {
            dice = dice * 1664525u + 1013904223u;
            change_word(data + head, size - head, dice ^ dice >> 13);
        }
    }
    if (size > head && (dice >> 8) % 16u != 0u) {
        repair(data + head, size - head);
    }
    return size;
}
