// SPDX-License-Identifier: Apache-2.0
// Hashes as Python's hashlib.blake2b(message, key=key) gives them; bytes count from 0.
#include "cam_param_inner.h"
#include "unity.h"

static void test_hashes_of_another_implementation(void)
{
    static const struct {
        uint32_t n_key, n, expected;
    } cases[] = {
        {64, 1, 0xD16D1F96}, {64, 128, 0xE45E0672}, {1, 12, 0x72E98837},
        {16, 4, 0x61569D66}, {33, 12, 0x12576000},
    };
    uint8_t bytes[128];
    for (uint32_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)i;
    }
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_HEX32(cases[i].expected,
                                cam_blake2b_keyed(bytes, cases[i].n_key, bytes, cases[i].n));
    }
}
