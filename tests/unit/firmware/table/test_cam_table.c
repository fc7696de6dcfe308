// SPDX-License-Identifier: Apache-2.0
// An image is untrusted: every error in it is refused, with a code of its own. test_cam_entry.c has
// those of a channel, test_cam_table_header.c the name.
#include "fixture_image.h"
#include "unity.h"
#include <stdlib.h>
#include <string.h>

static fixture_image_t image;
static fixture_part_t part;
static cam_table_t table;

void setUp(void)
{
    part = fixture_part_short();
    fixture_image_make(&image, &part);
}

static cam_err_t check(void)
{
    return cam_table_check(image.bytes, image.size, &table);
}

/// @return result of the check when one word of the header is changed and the CRC is valid
static cam_err_t with_word(size_t at, uint32_t value)
{
    fixture_image_make(&image, &part);
    fixture_image_put(&image, at, value);
    fixture_image_seal(&image);
    return check();
}

static cam_err_t with_field(uint32_t channel, size_t field, uint32_t value)
{
    return with_word(fixture_image_in(channel, field), value);
}

static uint32_t field(uint32_t channel, size_t name)
{
    return fixture_image_get(&image, fixture_image_in(channel, name));
}

static void test_crc32_gives_the_check_value_whole_and_in_pieces(void)
{
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926u, cam_crc32(0, "123456789", 9));
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926u, cam_crc32(cam_crc32(0, "1234", 4), "56789", 5));
    TEST_ASSERT_EQUAL_HEX32(0, cam_crc32(0, "", 0));
}

static void test_check_good_image_is_accepted_and_described(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    TEST_ASSERT_EQUAL_UINT32(part.n_slices, table.u.n_slices);
    TEST_ASSERT_EQUAL_UINT32(part.n_x, table.x.n_slices);
    TEST_ASSERT_EQUAL_PTR(fixture_image_knots(&image, fixture_u), table.u.knots);
    TEST_ASSERT_EQUAL_PTR(fixture_image_knots(&image, fixture_x), table.x.knots);
}

static void test_check_every_length_but_the_right_one_is_refused(void)
{
    for (size_t size = 0; size < image.size + 64u; size++) {
        const cam_err_t err = cam_table_check(image.bytes, size, &table);
        TEST_ASSERT_EQUAL_INT(size == image.size ? cam_ok : cam_err_image_size, err);
    }
    TEST_ASSERT_NULL(table.u.knots);
}

static void test_check_every_flipped_bit_is_refused(void)
{
    part = fixture_part_smallest();
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    for (size_t bit = 0; bit < image.size * 8u; bit++) {
        image.bytes[bit / 8u] ^= (uint8_t)(1u << (bit % 8u));
        TEST_ASSERT_NOT_EQUAL_INT(cam_ok, check());
        image.bytes[bit / 8u] ^= (uint8_t)(1u << (bit % 8u));
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
}

static void test_check_address_is_refused_when_null_or_misaligned(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_address, cam_table_check(NULL, 4096, &table));
    for (size_t off = 1; off < 4u; off++) {
        TEST_ASSERT_EQUAL_INT(cam_err_image_address,
                              cam_table_check(image.bytes + off, image.size - off, &table));
    }
}

static void test_check_frame_fields_have_their_own_codes(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_magic, with_word(fixture_at_magic, 0x544D4142u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_order, with_word(fixture_at_order, 0x04030201u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_version, with_word(fixture_at_version, 2u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_version, with_word(fixture_at_version, 0x00010001u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_size,
                          with_word(fixture_at_image_size, (uint32_t)image.size - 32u));
    fixture_image_make(&image, &part);
    image.bytes[fixture_at_crc] ^= 1u;
    TEST_ASSERT_EQUAL_INT(cam_err_image_crc, check());
}

typedef struct {
    size_t at;
    uint32_t value;
} word_t;

static void test_check_header_fields_out_of_range_are_refused(void)
{
    static const word_t bad[] = {
        {fixture_at_header_size, 124u},       {fixture_at_header_size, 0u},
        {fixture_at_n_channels, 0u},          {fixture_at_n_channels, 9u},
        {fixture_at_n_channels, UINT32_MAX},  {fixture_at_z_first, 0x80000000u},
        {fixture_at_z_first, 1000000u},       {fixture_at_z_last, 0u},
        {fixture_at_z_last, 0x7FFFFFFFu},     {fixture_at_direction, 0u},
        {fixture_at_direction, 2u},           {fixture_at_spindle, 0u},
        {fixture_at_spindle, 60000001u},      {fixture_at_feed, 0u},
        {fixture_at_feed, 10000001u},         {fixture_at_depth, 0x80000000u},
        {fixture_at_limit_stroke, 0u},        {fixture_at_limit_stroke, 33554433u},
        {fixture_at_limit_speed, 0u},         {fixture_at_limit_speed, 0x80000000u},
        {fixture_at_limit_acceleration, 0u},  {fixture_at_limit_acceleration, 0x80000000u},
        {fixture_at_limit_spindle, 0u},       {fixture_at_limit_spindle, 60000001u},
        {fixture_at_u_min, 0x80000000u},      {fixture_at_u_min, 16777217u},
        {fixture_at_u_max, 0x80000000u},      {fixture_at_u_max, 16777217u},
        {fixture_at_u1_peak, 0x80000000u},    {fixture_at_u2_peak, 0x80000000u},
        {fixture_at_spindle_peak, 10000001u},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(cam_err_image_header, with_word(bad[i].at, bad[i].value),
                                      "header field");
    }
}

/// The ends of the ranges themselves are good: U from one end of its range to the other is a stroke
/// of 2^25 nm.
static void test_check_header_fields_at_the_ends_of_their_ranges_are_accepted(void)
{
    static const word_t good[] = {
        {fixture_at_spindle, 1u},
        {fixture_at_spindle, 60000000u},
        {fixture_at_feed, 1u},
        {fixture_at_feed, 10000000u},
        {fixture_at_depth, 0u},
        {fixture_at_depth, 0x7FFFFFFFu},
        {fixture_at_limit_stroke, 1u},
        {fixture_at_limit_stroke, 16777217u},
        {fixture_at_limit_speed, 1u},
        {fixture_at_limit_stroke, 33554432u},
        {fixture_at_limit_spindle, 1u},
        {fixture_at_limit_speed, 0x7FFFFFFFu},
        {fixture_at_u_min, 0xFF000000u},
        {fixture_at_limit_spindle, 60000000u},
        {fixture_at_u_max, 16777216u},
        {fixture_at_limit_acceleration, 1u},
        {fixture_at_u1_peak, 0x7FFFFFFF},
        {fixture_at_limit_acceleration, 0x7FFFFFFFu},
        {fixture_at_u2_peak, 0x7FFFFFFF},
    };
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(cam_ok, with_word(good[i].at, good[i].value), "header field");
    }
}

/// The entry of x says how Z follows the turns; a modulated spindle allows no ring-helix.
static void test_check_path_is_a_helix_or_a_ring_helix(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, with_field(fixture_x, fixture_in_path, 0u));
    TEST_ASSERT_FALSE(table.is_ring_helix);
    TEST_ASSERT_EQUAL_INT(cam_ok, with_field(fixture_x, fixture_in_path, 1u));
    TEST_ASSERT_TRUE(table.is_ring_helix);
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_field(fixture_x, fixture_in_path, 2u));
    part = fixture_part_modulated();
    TEST_ASSERT_EQUAL_INT(cam_ok, with_field(fixture_x, fixture_in_path, 0u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_field(fixture_x, fixture_in_path, 1u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_field(fixture_speed, fixture_in_path, 1u));
}

static void test_check_twice_or_missing_channel_is_refused(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_word(fixture_at_n_channels, 1u));
    part.log2_knots = 2;
    part.n_slices = 5; // x could be read as a second u
    fixture_image_make(&image, &part);
    const uint32_t size = field(fixture_x, fixture_in_size);
    TEST_ASSERT_EQUAL_UINT32(5u * 12u, size);
    fixture_image_put(&image, fixture_image_in(fixture_u, fixture_in_kind), 2u);
    fixture_image_seal(&image);
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check());
}

/// A part with an angle channel in the place of its speed channel.
static void make_cam(uint32_t kind)
{
    part = fixture_part_modulated();
    fixture_image_make(&image, &part);
    fixture_image_put(&image, fixture_image_in(fixture_speed, fixture_in_kind), kind);
    fixture_image_put(&image, fixture_at_spindle_peak, 0u);
    fixture_image_put(&image, fixture_at_u1_peak, 1000000u);
    fixture_image_put(&image, fixture_at_u2_peak, 1000000u);
    fixture_image_seal(&image);
}

static void test_check_cam_has_one_angle_channel_within_a_quarter_turn(void)
{
    for (uint32_t kind = 4; kind <= 5; kind++) { // swing, contact
        make_cam(kind);
        TEST_ASSERT_EQUAL_INT(cam_ok, check());
        TEST_ASSERT_NOT_NULL(table.angle.knots);
        TEST_ASSERT_NULL(table.speed.knots);
        TEST_ASSERT_EQUAL_INT(kind == 4u, table.is_swung);
        fixture_image_put(&image, fixture_image_in(fixture_speed, fixture_in_value_offset),
                          (uint32_t)CAM_TABLE_ANGLE_MAX);
        fixture_image_seal(&image);
        TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check());
    }
    make_cam(4);
    fixture_image_put(&image, fixture_image_in(fixture_u, fixture_in_kind), 5u);
    fixture_image_seal(&image);
    TEST_ASSERT_EQUAL_INT_MESSAGE(cam_err_image_channel, check(), "two angles, no u");
}

static void test_check_directory_beyond_the_image_is_refused(void)
{
    part = fixture_part_smallest();
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_err_image_layout, with_word(fixture_at_n_channels, 8u));
    enum { header_size = 128 };
    image.size = header_size; // nothing behind it is looked at
    fixture_image_put(&image, fixture_at_image_size, header_size);
    fixture_image_seal(&image);
    uint8_t *alone = malloc(header_size);
    TEST_ASSERT_NOT_NULL(alone);
    memcpy(alone, image.bytes, header_size);
    TEST_ASSERT_EQUAL_INT(cam_err_image_layout, cam_table_check(alone, header_size, &table));
    free(alone);
}

static void test_check_values_beyond_the_promise_of_the_header_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, with_word(fixture_at_u_max, 140000u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, with_word(fixture_at_u_min, 10u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, with_word(fixture_at_u1_peak, 140000u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, with_word(fixture_at_u2_peak, 280000u));
}
