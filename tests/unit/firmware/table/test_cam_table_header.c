// SPDX-License-Identifier: Apache-2.0
// What a checked table tells of its header, field by field, and what may follow the image.
#include "cam_table.h"
#include "fixture_image.h"
#include "fixture_newer.h"
#include "unity.h"
#include <string.h> // memcpy

enum { block = 128, room = 4 };

static fixture_image_t image;
static cam_table_t table;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
}

static uint32_t word(uint32_t at)
{
    return fixture_image_get(&image, at);
}

static void expect(uint32_t at, uint32_t told)
{
    TEST_ASSERT_NOT_EQUAL_UINT32(0, word(at));
    TEST_ASSERT_EQUAL_HEX32(word(at), told);
}

static void test_fields_are_told_as_they_stand(void)
{
    fixture_image_put(&image, fixture_at_error, 123456);
    fixture_image_seal(&image);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    expect(fixture_at_image_size, (uint32_t)table.image_size);
    expect(fixture_at_crc, table.crc32);
    expect(fixture_at_z_last, (uint32_t)table.z_last_nm);
    TEST_ASSERT_EQUAL_HEX32(word(fixture_at_z_first), (uint32_t)table.z_first_nm);
    expect(fixture_at_direction, (uint32_t)table.direction);
    expect(fixture_at_spindle, table.spindle_mrpm);
    expect(fixture_at_feed, table.feed_nm);
    expect(fixture_at_depth, table.depth_nm);
    expect(fixture_at_limit_stroke, table.limit_u_stroke_nm);
    expect(fixture_at_limit_speed, table.limit_u_speed_um_per_s);
    expect(fixture_at_limit_acceleration, table.limit_u_acceleration_mm_per_s2);
    expect(fixture_at_limit_spindle, table.limit_spindle_mrpm);
    expect(fixture_at_u_min, (uint32_t)table.u_min_nm);
    expect(fixture_at_u_max, (uint32_t)table.u_max_nm);
    expect(fixture_at_u1_peak, table.u1_peak_nm_per_rad);
    expect(fixture_at_u2_peak, table.u2_peak_nm_per_rad2);
    expect(fixture_at_error, table.error_pm);
    TEST_ASSERT_EQUAL_HEX32(word(fixture_at_spindle_peak), table.spindle_peak_ppm_per_rad);
    TEST_ASSERT_EQUAL_STRING((const char *)&image.bytes[fixture_at_name], table.name);
    TEST_ASSERT_EQUAL_PTR(image.bytes, table.image);
}

/// Behind the image is nothing, or the block of a signature and nothing behind that.
static void test_image_is_followed_by_a_signature_or_nothing(void)
{
    static const uint8_t magic[8] = {0x43, 0x41, 0x4D, 0x53, 0x49, 0x47, 0x1A, 0x0A};
    uint8_t *bytes = image.bytes;
    TEST_ASSERT_LESS_OR_EQUAL_size_t(sizeof image.bytes, image.size + block + room);
    memset(&bytes[image.size], 0, block + room);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(bytes, image.size, &table));
    TEST_ASSERT_EQUAL_INT(cam_err_image_size, cam_table_check(bytes, image.size + block, &table));
    memcpy(&bytes[image.size], magic, sizeof magic);
    for (uint32_t more = 0; more <= room; more++) {
        TEST_ASSERT_EQUAL_INT(more == 0u ? cam_ok : cam_err_image_size,
                              cam_table_check(bytes, image.size + block + more, &table));
    }
    TEST_ASSERT_EQUAL_INT(cam_err_image_size,
                          cam_table_check(bytes, image.size + block - 1u, &table));
}

/// A name has 1 to 31 printable characters and zeros behind them.
static void test_name_has_a_character_and_an_end(void)
{
    for (uint32_t n = 0; n <= cam_table_name_size; n++) {
        setUp();
        memset(&image.bytes[fixture_at_name], 0, cam_table_name_size);
        memset(&image.bytes[fixture_at_name], n % 2u == 0u ? 0x20 : 0x7E, n);
        fixture_image_seal(&image);
        const bool is_good = n > 0u && n < cam_table_name_size;
        TEST_ASSERT_EQUAL_INT(is_good ? cam_ok : cam_err_image_name,
                              cam_table_check(image.bytes, image.size, &table));
    }
    static const uint8_t bad[] = {0x1F, 0x7F, 0x80, 0xFF};
    for (uint32_t i = 0; i < sizeof bad; i++) {
        for (uint32_t at = 1; at < cam_table_name_size; at += 29u) { // in it, and behind its end
            setUp();
            image.bytes[fixture_at_name + at] = bad[i];
            fixture_image_seal(&image);
            TEST_ASSERT_EQUAL_INT(cam_err_image_name,
                                  cam_table_check(image.bytes, image.size, &table));
        }
    }
}

/// The most passes of the format are taken, one more is refused.
static void test_passes_are_sixteen_at_most(void)
{
    static fixture_pass_t passes[17];
    for (uint32_t i = 0; i < 17u; i++) {
        passes[i] = (fixture_pass_t){.allowance_nm = (int32_t)(16000u - 1000u * i),
                                     .feed_nm = 100000,
                                     .spindle_mrpm = 1000000};
    }
    passes[15].allowance_nm = 0;
    fixture_newer_passes(&image, passes, 16);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    TEST_ASSERT_EQUAL_UINT32(16, table.n_passes);
    setUp();
    passes[15].allowance_nm = 1000;
    passes[16].allowance_nm = 0;
    fixture_newer_passes(&image, passes, 17);
    TEST_ASSERT_NOT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
}
