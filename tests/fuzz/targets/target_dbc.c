// SPDX-License-Identifier: Apache-2.0
// Every message of camturn.dbc, packed and unpacked by the generated functions. What is unpacked
// from any bytes and packed again is the same message, and values that were packed come back.
#include "camturn.h"
#include "fuzz_expect.h"
#include <string.h>

enum { most_bytes = 64 };

// clang-format off
/// Message, and by how many bytes it travels.
#define MESSAGES(X) \
    X(command) X(answer) X(state) X(spindle) X(axis_u) X(detail) X(recording) X(recording_fd) \
    X(strobe) X(block) X(block_flow)
// clang-format on

/// From bytes to values to bytes to values: the values are the same. From values to bytes to values
/// to bytes: the bytes are the same.
#define MESSAGE_CHECK(name)                                                                        \
    static void check_##name(const uint8_t *bytes, const uint8_t *values, size_t n)                \
    {                                                                                              \
        struct camturn_##name##_t first, second;                                                   \
        uint8_t packed[most_bytes] = {0}, again[most_bytes] = {0};                                 \
        memset(&first, 0, sizeof first);                                                           \
        memset(&second, 0, sizeof second);                                                         \
        const int unpacked = camturn_##name##_unpack(&first, bytes, most_bytes);                   \
        FUZZ_EXPECT(unpacked == 0, #name " is not unpacked: %d", unpacked);                        \
        const int size = camturn_##name##_pack(packed, &first, most_bytes);                        \
        FUZZ_EXPECT(size > 0 && size <= most_bytes, #name " has %d bytes", size);                  \
        FUZZ_EXPECT(camturn_##name##_unpack(&second, packed, (size_t)size) == 0, #name);           \
        FUZZ_EXPECT(memcmp(&first, &second, sizeof first) == 0, #name " comes back as another");   \
        FUZZ_EXPECT(camturn_##name##_pack(again, &first, (size_t)size - 1u) < 0,                   \
                    #name " is packed into too few bytes");                                        \
        FUZZ_EXPECT(camturn_##name##_unpack(&second, packed, (size_t)size - 1u) < 0,               \
                    #name " is unpacked from too few bytes");                                      \
        memcpy(&first, values, n < sizeof first ? n : sizeof first);                               \
        memset(packed, 0, sizeof packed);                                                          \
        memset(&second, 0, sizeof second);                                                         \
        FUZZ_EXPECT(camturn_##name##_pack(packed, &first, most_bytes) == size, #name);             \
        FUZZ_EXPECT(camturn_##name##_unpack(&second, packed, (size_t)size) == 0, #name);           \
        FUZZ_EXPECT(camturn_##name##_pack(again, &second, most_bytes) == size, #name);             \
        FUZZ_EXPECT(memcmp(packed, again, most_bytes) == 0, #name " packs in two ways");           \
    }
MESSAGES(MESSAGE_CHECK)

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static void (*const checks[])(const uint8_t *, const uint8_t *, size_t) = {
#define MESSAGE_NAME(name) check_##name,
        MESSAGES(MESSAGE_NAME)
#undef MESSAGE_NAME
    };
    enum { n_checks = sizeof checks / sizeof checks[0] };
    if (size < 1u) {
        return -1;
    }
    uint8_t bytes[most_bytes] = {0};
    memcpy(bytes, data + 1, size - 1u < sizeof bytes ? size - 1u : sizeof bytes);
    checks[data[0] % n_checks](bytes, data + 1, size - 1u);
    return 0;
}
