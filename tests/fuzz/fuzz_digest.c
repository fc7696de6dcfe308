// SPDX-License-Identifier: Apache-2.0
#include "fuzz_digest.h"
#include <stdio.h>  // fopen
#include <string.h> // memcpy, strcmp

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

bool fuzz_digest_is_recorded(const char *path, const char *name, uint64_t sum)
{
    char line[128], now[128];
    (void)snprintf(now, sizeof now, "%s %016llx\n", name, (unsigned long long)sum);
    FILE *file = fopen(path, "r");
    bool is_same = false;
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        is_same = is_same || strcmp(line, now) == 0;
    }
    if (file != NULL) {
        (void)fclose(file);
    }
    if (!is_same) {
        (void)printf("%s does not have the line\n%s"
                     "The firmware acts otherwise than when it was recorded. If that is meant, "
                     "record this line.\n",
                     path, now);
    }
    return is_same;
}
