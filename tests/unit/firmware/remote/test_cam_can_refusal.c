// SPDX-License-Identifier: Apache-2.0
// Downloads that are refused: too long, damaged, of a bad table, in a wrong state, into memory that
// fails. All of them leave the old table in force.
#include "cam_can.h"
#include "expect_can.h"
#include "fixture_download.h"
#include "hal_host.h"
#include "unity.h"

enum { enable = 1, disable = 2 };

static fixture_download_t d;

void setUp(void)
{
    fixture_download_init(&d);
}

static void expect_wrong(cam_err_t err, uint32_t crc)
{
    expect_begin(&d);
    expect_blocks(&d, 0, fixture_download_blocks(&d));
    TEST_ASSERT_EQUAL_INT32(err, fixture_download_send(&d, fixture_end, crc).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order,
                            fixture_download_send(&d, fixture_end, crc).result);
    expect_old_in_force(&d);
}

static void test_damaged_and_wrong_images_are_refused(void)
{
    expect_wrong(cam_err_download_crc, fixture_download_crc(&d) ^ 1u);
    d.other.bytes[3000] ^= 4u;
    expect_wrong(cam_err_image_crc, fixture_download_crc(&d));
    d.other.bytes[3000] ^= 4u;
    fixture_image_put(&d.other, fixture_at_version, 2);
    fixture_image_seal(&d.other);
    expect_wrong(cam_err_image_version, fixture_download_crc(&d));
    d.other.bytes[0] ^= 1u;
    expect_wrong(cam_err_image_magic, fixture_download_crc(&d));
}

static void test_sizes_that_cannot_be_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_err_image_size, fixture_download_send(&d, fixture_begin, 0).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_size,
                            fixture_download_send(&d, fixture_begin, 127).result);
    TEST_ASSERT_EQUAL_INT32(
        cam_err_download_room,
        fixture_download_send(&d, fixture_begin, hal_host_place_bytes + 1).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room,
                            fixture_download_send(&d, fixture_begin, UINT32_MAX).result);
    expect_block(&d, cam_err_download_order, 0, 512, 0);
    expect_old_in_force(&d);
}

static void test_blocks_beyond_the_end_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_download_send(&d, fixture_begin, 1000).result);
    expect_block(&d, cam_ok, 0, 512, 512);
    expect_block(&d, cam_err_download_room, 512, 489, 512);
    expect_block(&d, cam_err_download_room, 1024, 8, 512);
    uint8_t message[8] = {0xFF, 0xFF, 0xFF, 0xFF, 1};
    fixture_download_message(&d, message, 8, 0);
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, fixture_can_answer(&frame).result);
    expect_block(&d, cam_ok, 512, 488, 1000);
    TEST_ASSERT_EQUAL_INT32(
        cam_err_image_size,
        fixture_download_send(&d, fixture_end, cam_crc32(0, d.other.bytes, 1000)).result);
    expect_old_in_force(&d);
}

static void test_a_block_too_long_for_the_controller_is_told_by_flow_control(void)
{
    expect_begin(&d);
    static const uint8_t data[8] = {0x10, 0, 0, 0, 0x10, 0x05}; // 4101
    (void)fixture_download_frame(&d, data, 8);
    const hal_can_frame_t frame = fixture_can_sent(0x540);
    TEST_ASSERT_EQUAL_UINT32(3, frame.n);
    TEST_ASSERT_EQUAL_HEX8(0x32, frame.data[0]);
}

static void test_memory_that_fails_leaves_the_old_table(void)
{
    hal_host.slow.n_store = 0;
    TEST_ASSERT_EQUAL_INT32(
        cam_err_download_room,
        fixture_download_send(&d, fixture_begin, (uint32_t)d.other.size).result);
    for (uint32_t n = 0; n < fixture_download_blocks(&d); n++) {
        hal_host.slow.n_store = 1u + n;
        expect_begin(&d);
        expect_blocks(&d, 0, n);
        expect_block(&d, cam_err_download_store, n * fixture_block_bytes,
                     fixture_download_bytes(&d, n), n * fixture_block_bytes);
        hal_host.slow.n_store = UINT32_MAX;
        expect_block(&d, cam_err_download_order, n * fixture_block_bytes,
                     fixture_download_bytes(&d, n), n * fixture_block_bytes);
    }
    expect_download(&d);
    hal_host.slow.n_store = 0;
    for (int i = 0; i < 2; i++) { // select never takes the old table instead
        expect_select(&d, cam_err_download_store, "short skirt");
    }
    TEST_ASSERT_EQUAL_PTR(d.can.rig.image.bytes, hal_table_image().bytes);
    hal_host.slow.n_store = UINT32_MAX;
    expect_select(&d, cam_ok, "other skirt");
}

/// The next part: its table comes while the machine is ready, and the next start cuts it.
static void test_a_download_goes_on_in_ready_and_is_selected_there(void)
{
    expect_begin(&d);
    expect_blocks(&d, 0, 2);
    TEST_ASSERT_TRUE(fixture_rig_bring(&d.can.rig, cam_state_ready));
    fixture_can_loop(&d.can, 2);
    expect_blocks(&d, 2, fixture_download_blocks(&d));
    expect_end(&d, cam_ok);
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
    expect_select(&d, cam_ok, "other skirt");
    fixture_can_loop(&d.can, 2);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&d.can.rig.machine));
}

/// What the running spindle cannot cut is refused before the place in use changes.
static void test_an_infeasible_table_is_refused_in_ready_and_stays_downloaded(void)
{
    expect_download(&d);
    TEST_ASSERT_TRUE(fixture_rig_bring(&d.can.rig, cam_state_ready));
    d.can.rig.machine.params.feed_override_ppm = 1500000;
    d.can.rig.machine.params.z_is_measured = 1; // both together are refused
    expect_select(&d, cam_err_override_measured, "short skirt");
    TEST_ASSERT_EQUAL_PTR(d.can.rig.machine.table.image, hal_table_image().bytes);
    d.can.rig.machine.params.feed_override_ppm = 1000000;
    d.can.rig.machine.params.z_is_measured = 0;
    expect_select(&d, cam_ok, "other skirt");
}

static void test_the_cut_refuses_everything(void)
{
    expect_download(&d);
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&d.can.rig, cam_param_lead_ns, 50000));
    TEST_ASSERT_TRUE(fixture_rig_bring(&d.can.rig, cam_state_cutting));
    TEST_ASSERT_EQUAL_INT32(
        cam_err_state, fixture_download_send(&d, fixture_begin, (uint32_t)d.other.size).result);
    expect_block(&d, cam_err_state, 0, fixture_block_bytes, (uint32_t)d.other.size);
    expect_end(&d, cam_err_state);
    expect_select(&d, cam_err_state, "short skirt");
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
}

static void test_a_command_on_its_way_makes_it_wait(void)
{
    fixture_can_receive(0x640, 8, enable, 0, 0);
    fixture_can_receive(0x640, 8, fixture_begin, 0, (int32_t)d.other.size);
    cam_can_poll(&d.can.can);
    cam_can_poll(&d.can.can); // no tick in between
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(cam_err_busy, fixture_can_answer(&frame).result);
}

static void test_a_table_in_use_is_not_overwritten_after_a_select_that_failed(void)
{
    expect_download(&d);
    ((uint8_t *)(uintptr_t)hal_table_staged().bytes)[2000] ^= 1u; // the memory loses a bit
    expect_select(&d, cam_err_image_crc, "short skirt");
    TEST_ASSERT_EQUAL_PTR(d.can.rig.machine.table.image, hal_table_image().bytes);
    expect_begin(&d);
}

/// The place in use has changed, but its table was refused: the machine still cuts that of the
/// other place, which therefore is not emptied.
static void test_the_place_of_the_table_that_the_machine_holds_is_not_emptied(void)
{
    hal_host.slow.table.bytes = d.other.bytes;
    d.other.bytes[0] ^= 1u;
    expect_select(&d, cam_err_image_magic, "short skirt");
    TEST_ASSERT_EQUAL_INT32(
        cam_err_state, fixture_download_send(&d, fixture_begin, (uint32_t)d.other.size).result);
    d.other.bytes[0] ^= 1u;
    expect_select(&d, cam_ok, "other skirt");
    fixture_can_loop(&d.can, 2);
    expect_begin(&d);
}
