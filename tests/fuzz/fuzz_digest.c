// SPDX-License-Identifier: Apache-2.0
#include "fuzz_digest.h"
#include <string.h> // memcpy

// As FNV-1a, with 64-bit values for bytes, and the high half folded into the low half.
static uint64_t digest;

void fuzz_digest_begin(void)
{
    digest = UINT64_C(14695981039346656037);
}

void fuzz_note(int64_t value)
{
    digest = (digest ^ (uint64_t)value) * UINT64_C(1099511628211);
    digest ^= digest >> 32;
}

void fuzz_note_words(const void *words, size_t n_bytes)
{
    for (size_t i = 0; i + sizeof(int32_t) <= n_bytes; i += sizeof(int32_t)) {
        int32_t word;
        memcpy(&word, (const char *)words + i, sizeof word);
        fuzz_note(word);
    }
}

uint64_t fuzz_digest(void)
{
    return digest;
}
