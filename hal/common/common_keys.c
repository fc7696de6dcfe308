// SPDX-License-Identifier: Apache-2.0
#include "common_keys.h"
#include <stddef.h> // size_t
#include <string.h> // memcmp, strchr, strspn

static const char separators[] = " ,\t\r\n";

/// @return the value of a hexadecimal digit, -1 for any other character
static int digit(char c)
{
    static const char digits[] = "0123456789abcdefABCDEF";
    const char *at = c == '\0' ? NULL : strchr(digits, c);
    if (at == NULL) {
        return -1;
    }
    const int i = (int)(at - digits);
    return i < 16 ? i : i - 6;
}

/// Read 64 digits, followed by a separator or the end of the text.
static bool read_key(const char *text, uint8_t *key)
{
    for (size_t i = 0; i < (size_t)common_keys_bytes; i++) {
        const int high = digit(text[2u * i]);
        const int low = high < 0 ? -1 : digit(text[2u * i + 1u]);
        if (low < 0) {
            return false;
        }
        key[i] = (uint8_t)(high * 16 + low);
    }
    return text[common_keys_digits] == '\0' || strchr(separators, text[common_keys_digits]) != NULL;
}

/// @return whether a key is a point of small order, with either sign, or not below the field prime
/// 2^255 - 19. The firmware rejects these keys too (cam_signature_check.h); rejecting them here
/// gives the machine builder a message.
static bool is_weak(const uint8_t *key)
{
    enum { last = common_keys_bytes - 1 };
    static const uint8_t of_order_8[2][common_keys_bytes] = {
        {0x26, 0xE8, 0x95, 0x8F, 0xC2, 0xB2, 0x27, 0xB0, 0x45, 0xC3, 0xF4,
         0x89, 0xF2, 0xEF, 0x98, 0xF0, 0xD5, 0xDF, 0xAC, 0x05, 0xD3, 0xC6,
         0x33, 0x39, 0xB1, 0x38, 0x02, 0x88, 0x6D, 0x53, 0xFC, 0x05},
        {0xC7, 0x17, 0x6A, 0x70, 0x3D, 0x4D, 0xD8, 0x4F, 0xBA, 0x3C, 0x0B,
         0x76, 0x0D, 0x10, 0x67, 0x0F, 0x2A, 0x20, 0x53, 0xFA, 0x2C, 0x39,
         0xCC, 0xC6, 0x4E, 0xC7, 0xFD, 0x77, 0x92, 0xAC, 0x03, 0x7A},
    };
    uint32_t n_zeros = 0, n_ones = 0;
    for (int i = 1; i < last; i++) {
        n_zeros += key[i] == 0u ? 1u : 0u;
        n_ones += key[i] == UINT8_MAX ? 1u : 0u;
    }
    const uint32_t top = key[last] & 0x7Fu;
    const bool is_0_or_1 = n_zeros == last - 1u && top == 0u && key[0] <= 1u;
    const bool is_from_minus_1 = n_ones == last - 1u && top == 0x7Fu && key[0] >= 0xECu;
    bool is_of_8 = false;
    for (int i = 0; i < 2; i++) {
        is_of_8 = is_of_8 || (memcmp(key, of_order_8[i], last) == 0 && top == of_order_8[i][last]);
    }
    return is_0_or_1 || is_from_minus_1 || is_of_8;
}

bool common_keys_add(common_keys_t *keys, const char *text)
{
    common_keys_t all = *keys;
    const char *at = text + strspn(text, separators);
    while (*at != '\0') {
        if (all.n == (uint32_t)common_keys_most ||
            !read_key(at, &all.bytes[(size_t)all.n * common_keys_bytes]) ||
            is_weak(&all.bytes[(size_t)all.n * common_keys_bytes])) {
            return false;
        }
        all.n++;
        at += common_keys_digits;
        at += strspn(at, separators);
    }
    *keys = all;
    return true;
}
