// SPDX-License-Identifier: Apache-2.0
/// stm_convert: units of the contract <-> codes and counts of the converters and scales.
///
/// Pure functions, one multiplication each; every result is clamped to its range, none wraps.
/// Context: ISR.
#ifndef STM_CONVERT_H
#define STM_CONVERT_H

#include <stdint.h> // int32_t, int64_t, uint32_t

static inline int32_t stm_clamp(int64_t value, int32_t least, int32_t most)
{
    return value < least ? least : value > most ? most : (int32_t)value;
}

/// @param value      [nm] or [r/min / 1000], any
/// @param codes_q32  [codes per unit / 2^32] positive, BOARD_CODES_Q32()
/// @return           -32 768 .. 32 767, nearest code
static inline int32_t stm_code16(int32_t value, int32_t codes_q32)
{
    const int64_t code = ((int64_t)value * codes_q32 + (INT64_C(1) << 31)) >> 32;
    return stm_clamp(code, INT16_MIN, INT16_MAX);
}

/// @return  code of a 12-bit converter whose middle is 0: 0 .. 4095
static inline uint32_t stm_code12(int32_t value, int32_t codes_q32)
{
    return (uint32_t)((stm_code16(value, codes_q32) >> 4) + 2048);
}

/// @param counts  any
/// @param nm_q16  [nm per count / 2^16], BOARD_NM_Q16()
/// @return        [nm]
static inline int32_t stm_counts_nm(int32_t counts, int32_t nm_q16)
{
    return stm_clamp(((int64_t)counts * nm_q16 + (1 << 15)) >> 16, INT32_MIN, INT32_MAX);
}

/// Continue a 16-bit counter with 32 bits; it may move by 32 767 counts between two calls.
/// @param counts   the last result
/// @param counter  0 .. 65 535
static inline int32_t stm_extend(int32_t counts, uint32_t counter)
{
    const int16_t moved = (int16_t)(uint16_t)(counter - (uint32_t)counts);
    return (int32_t)((uint32_t)counts + (uint32_t)moved); // wraps by design
}

#endif
