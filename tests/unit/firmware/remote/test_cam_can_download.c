// SPDX-License-Identifier: Apache-2.0
// Download of a table over CAN: complete ones, interruptions at and within blocks, repetitions and
// wrong orders, downloads that are refused. What is refused leaves the old table in force.
#define OWN_SET_UP
#include "can_bench.h"
#include <string.h> // memcpy

/// Number of the answer to a block; [bytes] of the image in each block.
enum { block = 18, block_bytes = 512 };

static fixture_image_t other;

/// Make the other table anew, with a name of eleven characters.
static void name_other(const char *name)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&other, &part);
    memcpy(other.bytes + fixture_at_name, name, 11);
    fixture_image_seal(&other);
}

/// Called by Unity before each test.
void setUp(void)
{
    name_other("other skirt");
    begin();
    run();
    fixture_can_loop(&f, 1);
}

static uint32_t n_blocks(void)
{
    return ((uint32_t)other.size + block_bytes - 1u) / block_bytes;
}

static uint32_t other_crc(void)
{
    return cam_crc32(0, other.bytes, other.size);
}

/// @return [bytes] of block i
static uint32_t bytes_of(uint32_t i)
{
    const uint32_t left = (uint32_t)other.size - i * block_bytes;
    return left < block_bytes ? left : block_bytes;
}

/// A frame of a block arrives, and main() runs through its loop once.
static void send_frame(const uint8_t *data, uint32_t n)
{
    hal_can_frame_t frame = {.id = 0x6C0, .n = n};
    memcpy(frame.data, data, n);
    (void)hal_host_can_receive(&frame);
    fixture_can_loop(&f, 1);
}

/// A message of ISO-TP arrives, except for its last n_held_back frames.
static void send_message(const uint8_t *message, uint32_t length, uint32_t n_held_back)
{
    const uint32_t n_frames = 1u + length / 7u - n_held_back; // six bytes in the first
    uint8_t data[8] = {(uint8_t)length};
    if (length < 8u) {
        memcpy(data + 1, message, length);
        send_frame(data, 8);
        return;
    }
    data[0] = (uint8_t)(0x10u | length >> 8);
    data[1] = (uint8_t)length;
    memcpy(data + 2, message, 6);
    send_frame(data, 8);
    for (uint32_t i = 1; i < n_frames; i++) {
        const uint32_t at = 6u + 7u * (i - 1u);
        const uint32_t n = length - at < 7u ? length - at : 7u;
        data[0] = (uint8_t)(0x20u | i % 16u);
        memcpy(data + 1, message + at, n);
        send_frame(data, 1u + n);
    }
}

/// Send n bytes of the other table from an offset on, except for the last n_held_back frames.
static void send_block(uint32_t offset, uint32_t n, uint32_t n_held_back)
{
    uint8_t message[4 + block_bytes];
    for (uint32_t i = 0; i < 4u; i++) {
        message[i] = (uint8_t)(offset >> (8u * i));
    }
    memcpy(message + 4, other.bytes + offset, n);
    send_message(message, 4u + n, n_held_back);
}

/// The newest answer is that to a block, and reports `received` bytes.
static void expect_block_answer(cam_err_t err, uint32_t received)
{
    expect_fields(last_answer(), err, (int32_t)received, block, 0);
}

/// Send a block; the answer must have this result and report `received` bytes.
static void expect_block(cam_err_t err, uint32_t offset, uint32_t n, uint32_t received)
{
    send_block(offset, n, 0);
    expect_block_answer(err, received);
}

/// Send the blocks from .. to - 1; each must be accepted.
static void expect_blocks(uint32_t from, uint32_t to)
{
    for (uint32_t i = from; i < to; i++) {
        const uint32_t offset = i * block_bytes;
        expect_block(cam_ok, offset, bytes_of(i), offset + bytes_of(i));
    }
}

/// Begin a download of the other table, which must be accepted.
static void expect_begin(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(begin_download, 0, (int32_t)other.size));
}

static int32_t send(uint8_t command, uint32_t value)
{
    return result_of(command, 0, (int32_t)value);
}

static void expect_end(cam_err_t err)
{
    TEST_ASSERT_EQUAL_INT32(err, send(end_download, other_crc()));
}

/// Send all of the other table; its end must have this result.
static void expect_download(cam_err_t err, uint32_t crc)
{
    expect_begin();
    expect_blocks(0, n_blocks());
    TEST_ASSERT_EQUAL_INT32(err, send(end_download, crc));
}

/// Select; the result must be this one, and the table of that name be in use.
static void expect_select(cam_err_t err, const char *in_use)
{
    TEST_ASSERT_EQUAL_INT32(err, send(select_table, 0));
    TEST_ASSERT_EQUAL_STRING(in_use, f.rig.machine.table.name);
}

/// The table of the start must be in force: now, after a select, and after a restart.
static void expect_old_in_force(void)
{
    TEST_ASSERT_EQUAL_PTR(f.rig.image.bytes, hal_table_image().bytes);
    expect_select(cam_ok, "short skirt");
    run();
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
    fixture_can_loop(&f, 1);
}

static void expect_download_works(void)
{
    expect_download(cam_ok, other_crc());
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
    expect_select(cam_ok, "other skirt");
}

/// The sectors take turns.
static void test_a_table_comes_over_the_bus(void)
{
    expect_download_works();
    TEST_ASSERT_EQUAL_STRING("table: other skirt in use", fixture_can_line(0));
    TEST_ASSERT_EQUAL_UINT32(2, f.can.store.generation);
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(enable, 0));
    run();
    TEST_ASSERT_EQUAL_STRING("other skirt", f.rig.machine.table.name);
    const void *first = hal_table_image().bytes;
    fixture_can_loop(&f, 2);
    name_other("third skirt");
    expect_begin();
    TEST_ASSERT_TRUE(first != hal_table_staged().bytes);
    expect_blocks(0, n_blocks());
    TEST_ASSERT_EQUAL_STRING("other skirt", f.rig.machine.table.name);
    expect_end(cam_ok);
    expect_select(cam_ok, "third skirt");
    expect_select(cam_ok, "third skirt"); // the same table is checked anew
}

static void test_interrupted_at_every_block(void)
{
    for (uint32_t n = 0; n < n_blocks(); n++) {
        expect_begin();
        expect_blocks(0, n);
        expect_answer(cam_err_download_short, (int32_t)(n * block_bytes), end_download, 0,
                      (int32_t)other_crc());
        expect_old_in_force(); // which restarts the controller
        expect_end(cam_err_download_order);
        expect_block(cam_err_download_order, n * block_bytes, bytes_of(n), 0);
    }
    expect_download_works();
}

/// More than a second of silence ends a block, and so does a frame out of order: it is answered
/// with where to go on, so that the tool need not wait on, and is sent again.
static void test_interrupted_within_a_block(void)
{
    static const uint8_t out_of_order[8] = {0x20};
    expect_begin();
    for (uint32_t i = 0; i < n_blocks(); i++) {
        send_block(i * block_bytes, bytes_of(i), 1);
        if (i % 2u == 0u) {
            fixture_can_loop(&f, 20003);
        } else {
            send_frame(out_of_order, 8);
        }
        expect_block_answer(cam_err_download_order, i * block_bytes);
        expect_blocks(i, i + 1u);
    }
    expect_end(cam_ok);
    TEST_ASSERT_EQUAL_STRING("short skirt", f.rig.machine.table.name);
}

static void test_a_new_begin_forgets_what_came(void)
{
    for (uint32_t n = 0; n <= n_blocks(); n++) {
        expect_begin();
        expect_blocks(0, n);
    }
    expect_end(cam_ok);
    expect_begin(); // a complete download is lost as well
    expect_old_in_force();
}

/// With other content they are refused.
static void test_repeated_blocks_are_accepted_once(void)
{
    expect_begin();
    expect_blocks(0, 3);
    expect_block(cam_ok, 2 * block_bytes, block_bytes, 3 * block_bytes);
    expect_block(cam_ok, 0, block_bytes, 3 * block_bytes);
    other.bytes[2 * block_bytes + 9] ^= 1u;
    expect_block(cam_err_download_order, 2 * block_bytes, block_bytes, 3 * block_bytes);
    other.bytes[2 * block_bytes + 9] ^= 1u;
    expect_blocks(3, n_blocks());
    expect_block(cam_ok, 0, block_bytes, (uint32_t)other.size);
    expect_end(cam_ok);
    expect_block(cam_err_download_order, 0, block_bytes, (uint32_t)other.size);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table, 0));
}

static void test_blocks_out_of_order_are_refused(void)
{
    enum { size = block_bytes };
    expect_begin();
    expect_block(cam_err_download_order, size, size, 0);
    expect_blocks(0, 1);
    expect_block(cam_err_download_order, 2 * size, size, size);
    expect_block(cam_err_download_order, size - 32, size, size); // overlaps the last block
    expect_block(cam_err_download_order, size, 31, size); // not a multiple of hal_table_grain
    expect_block(cam_err_download_order, 0, 0, size);
    expect_blocks(1, n_blocks());
    expect_end(cam_ok);
}

static void test_answers_and_flow_control_wait_for_room(void)
{
    expect_begin();
    fixture_can_loop(&f, 1);
    hal_host.slow.n_room = 0;
    send_block(0, 32, 0); // all frames are queued at once
    fixture_can_loop(&f, 5);
    TEST_ASSERT_EQUAL_UINT32(0, f.can.store.received);
    hal_host.slow.n_room = 1; // room for the flow control only
    fixture_can_loop(&f, 5);
    TEST_ASSERT_EQUAL_UINT32(32, f.can.store.received);
    hal_host.slow.n_room = 1;
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(block, last_answer().command);
}

static void test_blocks_of_an_old_session_are_refused(void)
{
    expect_begin();
    expect_blocks(0, 1);
    fixture_can_take(&f);
    send_block(block_bytes, bytes_of(1), 0);
    expect_block_answer(cam_err_not_commander, block_bytes);
    TEST_ASSERT_EQUAL_UINT32(block_bytes, f.can.store.received);
    expect_begin();
    expect_blocks(0, 1);
}

// Refused

static void expect_wrong(cam_err_t err, uint32_t crc)
{
    expect_download(err, crc);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, send(end_download, crc));
    expect_old_in_force();
}

static void test_damaged_and_wrong_images_are_refused(void)
{
    expect_wrong(cam_err_download_crc, other_crc() ^ 1u);
    other.bytes[3000] ^= 4u;
    expect_wrong(cam_err_image_crc, other_crc());
}

static void test_sizes_that_cannot_be_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_err_image_size, send(begin_download, 0));
    TEST_ASSERT_EQUAL_INT32(cam_err_image_size, send(begin_download, 127));
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, send(begin_download, hal_host_place_bytes + 1));
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, send(begin_download, UINT32_MAX));
    expect_block(cam_err_download_order, 0, 512, 0);
    expect_old_in_force();
}

/// A block too long for the controller is refused by flow control.
static void test_blocks_beyond_the_end_are_refused(void)
{
    static const uint8_t far[8] = {0xFF, 0xFF, 0xFF, 0xFF, 1};
    static const uint8_t long_block[8] = {0x10, 0, 0, 0, 0x10, 0x05}; // 4101
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(begin_download, 1000));
    expect_block(cam_ok, 0, 512, 512);
    expect_block(cam_err_download_room, 512, 489, 512);
    expect_block(cam_err_download_room, 1024, 8, 512);
    send_message(far, 8, 0);
    expect_block_answer(cam_err_download_room, 512);
    send_frame(long_block, 8);
    const hal_can_frame_t frame = fixture_can_sent(0x540);
    TEST_ASSERT_EQUAL_UINT32(3, frame.n);
    TEST_ASSERT_EQUAL_HEX8(0x32, frame.data[0]);
    expect_block(cam_ok, 512, 488, 1000);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_size,
                            send(end_download, cam_crc32(0, other.bytes, 1000)));
    expect_old_in_force();
}

static void test_memory_that_fails_leaves_the_old_table(void)
{
    hal_host.slow.n_store = 0;
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, send(begin_download, (uint32_t)other.size));
    for (uint32_t n = 0; n < n_blocks(); n++) {
        hal_host.slow.n_store = 1u + n;
        expect_begin();
        expect_blocks(0, n);
        expect_block(cam_err_download_store, n * block_bytes, bytes_of(n), n * block_bytes);
        hal_host.slow.n_store = UINT32_MAX;
        expect_block(cam_err_download_order, n * block_bytes, bytes_of(n), n * block_bytes);
    }
    expect_download(cam_ok, other_crc());
    hal_host.slow.n_store = 0;
    for (int i = 0; i < 2; i++) { // select never takes the old table instead
        expect_select(cam_err_download_store, "short skirt");
    }
    TEST_ASSERT_EQUAL_PTR(f.rig.image.bytes, hal_table_image().bytes);
    hal_host.slow.n_store = UINT32_MAX;
    expect_select(cam_ok, "other skirt");
}

/// The next part: its table comes while the machine is ready, and the next start cuts it. What the
/// running spindle cannot cut is refused before the place in use changes.
static void test_a_download_goes_on_in_ready_and_is_selected_there(void)
{
    expect_begin();
    expect_blocks(0, 2);
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    fixture_can_loop(&f, 2);
    expect_blocks(2, n_blocks());
    expect_end(cam_ok);
    f.rig.machine.params.feed_override_ppm = 1500000;
    f.rig.machine.params.z_is_measured = 1; // both together are refused
    expect_select(cam_err_override_measured, "short skirt");
    TEST_ASSERT_EQUAL_PTR(f.rig.machine.table.image, hal_table_image().bytes);
    f.rig.machine.params.feed_override_ppm = 1000000;
    f.rig.machine.params.z_is_measured = 0;
    expect_select(cam_ok, "other skirt");
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&f.rig.machine));
}

static void test_the_cut_refuses_everything(void)
{
    expect_download(cam_ok, other_crc());
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(begin_download, (uint32_t)other.size));
    expect_block(cam_err_state, 0, block_bytes, (uint32_t)other.size);
    expect_end(cam_err_state);
    expect_select(cam_err_state, "short skirt");
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
}

/// A select that fails keeps the table that the machine holds. Where the sector in use has changed
/// meanwhile, that of the machine is the other one, which therefore is not emptied.
static void test_a_table_in_use_is_not_overwritten_after_a_select_that_failed(void)
{
    expect_download(cam_ok, other_crc());
    ((uint8_t *)(uintptr_t)hal_table_staged().bytes)[2000] ^= 1u; // the memory loses a bit
    expect_select(cam_err_image_crc, "short skirt");
    TEST_ASSERT_EQUAL_PTR(f.rig.machine.table.image, hal_table_image().bytes);
    expect_begin();
    setUp();
    hal_host.slow.table.bytes = other.bytes;
    other.bytes[0] ^= 1u;
    expect_select(cam_err_image_magic, "short skirt");
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(begin_download, (uint32_t)other.size));
    other.bytes[0] ^= 1u;
    expect_select(cam_ok, "other skirt");
    fixture_can_loop(&f, 2);
    expect_begin();
}
