// SPDX-License-Identifier: Apache-2.0
// Recorder, excitation, learned values and samples of single ticks over CAN; pieces of a recording
// on a bus that is full, the pace of samples, and what goes first.
#include "cam_remote_inner.h" // cam_reading_hz
#include "can_bench.h"
#include <string.h> // memcpy

enum { n_rows = 300, most_bytes = 256 * 63, tick_hz = 20000, n_log = 4100, n_kept = 600 };

static uint8_t piece[most_bytes];
static uint32_t n_piece;               ///< bytes
static uint32_t n_seen;                ///< frames of the port that were looked at
static hal_can_frame_t last;           ///< answer to read_scope
static cam_tick_record_t ticks[n_log]; ///< records of the ticks
static hal_can_frame_t sent[n_kept];   ///< messages Strobe
static uint32_t sent_tick[n_kept];     ///< when each was sent
static uint32_t n_sent, n_status, n_answers;

/// Look at every frame that was sent since the last call.
static void look(void)
{
    for (; n_seen != hal_host.slow.n_sent; n_seen++) {
        const hal_can_frame_t *frame = &hal_host.slow.sent[n_seen % hal_host_can_frames];
        const uint32_t part = frame->id == 0x440u ? 7 : frame->id == 0x340u ? 63 : 0;
        if (part > 0u) {
            TEST_ASSERT_EQUAL_UINT8(n_piece / part, frame->data[0]);
            TEST_ASSERT_EQUAL_UINT32(1u + part, frame->n);
            memcpy(piece + n_piece, &frame->data[1], part);
            n_piece += part;
        } else if (frame->id == 0x240u) {
            sent[n_sent] = *frame;
            sent_tick[n_sent++] = fixture_rig_status(&f.rig).tick;
        } else if (frame->id == 0x5C0u) {
            n_answers++;
            last = frame->data[0] == read_scope || frame->data[0] == read_scope_fd ? *frame : last;
        } else {
            n_status++;
        }
    }
}

/// Forget all that was sent.
static void forget(void)
{
    n_seen = hal_host.slow.n_sent;
    n_piece = n_sent = n_status = n_answers = 0;
    last = (hal_can_frame_t){0};
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

/// Ask for words of the recording and poll until the answer is there. @return polls
static uint32_t ask_by(uint8_t command, uint32_t offset, uint32_t count)
{
    forget();
    fixture_can_receive(0x640, 8, command, 7, (int32_t)(offset | count << 24));
    uint32_t n = 0;
    for (; n < 4000u && last.id == 0u; n++) {
        go_on(1);
    }
    return n;
}

/// Record rows of tick and u_actual_nm.
static void record(void)
{
    const int32_t signals = 1 << cam_scope_tick | 1 << cam_scope_u_actual_nm;
    expect_answer(cam_ok, signals, set_scope, cam_scope_field_signals, signals);
    expect_answer(cam_ok, n_rows, set_scope, cam_scope_field_rows, n_rows);
    expect_answer(cam_ok, 0, start_scope, 0, 0);
    fixture_can_loop(&f, n_rows + 10);
    expect_answer(cam_ok, cam_scope_done, get_scope, cam_scope_field_phase, 0);
    expect_answer(cam_ok, n_rows, get_scope, cam_scope_field_n_rows, 0);
    forget();
}

static void expect_parts(uint32_t offset, uint32_t n_words, uint32_t part)
{
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_can_answer(&last).result);
    TEST_ASSERT_EQUAL_UINT32(7, fixture_can_answer(&last).index);
    const uint32_t n_bytes = n_words * 4u;
    TEST_ASSERT_EQUAL_UINT32((n_bytes + part - 1u) / part * part, n_piece);
    TEST_ASSERT_EQUAL_MEMORY(&f.rig.machine.scope.words[f.rig.machine.scope.at + offset], piece,
                             n_bytes);
    TEST_ASSERT_EQUAL_HEX32(cam_crc32(0, piece, n_bytes),
                            (uint32_t)fixture_can_answer(&last).value);
}

static void test_pieces_are_the_words_of_the_recording(void)
{
    record();
    const uint32_t polls = ask_by(read_scope, 0, 255);
    expect_parts(0, 255, 7);
    TEST_ASSERT_UINT32_WITHIN(40, 146u * tick_hz / cam_reading_hz, polls);
    (void)ask_by(read_scope, 598, 255);
    expect_parts(598, 2, 7); // where it ends
    (void)ask_by(read_scope, 5, 1);
    expect_parts(5, 1, 7);
    const uint32_t polls_fd = ask_by(read_scope_fd, 0, 16);
    expect_parts(0, 256, 63);
    TEST_ASSERT_UINT32_WITHIN(30, 17u * tick_hz / cam_reading_fd_hz, polls_fd);
    TEST_ASSERT_EQUAL_UINT32(read_scope_fd, fixture_can_answer(&last).command);
    (void)ask_by(read_scope_fd, 3, 255);
    expect_parts(3, 597, 63);
    expect_answer(cam_err_scope_range, 0, read_scope_fd, 3, 600 | 1 << 24);
}

/// A ring that has wrapped is sent in the order of time, by both commands.
static void test_pieces_of_a_ring_are_in_order(void)
{
    static const int32_t fields[][2] = {{cam_scope_field_signals, 1 << cam_scope_tick},
                                        {cam_scope_field_rows, 900},
                                        {cam_scope_field_before, 700},
                                        {cam_scope_field_trigger, cam_trigger_time},
                                        {cam_scope_field_level, 1500}};
    const cam_scope_t *s = &f.rig.machine.scope;
    for (uint32_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        const int32_t value = fields[i][1];
        expect_answer(cam_ok, value, set_scope, (uint8_t)fields[i][0], value);
    }
    expect_answer(cam_ok, 0, start_scope, 0, 0);
    expect_answer(cam_err_scope_on, 0, read_scope, 0, 1 << 24);
    fixture_can_loop(&f, 1800);
    TEST_ASSERT_EQUAL_INT(cam_scope_full, s->end);
    TEST_ASSERT_GREATER_THAN_UINT32(0, s->ring.oldest);
    for (int is_fd = 0; is_fd < 2; is_fd++) {
        (void)ask_by(is_fd == 0 ? read_scope : read_scope_fd, 0, 252);
        TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_can_answer(&last).result);
        const uint32_t n_words = is_fd == 0 ? 252 : 900;
        for (uint32_t i = 0; i < n_words; i++) {
            uint32_t tick = 0;
            memcpy(&tick, &piece[4u * i], sizeof tick);
            TEST_ASSERT_EQUAL_UINT32(s->ring.first_tick + i, tick);
        }
        TEST_ASSERT_EQUAL_HEX32(cam_crc32(0, piece, n_words * 4u),
                                (uint32_t)fixture_can_answer(&last).value);
    }
}

/// Record, and ask for a piece of so many words.
static void ask_for_piece(uint32_t n)
{
    record();
    fixture_can_receive(0x640, 8, read_scope, 7, (int32_t)(n << 24));
}

/// A block ends it.
static void test_a_full_queue_delays_a_piece(void)
{
    ask_for_piece(100);
    hal_host.slow.n_room = 3;
    go_on(400);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(21, n_piece);
    TEST_ASSERT_EQUAL_UINT32(0, last.id);
    hal_host.slow.n_room = 1000;
    go_on(1000);
    expect_parts(0, 100, 7);
    ask_for_piece(255);
    go_on(100);
    TEST_ASSERT_GREATER_THAN_UINT32(0, n_piece);
    const hal_can_frame_t single = {.id = 0x6C0, .n = 8, .data = {7}};
    (void)hal_host_can_receive(&single);
    go_on(2000);
    TEST_ASSERT_EQUAL_UINT32(0, last.id); // the piece has no answer
    TEST_ASSERT_LESS_THAN_UINT32(255u * 4u, n_piece);
}

static void test_a_command_ends_a_piece_and_a_new_recording_too(void)
{
    ask_for_piece(255);
    go_on(100);
    TEST_ASSERT_TRUE(f.can.reading.is_on);
    fixture_can_receive(0x100, 8, get_scope, cam_scope_field_every, 0); // nobody's
    fixture_can_receive(0x700, 8, get_scope, cam_scope_field_every, 0);
    go_on(5);
    TEST_ASSERT_TRUE(f.can.reading.is_on);
    fixture_can_receive(0x640, 8, beat, 0, 0);
    go_on(5);
    TEST_ASSERT_TRUE(f.can.reading.is_on);
    fixture_can_receive(0x640, 8, get_scope, cam_scope_field_every, 0);
    go_on(400);
    TEST_ASSERT_EQUAL_UINT32(0, last.id);
    TEST_ASSERT_FALSE(f.can.reading.is_on);
    n_piece = 0;
    fixture_can_receive(0x640, 8, read_scope, 7, (int32_t)(255u << 24));
    go_on(10);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_begin(&f.rig.machine.scope, &f.rig.machine.scope.set,
                                                  cam_scope_user, 0, 0));
    go_on(10);
    TEST_ASSERT_EQUAL_INT32(cam_err_scope_range, fixture_can_answer(&last).result);
    TEST_ASSERT_EQUAL_INT32(0, fixture_can_answer(&last).value);
}

/// Of a recording that was released, too.
static void test_words_that_are_not_there_are_refused(void)
{
    expect_answer(cam_err_scope_range, 0, read_scope, 0, 1 << 24);
    record();
    expect_answer(cam_err_scope_range, 0, read_scope, 3, 600 | 1 << 24);
    expect_answer(cam_err_scope_range, 0, read_scope, 3, 0); // no words are asked for
    expect_answer(cam_err_scope_range, 0, read_scope, 3, -1);
    expect_answer(cam_ok, 0, release_scope, 0, 0);
    expect_answer(cam_ok, cam_scope_idle, get_scope, cam_scope_field_phase, 0);
    expect_answer(cam_err_scope_range, 0, read_scope, 0, 1 << 24);
}

static void test_fields_and_learned_values_have_their_errors(void)
{
    static const struct {
        int32_t result, value;
        uint8_t command, index;
        int32_t sent;
    } cases[] = {
        {cam_ok, 20000, get_scope, cam_scope_field_tick_hz, 0},
        {cam_err_scope_field, 0, get_scope, cam_scope_n_fields, 0},
        {cam_err_scope_field, 0, set_scope, cam_scope_field_n_rows, 5},
        {cam_err_scope_range, 1, set_scope, cam_scope_field_every, 0},
        {cam_ok, -5, set_scope, cam_scope_field_place_nm, -5},
        {cam_ok, 0, get_learned, 0, 0},
        {cam_err_param_id, 0, get_learned, 255, 0},
        {cam_err_param_id, 0, set_learned, 255, 1},
        {cam_err_param_range, 0, set_learned, cam_ilc_value_k1, 1 << 30},
        {cam_err_param_range, 0, set_learned, cam_ilc_value_k2, -(1 << 30)},
        {cam_ok, 0, stop_scope, 0, 0},
        {cam_ok, 0, keep_alive, 9, 0},
        {cam_err_state, 0, excite, 0, 1 | 100 << 16},
        {cam_err_wave_length, 0, begin_wave, 0, 63},
        {cam_err_download_order, 0, end_wave, 0, 0},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        expect_answer((cam_err_t)cases[i].result, cases[i].value, cases[i].command, cases[i].index,
                      cases[i].sent);
    }
}

/// Frames of a block arrive. @return the answer
static fixture_answer_t send_block(const hal_can_frame_t *frames, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        (void)hal_host_can_receive(&frames[i]);
        fixture_can_loop(&f, 2);
    }
    return last_answer();
}

/// Blocks belong to what was begun last.
static void test_blocks_of_a_wave_and_of_a_table_are_distinguished(void)
{
    static const hal_can_frame_t odd = {.id = 0x6C0, .n = 8, .data = {7, 0, 0, 0, 0, 1, 2, 3}};
    static const hal_can_frame_t less = {.id = 0x6C0, .n = 8, .data = {3}}; // not even an offset
    static const hal_can_frame_t word[] = {
        {.id = 0x6C0, .n = 8, .data = {0x10, 8, 0, 0, 0, 0, 1, 2}},
        {.id = 0x6C0, .n = 3, .data = {0x21, 3, 4}},
    };
    expect_answer(cam_ok, 0, begin_wave, 0, 64);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, send_block(&odd, 1).result); // no whole sample
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, send_block(&less, 1).result);
    TEST_ASSERT_EQUAL_UINT32(18, last_answer().command);
    expect_answer(cam_err_download_short, 0, end_wave, 0, 0);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send_block(word, 2).result);
    TEST_ASSERT_EQUAL_UINT32(4, f.rig.machine.identify.received);
    expect_answer(cam_ok, 0, begin_download, 0, 4096);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, send_block(word, 2).result); // no whole grain
    TEST_ASSERT_EQUAL_INT32(0, last_answer().value);
}

static void test_a_sign_of_life_is_taken(void)
{
    fixture_rig_ticks(&f.rig, 100);
    f.rig.machine.identify.alive_tick = 0;
    expect_answer(cam_ok, 0, keep_alive, 3, 0);
    TEST_ASSERT_UINT32_WITHIN(2, fixture_rig_status(&f.rig).tick,
                              f.rig.machine.identify.alive_tick);
}

// Samples of single ticks

/// Ask for a sample of every so many ticks.
static void sample(int32_t every)
{
    expect_answer(cam_ok, every, strobe, 0, every);
}

static void test_frames_are_the_records_of_their_ticks(void)
{
    f.rig.log = ticks;
    f.rig.log_capacity = n_log;
    f.rig.lathe.error_nm[hal_axis_u] = -4321;
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
    f.rig.n_log = 0;
    forget();
    sample(47);
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

static void test_a_large_error_is_saturated_and_marked(void)
{
    static const struct {
        int32_t error_nm, sent_nm;
        uint8_t bits;
    } cases[] = {{8388607, 8388607, 0},   {8388608, 8388607, 0x20},   {INT32_MAX, 8388607, 0x20},
                 {-8388608, -8388608, 0}, {-8388609, -8388608, 0x20}, {INT32_MIN, -8388608, 0x20}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        cam_tick_record_t r = {.want.state = cam_state_fault};
        r.in.actual_nm[hal_axis_u] = cases[i].error_nm;
        fixture_rig_ticks(&f.rig, 40);
        sample(0);
        sample(40);
        r.tick = f.rig.machine.strobe.next_tick;
        cam_strobe_take(&f.rig.machine.strobe, &r);
        cam_can_poll(&f.can); // the sample of the tick after the command
        fixture_rig_ticks(&f.rig, 40);
        cam_can_poll(&f.can);
        const hal_can_frame_t frame = fixture_can_sent(0x240);
        TEST_ASSERT_EQUAL_INT32(cases[i].sent_nm,
                                (int32_t)((uint32_t)fixture_can_i32(&frame, 4) << 8) >> 8);
        TEST_ASSERT_EQUAL_HEX8((uint32_t)cam_state_fault | cases[i].bits, frame.data[7]);
    }
}

static void test_a_distance_out_of_range_is_answered_with_the_range(void)
{
    static const int32_t bad[] = {1, 39, 20001, INT32_MAX, -1, INT32_MIN};
    for (uint32_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        forget();
        expect_answer(cam_err_param_range, 0, strobe, 0, bad[i]);
        go_on(2);
        TEST_ASSERT_EQUAL_UINT32(3, n_answers);
    }
    TEST_ASSERT_EQUAL_UINT32(get_maximum, last_answer().command);
    TEST_ASSERT_EQUAL_INT32(tick_hz, last_answer().value);
    go_on(200);
    TEST_ASSERT_EQUAL_UINT32(0, n_sent);
    sample(tick_hz);
    sample(40);
    expect_answer(cam_err_param_range, 40, strobe, 0, 39);
    TEST_ASSERT_EQUAL_UINT32(40, f.rig.machine.strobe.every); // a refusal changes nothing
}

/// The status comes as before; test_cam_strobe.c renews the samples.
static void test_samples_end_after_two_seconds(void)
{
    forget();
    sample(80);
    go_on(20000);
    TEST_ASSERT_UINT32_WITHIN(1, 250, n_sent);
    TEST_ASSERT_UINT32_WITHIN(5, 500, n_status);
    go_on(19900);
    TEST_ASSERT_UINT32_WITHIN(2, 499, n_sent);
    const uint32_t n = n_sent;
    go_on(10000);
    TEST_ASSERT_UINT32_WITHIN(1, n, n_sent);
}

/// Whatever rounds the main loop makes, no two messages are nearer than 2 ms, and each sample is
/// sent or missing in the numbers.
static void test_the_pace_is_kept_when_the_main_loop_dawdles(void)
{
    static const uint32_t dawdle[] = {1, 250, 3, 90, 17, 400, 1, 1, 33};
    forget();
    sample(40);
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
    sample(40);
    forget();
    hal_host.slow.n_room = 0;
    go_on(400);
    TEST_ASSERT_EQUAL_UINT32(0, n_sent);
    fixture_can_receive(0x640, 8, get_position, 0, 0);
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

/// A renewal does not end it.
static void test_a_piece_of_a_recording_takes_as_long_as_ever(void)
{
    record();
    const uint32_t n = ask_by(read_scope, 0, 255);
    sample(40);
    TEST_ASSERT_EQUAL_UINT32(n, ask_by(read_scope, 0, 255));
    TEST_ASSERT_UINT32_WITHIN(2, n / 160u, n_sent); // 125 a second
    for (uint32_t i = 2; i + 1u < n_sent; i++) {    // to the end of the piece
        TEST_ASSERT_EQUAL_UINT32(160, sent_tick[i] - sent_tick[i - 1u]);
    }
    forget();
    fixture_can_receive(0x640, 8, read_scope, 0, (int32_t)(255u << 24));
    go_on(300);
    sample(40);
    go_on(1800);
    TEST_ASSERT_EQUAL_UINT32(146 * 7, n_piece);
}
