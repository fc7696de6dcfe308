// SPDX-License-Identifier: Apache-2.0
// SHA-512 against the examples of FIPS 180 (NIST, "SHA512.pdf", and the message of a million "a"),
// in one piece and in all divisions.
#include "cam_sha512.h"
#include "unity.h"
#include <stdio.h>  // snprintf
#include <string.h> // strlen, memset

static void expect_hash(const char *expected, cam_sha512_t *s)
{
    uint8_t hash[cam_sha512_bytes];
    char text[2 * cam_sha512_bytes + 1];
    cam_sha512_end(s, hash);
    for (int i = 0; i < cam_sha512_bytes; i++) {
        (void)snprintf(text + 2 * i, 3, "%02x", hash[i]);
    }
    TEST_ASSERT_EQUAL_STRING(expected, text);
}

static const char hash_of_two_blocks[] =
    "8e959b75dae313da8cf4f72814fc143f8f7779c6eb9f7fa17299aeadb6889018"
    "501d289e4900f7e4331b99dec4b5433ac7d329eeb6dd26545e96e55b874be909";
static const char two_blocks[] = "abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmn"
                                 "hijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmnopqrstnopqrstu";

static void test_the_examples_of_the_standard(void)
{
    cam_sha512_t s;
    cam_sha512_begin(&s);
    expect_hash("cf83e1357eefb8bdf1542850d66d8007d620e4050b5715dc83f4a921d36ce9ce"
                "47d0d13c5d85f2b0ff8318d2877eec2f63b931bd47417a81a538327af927da3e",
                &s);
    cam_sha512_begin(&s);
    cam_sha512_add(&s, "abc", 3);
    expect_hash("ddaf35a193617abacc417349ae20413112e6fa4e89a97ea20a9eeee64b55d39a"
                "2192992a274fc1a836ba3c23a3feebbd454d4423643ce80e2a9ac94fa54ca49f",
                &s);
    cam_sha512_begin(&s);
    cam_sha512_add(&s, two_blocks, strlen(two_blocks));
    expect_hash(hash_of_two_blocks, &s);
}

static void test_every_division_gives_the_same_hash(void)
{
    for (size_t n = 0; n <= strlen(two_blocks); n++) {
        cam_sha512_t s;
        cam_sha512_begin(&s);
        cam_sha512_add(&s, two_blocks, n);
        cam_sha512_add(&s, two_blocks + n, strlen(two_blocks) - n);
        expect_hash(hash_of_two_blocks, &s);
    }
}

static void test_a_million_a_in_pieces_of_any_length(void)
{
    static uint8_t as[1000];
    memset(as, 'a', sizeof as);
    cam_sha512_t s;
    cam_sha512_begin(&s);
    for (uint32_t i = 0, left = 1000000; left > 0u; i++) {
        const uint32_t n = i % 401u < left ? i % 401u : left;
        cam_sha512_add(&s, as, n);
        left -= n;
    }
    expect_hash("e718483d0ce769644e2e42c7bc15b4638e1f98b13b2044285632a803afa973eb"
                "de0ff244877ea60a4cb0432ce577c31beb009c5c2c49aa2e4eadb217ad8cc09b",
                &s);
}
