// SPDX-License-Identifier: Apache-2.0
#include "expect_can.h"
#include "hal/hal.h" // hal_table_image
#include "unity.h"   // TEST_ASSERT_EQUAL_INT32

void expect_answer(fixture_can_t *f, cam_err_t result, int32_t value, uint8_t command,
                   uint8_t index, int32_t sent)
{
    const fixture_answer_t answer = fixture_can_command(f, command, index, sent);
    TEST_ASSERT_EQUAL_UINT32(command, answer.command);
    TEST_ASSERT_EQUAL_UINT32(index, answer.index);
    TEST_ASSERT_EQUAL_INT32(result, answer.result);
    TEST_ASSERT_EQUAL_INT32(value, answer.value);
}

void expect_block(fixture_download_t *d, cam_err_t err, uint32_t offset, uint32_t n,
                  uint32_t received)
{
    const fixture_answer_t answer = fixture_download_block(d, offset, n);
    TEST_ASSERT_EQUAL_UINT32(fixture_block, answer.command);
    TEST_ASSERT_EQUAL_INT32(err, answer.result);
    TEST_ASSERT_EQUAL_INT32(received, answer.value);
}

void expect_blocks(fixture_download_t *d, uint32_t from, uint32_t to)
{
    for (uint32_t i = from; i < to; i++) {
        const uint32_t n = fixture_download_bytes(d, i);
        const uint32_t offset = i * fixture_block_bytes;
        expect_block(d, cam_ok, offset, n, offset + n);
    }
}

void expect_begin(fixture_download_t *d)
{
    const fixture_answer_t answer =
        fixture_download_send(d, fixture_begin, (uint32_t)d->other.size);
    TEST_ASSERT_EQUAL_INT32(cam_ok, answer.result);
}

void expect_old_in_force(fixture_download_t *d)
{
    TEST_ASSERT_EQUAL_PTR(d->can.rig.image.bytes, hal_table_image().bytes);
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_download_send(d, fixture_select, 0).result);
    TEST_ASSERT_EQUAL_STRING("short skirt", d->can.rig.machine.table.name);
    fixture_can_start(&d->can); // the same after a restart
    TEST_ASSERT_EQUAL_STRING("short skirt", d->can.rig.machine.table.name);
    fixture_can_loop(&d->can, 1);
}
