// SPDX-License-Identifier: Apache-2.0
/// fuzz_bytes: an input, eaten from its front; behind its end everything is 0.
#ifndef FUZZ_BYTES_H
#define FUZZ_BYTES_H

#include <stdint.h> // uint8_t, uint32_t
#include <stddef.h> // size_t

typedef struct {
    const uint8_t *at;
    size_t n; ///< [bytes] that are left
} fuzz_bytes_t;

/// @return the next byte
static inline uint8_t fuzz_u8(fuzz_bytes_t *b)
{
    if (b->n == 0u) {
        return 0;
    }
    b->n--;
    return *b->at++;
}

/// @return the next two bytes, the lowest first
static inline uint16_t fuzz_u16(fuzz_bytes_t *b)
{
    const uint8_t low = fuzz_u8(b);
    return (uint16_t)(low | fuzz_u8(b) << 8);
}

/// @return the next four bytes, the lowest first
static inline uint32_t fuzz_u32(fuzz_bytes_t *b)
{
    const uint32_t low = fuzz_u16(b);
    return low | (uint32_t)fuzz_u16(b) << 16;
}

/// @return the next four bytes as a signed number
static inline int32_t fuzz_i32(fuzz_bytes_t *b)
{
    return (int32_t)fuzz_u32(b);
}

#endif
