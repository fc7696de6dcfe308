// SPDX-License-Identifier: Apache-2.0
#include "cam_param_inner.h"
#include <stdbool.h> // bool
#include <string.h>  // memcpy, memset

enum { block_bytes = 128, n_words = 16, n_rounds = 12, hash_bytes = 64 };

/// Start of the hash, and half of the working vector. RFC 7693, 2.6.
static const uint64_t initial[8] = {
    0x6A09E667F3BCC908u, 0xBB67AE8584CAA73Bu, 0x3C6EF372FE94F82Bu, 0xA54FF53A5F1D36F1u,
    0x510E527FADE682D1u, 0x9B05688C2B3E6C1Fu, 0x1F83D9ABFB41BD6Bu, 0x5BE0CD19137E2179u,
};

static uint64_t rotated(uint64_t x, uint32_t n)
{
    const uint32_t left = 64u - n;
    return x >> n | x << left;
}

/// The function G on four words of the working vector. RFC 7693, 3.1.
static void mix(uint64_t v[n_words], const uint8_t at[4], uint64_t x, uint64_t y)
{
    uint64_t *a = &v[at[0]];
    uint64_t *b = &v[at[1]];
    uint64_t *c = &v[at[2]];
    uint64_t *d = &v[at[3]];
    *a += *b + x;
    *d = rotated(*d ^ *a, 32);
    *c += *d;
    *b = rotated(*b ^ *c, 24);
    *a += *b + y;
    *d = rotated(*d ^ *a, 16);
    *c += *d;
    *b = rotated(*b ^ *c, 63);
}

/// Hash a block. RFC 7693, 3.2.
/// @param n_hashed  [bytes] hashed so far, this block included
static void take_block(uint64_t h[8], const uint8_t block[block_bytes], uint64_t n_hashed,
                       bool is_last)
{
    static const uint8_t order[10][n_words] = {
        {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15},
        {14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3},
        {11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4},
        {7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8},
        {9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13},
        {2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9},
        {12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11},
        {13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10},
        {6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5},
        {10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0},
    };
    static const uint8_t columns_and_diagonals[8][4] = {
        {0, 4, 8, 12},  {1, 5, 9, 13},  {2, 6, 10, 14}, {3, 7, 11, 15},
        {0, 5, 10, 15}, {1, 6, 11, 12}, {2, 7, 8, 13},  {3, 4, 9, 14},
    };
    uint64_t m[n_words] = {0};
    uint64_t v[n_words];
    for (uint32_t i = 0; i < (uint32_t)block_bytes; i++) {
        const uint32_t shift = 8u * (i % 8u);
        m[i / 8u] |= (uint64_t)block[i] << shift;
    }
    for (uint32_t i = 0; i < 8u; i++) {
        v[i] = h[i];
        v[i + 8u] = initial[i];
    }
    v[12] ^= n_hashed;
    v[14] = is_last ? ~v[14] : v[14];
    for (uint32_t round = 0; round < (uint32_t)n_rounds; round++) {
        const uint8_t *word = order[round % 10u];
        for (size_t i = 0; i < 8u; i++) {
            mix(v, columns_and_diagonals[i], m[word[2u * i]], m[word[2u * i + 1u]]);
        }
    }
    for (uint32_t i = 0; i < 8u; i++) {
        h[i] ^= v[i] ^ v[i + 8u];
    }
}

uint32_t cam_blake2b_keyed(const uint8_t *key, uint32_t n_key, const uint8_t *bytes, uint32_t n)
{
    uint64_t h[8];
    uint8_t block[block_bytes] = {0};
    (void)memcpy(h, initial, sizeof h);
    h[0] ^= 0x01010000u ^ (uint64_t)n_key << 8 ^ (uint64_t)hash_bytes;
    (void)memcpy(block, key, n_key);
    take_block(h, block, block_bytes, false);
    (void)memset(block, 0, sizeof block);
    (void)memcpy(block, bytes, n);
    take_block(h, block, (uint64_t)block_bytes + n, true);
    return (uint32_t)(h[0] & UINT32_MAX);
}
