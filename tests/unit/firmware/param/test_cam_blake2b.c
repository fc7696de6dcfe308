// SPDX-License-Identifier: Apache-2.0
// Hashes as Python's hashlib.blake2b(message, key=key) gives them; bytes count from 1.
#include "cam_param_inner.h"
#include "unity.h"

static void test_hashes_of_another_implementation(void)
{
    static const struct {
        uint32_t n_key, n, expected;
    } cases[] = {
        {64, 1, 0xB7DF3620}, {64, 128, 0xA4A55676}, {1, 12, 0x4C9EC2D8},
        {16, 4, 0xA7A7737F}, {33, 12, 0xADC09D7A},
    };
    uint8_t bytes[128];
    for (uint32_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)(i + 1u);
    }
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_HEX32(cases[i].expected,
                                cam_blake2b_keyed(bytes, cases[i].n_key, bytes, cases[i].n));
    }
}
