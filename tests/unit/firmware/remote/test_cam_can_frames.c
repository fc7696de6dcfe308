// SPDX-License-Identifier: Apache-2.0
// Frames that no tool should send: malformed, foreign, too many; tests/fuzz sends random ones. The
// bytes are those of camturn.dbc, written out by hand.
#include "cam_can.h"
#include "can_bench.h"
#include "expect_can.h"

#include "hal_host.h"
#include "unity.h"

enum { enable = 1, get = 7 };

static fixture_answer_t answer_to(const hal_can_frame_t *frame)
{
    const uint32_t n_sent = hal_host.slow.n_sent;
    (void)hal_host_can_receive(frame);
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 1u, hal_host.slow.n_sent);
    const hal_can_frame_t sent = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_UINT32(8, sent.n);
    return fixture_can_answer(&sent);
}

static void test_malformed_frames_are_answered_and_do_nothing(void)
{
    static const uint32_t lengths[] = {0, 1, 2, 7, 12, 64};
    for (uint32_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        const uint32_t n = lengths[i];
        const hal_can_frame_t frame = {.id = 0x640, .n = n, .data = {enable, 9}};
        const fixture_answer_t answer = answer_to(&frame);
        TEST_ASSERT_EQUAL_INT32(cam_err_frame, answer.result);
        TEST_ASSERT_EQUAL_UINT32(n > 0u ? enable : 0, answer.command);
        TEST_ASSERT_EQUAL_UINT32(n > 1u ? 9 : 0, answer.index);
        TEST_ASSERT_EQUAL_INT32(0, answer.value);
    }
    for (uint32_t at = 2; at < 4u; at++) {
        hal_can_frame_t frame = {.id = 0x640, .n = 8, .data = {enable}};
        frame.data[at] = 0x80;
        TEST_ASSERT_EQUAL_INT32(cam_err_not_commander, answer_to(&frame).result);
    }
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
}

static void test_foreign_ids_are_passed_over(void)
{
    const uint32_t n_sent = hal_host.slow.n_sent;
    static const uint32_t ids[] = {0, 0x63F, 0x641, 0x5C0, 0x1C0, 0x6C1, 0x540, 0x7FF};
    for (uint32_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        fixture_can_receive(ids[i], 8, enable, 0, 0);
    }
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_sent, hal_host.slow.n_sent);
    fixture_can_receive(0x123, 8, enable, 0, 0);
    expect_answer(&f, cam_ok, 0, enable, 0, 0); // follows a foreign frame in the same poll
}

static void test_a_flood_of_foreign_ids_does_not_hold_up_a_poll(void)
{
    for (uint32_t i = 0; i < hal_host_can_frames; i++) {
        fixture_can_receive(0x123, 8, 0, 0, 0);
    }
    const uint32_t n_read = hal_host.slow.n_read;
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_read + 8u, hal_host.slow.n_read);
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(hal_host.slow.n_received, hal_host.slow.n_read);
}

static void test_one_command_per_poll(void)
{
    fixture_can_receive(0x640, 8, get, 0, 0);
    fixture_can_receive(0x640, 8, get, 1, 0);
    const uint32_t n_sent = hal_host.slow.n_sent;
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 1u, hal_host.slow.n_sent);
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 2u, hal_host.slow.n_sent);
}
