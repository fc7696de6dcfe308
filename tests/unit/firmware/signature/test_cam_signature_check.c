// SPDX-License-Identifier: Apache-2.0
// Signed tables: the vectors of RFC 8032, the policy as a matrix, every bit of block and header
// turned over, tables cut off, blocks of other formats, other keys.
#include "cam_signature_check.h"
#include "fixture_image.h"
#include "fixture_sign.h"
#include "hal_host.h"
#include "unity.h"
#include <string.h> // memcpy, memset

/// Emulated cores verify a hundred times more slowly than the host; there every 61st bit is turned.
enum { step = sizeof(void *) == 4u ? 61 : 1 };

static fixture_image_t image;
static fixture_keys_t keys, others;
static uint8_t trusted[2 * fixture_key_size];

static void trust(uint32_t n_keys, bool is_required)
{
    memcpy(trusted, others.public, fixture_key_size); // the right one is the second
    memcpy(trusted + fixture_key_size, keys.public, fixture_key_size);
    hal_host.slow.trust =
        (hal_trust_t){.keys = trusted, .n_keys = n_keys, .is_required = is_required};
}

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    keys = fixture_keys(1);
    others = fixture_keys(2);
    fixture_image_make(&image, &part);
    trust(2, true);
}

static cam_signature_check_t verdict;

static cam_err_t check(size_t size)
{
    cam_table_t table;
    const cam_err_t err = cam_signature_check_table(image.bytes, size, &table, &verdict);
    TEST_ASSERT_TRUE(err == cam_ok ||
                     (table.image == NULL && verdict.kind == cam_signature_check_unsigned));
    return err;
}

static void hex(const char *text, uint8_t *bytes)
{
    for (size_t i = 0; text[2 * i] != '\0'; i++) {
        const char *digits = "0123456789abcdef";
        const long high = strchr(digits, text[2 * i]) - digits;
        const long low = strchr(digits, text[2 * i + 1]) - digits;
        bytes[i] = (uint8_t)(high * 16 + low);
    }
}

/// RFC 8032, 7.1: TEST 1, 2, 3 and SHA(abc).
static void test_the_vectors_of_rfc_8032_hold(void)
{
    static const char *const vectors[][3] = {
        {"d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a", "",
         "e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e065224901555fb8821590a33bacc61e397"
         "01cf9b46bd25bf5f0595bbe24655141438e7a100b"},
        {"3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c", "72",
         "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da085ac1e43e15996e458f361"
         "3d0f11d8c387b2eaeb4302aeeb00d291612bb0c00"},
        {"fc51cd8e6218a1a38da47ed00230f0580816ed13ba3303ac5deb911548908025", "af82",
         "6291d657deec24024827e69c3abe01a30ce548a284743a445e3680d7db5ac3ac18ff9b538d16f290ae67f76"
         "0984dc6594a7c15e9716ed28dc027beceea1ec40a"},
        {"ec172b93ad5e563bf4932c70e1245034c35467ef2efd4d64ebf819683467e2bf",
         "ddaf35a193617abacc417349ae20413112e6fa4e89a97ea20a9eeee64b55d39a2192992a274fc1a836ba3c2"
         "3a3feebbd454d4423643ce80e2a9ac94fa54ca49f",
         "dc2a4459e7369633a52b1bf277839a00201009a3efbf3ecb69bea2186c26b58909351fc9ac90b3ecfdfbc7c"
         "66431e0303dca179c138ac17ad9bef1177331a704"},
    };
    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        uint8_t key[32], message[64], signature[64];
        hex(vectors[i][0], key);
        hex(vectors[i][1], message);
        hex(vectors[i][2], signature);
        const size_t n = strlen(vectors[i][1]) / 2;
        TEST_ASSERT_TRUE(cam_signature_check_is_signed_by(key, message, n, signature));
        signature[63] ^= 0x10u; // S + 2^252 is not below the order
        TEST_ASSERT_FALSE(cam_signature_check_is_signed_by(key, message, n, signature));
    }
}

static void test_the_policy_as_a_matrix(void)
{
    static const struct {
        uint32_t n_keys;
        bool is_required;
        cam_err_t not_signed, of_trusted, of_other, wrong;
    } rows[] = {
        {2, true, cam_err_sign_none, cam_ok, cam_err_sign_key, cam_err_sign_wrong},
        {2, false, cam_ok, cam_ok, cam_err_sign_key, cam_err_sign_wrong},
        {0, false, cam_ok, cam_ok, cam_ok, cam_ok},
        {0, true, cam_err_sign_no_keys, cam_err_sign_no_keys, cam_err_sign_no_keys,
         cam_err_sign_no_keys},
    };
    const fixture_keys_t third = fixture_keys(3);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        setUp();
        trust(rows[i].n_keys, rows[i].is_required);
        TEST_ASSERT_EQUAL_INT(rows[i].not_signed, check(image.size));
        fixture_sign(&image, &third);
        TEST_ASSERT_EQUAL_INT(rows[i].of_other, check(image.size));
        fixture_sign(&image, &keys);
        TEST_ASSERT_EQUAL_INT(rows[i].of_trusted, check(image.size));
        image.bytes[image.size - 1] ^= 1u;
        TEST_ASSERT_EQUAL_INT(rows[i].wrong, check(image.size));
    }
}

/// The eight points of small order, in each of the ways in which they can be written, and what lies
/// beyond the prime: with such a key somebody signs who has no secret.
static const char *const weak[] = {
    "0100000000000000000000000000000000000000000000000000000000000000", // order 1
    "ecffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff7f", // 2
    "0000000000000000000000000000000000000000000000000000000000000000", // 4: the key of zeros
    "0000000000000000000000000000000000000000000000000000000000000080", // 4
    "26e8958fc2b227b045c3f489f2ef98f0d5dfac05d3c63339b13802886d53fc05", // 8
    "26e8958fc2b227b045c3f489f2ef98f0d5dfac05d3c63339b13802886d53fc85", // 8
    "c7176a703d4dd84fba3c0b760d10670f2a2053fa2c39ccc64ec7fd7792ac037a", // 8
    "c7176a703d4dd84fba3c0b760d10670f2a2053fa2c39ccc64ec7fd7792ac03fa", // 8
    "0100000000000000000000000000000000000000000000000000000000000080", // x = 0, and a sign
    "ecffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff",
    "edffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff7f", // p is 0
    "edffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff",
    "eeffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff7f", // p + 1 is 1
    "eeffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff",
    "f0ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff7f", // p + 3
    "ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff",
};

static void test_weak_keys_are_known(void)
{
    uint8_t key[32];
    for (size_t i = 0; i < sizeof weak / sizeof weak[0]; i++) {
        hex(weak[i], key);
        TEST_ASSERT_TRUE_MESSAGE(cam_signature_check_is_weak(key), weak[i]);
    }
    for (uint32_t i = 1; i < 20u; i++) {
        const fixture_keys_t honest = fixture_keys((uint8_t)i);
        TEST_ASSERT_FALSE(cam_signature_check_is_weak(honest.public));
    }
    hex("ebffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff7f", key); // p - 2
    TEST_ASSERT_FALSE(cam_signature_check_is_weak(key));
}

/// R = 0 and s = 0 are a signature of the point of order 1 over anything.
static void test_a_table_signed_for_a_weak_key_is_refused_where_that_key_was_named(void)
{
    hex(weak[0], keys.public);
    fixture_sign(&image, &keys);
    uint8_t *signature = &image.bytes[image.size - 64];
    memset(signature, 0, 64);
    signature[0] = 1;
    TEST_ASSERT_TRUE(
        cam_signature_check_is_signed_by(keys.public, image.bytes, image.size - 64, signature));
    trust(2, true);
    TEST_ASSERT_EQUAL_INT(cam_err_sign_key, check(image.size));
}

static void test_the_verdict_names_the_key(void)
{
    trust(2, false);
    TEST_ASSERT_EQUAL_INT(cam_ok, check(image.size));
    TEST_ASSERT_EQUAL_INT(cam_signature_check_unsigned, verdict.kind);
    fixture_sign(&image, &keys);
    TEST_ASSERT_EQUAL_INT(cam_ok, check(image.size));
    TEST_ASSERT_EQUAL_INT(cam_signature_check_signed, verdict.kind);
    TEST_ASSERT_EQUAL_MEMORY(image.bytes + image.size - 128 + 16, verdict.key_id, 8);
    trust(0, false);
    TEST_ASSERT_EQUAL_INT(cam_ok, check(image.size));
    TEST_ASSERT_EQUAL_INT(cam_signature_check_unchecked, verdict.kind);
}

/// In every one of the 1024 bits of the block, and with signatures required.
static void test_every_bit_of_the_block_counts(void)
{
    fixture_sign(&image, &keys);
    const size_t from = (image.size - (size_t)fixture_block_size) * 8u;
    for (size_t bit = from; bit < image.size * 8u; bit += (size_t)step) {
        image.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        TEST_ASSERT_NOT_EQUAL(cam_ok, check(image.size));
        image.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, check(image.size));
}

/// An attacker computes the CRC anew, so that the signature alone, or the check, can refuse.
static void test_every_bit_of_the_header_counts_with_a_right_crc(void)
{
    fixture_sign(&image, &keys);
    uint32_t n_by_signature = 0;
    for (size_t bit = 0; bit < (size_t)cam_table_header_size * 8u; bit += (size_t)step) {
        const size_t size = image.size;
        image.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        image.size -= fixture_block_size;
        if (bit / 32u != fixture_at_crc / 4u) {
            fixture_image_seal(&image);
        }
        image.size = size;
        const cam_err_t err = check(image.size);
        TEST_ASSERT_NOT_EQUAL(cam_ok, err);
        n_by_signature += err == cam_err_sign_wrong ? 1u : 0u;
        setUp();
        fixture_sign(&image, &keys);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(300u / (uint32_t)step, n_by_signature);
}

static void test_a_knot_that_changed_with_the_crc_is_refused(void)
{
    fixture_sign(&image, &keys);
    fixture_image_knots(&image, fixture_u)[7].p ^= 1;
    const size_t size = image.size;
    image.size -= fixture_block_size;
    fixture_image_seal(&image);
    TEST_ASSERT_EQUAL_INT(cam_err_sign_wrong, check(size));
    trust(2, false); // a wrong signature is refused where none is required, too
    TEST_ASSERT_EQUAL_INT(cam_err_sign_wrong, check(size));
}

static void test_a_block_that_is_cut_off_is_no_table(void)
{
    fixture_sign(&image, &keys);
    trust(2, false);
    const size_t without = image.size - (size_t)fixture_block_size;
    for (size_t size = without + 1u; size < image.size; size++) {
        TEST_ASSERT_EQUAL_INT(cam_err_image_size, check(size));
    }
    TEST_ASSERT_EQUAL_INT(cam_err_image_size, check(image.size + 32u));
    TEST_ASSERT_EQUAL_INT(cam_ok, check(without)); // stripped: unsigned, which is optional here
    trust(2, true);
    TEST_ASSERT_EQUAL_INT(cam_err_sign_none, check(without));
}

/// A signature is good for its own image only, however right the key is.
static void test_the_signature_of_another_table_is_refused(void)
{
    fixture_sign(&image, &keys);
    uint8_t block[fixture_block_size];
    const size_t at = image.size - sizeof block;
    memcpy(block, image.bytes + at, sizeof block);
    image.bytes[fixture_at_name] ^= 1u;
    image.size = at;
    fixture_image_seal(&image);
    TEST_ASSERT_EQUAL_INT(cam_err_sign_wrong, check(at + sizeof block));
    TEST_ASSERT_EQUAL_MEMORY(block, image.bytes + at, sizeof block);
}

/// Fields that this firmware does not know are refused although the key signed them.
static void test_blocks_of_another_format_are_refused(void)
{
    static const size_t fields[] = {8, 11, 12, 15, 24, 63}; // version, size, zeros
    fixture_sign(&image, &keys);
    const size_t size = image.size - (size_t)fixture_block_size;
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        fixture_sign(&image, &keys);
        image.bytes[size + fields[i]] ^= 0x40u;
        fixture_sign_anew(image.bytes, size, &keys);
        TEST_ASSERT_EQUAL_INT(cam_err_sign_block, check(image.size));
    }
}
