// SPDX-License-Identifier: Apache-2.0
// Download of a table over CAN: complete ones, interruptions at and within blocks, repetitions and
// wrong orders, downloads that are refused, signed tables. What is refused leaves the old table in
// force.
#include "expect_can.h"
#include "fixture_sign.h"
#include "hal_host.h"
#include "unity.h"

enum { enable = 1 };

static fixture_download_t d;

void setUp(void)
{
    fixture_download_init(&d);
}

static int32_t send(uint8_t command, uint32_t value)
{
    return fixture_download_send(&d, command, value).result;
}

static fixture_answer_t last_answer(void)
{
    return fixture_download_answer();
}

/// Send all of the other table. @return the result of its end
static int32_t download(uint32_t crc)
{
    expect_begin(&d);
    expect_blocks(&d, 0, fixture_download_blocks(&d));
    return send(fixture_end, crc);
}

static void expect_end(cam_err_t err)
{
    TEST_ASSERT_EQUAL_INT32(err, send(fixture_end, fixture_download_crc(&d)));
}

static void expect_download(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_ok, download(fixture_download_crc(&d)));
}

/// Select; the result must be this one, and the table of that name be in use.
static void expect_select(cam_err_t err, const char *in_use)
{
    TEST_ASSERT_EQUAL_INT32(err, send(fixture_select, 0));
    TEST_ASSERT_EQUAL_STRING(in_use, d.can.rig.machine.table.name);
}

/// The table of the start must be in force: now, after a select, and after a restart.
static void expect_old_in_force(void)
{
    TEST_ASSERT_EQUAL_PTR(d.can.rig.image.bytes, hal_table_image().bytes);
    expect_select(cam_ok, "short skirt");
    fixture_can_start(&d.can);
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
    fixture_can_loop(&d.can, 1);
}

static void expect_download_works(void)
{
    expect_download();
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
    expect_select(cam_ok, "other skirt");
}

static void test_a_table_comes_over_the_bus(void)
{
    expect_download_works();
    TEST_ASSERT_EQUAL_STRING("table: other skirt in use", fixture_can_line(0));
    TEST_ASSERT_EQUAL_UINT32(2, d.can.can.store.generation);
    fixture_can_loop(&d.can, 2);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(enable, 0));
    fixture_can_start(&d.can);
    TEST_ASSERT_EQUAL_STRING("other skirt", d.can.rig.machine.table.name);
}

static void test_the_sectors_take_turns(void)
{
    expect_download_works();
    const void *first = hal_table_image().bytes;
    fixture_can_loop(&d.can, 2);
    fixture_download_name(&d, "third skirt");
    expect_begin(&d);
    TEST_ASSERT_TRUE(first != hal_table_staged().bytes);
    expect_blocks(&d, 0, fixture_download_blocks(&d));
    TEST_ASSERT_EQUAL_STRING("other skirt", d.can.rig.machine.table.name);
    expect_end(cam_ok);
    expect_select(cam_ok, "third skirt");
    expect_select(cam_ok, "third skirt"); // the same table is checked anew
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
        expect_old_in_force(); // which restarts the controller
        expect_end(cam_err_download_order);
        expect_block(&d, cam_err_download_order, n * fixture_block_bytes,
                     fixture_download_bytes(&d, n), 0);
    }
    expect_download_works();
}

/// More than a second of silence ends a block: it is answered, so that the tool need not wait on,
/// and is sent again.
static void test_interrupted_within_a_block(void)
{
    const uint32_t n_blocks = fixture_download_blocks(&d);
    const uint32_t broken[] = {0, n_blocks / 2u, n_blocks - 1u};
    expect_begin(&d);
    for (uint32_t k = 0; k < 3u; k++) {
        const uint32_t i = broken[k];
        uint8_t message[4 + fixture_block_bytes];
        const uint32_t n = fixture_download_make(message, d.other.bytes, i * fixture_block_bytes,
                                                 fixture_download_bytes(&d, i));
        expect_blocks(&d, k == 0u ? 0 : broken[k - 1u] + 1u, i);
        fixture_download_message(&d, message, n, 1);
        fixture_can_loop(&d.can, 20003);
        TEST_ASSERT_EQUAL_UINT32(fixture_block, last_answer().command);
        TEST_ASSERT_EQUAL_INT32(cam_err_download_order, last_answer().result);
        expect_blocks(&d, i, i + 1u);
    }
    expect_end(cam_ok);
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
    TEST_ASSERT_EQUAL_UINT32(fixture_block, last_answer().command);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, last_answer().result);
    TEST_ASSERT_EQUAL_INT32(2 * fixture_block_bytes, last_answer().value);
    expect_blocks(&d, 2, fixture_download_blocks(&d));
    expect_end(cam_ok);
}

static void test_a_new_begin_forgets_what_came(void)
{
    for (uint32_t n = 0; n <= fixture_download_blocks(&d); n++) {
        expect_begin(&d);
        expect_blocks(&d, 0, n);
    }
    expect_end(cam_ok);
    expect_begin(&d); // a complete download is lost as well
    expect_old_in_force();
}

static void test_repeated_blocks_are_accepted_once(void)
{
    expect_begin(&d);
    expect_blocks(&d, 0, 3);
    expect_block(&d, cam_ok, 2 * fixture_block_bytes, fixture_block_bytes, 3 * fixture_block_bytes);
    expect_block(&d, cam_ok, 0, fixture_block_bytes, 3 * fixture_block_bytes);
    expect_blocks(&d, 3, fixture_download_blocks(&d));
    expect_block(&d, cam_ok, 0, fixture_block_bytes, (uint32_t)d.other.size);
    expect_end(cam_ok);
    expect_block(&d, cam_err_download_order, 0, fixture_block_bytes, (uint32_t)d.other.size);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(fixture_select, 0));
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
    expect_end(cam_ok);
}

static void test_blocks_out_of_order_are_refused(void)
{
    enum { size = fixture_block_bytes };
    static const uint32_t wrong[][2] = {
        {2 * size, size},
        {size - 32, size}, // overlaps the last block
        {size, 31},        // not a multiple of hal_table_grain
        {0, 0},
    };
    expect_begin(&d);
    expect_block(&d, cam_err_download_order, size, size, 0);
    expect_blocks(&d, 0, 1);
    for (uint32_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        expect_block(&d, cam_err_download_order, wrong[i][0], wrong[i][1], size);
    }
    expect_blocks(&d, 1, fixture_download_blocks(&d));
    expect_end(cam_ok);
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
    TEST_ASSERT_EQUAL_UINT32(fixture_block, last_answer().command);
}

// Refused

static void expect_wrong(cam_err_t err, uint32_t crc)
{
    TEST_ASSERT_EQUAL_INT32(err, download(crc));
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, send(fixture_end, crc));
    expect_old_in_force();
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
    static const struct {
        uint32_t size;
        cam_err_t err;
    } cases[] = {{0, cam_err_image_size},
                 {127, cam_err_image_size},
                 {hal_host_place_bytes + 1, cam_err_download_room},
                 {UINT32_MAX, cam_err_download_room}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_INT32(cases[i].err, send(fixture_begin, cases[i].size));
    }
    expect_block(&d, cam_err_download_order, 0, 512, 0);
    expect_old_in_force();
}

static void test_blocks_beyond_the_end_are_refused(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(fixture_begin, 1000));
    expect_block(&d, cam_ok, 0, 512, 512);
    expect_block(&d, cam_err_download_room, 512, 489, 512);
    expect_block(&d, cam_err_download_room, 1024, 8, 512);
    uint8_t message[8] = {0xFF, 0xFF, 0xFF, 0xFF, 1};
    fixture_download_message(&d, message, 8, 0);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, last_answer().result);
    expect_block(&d, cam_ok, 512, 488, 1000);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_size,
                            send(fixture_end, cam_crc32(0, d.other.bytes, 1000)));
    expect_old_in_force();
}

static void test_a_block_too_long_for_the_controller_is_refused_by_flow_control(void)
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
    TEST_ASSERT_EQUAL_INT32(cam_err_download_room, send(fixture_begin, (uint32_t)d.other.size));
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
    expect_download();
    hal_host.slow.n_store = 0;
    for (int i = 0; i < 2; i++) { // select never takes the old table instead
        expect_select(cam_err_download_store, "short skirt");
    }
    TEST_ASSERT_EQUAL_PTR(d.can.rig.image.bytes, hal_table_image().bytes);
    hal_host.slow.n_store = UINT32_MAX;
    expect_select(cam_ok, "other skirt");
}

/// The next part: its table comes while the machine is ready, and the next start cuts it.
static void test_a_download_goes_on_in_ready_and_is_selected_there(void)
{
    expect_begin(&d);
    expect_blocks(&d, 0, 2);
    TEST_ASSERT_TRUE(fixture_rig_bring(&d.can.rig, cam_state_ready));
    fixture_can_loop(&d.can, 2);
    expect_blocks(&d, 2, fixture_download_blocks(&d));
    expect_end(cam_ok);
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
    expect_select(cam_ok, "other skirt");
    fixture_can_loop(&d.can, 2);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&d.can.rig.machine));
}

/// What the running spindle cannot cut is refused before the place in use changes.
static void test_an_infeasible_table_is_refused_in_ready_and_stays_downloaded(void)
{
    expect_download();
    TEST_ASSERT_TRUE(fixture_rig_bring(&d.can.rig, cam_state_ready));
    d.can.rig.machine.params.feed_override_ppm = 1500000;
    d.can.rig.machine.params.z_is_measured = 1; // both together are refused
    expect_select(cam_err_override_measured, "short skirt");
    TEST_ASSERT_EQUAL_PTR(d.can.rig.machine.table.image, hal_table_image().bytes);
    d.can.rig.machine.params.feed_override_ppm = 1000000;
    d.can.rig.machine.params.z_is_measured = 0;
    expect_select(cam_ok, "other skirt");
}

static void test_the_cut_refuses_everything(void)
{
    expect_download();
    TEST_ASSERT_TRUE(fixture_rig_bring(&d.can.rig, cam_state_cutting));
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(fixture_begin, (uint32_t)d.other.size));
    expect_block(&d, cam_err_state, 0, fixture_block_bytes, (uint32_t)d.other.size);
    expect_end(cam_err_state);
    expect_select(cam_err_state, "short skirt");
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
}

static void test_a_table_in_use_is_not_overwritten_after_a_select_that_failed(void)
{
    expect_download();
    ((uint8_t *)(uintptr_t)hal_table_staged().bytes)[2000] ^= 1u; // the memory loses a bit
    expect_select(cam_err_image_crc, "short skirt");
    TEST_ASSERT_EQUAL_PTR(d.can.rig.machine.table.image, hal_table_image().bytes);
    expect_begin(&d);
}

/// The sector in use has changed, but its table was refused: the machine still cuts that of the
/// other sector, which therefore is not emptied.
static void test_the_sector_of_the_table_that_the_machine_holds_is_not_emptied(void)
{
    hal_host.slow.table.bytes = d.other.bytes;
    d.other.bytes[0] ^= 1u;
    expect_select(cam_err_image_magic, "short skirt");
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(fixture_begin, (uint32_t)d.other.size));
    d.other.bytes[0] ^= 1u;
    expect_select(cam_ok, "other skirt");
    fixture_can_loop(&d.can, 2);
    expect_begin(&d);
}

// Signed, see test_cam_signature_check.c: judged at the end, at select and at the start

static fixture_keys_t keys;

static void trust(bool is_required)
{
    keys = fixture_keys(1);
    hal_host.slow.trust =
        (hal_trust_t){.keys = keys.public, .n_keys = 1, .is_required = is_required};
}

static int32_t download_and_select(void)
{
    const int32_t result = download(fixture_download_crc(&d));
    const int32_t selected = result == cam_ok ? send(fixture_select, 0) : result;
    fixture_can_loop(&d.can, 2);
    return selected;
}

static void test_a_signed_table_comes_over_the_bus(void)
{
    trust(true);
    fixture_sign(&d.other, &keys);
    TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
    TEST_ASSERT_EQUAL_STRING("table: other skirt in use, signed by key 3784728ae7309eab",
                             fixture_can_line(0));
    fixture_can_start(&d.can); // and lies there after a restart, with its signature
    TEST_ASSERT_EQUAL_STRING("other skirt", d.can.rig.machine.table.name);
    TEST_ASSERT_EQUAL_INT(cam_signature_check_signed, d.can.rig.machine.signature.kind);
}

static void test_a_table_without_its_signature_is_refused_at_the_end(void)
{
    trust(true);
    TEST_ASSERT_EQUAL_INT32(cam_err_sign_none, download_and_select());
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
    trust(false);
    TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
    TEST_ASSERT_EQUAL_STRING("table: other skirt in use, not signed", fixture_can_line(0));
    fixture_download_name(&d, "third skirt");
    const fixture_keys_t others = fixture_keys(2);
    fixture_sign(&d.other, &others);
    TEST_ASSERT_EQUAL_INT32(cam_err_sign_key, download_and_select());
    TEST_ASSERT_EQUAL_STRING("other skirt", d.can.rig.machine.table.name);
}

/// What came while nothing was required does not pass a select once it is.
static void test_a_table_is_judged_again_when_it_is_selected(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_ok, download(fixture_download_crc(&d)));
    trust(true);
    expect_select(cam_err_sign_none, "short skirt");
}

static void test_the_table_in_the_flash_is_judged_at_the_start(void)
{
    trust(true);
    fixture_can_start(&d.can);
    TEST_ASSERT_FALSE(d.can.rig.machine.has_table);
    TEST_ASSERT_EQUAL_STRING("table: the table is not signed, but must be here: sign it with "
                             "tools/keys - home refused until a table is written",
                             fixture_can_line(0));
    TEST_ASSERT_EQUAL_INT32(cam_err_sign_none, send(enable, 0));
}

/// The sector still holds the signed table of before, and the new one is as long as that was.
static void test_no_signature_of_before_follows_a_table_without_one(void)
{
    trust(false);
    for (int i = 0; i < 2; i++) { // both sectors
        fixture_sign(&d.other, &keys);
        TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
    }
    d.other.size -= fixture_block_size;
    TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
    TEST_ASSERT_EQUAL_INT(cam_signature_check_unsigned, d.can.rig.machine.signature.kind);
}

/// There is no counter against it: an older table of the same key is as good as a newer one.
static void test_an_older_signed_table_is_taken_again(void)
{
    static const char *const names[] = {"other skirt", "newer skirt", "other skirt"};
    trust(true);
    for (uint32_t i = 0; i < 3u; i++) {
        fixture_download_name(&d, names[i]);
        fixture_sign(&d.other, &keys);
        TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
        TEST_ASSERT_EQUAL_STRING(names[i], d.can.rig.machine.table.name);
    }
}
