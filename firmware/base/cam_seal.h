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
#include <string.h> // memcpy

/// Go on with a sum.
/// @param sum    0, or the result over the words before
/// @param words  structure whose size is a multiple of 4 bytes, padding included
/// @param n      [words]
/// @return       the sum; two instructions a word. Context: both sides.
static inline uint32_t cam_seal_more(uint32_t sum, const void *words, uint32_t n)
{
    const unsigned char *at = words;
    for (uint32_t i = 0; i < n; i++) {
        uint32_t word = 0;
        (void)memcpy(&word, &at[4u * i], sizeof word);
        sum = (sum << 1 | sum >> 31) ^ word;
    }
    return sum;
}

#endif
