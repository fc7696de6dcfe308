// SPDX-License-Identifier: Apache-2.0
/// lin_number: little-endian members of CAN frames, and division that rounds.
#ifndef LIN_NUMBER_H
#define LIN_NUMBER_H

#include <stdint.h> // int32_t, int64_t, uint8_t, uint16_t, uint32_t

static inline uint16_t lin_get_u16(const uint8_t *at)
{
    return (uint16_t)(at[0] | at[1] << 8);
}

static inline uint32_t lin_get_u32(const uint8_t *at)
{
    return (uint32_t)lin_get_u16(at) | (uint32_t)lin_get_u16(at + 2) << 16;
}

static inline void lin_put_u16(uint8_t *at, uint16_t value)
{
    at[0] = (uint8_t)(value & 0xFFu);
    at[1] = (uint8_t)(value >> 8);
}

static inline void lin_put_i32(uint8_t *at, int32_t value)
{
    lin_put_u16(at, (uint16_t)((uint32_t)value & 0xFFFFu));
    lin_put_u16(at + 2, (uint16_t)((uint32_t)value >> 16));
}

static inline int32_t lin_clamp_i32(int64_t value)
{
    return value < INT32_MIN ? INT32_MIN : value > INT32_MAX ? INT32_MAX : (int32_t)value;
}

/// @param b  not 0
/// @return   a / b, nearest, halves away from 0
static inline int64_t lin_div_round(int64_t a, int64_t b)
{
    const int64_t half = (b < 0 ? -b : b) / 2;
    return (a < 0 ? a - half : a + half) / b;
}

/// @param b  above 0
/// @return   a / b, rounded down
static inline int64_t lin_div_floor(int64_t a, int64_t b)
{
    return a / b - (a % b < 0 ? 1 : 0);
}

#endif
