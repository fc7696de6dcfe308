// SPDX-License-Identifier: Apache-2.0
#include "common_keys.h"
#include <stddef.h> // size_t
#include <string.h> // strchr, strspn

static const char between[] = " ,\t\r\n";

/// @return the value of a hexadecimal digit, -1: it is none
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

/// Read 64 digits that nothing but a separator follows.
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
    return text[common_keys_digits] == '\0' || strchr(between, text[common_keys_digits]) != NULL;
}

bool common_keys_add(common_keys_t *keys, const char *text)
{
    common_keys_t all = *keys;
    const char *at = text + strspn(text, between);
    while (*at != '\0') {
        if (all.n == (uint32_t)common_keys_most ||
            !read_key(at, &all.bytes[(size_t)all.n * common_keys_bytes])) {
            return false;
        }
        all.n++;
        at += common_keys_digits;
        at += strspn(at, between);
    }
    *keys = all;
    return true;
}
