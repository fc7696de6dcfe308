// SPDX-License-Identifier: Apache-2.0
// Recorder, excitation and learned values over CAN; pieces of a recording on a bus that is full.
#include "cam_table.h" // cam_crc32
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"
#include <string.h> // memcpy

enum {
    set_scope = 19,
    get_scope,
    start_scope,
    stop_scope,
    read_scope,
    begin_wave,
    end_wave,
    excite,
    keep_alive,
    get_learned,
    set_learned,
};

enum { read_scope_fd = 57, release_scope };

enum { n_rows = 300, most_bytes = 256 * 63 };

static fixture_can_t f;
static uint8_t piece[most_bytes];
static uint32_t n_piece;     ///< bytes
static uint32_t n_seen;      ///< frames of the port that were looked at
static hal_can_frame_t last; ///< answer to read_scope

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_can_init(&f, &part, 20000);
    fixture_can_start(&f);
    n_seen = hal_host.slow.n_sent;
}

static void expect(cam_err_t err, int32_t value, uint8_t command, uint8_t index, int32_t given)
{
    const fixture_answer_t a = fixture_can_command(&f, command, index, given);
    TEST_ASSERT_EQUAL_UINT32(command, a.command);
    TEST_ASSERT_EQUAL_UINT32(index, a.index);
    TEST_ASSERT_EQUAL_INT32(err, a.result);
    TEST_ASSERT_EQUAL_INT32(value, a.value);
}

/// Look at every frame that was sent since the last call.
static void look(void)
{
    for (; n_seen != hal_host.slow.n_sent; n_seen++) {
        const hal_can_frame_t *frame = &hal_host.slow.sent[n_seen % hal_host_can_frames];
        if (frame->id == 0x440u) {
            TEST_ASSERT_EQUAL_UINT8(n_piece / 7u, frame->data[0]);
            memcpy(piece + n_piece, &frame->data[1], 7);
            n_piece += 7u;
        } else if (frame->id == 0x340u) {
            TEST_ASSERT_EQUAL_UINT8(n_piece / 63u, frame->data[0]);
            TEST_ASSERT_EQUAL_UINT32(64, frame->n);
            memcpy(piece + n_piece, &frame->data[1], 63);
            n_piece += 63u;
        } else if (frame->id == 0x5C0u &&
                   (frame->data[0] == read_scope || frame->data[0] == read_scope_fd)) {
            last = *frame;
        } else {
            // status
        }
    }
}

/// Ticks of the main loop, after each of which the frames are looked at.
static void go_on(uint32_t ticks)
{
    for (uint32_t i = 0; i < ticks; i++) {
        fixture_can_loop(&f, 1);
        look();
    }
}

/// Ask for words of the recording and poll until the answer is there. @return polls
static uint32_t ask_by(uint8_t command, uint32_t offset, uint32_t count)
{
    n_piece = 0;
    last = (hal_can_frame_t){0};
    look();
    n_piece = 0;
    fixture_can_receive(0x640, 8, command, 7, (int32_t)(offset | count << 24));
    uint32_t n = 0;
    for (; n < 4000u && last.id == 0u; n++) {
        fixture_can_loop(&f, 1);
        look();
    }
    return n;
}

static uint32_t ask_piece(uint32_t offset, uint32_t count)
{
    return ask_by(read_scope, offset, count);
}

/// Record rows of tick and u_actual_nm.
static void record(void)
{
    expect(cam_ok, 1 << cam_scope_tick | 1 << cam_scope_u_actual_nm, set_scope,
           cam_scope_field_signals, 1 << cam_scope_tick | 1 << cam_scope_u_actual_nm);
    expect(cam_ok, n_rows, set_scope, cam_scope_field_rows, n_rows);
    expect(cam_ok, 0, start_scope, 0, 0);
    fixture_can_loop(&f, n_rows + 10);
    expect(cam_ok, cam_scope_done, get_scope, cam_scope_field_phase, 0);
    expect(cam_ok, n_rows, get_scope, cam_scope_field_n_rows, 0);
    look();
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

static void expect_piece(uint32_t offset, uint32_t n_words)
{
    expect_parts(offset, n_words, 7);
}

static void test_pieces_are_the_words_of_the_recording(void)
{
    record();
    const uint32_t polls = ask_piece(0, 255);
    expect_piece(0, 255);
    TEST_ASSERT_UINT32_WITHIN(40, 146u * 20000u / cam_reading_hz, polls);
    (void)ask_piece(598, 255);
    expect_piece(598, 2); // where it ends
    (void)ask_piece(5, 1);
    expect_piece(5, 1);
}

static void test_pieces_over_fd_are_the_same_words(void)
{
    record();
    const uint32_t polls = ask_by(read_scope_fd, 0, 16);
    expect_parts(0, 256, 63);
    TEST_ASSERT_UINT32_WITHIN(30, 17u * 20000u / cam_reading_fd_hz, polls);
    TEST_ASSERT_EQUAL_UINT32(read_scope_fd, fixture_can_answer(&last).command);
    (void)ask_by(read_scope_fd, 3, 255);
    expect_parts(3, 597, 63); // where it ends
    expect(cam_err_scope_range, 0, read_scope_fd, 3, 600 | 1 << 24);
}

/// A ring that has wrapped is sent in the order of time, by both ways.
static void test_pieces_of_a_ring_are_in_order(void)
{
    cam_scope_t *s = &f.rig.machine.scope;
    expect(cam_ok, 1 << cam_scope_tick, set_scope, cam_scope_field_signals, 1 << cam_scope_tick);
    expect(cam_ok, 900, set_scope, cam_scope_field_rows, 900);
    expect(cam_ok, 700, set_scope, cam_scope_field_before, 700);
    expect(cam_ok, cam_trigger_time, set_scope, cam_scope_field_trigger, cam_trigger_time);
    expect(cam_ok, 1500, set_scope, cam_scope_field_level, 1500);
    expect(cam_ok, 0, start_scope, 0, 0);
    expect(cam_err_scope_on, 0, read_scope, 0, 1 << 24);
    fixture_can_loop(&f, 1800);
    TEST_ASSERT_EQUAL_INT(cam_scope_full, s->end);
    TEST_ASSERT_GREATER_THAN_UINT32(0, s->ring.oldest);
    for (int way = 0; way < 2; way++) {
        (void)ask_by(way == 0 ? read_scope : read_scope_fd, 0, 252);
        TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_can_answer(&last).result);
        const uint32_t n_words = way == 0 ? 252 : 900;
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
    n_piece = 0;
    last = (hal_can_frame_t){0};
    fixture_can_receive(0x640, 8, read_scope, 7, (int32_t)(n << 24));
}

static void test_release_gives_the_recording_up(void)
{
    record();
    expect(cam_ok, 0, release_scope, 0, 0);
    expect(cam_ok, cam_scope_idle, get_scope, cam_scope_field_phase, 0);
    expect(cam_err_scope_range, 0, read_scope, 0, 1 << 24);
}

static void test_a_full_queue_delays_a_piece(void)
{
    ask_for_piece(100);
    hal_host.slow.n_room = 3;
    go_on(400);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(21, n_piece);
    TEST_ASSERT_EQUAL_UINT32(0, last.id);
    hal_host.slow.n_room = 1000;
    go_on(1000);
    expect_piece(0, 100);
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

static void test_a_block_ends_a_piece(void)
{
    ask_for_piece(255);
    go_on(100);
    TEST_ASSERT_GREATER_THAN_UINT32(0, n_piece);
    const hal_can_frame_t single = {.id = 0x6C0, .n = 8, .data = {7}};
    (void)hal_host_can_receive(&single);
    go_on(2000);
    TEST_ASSERT_EQUAL_UINT32(0, last.id); // the piece has no answer
    TEST_ASSERT_LESS_THAN_UINT32(255u * 4u, n_piece);
}

static void test_words_that_are_not_there_are_refused(void)
{
    expect(cam_err_scope_range, 0, read_scope, 0, 1 << 24);
    record();
    expect(cam_err_scope_range, 0, read_scope, 3, 600 | 1 << 24);
    expect(cam_err_scope_range, 0, read_scope, 3, 0); // no words are asked for
    expect(cam_err_scope_range, 0, read_scope, 3, -1);
}

static void test_fields_and_learned_values_have_their_errors(void)
{
    expect(cam_ok, 20000, get_scope, cam_scope_field_tick_hz, 0);
    expect(cam_err_scope_field, 0, get_scope, cam_scope_n_fields, 0);
    expect(cam_err_scope_field, 0, set_scope, cam_scope_field_n_rows, 5);
    expect(cam_err_scope_range, 1, set_scope, cam_scope_field_every, 0);
    expect(cam_ok, -5, set_scope, cam_scope_field_place_nm, -5);
    expect(cam_ok, 0, get_learned, 0, 0);
    expect(cam_err_param_id, 0, get_learned, 255, 0);
    expect(cam_err_param_id, 0, set_learned, 255, 1);
    expect(cam_err_param_range, 0, set_learned, cam_ilc_value_k1, 1 << 30);
    expect(cam_err_param_range, 0, set_learned, cam_ilc_value_k2, -(1 << 30));
    expect(cam_ok, 0, stop_scope, 0, 0);
    expect(cam_ok, 0, keep_alive, 9, 0);
    expect(cam_err_state, 0, excite, 0, 1 | 100 << 16);
    expect(cam_err_wave_length, 0, begin_wave, 0, 63);
    expect(cam_err_download_order, 0, end_wave, 0, 0);
}

/// A block of one word arrives, for offset 0. @return the answer
static fixture_answer_t send_word(void)
{
    static const hal_can_frame_t frames[] = {
        {.id = 0x6C0, .n = 8, .data = {0x10, 8, 0, 0, 0, 0, 1, 2}},
        {.id = 0x6C0, .n = 3, .data = {0x21, 3, 4}},
    };
    for (int i = 0; i < 2; i++) {
        (void)hal_host_can_receive(&frames[i]);
        fixture_can_loop(&f, 2);
    }
    const hal_can_frame_t answer = fixture_can_sent(0x5C0);
    return fixture_can_answer(&answer);
}

/// Blocks go where the last begin said.
static void test_blocks_of_a_wave_and_of_a_table_are_told_apart(void)
{
    expect(cam_ok, 0, begin_wave, 0, 64);
    hal_can_frame_t single = {.id = 0x6C0, .n = 8, .data = {7, 0, 0, 0, 0, 1, 2, 3}};
    (void)hal_host_can_receive(&single); // three bytes: no whole sample
    fixture_can_loop(&f, 2);
    hal_can_frame_t answer = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, fixture_can_answer(&answer).result);
    single.data[0] = 3; // not even an offset
    (void)hal_host_can_receive(&single);
    fixture_can_loop(&f, 2);
    answer = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, fixture_can_answer(&answer).result);
    TEST_ASSERT_EQUAL_UINT32(18, fixture_can_answer(&answer).command);
    expect(cam_err_download_short, 0, end_wave, 0, 0);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send_word().result);
    TEST_ASSERT_EQUAL_UINT32(4, f.rig.machine.identify.received);
    expect(cam_ok, 0, 16, 0, 4096); // begin_download: blocks are of a table again
    TEST_ASSERT_EQUAL_INT32(cam_err_download_order, send_word().result); // no whole grain
    TEST_ASSERT_EQUAL_INT32(0, send_word().value);
}

static void test_a_sign_of_life_is_taken(void)
{
    fixture_rig_ticks(&f.rig, 100);
    f.rig.machine.identify.alive_tick = 0;
    expect(cam_ok, 0, keep_alive, 3, 0);
    TEST_ASSERT_UINT32_WITHIN(2, fixture_rig_status(&f.rig).tick,
                              f.rig.machine.identify.alive_tick);
}
