// SPDX-License-Identifier: Apache-2.0
#include "cam_sha512.h"
#include <string.h> // memcpy

enum { n_rounds = 80, n_words = 16, length_bytes = 16 };

/// Fractions of the cube roots of the first 80 primes. FIPS 180-4, 4.2.3.
static const uint64_t round_constant[n_rounds] = {
    0x428A2F98D728AE22u, 0x7137449123EF65CDu, 0xB5C0FBCFEC4D3B2Fu, 0xE9B5DBA58189DBBCu,
    0x3956C25BF348B538u, 0x59F111F1B605D019u, 0x923F82A4AF194F9Bu, 0xAB1C5ED5DA6D8118u,
    0xD807AA98A3030242u, 0x12835B0145706FBEu, 0x243185BE4EE4B28Cu, 0x550C7DC3D5FFB4E2u,
    0x72BE5D74F27B896Fu, 0x80DEB1FE3B1696B1u, 0x9BDC06A725C71235u, 0xC19BF174CF692694u,
    0xE49B69C19EF14AD2u, 0xEFBE4786384F25E3u, 0x0FC19DC68B8CD5B5u, 0x240CA1CC77AC9C65u,
    0x2DE92C6F592B0275u, 0x4A7484AA6EA6E483u, 0x5CB0A9DCBD41FBD4u, 0x76F988DA831153B5u,
    0x983E5152EE66DFABu, 0xA831C66D2DB43210u, 0xB00327C898FB213Fu, 0xBF597FC7BEEF0EE4u,
    0xC6E00BF33DA88FC2u, 0xD5A79147930AA725u, 0x06CA6351E003826Fu, 0x142929670A0E6E70u,
    0x27B70A8546D22FFCu, 0x2E1B21385C26C926u, 0x4D2C6DFC5AC42AEDu, 0x53380D139D95B3DFu,
    0x650A73548BAF63DEu, 0x766A0ABB3C77B2A8u, 0x81C2C92E47EDAEE6u, 0x92722C851482353Bu,
    0xA2BFE8A14CF10364u, 0xA81A664BBC423001u, 0xC24B8B70D0F89791u, 0xC76C51A30654BE30u,
    0xD192E819D6EF5218u, 0xD69906245565A910u, 0xF40E35855771202Au, 0x106AA07032BBD1B8u,
    0x19A4C116B8D2D0C8u, 0x1E376C085141AB53u, 0x2748774CDF8EEB99u, 0x34B0BCB5E19B48A8u,
    0x391C0CB3C5C95A63u, 0x4ED8AA4AE3418ACBu, 0x5B9CCA4F7763E373u, 0x682E6FF3D6B2B8A3u,
    0x748F82EE5DEFB2FCu, 0x78A5636F43172F60u, 0x84C87814A1F0AB72u, 0x8CC702081A6439ECu,
    0x90BEFFFA23631E28u, 0xA4506CEBDE82BDE9u, 0xBEF9A3F7B2C67915u, 0xC67178F2E372532Bu,
    0xCA273ECEEA26619Cu, 0xD186B8C721C0C207u, 0xEADA7DD6CDE0EB1Eu, 0xF57D4F7FEE6ED178u,
    0x06F067AA72176FBAu, 0x0A637DC5A2C898A6u, 0x113F9804BEF90DAEu, 0x1B710B35131C471Bu,
    0x28DB77F523047D84u, 0x32CAAB7B40C72493u, 0x3C9EBE0A15C9BEBCu, 0x431D67C49C100D4Cu,
    0x4CC5D4BECB3E42B6u, 0x597F299CFC657E2Au, 0x5FCB6FAB3AD6FAECu, 0x6C44198C4A475817u,
};

static uint64_t rotated(uint64_t x, uint32_t n)
{
    const uint32_t left = 64u - n;
    return x >> n | x << left;
}

static uint64_t big_endian(const uint8_t *bytes)
{
    uint64_t x = 0;
    for (uint32_t i = 0; i < 8u; i++) {
        x = x << 8 | bytes[i];
    }
    return x;
}

static void put_big_endian(uint8_t *bytes, uint64_t x)
{
    for (uint32_t i = 0; i < 8u; i++) {
        const uint32_t shift = 56u - 8u * i;
        bytes[i] = (uint8_t)(x >> shift & 0xFFu);
    }
}

/// @return word t of the schedule, of which the last 16 are kept. FIPS 180-4, 6.4.2, step 1.
static uint64_t scheduled(uint64_t w[n_words], uint32_t t)
{
    const uint64_t w15 = w[(t + 1u) % n_words];
    const uint64_t w2 = w[(t + 14u) % n_words];
    const uint64_t s0 = rotated(w15, 1) ^ rotated(w15, 8) ^ w15 >> 7;
    const uint64_t s1 = rotated(w2, 19) ^ rotated(w2, 61) ^ w2 >> 6;
    w[t % n_words] += s0 + w[(t + 9u) % n_words] + s1;
    return w[t % n_words];
}

/// Hash a block of 128 bytes. FIPS 180-4, 6.4.2.
static void take_block(uint64_t h[8], const uint8_t *block)
{
    uint64_t w[n_words] = {0};
    uint64_t v[8]; // a .. h of the standard
    (void)memcpy(v, h, sizeof v);
    for (uint32_t t = 0; t < (uint32_t)n_rounds; t++) {
        if (t < (uint32_t)n_words) {
            w[t] = big_endian(&block[t * sizeof w[0]]);
        }
        const uint64_t word = t < (uint32_t)n_words ? w[t] : scheduled(w, t);
        const uint64_t s1 = rotated(v[4], 14) ^ rotated(v[4], 18) ^ rotated(v[4], 41);
        const uint64_t choice = (v[4] & v[5]) ^ (~v[4] & v[6]);
        const uint64_t t1 = v[7] + s1 + choice + round_constant[t] + word;
        const uint64_t s0 = rotated(v[0], 28) ^ rotated(v[0], 34) ^ rotated(v[0], 39);
        const uint64_t majority = (v[0] & v[1]) ^ (v[0] & v[2]) ^ (v[1] & v[2]);
        for (uint32_t i = 7; i > 0u; i--) {
            v[i] = v[i - 1u];
        }
        v[4] += t1;
        v[0] = t1 + s0 + majority;
    }
    for (uint32_t i = 0; i < 8u; i++) {
        h[i] += v[i];
    }
}

void cam_sha512_begin(cam_sha512_t *s)
{
    // Fractions of the square roots of the first 8 primes. FIPS 180-4, 5.3.5.
    *s = (cam_sha512_t){
        .h = {0x6A09E667F3BCC908u, 0xBB67AE8584CAA73Bu, 0x3C6EF372FE94F82Bu, 0xA54FF53A5F1D36F1u,
              0x510E527FADE682D1u, 0x9B05688C2B3E6C1Fu, 0x1F83D9ABFB41BD6Bu, 0x5BE0CD19137E2179u},
    };
}

void cam_sha512_add(cam_sha512_t *s, const void *bytes, size_t n)
{
    const uint8_t *from = bytes;
    size_t left = n;
    while (left > 0u) {
        const size_t n_pending = (size_t)(s->n % (uint64_t)cam_sha512_block);
        const size_t room = (size_t)cam_sha512_block - n_pending;
        const size_t n_now = left < room ? left : room;
        if (n_now == (size_t)cam_sha512_block) {
            take_block(s->h, from); // in place: copying a table would cost a tenth
        } else {
            (void)memcpy(&s->pending[n_pending], from, n_now);
            if (n_now == room) {
                take_block(s->h, s->pending);
            }
        }
        s->n += n_now;
        from = &from[n_now];
        left -= n_now;
    }
}

void cam_sha512_end(cam_sha512_t *s, uint8_t hash[cam_sha512_bytes])
{
    uint8_t padding[cam_sha512_block] = {0};
    padding[0] = 0x80u;
    uint8_t length[length_bytes] = {0};
    put_big_endian(&length[8], s->n * 8u);
    const uint32_t n_pending = (uint32_t)(s->n % (uint64_t)cam_sha512_block);
    const uint32_t end = (uint32_t)cam_sha512_block - (uint32_t)length_bytes;
    cam_sha512_add(s, padding,
                   (size_t)(n_pending < end ? end - n_pending : end + 128u - n_pending));
    cam_sha512_add(s, length, sizeof length);
    for (uint32_t i = 0; i < 8u; i++) {
        put_big_endian(&hash[i * sizeof s->h[0]], s->h[i]);
    }
}
