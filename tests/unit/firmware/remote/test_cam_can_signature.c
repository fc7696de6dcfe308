// SPDX-License-Identifier: Apache-2.0
// Signed tables on their way over CAN: at the end of the download, at select and at the start.
#include "cam_can.h"
#include "expect_can.h"
#include "fixture_download.h"
#include "fixture_sign.h"
#include "hal_host.h"
#include "unity.h"

static fixture_download_t d;
static fixture_keys_t keys;

static void trust(bool is_required)
{
    hal_host.slow.trust =
        (hal_trust_t){.keys = keys.public, .n_keys = 1, .is_required = is_required};
}

void setUp(void)
{
    keys = fixture_keys(1);
    fixture_download_init(&d);
}

static int32_t download(void)
{
    expect_begin(&d);
    expect_blocks(&d, 0, fixture_download_blocks(&d));
    return fixture_download_send(&d, fixture_end, fixture_download_crc(&d)).result;
}

static int32_t download_and_select(void)
{
    const int32_t result = download();
    return result == cam_ok ? fixture_download_send(&d, fixture_select, 0).result : result;
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

static void test_a_table_without_a_signature_is_refused_at_the_end(void)
{
    trust(true);
    TEST_ASSERT_EQUAL_INT32(cam_err_sign_none, download());
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
    trust(false);
    TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
    TEST_ASSERT_EQUAL_STRING("table: other skirt in use, not signed", fixture_can_line(0));
}

static void test_a_wrong_signature_is_refused_at_the_end(void)
{
    trust(false);
    const fixture_keys_t others = fixture_keys(2);
    fixture_sign(&d.other, &others);
    TEST_ASSERT_EQUAL_INT32(cam_err_sign_key, download());
    fixture_sign(&d.other, &keys);
    d.other.bytes[d.other.size - 64u] ^= 4u;
    TEST_ASSERT_EQUAL_INT32(cam_err_sign_wrong, download());
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
}

/// What came while nothing was required does not pass a select once it is.
static void test_a_table_is_judged_again_when_it_is_selected(void)
{
    trust(false);
    TEST_ASSERT_EQUAL_INT32(cam_ok, download());
    trust(true);
    TEST_ASSERT_EQUAL_INT32(cam_err_sign_none, fixture_download_send(&d, fixture_select, 0).result);
    TEST_ASSERT_EQUAL_STRING("short skirt", d.can.rig.machine.table.name);
}

static void test_the_table_in_the_flash_is_judged_at_the_start(void)
{
    trust(true);
    fixture_can_start(&d.can);
    TEST_ASSERT_FALSE(d.can.rig.machine.has_table);
    TEST_ASSERT_EQUAL_STRING("table: the table is not signed, but must be here: sign it with "
                             "tools/keys - home refused until a table is written",
                             fixture_can_line(0));
    TEST_ASSERT_EQUAL_INT32(cam_err_sign_none, fixture_download_send(&d, 1, 0).result); // enable
}

/// The place still holds the signed table of before, and the new one is as long as that was.
static void test_no_signature_of_before_lies_behind_a_table_without_one(void)
{
    trust(false);
    for (int i = 0; i < 2; i++) { // both places
        fixture_sign(&d.other, &keys);
        TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
        fixture_can_loop(&d.can, 2);
    }
    d.other.size -= fixture_block_size;
    TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
    TEST_ASSERT_EQUAL_INT(cam_signature_check_unsigned, d.can.rig.machine.signature.kind);
}

/// There is no counter against it: an older table of the same key is as good as a newer one.
static void test_an_older_signed_table_is_taken_again(void)
{
    trust(true);
    fixture_sign(&d.other, &keys);
    TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
    fixture_can_loop(&d.can, 2);
    const fixture_image_t older = d.other;
    fixture_download_name(&d, "newer skirt");
    fixture_sign(&d.other, &keys);
    TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
    fixture_can_loop(&d.can, 2);
    d.other = older;
    TEST_ASSERT_EQUAL_INT32(cam_ok, download_and_select());
    TEST_ASSERT_EQUAL_STRING("other skirt", d.can.rig.machine.table.name);
}
