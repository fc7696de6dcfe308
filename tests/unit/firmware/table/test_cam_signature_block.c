// SPDX-License-Identifier: Apache-2.0
// The block of a signature: its place behind the image, its fields, and what must be 0 in it.
#include "cam_table.h"
#include "unity.h"
#include <string.h> // memcpy

enum { image_size = 700 };

static uint8_t bytes[image_size + cam_signature_block_size];
static uint8_t *const block = &bytes[image_size];

void setUp(void)
{
    static const uint8_t head[16] = {
        0x43,           0x41, 0x4D, 0x53, 0x49, 0x47, 0x1A, 0x0A, 1, 0, 0, 0, image_size & 0xFF,
        image_size >> 8};
    memset(bytes, 0xEE, sizeof bytes);
    memcpy(block, head, sizeof head);
    memset(block + 24, 0, 40);
}

static void test_block_follows_where_all_of_it_is_there(void)
{
    TEST_ASSERT_TRUE(cam_signature_block_follows(bytes, image_size, sizeof bytes));
    TEST_ASSERT_FALSE(cam_signature_block_follows(bytes, image_size, sizeof bytes - 1u));
    TEST_ASSERT_FALSE(cam_signature_block_follows(bytes, image_size - 1u, sizeof bytes));
    TEST_ASSERT_FALSE(cam_signature_block_follows(bytes, sizeof bytes + 1u, sizeof bytes));
    for (uint32_t i = 0; i < 8u; i++) {
        block[i] ^= 1u;
        TEST_ASSERT_FALSE(cam_signature_block_follows(bytes, image_size, sizeof bytes));
        block[i] ^= 1u;
    }
}

/// Version, size and the zeros count; the key's number and the signature are for others to judge.
static void test_each_byte_has_its_meaning(void)
{
    TEST_ASSERT_TRUE(cam_signature_block_is_sound(block, image_size));
    TEST_ASSERT_FALSE(cam_signature_block_is_sound(block, image_size + 1u));
    for (uint32_t i = 8; i < (uint32_t)cam_signature_block_size; i++) {
        block[i] ^= 0x80u;
        const bool is_free = (i >= 16u && i < 24u) || i >= 64u;
        TEST_ASSERT_EQUAL(is_free, cam_signature_block_is_sound(block, image_size));
        block[i] ^= 0x80u;
    }
}
