// SPDX-License-Identifier: Apache-2.0
// Samples of single ticks over CAN: their bytes, their pace, and what goes first.
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"
#include <string.h> // memset

enum { set_scope = 19, start_scope = 21, read_scope = 23, strobe = 59 };

enum {
    tick_hz = 20000,
    n_log = 4100,
    n_kept = 600,
    strobe_id = 0x240,
    answer_id = 0x5C0,
    part_id = 0x440
};

static fixture_can_t f;
static cam_tick_record_t ticks[n_log]; ///< records of the ticks
static uint32_t n_seen;                ///< frames of the port that were looked at
static hal_can_frame_t sent[n_kept];   ///< messages Strobe
static uint32_t sent_tick[n_kept];     ///< when each was sent
static uint32_t n_sent, n_status, n_parts, n_answers;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_can_init(&f, &part, tick_hz);
    fixture_can_start(&f);
    f.rig.log = ticks;
    f.rig.log_capacity = n_log;
    n_seen = hal_host.slow.n_sent;
    n_sent = n_status = n_parts = n_answers = 0;
}

static fixture_answer_t ask(int32_t every)
{
    const fixture_answer_t a = fixture_can_command(&f, strobe, 0, every);
    TEST_ASSERT_EQUAL_UINT32(strobe, a.command);
    return a;
}

static void begin(int32_t every)
{
    const fixture_answer_t a = ask(every);
    TEST_ASSERT_EQUAL_INT32(cam_ok, a.result);
    TEST_ASSERT_EQUAL_INT32(every, a.value);
}

/// Look at every frame that was sent since the last call.
static void look(void)
{
    for (; n_seen != hal_host.slow.n_sent; n_seen++) {
        const hal_can_frame_t *frame = &hal_host.slow.sent[n_seen % hal_host_can_frames];
        if (frame->id == (uint32_t)strobe_id) {
            sent[n_sent] = *frame;
            sent_tick[n_sent] = fixture_rig_status(&f.rig).tick;
            n_sent++;
        } else if (frame->id == (uint32_t)answer_id) {
            n_answers++;
        } else if (frame->id == (uint32_t)part_id) {
            n_parts++;
        } else {
            n_status++;
        }
    }
}

/// Ticks, each with a round of the main loop, after which the frames are looked at; in long waits
/// the main loop is slower than the ticks.
static void go_on(uint32_t n)
{
    const uint32_t every = n < 10000u ? 1u : 8u;
    for (uint32_t i = 0; i < n; i++) {
        if (i % every == 0u) {
            fixture_can_loop(&f, 1);
            look();
        } else {
            fixture_rig_tick(&f.rig);
        }
    }
}

static void test_frames_are_the_records_of_their_ticks(void)
{
    f.rig.lathe.error_nm[hal_axis_u] = -4321;
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
    f.rig.n_log = 0;
    begin(47);
    const uint32_t first = (uint32_t)(f.rig.n_log - 1u);
    go_on(4000);
    TEST_ASSERT_GREATER_THAN_UINT32(80, n_sent);
    for (uint32_t i = 0; i < n_sent; i++) {
        const cam_tick_record_t *r = &ticks[first + 47u * i];
        const uint64_t pos_q32 = (uint64_t)r->angle.pos_q32;
        TEST_ASSERT_EQUAL_UINT32(8, sent[i].n);
        TEST_ASSERT_EQUAL_UINT8(i, sent[i].data[0]);
        TEST_ASSERT_EQUAL_HEX32(pos_q32 >> 16 & 0xFFFFFFu,
                                (uint32_t)fixture_can_i32(&sent[i], 0) >> 8);
        const int32_t nm = (int32_t)((uint32_t)fixture_can_i32(&sent[i], 4) << 8) >> 8;
        TEST_ASSERT_EQUAL_INT32(r->in.actual_nm[hal_axis_u] - (r->want.u_due_q6 >> 6), nm);
        TEST_ASSERT_LESS_THAN_INT32(-1000, nm);
        TEST_ASSERT_EQUAL_HEX8((uint32_t)r->want.state | 0x10u, sent[i].data[7]);
    }
    TEST_ASSERT_GREATER_THAN_UINT8(sent[0].data[3], sent[n_sent - 1u].data[3]); // whole turns
}

static void expect_error(int32_t error_nm, int32_t told_nm, uint8_t bits)
{
    cam_tick_record_t r = {.tick = fixture_rig_status(&f.rig).tick + 1u};
    r.in.actual_nm[hal_axis_u] = error_nm;
    r.want.state = cam_state_fault;
    fixture_rig_ticks(&f.rig, 40);
    begin(0);
    begin(40);
    r.tick = f.rig.machine.strobe.next_tick;
    cam_strobe_take(&f.rig.machine.strobe, &r);
    cam_can_poll(&f.can); // the sample of the tick behind the command
    fixture_rig_ticks(&f.rig, 40);
    cam_can_poll(&f.can);
    const hal_can_frame_t frame = fixture_can_sent(strobe_id);
    TEST_ASSERT_EQUAL_INT32(told_nm, (int32_t)((uint32_t)fixture_can_i32(&frame, 4) << 8) >> 8);
    TEST_ASSERT_EQUAL_HEX8((uint32_t)cam_state_fault | bits, frame.data[7]);
}

static void test_a_large_error_is_saturated_and_says_so(void)
{
    expect_error(8388607, 8388607, 0);
    expect_error(8388608, 8388607, 0x20);
    expect_error(INT32_MAX, 8388607, 0x20);
    expect_error(-8388608, -8388608, 0);
    expect_error(-8388609, -8388608, 0x20);
    expect_error(INT32_MIN, -8388608, 0x20);
}

static void expect_refused(int32_t every)
{
    look();
    n_answers = 0;
    const fixture_answer_t a = ask(every);
    TEST_ASSERT_EQUAL_INT32(cam_err_param_range, a.result);
    TEST_ASSERT_EQUAL_INT32(0, a.value);
    fixture_can_loop(&f, 2);
    look();
    TEST_ASSERT_EQUAL_UINT32(3, n_answers);
}

static void test_a_distance_out_of_range_is_answered_with_the_range(void)
{
    static const int32_t bad[] = {1, 39, 20001, INT32_MAX, -1, INT32_MIN};
    for (uint32_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        expect_refused(bad[i]);
    }
    const hal_can_frame_t most = fixture_can_sent(answer_id);
    const fixture_answer_t a = fixture_can_answer(&most);
    TEST_ASSERT_EQUAL_UINT32(10, a.command);
    TEST_ASSERT_EQUAL_INT32(tick_hz, a.value);
    go_on(200);
    TEST_ASSERT_EQUAL_UINT32(0, n_sent);
}

static void test_it_ends_two_seconds_after_the_last_renewal(void)
{
    begin(1000);
    go_on(30000);
    begin(1000);
    go_on(39900);
    const uint32_t n = n_sent;
    TEST_ASSERT_UINT32_WITHIN(1, 70, n);
    go_on(20000);
    TEST_ASSERT_UINT32_WITHIN(1, n, n_sent);
    begin(1000); // numbered from 0 again
    go_on(100);
    TEST_ASSERT_EQUAL_UINT8(0, sent[n_sent - 1u].data[0]);
}

static void test_status_comes_as_before(void)
{
    begin(40);
    go_on(20000);
    TEST_ASSERT_UINT32_WITHIN(1, 500, n_sent);
    TEST_ASSERT_UINT32_WITHIN(5, 500, n_status);
}

/// Whatever rounds the main loop makes, no two messages are nearer than 2 ms, and each sample is
/// sent or missing in the numbers.
static void test_the_pace_is_kept_when_the_main_loop_dawdles(void)
{
    static const uint32_t dawdle[] = {1, 250, 3, 90, 17, 400, 1, 1, 33};
    begin(40);
    for (uint32_t i = 0; i < 90u; i++) {
        fixture_rig_ticks(&f.rig, dawdle[i % 9u]);
        go_on(2);
    }
    go_on(1200);
    TEST_ASSERT_GREATER_THAN_UINT32(60, n_sent);
    for (uint32_t i = 1; i < n_sent; i++) {
        TEST_ASSERT_GREATER_OR_EQUAL_UINT32(40, sent_tick[i] - sent_tick[i - 1u]);
        TEST_ASSERT_NOT_EQUAL(sent[i - 1u].data[0], sent[i].data[0]);
    }
    const cam_strobe_t *s = &f.rig.machine.strobe;
    TEST_ASSERT_EQUAL_UINT32(s->number, n_sent + s->n_lost + (s->n_in - s->n_out));
}

/// With room for one frame, answers and status get it.
static void test_everything_else_goes_first(void)
{
    begin(40);
    look();
    n_answers = 0;
    hal_host.slow.n_room = 0;
    go_on(400);
    TEST_ASSERT_EQUAL_UINT32(0, n_sent);
    fixture_can_receive(0x640, 8, 37, 0, 0); // get_place
    go_on(1);
    hal_host.slow.n_room = 1;
    go_on(1);
    TEST_ASSERT_EQUAL_UINT32(0, n_sent);
    TEST_ASSERT_EQUAL_UINT32(1, n_answers);
    hal_host.slow.n_room = 100000;
    go_on(400);
    TEST_ASSERT_GREATER_THAN_UINT32(5, n_sent);
    TEST_ASSERT_EQUAL_UINT32(0, f.rig.machine.strobe.n_lost); // the queue bridged it
}

/// Record 255 words, which a piece tells in 37 messages.
static void record(void)
{
    (void)fixture_can_command(&f, set_scope, cam_scope_field_signals, 1 << cam_scope_tick);
    (void)fixture_can_command(&f, set_scope, cam_scope_field_rows, 255);
    (void)fixture_can_command(&f, start_scope, 0, 0);
    go_on(300);
    TEST_ASSERT_EQUAL_INT(cam_scope_done, f.rig.machine.scope.phase);
}

/// @return rounds until all messages of the piece are there
static uint32_t read_piece(void)
{
    fixture_can_receive(0x640, 8, read_scope, 0, (int32_t)(255u << 24));
    look();
    n_parts = n_answers = n_sent = 0;
    uint32_t n = 0;
    for (; n < 4000u && n_answers == 0u; n++) {
        go_on(1);
    }
    TEST_ASSERT_EQUAL_UINT32(146, n_parts);
    return n;
}

static void test_a_piece_of_a_recording_takes_as_long_as_ever(void)
{
    record();
    const uint32_t n = read_piece();
    begin(40);
    TEST_ASSERT_EQUAL_UINT32(n, read_piece());
    TEST_ASSERT_UINT32_WITHIN(2, n / 160u, n_sent); // 125 a second
    for (uint32_t i = 2; i + 1u < n_sent; i++) {    // to the end of the piece
        TEST_ASSERT_EQUAL_UINT32(160, sent_tick[i] - sent_tick[i - 1u]);
    }
}

static void test_a_renewal_does_not_end_a_piece(void)
{
    record();
    begin(40);
    fixture_can_receive(0x640, 8, read_scope, 0, (int32_t)(255u << 24));
    look();
    n_parts = 0;
    go_on(300);
    begin(40);
    look();
    go_on(1500);
    TEST_ASSERT_EQUAL_UINT32(146, n_parts);
}
