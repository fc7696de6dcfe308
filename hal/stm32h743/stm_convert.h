// SPDX-License-Identifier: Apache-2.0
/// stm_convert: between the units of the contract and the codes and counts of converters and
/// scales.
///
/// Pure functions of one multiplication each. Every result is clamped to its range; none wraps.
/// Context: ISR.
#ifndef STM_CONVERT_H
#define STM_CONVERT_H

#include <stdint.h> // int32_t, int64_t, uint32_t

/// @return value limited to [least, most]
static inline int32_t stm_clamp(int64_t value, int32_t least, int32_t most)
{
    return value < least ? least : value > most ? most : (int32_t)value;
}

/// Convert a set-point to the code of a 16-bit converter.
/// @param value      [nm] or [r/min / 1000], any
/// @param codes_q32  [codes per unit / 2^32] positive, BOARD_CODES_Q32()
/// @return           nearest code, -32 768 .. 32 767
static inline int32_t stm_code16(int32_t value, int32_t codes_q32)
{
    const int64_t code = ((int64_t)value * codes_q32 + (INT64_C(1) << 31)) >> 32;
    return stm_clamp(code, INT16_MIN, INT16_MAX);
}

/// Convert a set-point to the code of a 12-bit converter, whose middle code 2048 stands for 0.
/// @return code 0 .. 4095; parameters as of stm_code16()
static inline uint32_t stm_code12(int32_t value, int32_t codes_q32)
{
    return (uint32_t)((stm_code16(value, codes_q32) >> 4) + 2048);
}

/// Convert a set-point to steps.
/// @param value_nm   any
/// @param steps_q32  [steps per nm / 2^32] not negative, BOARD_STEPS_Q32()
/// @return           nearest whole number of steps
static inline int32_t stm_steps(int32_t value_nm, int32_t steps_q32)
{
    return (int32_t)(((int64_t)value_nm * steps_q32 + (INT64_C(1) << 31)) >> 32);
}

/// Convert counts of a linear scale to a position.
/// @param counts  any; or steps
/// @param nm_q16  [nm per count / 2^16], BOARD_NM_Q16()
/// @return        [nm] nearest position
static inline int32_t stm_counts_nm(int32_t counts, int32_t nm_q16)
{
    return stm_clamp(((int64_t)counts * nm_q16 + (1 << 15)) >> 16, INT32_MIN, INT32_MAX);
}

/// Extend a 16-bit counter to 32 bits. It may move by up to 32 767 counts between two calls.
/// @param counts   [counts] the last result
/// @param counter  [counts] the counter, 0 .. 65 535
/// @return         [counts] the new result; its low 16 bits are the counter
static inline int32_t stm_extend(int32_t counts, uint32_t counter)
{
    const int16_t moved = (int16_t)(uint16_t)(counter - (uint32_t)counts);
    return (int32_t)((uint32_t)counts + (uint32_t)moved); // wraps by design
}

#endif
