// SPDX-License-Identifier: Apache-2.0
// Download of a table over CAN: complete ones, and interruptions at and within every block,
// repetitions and wrong orders, all of which must leave the old table in force.
#include "cam_can.h"
#include "expect_can.h"
#include "fixture_download.h"
#include "hal_host.h"
#include "unity.h"

enum { enable = 1 };

static fixture_download_t d;

void setUp(void)
{
    fixture_download_init(&d);
}

static void expect_download_works(void)
{
    expect_download(&d);
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
    expect_select(&d, cam_ok, "other skirt");
}

static void test_a_table_comes_over_the_bus(void)
{
    expect_download_works();
    TEST_ASSERT_EQUAL_STRING("table: other skirt in use", fixture_can_line(0));
    TEST_ASSERT_EQUAL_UINT32(2, d.can.can.store.generation);
    fixture_can_loop(&d.can, 2);
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_download_send(&d, enable, 0).result);
    fixture_can_start(&d.can);
    TEST_ASSERT_EQUAL_STRING("other skirt", d.can.rig.machine.table.name);
}

static void test_the_places_take_turns(void)
{
    expect_download_works();
    const void *first = hal_table_image().bytes;
    fixture_can_loop(&d.can, 2);
    fixture_download_name(&d, "third skirt");
    expect_begin(&d);
    TEST_ASSERT_TRUE(first != hal_table_staged().bytes);
    expect_blocks(&d, 0, fixture_download_blocks(&d));
    TEST_ASSERT_EQUAL_STRING("other skirt", d.can.rig.machine.table.name);
    expect_end(&d, cam_ok);
    expect_select(&d, cam_ok, "third skirt");
    expect_select(&d, cam_ok, "third skirt"); // the same table is checked anew
}

static void test_interrupted_at_every_block(void)
{
    for (uint32_t n = 0; n < fixture_download_blocks(&d); n++) {
        expect_begin(&d);
        expect_blocks(&d, 0, n);
        const fixture_answer_t answer =
            fixture_download_send(&d, fixture_end, fixture_download_crc(&d));
        TEST_ASSERT_EQUAL_INT32(cam_err_download_short, answer.result);
        TEST_ASSERT_EQUAL_INT32(n * fixture_block_bytes, answer.value);
        expect_old_in_force(&d); // which restarts the controller
        expect_end(&d, cam_err_download_order);
        expect_block(&d, cam_err_download_order, n * fixture_block_bytes,
                     fixture_download_bytes(&d, n), 0);
    }
    expect_download_works();
}

static void test_interrupted_within_every_block(void)
{
    expect_begin(&d);
    for (uint32_t i = 0; i < fixture_download_blocks(&d); i++) {
        uint8_t message[4 + fixture_block_bytes];
        const uint32_t n = fixture_download_make(message, d.other.bytes, i * fixture_block_bytes,
                                                 fixture_download_bytes(&d, i));
        fixture_download_message(&d, message, n, 1);
        fixture_can_loop(&d.can, 20000); // more than a second of silence ends the block
        fixture_can_loop(&d.can, 3);
        const uint32_t n_sent = hal_host.slow.n_sent;
        expect_blocks(&d, i, i + 1u); // sent again
        TEST_ASSERT_TRUE(hal_host.slow.n_sent > n_sent);
    }
    expect_end(&d, cam_ok);
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
}

static void test_a_break_is_answered_with_where_to_go_on(void)
{
    expect_begin(&d);
    expect_blocks(&d, 0, 2);
    uint8_t message[4 + fixture_block_bytes];
    const uint32_t n =
        fixture_download_make(message, d.other.bytes, 2 * fixture_block_bytes, fixture_block_bytes);
    fixture_download_message(&d, message, n, 3);
    static const uint8_t wrong[8] = {0x20};
    (void)fixture_download_frame(&d, wrong, 8);
    hal_can_frame_t frame = fixture_can_sent(0x5C0);
    fixture_answer_t answer = fixture_can_answer(&frame);
    TEST_ASSERT_EQUAL_UINT32(fixture_block, answer.command);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, answer.result);
    TEST_ASSERT_EQUAL_INT32(2 * fixture_block_bytes, answer.value);
    expect_blocks(&d, 2, fixture_download_blocks(&d));
    expect_end(&d, cam_ok);
}

static void test_a_new_begin_forgets_what_came(void)
{
    for (uint32_t n = 0; n <= fixture_download_blocks(&d); n++) {
        expect_begin(&d);
        expect_blocks(&d, 0, n);
    }
    expect_end(&d, cam_ok);
    expect_begin(&d); // a complete download is lost as well
    expect_old_in_force(&d);
}

static void test_repeated_blocks_are_accepted_once(void)
{
    expect_begin(&d);
    expect_blocks(&d, 0, 3);
    expect_block(&d, cam_ok, 2 * fixture_block_bytes, fixture_block_bytes, 3 * fixture_block_bytes);
    expect_block(&d, cam_ok, 0, fixture_block_bytes, 3 * fixture_block_bytes);
    expect_blocks(&d, 3, fixture_download_blocks(&d));
    expect_block(&d, cam_ok, 0, fixture_block_bytes, (uint32_t)d.other.size);
    expect_end(&d, cam_ok);
    expect_block(&d, cam_err_download_order, 0, fixture_block_bytes, (uint32_t)d.other.size);
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_download_send(&d, fixture_select, 0).result);
}

static void test_a_block_repeated_with_other_content_is_refused(void)
{
    expect_begin(&d);
    expect_blocks(&d, 0, 2);
    d.other.bytes[fixture_block_bytes + 9] ^= 1u;
    expect_block(&d, cam_err_download_order, fixture_block_bytes, fixture_block_bytes,
                 2 * fixture_block_bytes);
    d.other.bytes[fixture_block_bytes + 9] ^= 1u;
    expect_blocks(&d, 2, fixture_download_blocks(&d));
    expect_end(&d, cam_ok);
}

static void test_blocks_out_of_order_are_refused(void)
{
    expect_begin(&d);
    expect_block(&d, cam_err_download_order, fixture_block_bytes, fixture_block_bytes, 0);
    expect_blocks(&d, 0, 1);
    expect_block(&d, cam_err_download_order, 2 * fixture_block_bytes, fixture_block_bytes,
                 fixture_block_bytes);
    expect_block(&d, cam_err_download_order, fixture_block_bytes - 32, fixture_block_bytes,
                 fixture_block_bytes); // overlaps the last block
    expect_block(&d, cam_err_download_order, fixture_block_bytes, 31,
                 fixture_block_bytes); // not a multiple of hal_table_grain
    expect_block(&d, cam_err_download_order, 0, 0, fixture_block_bytes);
    expect_blocks(&d, 1, fixture_download_blocks(&d));
    expect_end(&d, cam_ok);
}

static void test_answers_and_flow_control_wait_for_room(void)
{
    expect_begin(&d);
    fixture_can_loop(&d.can, 1);
    hal_host.slow.n_room = 0;
    uint8_t message[4 + 32];
    const uint32_t length = fixture_download_make(message, d.other.bytes, 0, 32);
    fixture_download_message(&d, message, length, 0); // all frames are queued at once
    fixture_can_loop(&d.can, 5);
    TEST_ASSERT_EQUAL_UINT32(0, d.can.can.store.received);
    hal_host.slow.n_room = 1; // room for the flow control only
    fixture_can_loop(&d.can, 5);
    TEST_ASSERT_EQUAL_UINT32(32, d.can.can.store.received);
    hal_host.slow.n_room = 1;
    cam_can_poll(&d.can.can);
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_UINT32(fixture_block, fixture_can_answer(&frame).command);
}

/// A block whose next frame does not come within a second is answered: the tool need not wait on.
static void test_a_block_that_stops_is_answered(void)
{
    expect_begin(&d);
    const hal_can_frame_t first = {.id = 0x6C0, .n = 8, .data = {0x10, 0x40}};
    (void)hal_host_can_receive(&first);
    fixture_can_loop(&d.can, d.can.rig.machine.tick_hz + 100u);
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    const fixture_answer_t answer = fixture_can_answer(&frame);
    TEST_ASSERT_EQUAL_UINT32(18, answer.command); // download_block
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, answer.result);
}
