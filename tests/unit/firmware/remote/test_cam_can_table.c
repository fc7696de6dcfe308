// SPDX-License-Identifier: Apache-2.0
// A place without a table, erased, with foreign bytes, another version, a table cut off or
// overwritten. The controller starts all the same, refuses to home and reports why, until a good
// table is selected.
#include "cam_can.h"
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"
#include <stdio.h>  // snprintf
#include <string.h> // memset

enum { enable = 1, disable = 2, start = 3, reset = 5, table_anew = 8 };

static fixture_can_t f;
static fixture_part_t part;
static fixture_image_t other;

void setUp(void)
{
    part = fixture_part_short();
    fixture_can_init(&f, &part, 20000);
}

static int32_t send(uint8_t command)
{
    return fixture_can_command(&f, command, 0, 0).result;
}

static void expect_line(cam_err_t err, const char *behind)
{
    char line[200];
    (void)snprintf(line, sizeof line, "table: %s%s", cam_err_text(err), behind);
    TEST_ASSERT_EQUAL_STRING(line, fixture_can_line(0));
}

static void expect_table_result(cam_err_t err)
{
    fixture_can_loop(&f, 201);
    const hal_can_frame_t frame = fixture_can_sent(0x1C0);
    TEST_ASSERT_EQUAL_INT32(err, fixture_can_i16(&frame, 2));
}

/// The controller starts, refuses to home, and reports why in a line, the status and the answer.
static void expect_start_without_table(cam_err_t err)
{
    fixture_can_start(&f);
    expect_line(err, " - home refused until a table is written");
    expect_table_result(err);
    const fixture_answer_t answer = fixture_can_command(&f, enable, 0, 0);
    TEST_ASSERT_EQUAL_INT32(err, answer.result);
    TEST_ASSERT_EQUAL_INT32(0, answer.value);
    TEST_ASSERT_EQUAL_INT32(err, send(table_anew));
    fixture_can_loop(&f, 3);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
}

static void expect_homing(void)
{
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(enable));
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT(cam_state_homing, fixture_rig_state());
}

static void test_a_good_table_in_a_larger_sector_is_taken(void)
{
    fixture_can_start(&f);
    TEST_ASSERT_EQUAL_STRING("table: short skirt in use", fixture_can_line(0));
    TEST_ASSERT_EQUAL_UINT32(f.rig.image.size, f.rig.machine.table.image_size);
    expect_table_result(cam_ok);
    expect_homing();
}

static void test_a_good_table_that_fills_its_place_is_taken(void)
{
    hal_host.slow.table.size = (uint32_t)f.rig.image.size;
    fixture_can_start(&f);
    expect_homing();
}

static void test_no_place(void)
{
    hal_host.slow.table = (hal_image_t){.bytes = NULL, .size = 0};
    expect_start_without_table(cam_err_no_table);
    hal_host.slow.table = (hal_image_t){.bytes = f.rig.image.bytes, .size = 0};
    expect_start_without_table(cam_err_no_table);
    hal_host.slow.table = (hal_image_t){.bytes = NULL, .size = 1024};
    expect_start_without_table(cam_err_no_table);
}

static void test_erased_place(void)
{
    memset(f.rig.image.bytes, 0xFF, sizeof f.rig.image.bytes);
    expect_start_without_table(cam_err_image_magic);
    memset(f.rig.image.bytes, 0, sizeof f.rig.image.bytes);
    expect_start_without_table(cam_err_image_magic);
}

static void test_writing_that_stopped_is_refused_wherever_it_stopped(void)
{
    static uint8_t good[8192];
    const uint32_t size = (uint32_t)f.rig.image.size;
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(sizeof good, size);
    memcpy(good, f.rig.image.bytes, size);
    for (uint32_t n = 0; n < size; n += 16u) { // in the pieces that flash programs at once
        memset(f.rig.image.bytes, 0xFF, size);
        memcpy(f.rig.image.bytes, good, n);
        fixture_can_start(&f);
        const cam_err_t err = n == 0u    ? cam_err_image_magic
                              : n == 16u ? cam_err_image_size // the header's size is not there yet
                                         : cam_err_image_crc;
        TEST_ASSERT_EQUAL_INT32(err, send(enable));
    }
    expect_start_without_table(cam_err_image_crc);
    memcpy(f.rig.image.bytes, good, size);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(table_anew));
}

static void test_place_that_ends_within_the_image(void)
{
    static const uint32_t sizes[] = {1, 20, 127, 128, 4192};
    for (uint32_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        hal_host.slow.table.size = sizes[i];
        expect_start_without_table(cam_err_image_size);
    }
}

static void test_place_that_ends_within_the_header_is_not_read_beyond(void)
{
    _Alignas(uint32_t) static const uint8_t place[8]; // the sanitizer detects a read beyond its end
    hal_host.slow.table = (hal_image_t){.bytes = place, .size = sizeof place};
    expect_start_without_table(cam_err_image_size);
}

static void test_size_in_the_header_that_cannot_be(void)
{
    static const uint32_t sizes[] = {0, 31, 127, fixture_image_capacity + 32, UINT32_MAX};
    for (uint32_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        fixture_image_put(&f.rig.image, fixture_at_image_size, sizes[i]);
        expect_start_without_table(cam_err_image_size);
    }
    fixture_image_put(&f.rig.image, fixture_at_image_size, (uint32_t)f.rig.image.size - 32u);
    expect_start_without_table(cam_err_image_crc);
}

static void test_select_takes_a_table_written_after_the_start(void)
{
    f.rig.image.bytes[0] = 0;
    expect_start_without_table(cam_err_image_magic);
    fixture_image_make(&f.rig.image, &part);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(table_anew));
    TEST_ASSERT_EQUAL_STRING("table: short skirt in use", fixture_can_line(0));
    expect_table_result(cam_ok);
    expect_homing();
}

static void test_select_of_a_place_overwritten_with_rubbish_forgets_the_table(void)
{
    fixture_can_start(&f);
    fixture_image_put(&f.rig.image, fixture_at_version, 2);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_version, send(table_anew));
    expect_line(cam_err_image_version, " - home refused until a table is written");
    TEST_ASSERT_EQUAL_INT32(cam_err_image_version, send(enable));
}

static void test_select_of_a_damaged_table_in_ready_is_a_fault(void)
{
    fixture_can_start(&f);
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    f.rig.image.bytes[1000] ^= 1u;
    TEST_ASSERT_EQUAL_INT32(cam_err_image_crc, send(table_anew));
    fixture_rig_tick(&f.rig);
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(table), fixture_rig_status(&f.rig).first_fault);
}

static void test_select_of_a_bad_table_elsewhere_keeps_the_one_in_use(void)
{
    fixture_can_start(&f);
    memset(other.bytes, 0xFF, sizeof other.bytes);
    hal_host.slow.table.bytes = other.bytes;
    TEST_ASSERT_EQUAL_INT32(cam_err_image_magic, send(table_anew));
    expect_line(cam_err_image_magic, "");
    expect_table_result(cam_err_image_magic);
    expect_homing();
}

static void test_select_out_of_order_keeps_the_result_of_the_last_check(void)
{
    fixture_can_start(&f);
    expect_homing();
    const uint32_t n_lines = hal_host.n_lines;
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(table_anew));
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(disable));
    fixture_can_receive(0x640, 8, 6, cam_param_k1_ns, 5); // a change that no tick has taken yet
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_INT32(cam_err_busy, send(table_anew));
    expect_table_result(cam_ok);
    TEST_ASSERT_EQUAL_UINT32(n_lines + 1u, hal_host.n_lines); // state off
}

static void test_damage_found_in_the_background_is_told(void)
{
    fixture_can_start(&f);
    f.rig.image.bytes[1000] ^= 8u;
    fixture_can_loop(&f, 12); // two rounds of the check
    expect_line(cam_err_image_crc, " - home refused until a table is written");
    expect_table_result(cam_err_image_crc);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_crc, send(enable));
    f.rig.image.bytes[1000] ^= 8u;
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(table_anew));
    expect_homing();
}

static void test_damage_of_the_table_in_use_after_another_was_refused(void)
{
    fixture_can_start(&f);
    memset(other.bytes, 0xFF, sizeof other.bytes);
    hal_host.slow.table.bytes = other.bytes;
    TEST_ASSERT_EQUAL_INT32(cam_err_image_magic, send(table_anew));
    f.rig.image.bytes[1000] ^= 8u;
    fixture_can_loop(&f, 12);
    expect_line(cam_err_image_magic, " - home refused until a table is written");
    TEST_ASSERT_EQUAL_INT32(cam_err_image_magic, send(enable));
}

static void test_damage_while_enabled_is_told_beside_the_fault(void)
{
    fixture_can_start(&f);
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    fixture_can_loop(&f, 1);
    const uint32_t n_lines = hal_host.n_lines;
    f.rig.image.bytes[1000] ^= 8u;
    fixture_can_loop(&f, 14);
    TEST_ASSERT_EQUAL_UINT32(n_lines + 3u, hal_host.n_lines);
    TEST_ASSERT_EQUAL_STRING("state fault", fixture_can_line(1));
    TEST_ASSERT_EQUAL_STRING("fault table: table damaged", fixture_can_line(0));
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(enable));
    fixture_can_loop(&f, 4000);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(reset));
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_crc, send(enable));
}
