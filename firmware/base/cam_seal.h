// SPDX-License-Identifier: Apache-2.0
/// cam_seal: a sum over words that shows whether they have been changed from outside: by a bit that
/// flips, by a write that went astray.
///
/// Who may write a structure seals it behind the last write and looks at the seal before the next
/// one. A bit that flips changes exactly one bit of the sum, which is therefore always seen, at
/// half the price of a CRC's smallest table.
#ifndef CAM_SEAL_H
#define CAM_SEAL_H

#include <stdint.h> // uint32_t

/// A word of any structure.
typedef uint32_t __attribute__((may_alias)) cam_seal_word_t;

/// @return the sum, one word further; one instruction. Context: both sides.
static inline uint32_t cam_seal_word(uint32_t sum, uint32_t word)
{
    return (sum << 1 | sum >> 31) ^ word;
}

/// Go on with a sum.
/// @param sum    0, or the result over the words before
/// @param words  structure whose size and place are multiples of 4 bytes, padding included
/// @param n      [words]
/// @return       the sum. Context: both sides.
static inline uint32_t cam_seal_more(uint32_t sum, const void *words, uint32_t n)
{
    const cam_seal_word_t *at = words; // MISRA D20
    uint32_t longer = sum;
    for (uint32_t i = 0; i < n; i++) {
        longer = cam_seal_word(longer, at[i]);
    }
    return longer;
}

#endif
