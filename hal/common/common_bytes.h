// SPDX-License-Identifier: Apache-2.0
/// common_bytes: little-endian numbers in frame data (CiA 301, 7.1.4).
#ifndef COMMON_BYTES_H
#define COMMON_BYTES_H

#include <stdint.h> // int32_t, uint8_t, uint16_t, uint32_t

static inline uint16_t common_get_u16(const uint8_t *at)
{
    return (uint16_t)(at[0] | at[1] << 8);
}

static inline uint32_t common_get_u32(const uint8_t *at)
{
    return (uint32_t)common_get_u16(at) | (uint32_t)common_get_u16(at + 2) << 16;
}

static inline void common_put_u16(uint8_t *at, uint16_t value)
{
    at[0] = (uint8_t)(value & 0xFFu);
    at[1] = (uint8_t)(value >> 8);
}

static inline void common_put_u32(uint8_t *at, uint32_t value)
{
    common_put_u16(at, (uint16_t)(value & 0xFFFFu));
    common_put_u16(at + 2, (uint16_t)(value >> 16));
}

static inline void common_put_i32(uint8_t *at, int32_t value)
{
    common_put_u32(at, (uint32_t)value);
}

#endif
