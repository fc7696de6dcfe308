// SPDX-License-Identifier: Apache-2.0
// A sector without a table, erased, with foreign bytes, another version, a table cut off or
// overwritten. The controller starts all the same, refuses to home and reports why, until a good
// table is selected.
#include "can_bench.h"
#include <stdio.h>  // snprintf
#include <string.h> // memset

static fixture_image_t other;

static int32_t send(uint8_t command)
{
    return result_of(command, 0, 0);
}

/// @return the error in the status
static int32_t sent_err(void)
{
    fixture_can_loop(&f, 201);
    const hal_can_frame_t frame = fixture_can_sent(0x1C0);
    return fixture_can_i16(&frame, 2);
}

/// The line, the status and the answer to a home give the reason.
static void expect_no_table(cam_err_t err)
{
    char line[200];
    (void)snprintf(line, sizeof line, "table: %s - home refused until a table is written",
                   cam_err_text(err));
    TEST_ASSERT_EQUAL_STRING(line, fixture_can_line(0));
    TEST_ASSERT_EQUAL_INT32(err, sent_err());
    expect_answer(err, 0, enable, 0, 0);
}

/// The controller starts, refuses to home, and reports why.
static void expect_start_without_table(cam_err_t err)
{
    run();
    expect_no_table(err);
    TEST_ASSERT_EQUAL_INT32(err, send(select_table));
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

/// In a larger sector, whatever follows it there, and in one that it fills.
static void test_a_good_table_is_taken(void)
{
    TEST_ASSERT_EQUAL_STRING("table: short skirt in use", fixture_can_line(0));
    TEST_ASSERT_EQUAL_UINT32(f.rig.image.size, f.rig.machine.table.image_size);
    TEST_ASSERT_EQUAL_INT32(cam_ok, sent_err());
    expect_homing();
    begin();
    memset(&f.rig.image.bytes[f.rig.image.size], 0xA5, 128); // as long as an old signature
    run();
    expect_homing();
    begin();
    hal_host.slow.table.size = (uint32_t)f.rig.image.size;
    run();
    expect_homing();
}

/// No sector, erased ones, and those that end within header or image.
static void test_sectors_without_a_whole_table_are_refused(void)
{
    _Alignas(uint32_t) static const uint8_t short_one[8]; // the sanitizer sees a read beyond it
    static uint8_t erased[8192], zeros[8192];
    memset(erased, 0xFF, sizeof erased);
    const uint8_t *good = f.rig.image.bytes;
    const struct {
        const uint8_t *bytes;
        uint32_t size;
        cam_err_t err;
    } cases[] = {
        {NULL, 0, cam_err_no_table},
        {good, 0, cam_err_no_table},
        {NULL, 1024, cam_err_no_table},
        {erased, sizeof erased, cam_err_image_magic},
        {zeros, sizeof zeros, cam_err_image_magic},
        {good, 1, cam_err_image_size},
        {good, 20, cam_err_image_size},
        {good, 127, cam_err_image_size},
        {good, 128, cam_err_image_size},
        {good, 4192, cam_err_image_size},
        {short_one, sizeof short_one, cam_err_image_size},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin();
        hal_host.slow.table = (hal_image_t){.bytes = cases[i].bytes, .size = cases[i].size};
        expect_start_without_table(cases[i].err);
    }
}

static void test_select_takes_a_table_written_after_the_start_or_the_damage(void)
{
    f.rig.image.bytes[0] ^= 1u;
    expect_start_without_table(cam_err_image_magic);
    f.rig.image.bytes[0] ^= 1u;
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table));
    TEST_ASSERT_EQUAL_STRING("table: short skirt in use", fixture_can_line(0));
    f.rig.image.bytes[1000] ^= 8u;
    fixture_can_loop(&f, 12); // two rounds of the check in the background
    expect_no_table(cam_err_image_crc);
    f.rig.image.bytes[1000] ^= 8u;
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table));
    expect_homing();
}

/// In ready this is a fault.
static void test_select_of_an_overwritten_sector_forgets_the_table(void)
{
    fixture_image_put(&f.rig.image, fixture_at_version, 2);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_version, send(select_table));
    expect_no_table(cam_err_image_version);
    setUp();
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    f.rig.image.bytes[1000] ^= 1u;
    TEST_ASSERT_EQUAL_INT32(cam_err_image_crc, send(select_table));
    fixture_rig_tick(&f.rig);
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(table), fixture_rig_status(&f.rig).first_fault);
}

/// Its refusal is what is reported, also when the table in use is damaged later.
static void test_select_of_a_bad_table_elsewhere_keeps_the_one_in_use(void)
{
    memset(other.bytes, 0xFF, sizeof other.bytes);
    hal_host.slow.table.bytes = other.bytes;
    TEST_ASSERT_EQUAL_INT32(cam_err_image_magic, send(select_table));
    TEST_ASSERT_NULL(strstr(fixture_can_line(0), "home refused"));
    TEST_ASSERT_EQUAL_INT32(cam_err_image_magic, sent_err());
    expect_homing();
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(disable));
    fixture_can_loop(&f, 2);
    f.rig.image.bytes[1000] ^= 8u;
    fixture_can_loop(&f, 12);
    expect_no_table(cam_err_image_magic);
}

static void test_select_out_of_order_keeps_the_result_of_the_last_check(void)
{
    expect_homing();
    const uint32_t n_lines = hal_host.n_lines;
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(select_table));
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(disable));
    fixture_can_receive(0x640, 8, set, cam_param_k1_ns, 5); // no tick has taken it yet
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_INT32(cam_err_busy, send(select_table));
    TEST_ASSERT_EQUAL_INT(cam_ok, f.can.store.err);
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_UINT32(n_lines + 1u, hal_host.n_lines); // state off
}

static void test_damage_while_enabled_is_reported_with_the_fault(void)
{
    to_ready();
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
