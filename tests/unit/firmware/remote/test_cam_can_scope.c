// SPDX-License-Identifier: Apache-2.0
// Recorder, excitation and learned values over CAN; pieces of a recording on a bus that is full.
#include "cam_remote_inner.h" // cam_reading_hz
#include "can_bench.h"
#include <string.h> // memcpy

enum { n_rows = 300, most_bytes = 256 * 63, tick_hz = 20000 };

static uint8_t piece[most_bytes];
static uint32_t n_piece;     ///< bytes
static uint32_t n_seen;      ///< frames of the port that were looked at
static hal_can_frame_t last; ///< answer to read_scope

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
        } else if (frame->id == 0x5C0u &&
                   (frame->data[0] == read_scope || frame->data[0] == read_scope_fd)) {
            last = *frame;
        }
    }
}

/// Forget all that was sent.
static void forget(void)
{
    n_seen = hal_host.slow.n_sent;
    n_piece = 0;
    last = (hal_can_frame_t){0};
}

/// Ticks, each with a round of the main loop, after which the frames are looked at.
static void go_on(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        fixture_can_loop(&f, 1);
        look();
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
    TEST_ASSERT_FALSE(f.can.reading.is_on);
    ask_for_piece(255); // another recording with as many words
    go_on(10);
    f.rig.machine.scope.number++;
    go_on(10);
    TEST_ASSERT_EQUAL_INT32(cam_err_scope_range, fixture_can_answer(&last).result);
    TEST_ASSERT_FALSE(f.can.reading.is_on);
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
