// SPDX-License-Identifier: Apache-2.0
// An image is untrusted: every error in it is refused, with a code of its own, and a checked table
// has every field of its header. test_cam_entry.c has the errors of a channel.
#include "fixture_newer.h"
#include "image_bench.h"
#include <stdlib.h>
#include <string.h>

static cam_err_t with_field(uint32_t channel, size_t field, uint32_t value)
{
    return with_word(fixture_image_in(channel, field), value);
}

static void test_crc32_gives_the_check_value_whole_and_in_pieces(void)
{
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926u, cam_crc32(0, "123456789", 9));
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926u, cam_crc32(cam_crc32(0, "1234", 4), "56789", 5));
    TEST_ASSERT_EQUAL_HEX32(0, cam_crc32(0, "", 0));
}

static void test_good_image_is_accepted_and_described(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    const struct {
        uint32_t at, value;
    } rows[] = {
        {fixture_at_image_size, (uint32_t)table.image_size},
        {fixture_at_crc, table.crc32},
        {fixture_at_z_first, (uint32_t)table.z_first_nm},
        {fixture_at_spindle_peak, table.spindle_peak_ppm_per_rad},
        {fixture_at_z_last, (uint32_t)table.z_last_nm},
        {fixture_at_direction, (uint32_t)table.direction},
        {fixture_at_spindle, table.spindle_mrpm},
        {fixture_at_feed, table.feed_nm},
        {fixture_at_depth, table.depth_nm},
        {fixture_at_limit_stroke, table.limit_u_stroke_nm},
        {fixture_at_limit_speed, table.limit_u_speed_um_per_s},
        {fixture_at_limit_acceleration, table.limit_u_acceleration_mm_per_s2},
        {fixture_at_limit_spindle, table.limit_spindle_mrpm},
        {fixture_at_u_min, (uint32_t)table.u_min_nm},
        {fixture_at_u_max, (uint32_t)table.u_max_nm},
        {fixture_at_u1_peak, table.u1_peak_nm_per_rad},
        {fixture_at_u2_peak, table.u2_peak_nm_per_rad2},
    };
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uint32_t stored = fixture_image_get(&image, rows[i].at);
        TEST_ASSERT_EQUAL_HEX32(stored, rows[i].value);
        TEST_ASSERT_EQUAL((i == 2u || i == 3u), stored == 0u); // so that this is sharp
    }
    TEST_ASSERT_EQUAL_STRING((const char *)&image.bytes[fixture_at_name], table.name);
    TEST_ASSERT_EQUAL_PTR(image.bytes, table.image);
    TEST_ASSERT_EQUAL_UINT32(part.n_slices, table.u.n_slices);
    TEST_ASSERT_EQUAL_UINT32(part.n_x, table.x.n_slices);
    TEST_ASSERT_EQUAL_PTR(fixture_image_knots(&image, fixture_u), table.u.knots);
    TEST_ASSERT_EQUAL_PTR(fixture_image_knots(&image, fixture_x), table.x.knots);
}

/// Also with the 128 bytes of a signature, which earlier versions appended.
static void test_every_length_but_the_right_one_is_refused(void)
{
    for (size_t size = 0; size < image.size + 160u; size++) {
        const cam_err_t err = cam_table_check(image.bytes, size, &table);
        TEST_ASSERT_EQUAL_INT(size == image.size ? cam_ok : cam_err_image_size, err);
    }
    TEST_ASSERT_NULL(table.u.knots);
}

static void test_every_flipped_bit_is_refused(void)
{
    part = fixture_part_smallest();
    make();
    for (size_t bit = 0; bit < image.size * 8u; bit++) {
        image.bytes[bit / 8u] ^= (uint8_t)(1u << (bit % 8u));
        TEST_ASSERT_NOT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
        image.bytes[bit / 8u] ^= (uint8_t)(1u << (bit % 8u));
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
}

static void test_address_is_refused_when_null_or_misaligned(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_address, cam_table_check(NULL, 4096, &table));
    for (size_t off = 1; off < 4u; off++) {
        TEST_ASSERT_EQUAL_INT(cam_err_image_address,
                              cam_table_check(image.bytes + off, image.size - off, &table));
    }
}

static void test_fields_of_the_frame_have_their_own_codes(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_magic, with_word(fixture_at_magic, 0x544D4142u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_order, with_word(fixture_at_order, 0x04030201u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_version, with_word(fixture_at_version, 2u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_version, with_word(fixture_at_version, 0x00010001u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_version, with_word(fixture_at_version, 0x00020001u));
    const uint32_t size = (uint32_t)image.size;
    TEST_ASSERT_EQUAL_INT(cam_err_image_size, with_word(fixture_at_image_size, size - 32u));
    setUp();
    image.bytes[fixture_at_crc] ^= 1u;
    TEST_ASSERT_EQUAL_INT(cam_err_image_crc, cam_table_check(image.bytes, image.size, &table));
}

/// At its last good value and at a bad one. U from one end of its range to the other is a stroke of
/// 2^25 nm.
static void test_fields_of_the_header_are_limited(void)
{
    static const struct {
        const char *name;
        size_t at;
        uint32_t good, bad;
    } rows[] = {
        {"header size", fixture_at_header_size, 128, 124},
        {"header size 0", fixture_at_header_size, 128, 0},
        {"no channel", fixture_at_n_channels, 2, 0},
        {"channels", fixture_at_n_channels, 2, 9},
        {"most channels", fixture_at_n_channels, 2, UINT32_MAX},
        {"z first", fixture_at_z_first, 0, 0x80000000u},
        {"z first at the last", fixture_at_z_first, 0, 1000000},
        {"z last at the first", fixture_at_z_last, 1000000, 0},
        {"z last", fixture_at_z_last, 1000000, 0x7FFFFFFF},
        {"no direction", fixture_at_direction, 1, 0},
        {"direction", fixture_at_direction, 1, 2},
        {"least spindle", fixture_at_spindle, 1, 0},
        {"spindle", fixture_at_spindle, 60000000, 60000001},
        {"least feed", fixture_at_feed, 1, 0},
        {"feed", fixture_at_feed, 10000000, 10000001},
        {"depth", fixture_at_depth, 0x7FFFFFFF, 0x80000000u},
        {"least stroke", fixture_at_limit_stroke, 1, 0},
        {"stroke", fixture_at_limit_stroke, 33554432, 33554433},
        {"least speed", fixture_at_limit_speed, 1, 0},
        {"speed", fixture_at_limit_speed, 0x7FFFFFFF, 0x80000000u},
        {"least acceleration", fixture_at_limit_acceleration, 1, 0},
        {"acceleration", fixture_at_limit_acceleration, 0x7FFFFFFF, 0x80000000u},
        {"least spindle limit", fixture_at_limit_spindle, 1, 0},
        {"spindle limit", fixture_at_limit_spindle, 60000000, 60000001},
        {"least u", fixture_at_u_min, 0xFF000000u, 0x80000000u},
        {"least u above", fixture_at_u_min, 0xFF000000u, 16777217},
        {"largest u", fixture_at_u_max, 16777216, 16777217},
        {"largest u below", fixture_at_u_max, 16777216, 0x80000000u},
        {"u'", fixture_at_u1_peak, 0x7FFFFFFF, 0x80000000u},
        {"u''", fixture_at_u2_peak, 0x7FFFFFFF, 0x80000000u},
        {"spindle peak", fixture_at_spindle_peak, 0, 10000001},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(cam_ok, with_word(rows[i].at, rows[i].good), rows[i].name);
        TEST_ASSERT_EQUAL_INT_MESSAGE(cam_err_image_header, with_word(rows[i].at, rows[i].bad),
                                      rows[i].name);
    }
}

/// The entry of x gives the course of Z over the turns; a modulated spindle allows no ring-helix.
static void test_path_is_a_helix_or_a_ring_helix(void)
{
    for (uint32_t path = 0; path < 2u; path++) {
        TEST_ASSERT_EQUAL_INT(cam_ok, with_field(fixture_x, fixture_in_path, path));
        TEST_ASSERT_EQUAL(path == 1u, table.is_ring_helix);
    }
    part = fixture_part_modulated();
    TEST_ASSERT_EQUAL_INT(cam_ok, with_field(fixture_x, fixture_in_path, 0u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_field(fixture_x, fixture_in_path, 1u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_field(fixture_speed, fixture_in_path, 1u));
}

static void test_channel_that_is_twice_or_missing_is_refused(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_word(fixture_at_n_channels, 1u));
    part.log2_knots = 2;
    part.n_slices = 5; // x could be read as a second u
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_UINT32(
        5u * 12u, fixture_image_get(&image, fixture_image_in(fixture_x, fixture_in_size)));
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_field(fixture_u, fixture_in_kind, 2u));
    part = fixture_part_modulated();
    TEST_ASSERT_NOT_EQUAL_INT(cam_ok, with_field(fixture_u, fixture_in_kind, 3u));
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_field(fixture_x, fixture_in_kind, 3u));
}

/// A part with an angle channel in the place of its speed channel.
static void test_cam_has_one_angle_channel(void)
{
    part = fixture_part_modulated();
    for (uint32_t kind = 4; kind <= 5; kind++) { // swing, contact
        fixture_image_make(&image, &part);
        fixture_image_put(&image, fixture_image_in(fixture_speed, fixture_in_kind), kind);
        fixture_image_put(&image, fixture_at_spindle_peak, 0u);
        fixture_image_put(&image, fixture_at_u1_peak, 1000000u);
        fixture_image_put(&image, fixture_at_u2_peak, 1000000u);
        TEST_ASSERT_EQUAL_INT(cam_ok, check());
        TEST_ASSERT_NOT_NULL(table.angle.knots);
        TEST_ASSERT_NULL(table.speed.knots);
        TEST_ASSERT_EQUAL_INT(kind == 4u, table.is_swung);
        fixture_image_put(&image, fixture_image_in(fixture_u, fixture_in_kind), 9u - kind);
        TEST_ASSERT_EQUAL_INT_MESSAGE(cam_err_image_channel, check(), "two angles, no u");
    }
}

static void test_directory_beyond_the_image_is_refused(void)
{
    enum { header_size = 128 };
    part = fixture_part_smallest();
    TEST_ASSERT_EQUAL_INT(cam_err_image_layout, with_word(fixture_at_n_channels, 8u));
    image.size = header_size; // nothing after it is read
    fixture_image_put(&image, fixture_at_image_size, header_size);
    fixture_image_seal(&image);
    uint8_t *alone = malloc(header_size);
    TEST_ASSERT_NOT_NULL(alone);
    memcpy(alone, image.bytes, header_size);
    TEST_ASSERT_EQUAL_INT(cam_err_image_layout, cam_table_check(alone, header_size, &table));
    free(alone);
}

/// A knot that the arithmetic cannot hold is refused as that, before it is compared with what the
/// entry promises.
static void test_knot_beyond_the_arithmetic_is_refused_before_it_is_compared(void)
{
    for (uint32_t i = 0; i < 24u; i++) {
        setUp();
        const int32_t over = i < 12u ? 0 : 1;
        const int32_t value = (i % 2u == 0u ? 1 : -1) * ((1 << 25) - 1 + over);
        cam_knot_t *k = fixture_image_knots(&image, i % 12u < 6u ? fixture_u : fixture_x);
        *(i / 2u % 3u == 0u ? &k->p : i / 2u % 3u == 1u ? &k->v : &k->a) = value;
        TEST_ASSERT_EQUAL_INT(over == 1 ? cam_err_image_knots : cam_err_image_limits, check());
    }
}

/// A name has 1 to 31 printable characters and zeros up to its end.
static void test_name_has_a_character_and_an_end(void)
{
    uint8_t *const name = &image.bytes[fixture_at_name];
    for (uint32_t n = 0; n <= cam_table_name_size; n++) {
        setUp();
        memset(name, 0, cam_table_name_size);
        memset(name, n % 2u == 0u ? 0x20 : 0x7E, n);
        const bool is_good = n > 0u && n < cam_table_name_size;
        TEST_ASSERT_EQUAL_INT(is_good ? cam_ok : cam_err_image_name, check());
    }
    static const uint8_t bad[] = {0x1F, 0x7F, 0x80, 0xFF};
    for (uint32_t i = 0; i < 2u * sizeof bad; i++) {
        setUp();
        name[i % 2u == 0u ? 1 : 30] = bad[i / 2u]; // in it, and after its end
        TEST_ASSERT_EQUAL_INT(cam_err_image_name, check());
    }
}

static void test_passes_are_sixteen_at_most_and_there_once(void)
{
    static fixture_pass_t passes[17];
    for (uint32_t n = 17; n >= 16u; n--) {
        setUp();
        for (uint32_t i = 0; i < n; i++) {
            passes[i] = (fixture_pass_t){.allowance_nm = (int32_t)(1000u * (n - 1u - i)),
                                         .feed_nm = 100000,
                                         .spindle_mrpm = 1000000};
        }
        fixture_newer_passes(&image, passes, n);
        TEST_ASSERT_EQUAL(n == 16u, check() == cam_ok);
        TEST_ASSERT_TRUE(n == 17u || table.n_passes == 16u);
    }
    fixture_newer_passes(&image, passes, 16);
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check());
}
