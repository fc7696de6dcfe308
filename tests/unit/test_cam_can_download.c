// SPDX-License-Identifier: Apache-2.0
// Download of a table over CAN: what goes well, and everything that must leave the old table in
// force: interrupted at every block, repeated, out of order, too long, damaged, wrong, in the cut.
#include "cam/cam_can.h"
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"
#include <string.h> // memcpy

enum { enable = 1, disable, start, select_table = 8, begin = 16, end, block };

/// Small blocks, so that a download has many.
enum { block_bytes = 512 };

static fixture_can_t f;
static fixture_part_t part;
static fixture_image_t other;

static void make_other(const char *name)
{
    fixture_image_make(&other, &part);
    memcpy(other.bytes + fixture_at_name, name, 11);
    fixture_image_seal(&other);
}

void setUp(void)
{
    part = fixture_part_short();
    make_other("other skirt");
    fixture_can_init(&f, &part, 20000);
    fixture_can_start(&f);
    fixture_can_loop(&f, 1);
}

void tearDown(void) {}

static fixture_answer_t send(uint8_t command, uint32_t value)
{
    return fixture_can_command(&f, command, 0, (int32_t)value);
}

static uint32_t other_crc(void)
{
    return cam_crc32(0, other.bytes, other.size);
}

static uint32_t n_blocks(void)
{
    return ((uint32_t)other.size + block_bytes - 1u) / block_bytes;
}

static void give(const uint8_t *data, uint32_t n)
{
    hal_can_frame_t frame = {.id = 0x6C0, .n = n};
    memcpy(frame.data, data, n);
    TEST_ASSERT_TRUE(hal_host_can_receive(&frame));
    fixture_can_loop(&f, 1);
}

/// Send a message by ISO-TP, but for the last of its frames that are held back.
static void give_message(const uint8_t *message, uint32_t length, uint32_t n_held_back)
{
    const uint32_t n_frames = 1u + (length - 6u + 6u) / 7u - n_held_back;
    uint8_t data[8] = {(uint8_t)length};
    if (length < 8u) {
        memcpy(data + 1, message, length);
        give(data, 8);
        return;
    }
    data[0] = (uint8_t)(0x10u | length >> 8);
    data[1] = (uint8_t)length;
    memcpy(data + 2, message, 6);
    give(data, 8);
    for (uint32_t i = 1; i < n_frames; i++) {
        const uint32_t at = 6u + 7u * (i - 1u);
        const uint32_t n = length - at < 7u ? length - at : 7u;
        data[0] = (uint8_t)(0x20u | i % 16u);
        memcpy(data + 1, message + at, n);
        give(data, 1u + n);
    }
}

static uint32_t make_block(uint8_t *message, const uint8_t *image, uint32_t offset, uint32_t n)
{
    for (uint32_t i = 0; i < 4u; i++) {
        message[i] = (uint8_t)(offset >> (8u * i));
    }
    memcpy(message + 4, image + offset, n);
    return 4u + n;
}

/// @return the answer to a block
static fixture_answer_t give_block(const uint8_t *image, uint32_t offset, uint32_t n)
{
    uint8_t message[4 + block_bytes];
    const uint32_t length = make_block(message, image, offset, n);
    give_message(message, length, 0);
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    const fixture_answer_t answer = fixture_can_answer(&frame);
    TEST_ASSERT_EQUAL_UINT32(block, answer.command);
    return answer;
}

static void expect_block(cam_err_t err, uint32_t offset, uint32_t n, uint32_t received)
{
    const fixture_answer_t answer = give_block(other.bytes, offset, n);
    TEST_ASSERT_EQUAL_INT32(err, answer.result);
    TEST_ASSERT_EQUAL_INT32(received, answer.value);
}

static uint32_t bytes_of(uint32_t i)
{
    const uint32_t left = (uint32_t)other.size - i * block_bytes;
    return left < block_bytes ? left : block_bytes;
}

static void give_blocks(uint32_t from, uint32_t to)
{
    for (uint32_t i = from; i < to; i++) {
        expect_block(cam_ok, i * block_bytes, bytes_of(i), i * block_bytes + bytes_of(i));
    }
}

static void begin_download(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(begin, (uint32_t)other.size).result);
}

static void expect_old_in_force(void)
{
    TEST_ASSERT_EQUAL_PTR(f.rig.image.bytes, hal_table_image().bytes);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table, 0).result);
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
    fixture_can_start(&f); // the same after a restart
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
    fixture_can_loop(&f, 1);
}

static void expect_download_works(void)
{
    begin_download();
    give_blocks(0, n_blocks());
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table, 0).result);
    TEST_ASSERT_EQUAL_STRING("other skirt", f.rig.machine.table.name);
}

static void test_a_table_comes_over_the_bus(void)
{
    expect_download_works();
    TEST_ASSERT_EQUAL_STRING("table: other skirt in use", fixture_can_line(0));
    TEST_ASSERT_EQUAL_UINT32(2, f.can.store.generation);
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(enable, 0).result);
    fixture_can_start(&f);
    TEST_ASSERT_EQUAL_STRING("other skirt", f.rig.machine.table.name);
}

static void test_the_places_take_turns(void)
{
    expect_download_works();
    const void *first = hal_table_image().bytes;
    fixture_can_loop(&f, 2);
    make_other("third skirt");
    begin_download();
    TEST_ASSERT_TRUE(first != hal_table_staged().bytes);
    give_blocks(0, n_blocks());
    TEST_ASSERT_EQUAL_STRING("other skirt", f.rig.machine.table.name);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table, 0).result);
    TEST_ASSERT_EQUAL_STRING("third skirt", f.rig.machine.table.name);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table, 0).result); // again, what is there
}

static void test_interrupted_at_every_block(void)
{
    for (uint32_t n = 0; n < n_blocks(); n++) {
        begin_download();
        give_blocks(0, n);
        const fixture_answer_t answer = send(end, other_crc());
        TEST_ASSERT_EQUAL_INT32(cam_err_download_short, answer.result);
        TEST_ASSERT_EQUAL_INT32(n * block_bytes, answer.value);
        expect_old_in_force(); // which restarts
        TEST_ASSERT_EQUAL_INT32(cam_err_download_order, send(end, other_crc()).result);
        expect_block(cam_err_download_order, n * block_bytes, bytes_of(n), 0);
    }
    expect_download_works();
}

static void test_interrupted_within_every_block(void)
{
    begin_download();
    for (uint32_t i = 0; i < n_blocks(); i++) {
        uint8_t message[4 + block_bytes];
        const uint32_t n = make_block(message, other.bytes, i * block_bytes, bytes_of(i));
        give_message(message, n, 1);
        fixture_can_loop(&f, 20000); // a second and more of silence, then it is answered
        fixture_can_loop(&f, 3);
        const uint32_t n_sent = hal_host.slow.n_sent;
        give_blocks(i, i + 1u); // sent again
        TEST_ASSERT_TRUE(hal_host.slow.n_sent > n_sent);
    }
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
}

static void test_a_break_is_answered_with_where_to_go_on(void)
{
    begin_download();
    give_blocks(0, 2);
    uint8_t message[4 + block_bytes];
    const uint32_t n = make_block(message, other.bytes, 2 * block_bytes, block_bytes);
    give_message(message, n, 3);
    static const uint8_t wrong[8] = {0x20};
    give(wrong, 8);
    hal_can_frame_t frame = fixture_can_sent(0x5C0);
    fixture_answer_t answer = fixture_can_answer(&frame);
    TEST_ASSERT_EQUAL_UINT32(block, answer.command);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, answer.result);
    TEST_ASSERT_EQUAL_INT32(2 * block_bytes, answer.value);
    give_blocks(2, n_blocks());
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
}

static void test_a_new_begin_forgets_what_came(void)
{
    for (uint32_t n = 0; n <= n_blocks(); n++) {
        begin_download();
        give_blocks(0, n);
    }
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
    begin_download(); // also a whole one
    expect_old_in_force();
}

static void test_repeated_blocks_are_accepted_once(void)
{
    begin_download();
    give_blocks(0, 3);
    expect_block(cam_ok, 2 * block_bytes, block_bytes, 3 * block_bytes);
    expect_block(cam_ok, 0, block_bytes, 3 * block_bytes);
    give_blocks(3, n_blocks());
    expect_block(cam_ok, 0, block_bytes, (uint32_t)other.size);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
    expect_block(cam_err_download_order, 0, block_bytes, (uint32_t)other.size);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table, 0).result);
}

static void test_a_block_repeated_with_other_content_is_refused(void)
{
    begin_download();
    give_blocks(0, 2);
    other.bytes[block_bytes + 9] ^= 1u;
    expect_block(cam_err_download_order, block_bytes, block_bytes, 2 * block_bytes);
    other.bytes[block_bytes + 9] ^= 1u;
    give_blocks(2, n_blocks());
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
}

static void test_blocks_out_of_order_are_refused(void)
{
    begin_download();
    expect_block(cam_err_download_order, block_bytes, block_bytes, 0);
    give_blocks(0, 1);
    expect_block(cam_err_download_order, 2 * block_bytes, block_bytes, block_bytes);
    expect_block(cam_err_download_order, block_bytes - 32, block_bytes, block_bytes); // overlaps
    expect_block(cam_err_download_order, block_bytes, 31, block_bytes); // not whole grains
    expect_block(cam_err_download_order, 0, 0, block_bytes);
    give_blocks(1, n_blocks());
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
}

static void test_blocks_beyond_the_end_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(begin, 1000).result);
    expect_block(cam_ok, 0, 512, 512);
    expect_block(cam_err_download_room, 512, 489, 512);
    expect_block(cam_err_download_room, 1024, 8, 512);
    uint8_t message[8] = {0xFF, 0xFF, 0xFF, 0xFF, 1};
    give_message(message, 8, 0);
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, fixture_can_answer(&frame).result);
    expect_block(cam_ok, 512, 488, 1000);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_size, send(end, cam_crc32(0, other.bytes, 1000)).result);
    expect_old_in_force();
}

static void test_sizes_that_cannot_be_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_err_image_size, send(begin, 0).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_size, send(begin, 127).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, send(begin, hal_host_place_bytes + 1).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, send(begin, UINT32_MAX).result);
    expect_block(cam_err_download_order, 0, 512, 0);
    expect_old_in_force();
}

static void test_a_block_too_long_for_the_controller_is_told_by_flow_control(void)
{
    begin_download();
    static const uint8_t data[8] = {0x10, 0, 0, 0, 0x10, 0x05}; // 4101
    give(data, 8);
    const hal_can_frame_t frame = fixture_can_sent(0x6C1);
    TEST_ASSERT_EQUAL_UINT32(3, frame.n);
    TEST_ASSERT_EQUAL_HEX8(0x32, frame.data[0]);
}

static void expect_wrong(cam_err_t err, uint32_t crc)
{
    begin_download();
    give_blocks(0, n_blocks());
    TEST_ASSERT_EQUAL_INT32(err, send(end, crc).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, send(end, crc).result);
    expect_old_in_force();
}

static void test_damaged_and_wrong_images_are_refused(void)
{
    expect_wrong(cam_err_download_crc, other_crc() ^ 1u);
    other.bytes[3000] ^= 4u;
    expect_wrong(cam_err_image_crc, other_crc());
    other.bytes[3000] ^= 4u;
    fixture_image_put(&other, fixture_at_version, 2);
    fixture_image_seal(&other);
    expect_wrong(cam_err_image_version, other_crc());
    other.bytes[0] ^= 1u;
    expect_wrong(cam_err_image_magic, other_crc());
}

static void test_memory_that_fails_leaves_the_old_table(void)
{
    hal_host.slow.n_store = 0;
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, send(begin, (uint32_t)other.size).result);
    for (uint32_t n = 0; n < n_blocks(); n++) {
        hal_host.slow.n_store = 1u + n;
        begin_download();
        give_blocks(0, n);
        expect_block(cam_err_download_store, n * block_bytes, bytes_of(n), n * block_bytes);
        hal_host.slow.n_store = UINT32_MAX;
        expect_block(cam_err_download_order, n * block_bytes, bytes_of(n), n * block_bytes);
    }
    begin_download();
    give_blocks(0, n_blocks());
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
    hal_host.slow.n_store = 0;
    TEST_ASSERT_EQUAL_INT32(cam_err_download_store, send(select_table, 0).result);
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
    hal_host.slow.n_store = UINT32_MAX;
    expect_old_in_force();
}

static void test_a_download_goes_on_in_off_only(void)
{
    begin_download();
    give_blocks(0, 2);
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    expect_block(cam_err_state, 2 * block_bytes, block_bytes, 2 * block_bytes);
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(begin, (uint32_t)other.size).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(end, other_crc()).result);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(disable, 0).result);
    fixture_can_loop(&f, 2);
    give_blocks(2, n_blocks());
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(select_table, 0).result);
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(disable, 0).result);
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table, 0).result);
    TEST_ASSERT_EQUAL_STRING("other skirt", f.rig.machine.table.name);
}

static void test_the_cut_refuses_everything(void)
{
    begin_download();
    give_blocks(0, n_blocks());
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_lead_ns, 50000));
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(begin, (uint32_t)other.size).result);
    expect_block(cam_err_state, 0, block_bytes, (uint32_t)other.size);
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(end, other_crc()).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(select_table, 0).result);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_status(&f.rig).state);
}

static void test_a_command_on_its_way_makes_it_wait(void)
{
    fixture_can_receive(0x640, 8, enable, 0, 0);
    fixture_can_receive(0x640, 8, begin, 0, (int32_t)other.size);
    cam_can_poll(&f.can);
    cam_can_poll(&f.can); // no tick between them
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(cam_err_busy, fixture_can_answer(&frame).result);
}

static void test_a_table_in_use_is_not_overwritten_after_a_select_that_failed(void)
{
    begin_download();
    give_blocks(0, n_blocks());
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(end, other_crc()).result);
    ((uint8_t *)(uintptr_t)hal_table_staged().bytes)[2000] ^= 1u; // the memory forgets
    TEST_ASSERT_EQUAL_INT32(cam_err_image_crc, send(select_table, 0).result);
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(begin, (uint32_t)other.size).result);
}

static void test_answers_and_flow_control_wait_for_room(void)
{
    begin_download();
    fixture_can_loop(&f, 1);
    hal_host.slow.n_room = 0;
    uint8_t message[4 + 32];
    const uint32_t length = make_block(message, other.bytes, 0, 32);
    give_message(message, length, 0); // all of it is queued
    fixture_can_loop(&f, 5);
    TEST_ASSERT_EQUAL_UINT32(0, f.can.store.received);
    hal_host.slow.n_room = 1; // flow control
    fixture_can_loop(&f, 5);
    TEST_ASSERT_EQUAL_UINT32(32, f.can.store.received);
    hal_host.slow.n_room = 1;
    cam_can_poll(&f.can);
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_UINT32(block, fixture_can_answer(&frame).command);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_table_comes_over_the_bus);
    RUN_TEST(test_the_places_take_turns);
    RUN_TEST(test_interrupted_at_every_block);
    RUN_TEST(test_interrupted_within_every_block);
    RUN_TEST(test_a_break_is_answered_with_where_to_go_on);
    RUN_TEST(test_a_new_begin_forgets_what_came);
    RUN_TEST(test_repeated_blocks_are_accepted_once);
    RUN_TEST(test_a_block_repeated_with_other_content_is_refused);
    RUN_TEST(test_blocks_out_of_order_are_refused);
    RUN_TEST(test_blocks_beyond_the_end_are_refused);
    RUN_TEST(test_sizes_that_cannot_be_are_refused);
    RUN_TEST(test_a_block_too_long_for_the_controller_is_told_by_flow_control);
    RUN_TEST(test_damaged_and_wrong_images_are_refused);
    RUN_TEST(test_memory_that_fails_leaves_the_old_table);
    RUN_TEST(test_a_download_goes_on_in_off_only);
    RUN_TEST(test_the_cut_refuses_everything);
    RUN_TEST(test_a_command_on_its_way_makes_it_wait);
    RUN_TEST(test_a_table_in_use_is_not_overwritten_after_a_select_that_failed);
    RUN_TEST(test_answers_and_flow_control_wait_for_room);
    return UNITY_END();
}
