// SPDX-License-Identifier: Apache-2.0
#include "cam_scope.h"
#include "unity.h"
#include <string.h> // memset

enum { n_memory = 64 };

static int32_t memory[n_memory];
static cam_scope_t scope;

void setUp(void)
{
    memset(memory, 0x55, sizeof memory);
    cam_scope_init(&scope, (hal_memory_t){.words = memory, .n_words = n_memory}, 20000);
}

static cam_tick_record_t record(uint32_t tick)
{
    cam_tick_record_t r = {.tick = tick};
    r.want.state = cam_state_ready;
    r.want.u_set_q6 = (int32_t)tick * 64 - 7;
    r.in.actual_nm[hal_axis_u] = -(int32_t)tick;
    r.out[hal_axis_u].pos_nm = (int32_t)tick;
    return r;
}

static void take(uint32_t tick)
{
    const cam_tick_record_t r = record(tick);
    cam_scope_take(&scope, &r);
}

static void take_in(uint32_t tick, cam_state_t state)
{
    cam_tick_record_t r = record(tick);
    r.want.state = state;
    cam_scope_take(&scope, &r);
}

static int32_t field(uint32_t which)
{
    int32_t value = 0;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_get(&scope, which, &value));
    return value;
}

static void set(uint32_t which, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_set(&scope, which, value));
}

static void start(uint32_t tick)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_begin(&scope, &scope.set, cam_scope_user, 0, tick));
}

/// Of a recording that plays no wave there is nothing to tell.
static void test_fields_of_a_wave_are_zero_without_one(void)
{
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_place_nm));
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_excited));
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_n_fall));
}

static void test_rows_hold_the_chosen_signals_in_the_order_of_the_list(void)
{
    set(cam_scope_field_signals, 1 << cam_scope_tick | 1 << cam_scope_u_actual_nm);
    set(cam_scope_field_rows, 3);
    start(100);
    for (uint32_t tick = 98; tick < 110; tick++) { // two of before the start
        take(tick);
    }
    static const int32_t wanted[] = {100, -100, 101, -101, 102, -102, 0x55555555};
    TEST_ASSERT_EQUAL_INT32_ARRAY(wanted, &scope.words[scope.at], 7);
    TEST_ASSERT_EQUAL_INT32(3, field(cam_scope_field_n_rows));
    TEST_ASSERT_EQUAL_INT32(100, field(cam_scope_field_first_tick));
    TEST_ASSERT_EQUAL_INT32(cam_scope_done, field(cam_scope_field_phase));
    TEST_ASSERT_EQUAL_INT32(cam_scope_full, field(cam_scope_field_end));
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_n_lost));
    TEST_ASSERT_EQUAL_UINT32(6, cam_scope_n_recorded(&scope));
}

static void test_memory_bounds_the_rows_and_is_never_left(void)
{
    for (uint32_t n_wave = 0; n_wave < n_memory; n_wave++) {
        setUp();
        cam_scope_reserve(&scope, n_wave);
        set(cam_scope_field_rows, n_wave % 2u == 0u ? 0 : 1000000);
        if ((n_memory - n_wave) / 3u == 0u) {
            TEST_ASSERT_EQUAL_INT(cam_err_scope_memory,
                                  cam_scope_begin(&scope, &scope.set, cam_scope_user, 0, 0));
            continue;
        }
        start(0);
        for (uint32_t tick = 0; tick < 100; tick++) {
            take(tick);
        }
        TEST_ASSERT_EQUAL_INT32((n_memory - n_wave) / 3u, field(cam_scope_field_n_rows));
        TEST_ASSERT_EQUAL_INT32(cam_scope_full, field(cam_scope_field_end));
        for (uint32_t i = 0; i < n_wave; i++) {
            TEST_ASSERT_EQUAL_INT32(0x55555555, memory[i]);
        }
    }
}

static void test_without_memory_nothing_is_recorded(void)
{
    cam_scope_init(&scope, (hal_memory_t){0}, 20000);
    TEST_ASSERT_EQUAL_INT(cam_err_scope_memory,
                          cam_scope_begin(&scope, &scope.set, cam_scope_user, 0, 0));
    take(1);
    TEST_ASSERT_EQUAL_INT32(cam_scope_idle, field(cam_scope_field_phase));
}

static void test_every_nth_tick_is_recorded(void)
{
    set(cam_scope_field_signals, 1 << cam_scope_tick);
    set(cam_scope_field_every, 5);
    set(cam_scope_field_rows, 4);
    start(UINT32_MAX - 6u); // the tick's number wraps
    for (uint32_t i = 0; i < 30u; i++) {
        take(UINT32_MAX - 6u + i);
    }
    static const int32_t wanted[] = {-7, -2, 3, 8};
    TEST_ASSERT_EQUAL_INT32_ARRAY(wanted, &scope.words[scope.at], 4);
}

static void test_a_lost_record_ends_the_recording_and_is_counted(void)
{
    start(10);
    take(10);
    take(11);
    take(15);
    take(16);
    TEST_ASSERT_EQUAL_INT32(2, field(cam_scope_field_n_rows));
    TEST_ASSERT_EQUAL_INT32(cam_scope_gap, field(cam_scope_field_end));
    TEST_ASSERT_EQUAL_INT32(3, field(cam_scope_field_n_lost));
}

static void test_a_state_begins_and_ends_it(void)
{
    set(cam_scope_field_from_state, cam_state_identifying);
    start(10);
    take_in(10, cam_state_ready);
    TEST_ASSERT_EQUAL_INT32(cam_scope_armed, field(cam_scope_field_phase));
    take_in(12, cam_state_identifying); // what was lost while it waited is no gap
    take_in(13, cam_state_identifying);
    TEST_ASSERT_EQUAL_INT32(cam_scope_recording, field(cam_scope_field_phase));
    take_in(14, cam_state_ready);
    take_in(15, cam_state_identifying);
    TEST_ASSERT_EQUAL_INT32(2, field(cam_scope_field_n_rows));
    TEST_ASSERT_EQUAL_INT32(12, field(cam_scope_field_first_tick));
    TEST_ASSERT_EQUAL_INT32(cam_scope_state_left, field(cam_scope_field_end));
}

static void test_stop_ends_it_and_keeps_the_rows(void)
{
    start(10);
    take(10);
    cam_scope_stop(&scope);
    take(11);
    TEST_ASSERT_EQUAL_INT32(1, field(cam_scope_field_n_rows));
    TEST_ASSERT_EQUAL_INT32(cam_scope_stopped, field(cam_scope_field_end));
    cam_scope_stop(&scope); // of nothing: nothing
    TEST_ASSERT_EQUAL_INT32(cam_scope_stopped, field(cam_scope_field_end));
    start(20);
    TEST_ASSERT_EQUAL_INT32(2, field(cam_scope_field_number));
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_n_rows));
}

static void test_fields_are_checked(void)
{
    static const struct {
        uint32_t field;
        int32_t value;
        cam_err_t err;
    } cases[] = {
        {cam_scope_field_signals, 0, cam_err_scope_range},
        {cam_scope_field_signals, INT32_MIN, cam_err_scope_range},
        {cam_scope_field_every, 0, cam_err_scope_range},
        {cam_scope_field_every, 1000001, cam_err_scope_range},
        {cam_scope_field_every, 1000000, cam_ok},
        {cam_scope_field_rows, -1, cam_err_scope_range},
        {cam_scope_field_from_state, -2, cam_err_scope_range},
        {cam_scope_field_from_state, cam_n_states, cam_err_scope_range},
        {cam_scope_field_n_rows, 1, cam_err_scope_field},
        {cam_scope_n_fields, 1, cam_err_scope_field},
        {UINT32_MAX, 1, cam_err_scope_field},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_INT(cases[i].err, cam_scope_set(&scope, cases[i].field, cases[i].value));
    }
    int32_t value = 1;
    TEST_ASSERT_EQUAL_INT(cam_err_scope_field, cam_scope_get(&scope, cam_scope_n_fields, &value));
    TEST_ASSERT_EQUAL_INT32(0, value);
    TEST_ASSERT_EQUAL_STRING("?", cam_scope_signal_name(cam_scope_n_signals));
    TEST_ASSERT_EQUAL_STRING("u_set_q6", cam_scope_signal_name(cam_scope_u_set_q6));
}

/// Each signal is the member that its name tells.
static void test_signals_are_those_of_the_record(void)
{
    cam_tick_record_t r = record(5);
    r.angle.pos_q32 = INT64_C(-3) * 4294967296 + 77;
    r.angle.speed_q32 = 11;
    r.want.faults = UINT32_MAX;
    r.in.encoder = (hal_encoder_t){12, 13, 14, 15};
    r.in.swing_q32 = -16;
    set(cam_scope_field_signals, (int32_t)(UINT32_MAX >> (32 - cam_scope_n_signals)));
    start(5);
    cam_scope_take(&scope, &r);
    const int32_t *row = &scope.words[scope.at];
    TEST_ASSERT_EQUAL_INT32(cam_scope_n_signals, field(cam_scope_field_n_signals));
    TEST_ASSERT_EQUAL_INT32(5, row[cam_scope_tick]);
    TEST_ASSERT_EQUAL_INT32(313, row[cam_scope_u_set_q6]);
    TEST_ASSERT_EQUAL_INT32(-5, row[cam_scope_u_actual_nm]);
    TEST_ASSERT_EQUAL_INT32(5, row[cam_scope_u_command_nm]);
    TEST_ASSERT_EQUAL_INT32(-3, row[cam_scope_turn]);
    TEST_ASSERT_EQUAL_INT32(77, row[cam_scope_angle_q32]);
    TEST_ASSERT_EQUAL_INT32(11, row[cam_scope_speed_q32]);
    TEST_ASSERT_EQUAL_INT32(-1, row[cam_scope_faults]);
    TEST_ASSERT_EQUAL_INT32(12, row[cam_scope_counts]);
    TEST_ASSERT_EQUAL_INT32(13, row[cam_scope_index_counts]);
    TEST_ASSERT_EQUAL_INT32(14, row[cam_scope_n_index]);
    TEST_ASSERT_EQUAL_INT32(15, row[cam_scope_edge_clock]);
    TEST_ASSERT_EQUAL_INT32(-16, row[cam_scope_swing_q32]);
}

/// Whatever an earlier recording has left, only the memory, the wave in it and what is set stay.
static void test_recording_begins_anew_in_each_word(void)
{
    static int32_t words[64];
    cam_scope_t s;
    cam_scope_init(&s, (hal_memory_t){.words = words, .n_words = 64}, 20000);
    cam_scope_plan_t plan = s.set;
    plan.rows = 5;
    s.phase = cam_scope_done;
    s.end = cam_scope_gap;
    s.ring.oldest = s.ring.n_rows = s.ring.n_before = s.to_row = 3;
    s.start_tick = s.ring.first_tick = s.last_tick = s.ring.trigger_tick = 7;
    s.ring.faults = s.ring.n_lost = s.number = 9;
    s.last.is_there = true;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_begin(&s, &plan, cam_scope_box, 11, 1234));
    TEST_ASSERT_EQUAL_INT(cam_scope_armed, s.phase);
    TEST_ASSERT_EQUAL_INT(cam_scope_open, s.end);
    TEST_ASSERT_EQUAL_INT(cam_scope_box, s.use);
    TEST_ASSERT_EQUAL_UINT32(11, s.at);
    TEST_ASSERT_EQUAL_UINT32(5, s.ring.most_rows);
    TEST_ASSERT_EQUAL_UINT32(0, s.ring.oldest + s.ring.n_rows + s.ring.n_before + s.to_row);
    TEST_ASSERT_EQUAL_UINT32(0, s.ring.faults + s.ring.n_lost);
    TEST_ASSERT_EQUAL_UINT32(10, s.number);
    TEST_ASSERT_EQUAL_UINT32(1234, s.start_tick);
    TEST_ASSERT_EQUAL_UINT32(1234, s.ring.first_tick);
    TEST_ASSERT_EQUAL_UINT32(1234, s.last_tick);
    TEST_ASSERT_EQUAL_UINT32(1234, s.ring.trigger_tick);
    TEST_ASSERT_FALSE(s.last.is_there);
}
