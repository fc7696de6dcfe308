// SPDX-License-Identifier: Apache-2.0
// The recorder: its rows in the memory, its fields, rows before and after a trigger wherever it
// falls in the ring, every reading of them, and what fires a trigger.
#include "cam_recorder.h"
#include "unity.h"
#include <string.h> // memcpy, memset

enum { n_memory = 64, most_bytes = n_memory * 4 };

static int32_t memory[n_memory];
static cam_scope_t scope;
static cam_scope_plan_t plan; ///< two signals: the tick, and what is watched

void setUp(void)
{
    memset(memory, 0x55, sizeof memory);
    cam_scope_init(&scope, (hal_memory_t){.words = memory, .n_words = n_memory}, 20000);
    plan = (cam_scope_plan_t){
        .signals = 1u << cam_scope_tick | 1u << cam_scope_u_actual_nm,
        .every = 1,
        .from_state = -1,
        .trigger = {.kind = cam_trigger_level, .signal = cam_scope_u_actual_nm, .level = 1000},
    };
}

static cam_tick_record_t record(uint32_t tick, int32_t u_actual_nm, cam_state_t state)
{
    cam_tick_record_t r = {.tick = tick};
    r.want.state = state;
    r.want.u_set_q6 = (int32_t)tick * 64 - 7;
    r.in.actual_nm[hal_axis_u] = u_actual_nm;
    r.out[hal_axis_u].pos_nm = (int32_t)tick;
    return r;
}

static void take_in(uint32_t tick, cam_state_t state)
{
    const cam_tick_record_t r = record(tick, -(int32_t)tick, state);
    cam_scope_take(&scope, &r);
}

static void take(uint32_t tick)
{
    take_in(tick, cam_state_ready);
}

static void take_value(uint32_t tick, int32_t watched)
{
    const cam_tick_record_t r = record(tick, watched, cam_state_ready);
    cam_scope_take(&scope, &r);
}

static int32_t field(uint32_t which)
{
    int32_t value = 0;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_get(&scope, which, &value));
    return value;
}

static void begin(uint32_t tick)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_begin(&scope, &plan, cam_scope_user, 0, tick));
}

/// Begin with a trigger that fires at once.
static void begin_now(uint32_t tick)
{
    plan.trigger.kind = cam_trigger_now;
    begin(tick);
}

static void test_rows_hold_the_chosen_signals_in_the_order_of_the_list(void)
{
    plan.rows = 3;
    begin_now(100);
    for (uint32_t tick = 98; tick < 110; tick++) { // two of before the start
        take(tick);
    }
    static const int32_t wanted[] = {100, -100, 101, -101, 102, -102, 0x55555555};
    TEST_ASSERT_EQUAL_INT32_ARRAY(wanted, &scope.words[scope.at], 7);
    TEST_ASSERT_EQUAL_INT32((int32_t)plan.signals, field(cam_scope_field_signals));
    TEST_ASSERT_EQUAL_INT32(3, field(cam_scope_field_n_rows));
    TEST_ASSERT_EQUAL_INT32(100, field(cam_scope_field_first_tick));
    TEST_ASSERT_EQUAL_INT32(cam_scope_done, field(cam_scope_field_phase));
    TEST_ASSERT_EQUAL_INT32(cam_scope_full, field(cam_scope_field_end));
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_n_lost));
    TEST_ASSERT_EQUAL_UINT32(6, cam_scope_n_recorded(&scope));
}

static void test_memory_bounds_the_rows_and_is_never_left(void)
{
    for (uint32_t n_wave = 0; n_wave <= n_memory; n_wave++) {
        setUp();
        scope.use = cam_scope_box;
        cam_scope_reserve(&scope, n_wave);
        TEST_ASSERT_EQUAL_INT(cam_scope_nobody, scope.use);
        plan.signals = scope.set.signals; // three
        plan.rows = n_wave % 2u == 0u ? 0 : 1000000;
        if ((n_memory - n_wave) / 3u == 0u) {
            TEST_ASSERT_EQUAL_INT(cam_err_scope_memory,
                                  cam_scope_begin(&scope, &plan, cam_scope_user, 0, 0));
            take(1);
            TEST_ASSERT_EQUAL_INT32(cam_scope_idle, field(cam_scope_field_phase));
            continue;
        }
        begin_now(0);
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

static void test_a_state_begins_and_ends_it(void)
{
    plan.from_state = cam_state_identifying;
    begin_now(10);
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
    begin_now(10);
    take(10);
    cam_scope_stop(&scope);
    take(11);
    TEST_ASSERT_EQUAL_INT32(1, field(cam_scope_field_n_rows));
    TEST_ASSERT_EQUAL_INT32(cam_scope_stopped, field(cam_scope_field_end));
    cam_scope_stop(&scope); // of nothing: nothing
    TEST_ASSERT_EQUAL_INT32(cam_scope_stopped, field(cam_scope_field_end));
    begin_now(20);
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
        {cam_scope_field_signals, 3, cam_ok},
        {cam_scope_field_every, 0, cam_err_scope_range},
        {cam_scope_field_every, 1000001, cam_err_scope_range},
        {cam_scope_field_every, 1, cam_ok},
        {cam_scope_field_every, 1000000, cam_ok},
        {cam_scope_field_rows, 0, cam_ok},
        {cam_scope_field_rows, -1, cam_err_scope_range},
        {cam_scope_field_from_state, -2, cam_err_scope_range},
        {cam_scope_field_from_state, cam_n_states - 1, cam_ok},
        {cam_scope_field_from_state, cam_n_states, cam_err_scope_range},
        {cam_scope_field_before, 0, cam_ok},
        {cam_scope_field_before, 7, cam_ok},
        {cam_scope_field_before, -1, cam_err_scope_range},
        {cam_scope_field_trigger, cam_trigger_now, cam_ok},
        {cam_scope_field_trigger, cam_trigger_fault, cam_ok},
        {cam_scope_field_trigger, cam_trigger_n, cam_err_scope_range},
        {cam_scope_field_trigger, -1, cam_err_scope_range},
        {cam_scope_field_watched, cam_scope_n_signals - 1, cam_ok},
        {cam_scope_field_watched, cam_scope_n_signals, cam_err_scope_range},
        {cam_scope_field_watched, -1, cam_err_scope_range},
        {cam_scope_field_level, INT32_MIN, cam_ok},
        {cam_scope_field_edge, 0, cam_ok},
        {cam_scope_field_edge, 1, cam_ok},
        {cam_scope_field_edge, 2, cam_err_scope_range},
        {cam_scope_field_use, 1, cam_err_scope_field},
        {cam_scope_field_place_nm, 1, cam_err_scope_field},
        {cam_scope_field_wave_unit, 1, cam_err_scope_field},
        {cam_scope_field_n_rows, 1, cam_err_scope_field},
        {cam_scope_n_fields, 1, cam_err_scope_field},
        {UINT32_MAX, 1, cam_err_scope_field},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_INT(cases[i].err, cam_scope_set(&scope, cases[i].field, cases[i].value));
        if (cases[i].err == cam_ok) {
            TEST_ASSERT_EQUAL_INT32(cases[i].value, field(cases[i].field));
        }
    }
    TEST_ASSERT_EQUAL_UINT32(7, scope.set.before);
    TEST_ASSERT_TRUE(scope.set.trigger.falls);
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_place_nm)); // no wave is played
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_excited) | field(cam_scope_field_n_fall));
    int32_t value = 1;
    TEST_ASSERT_EQUAL_INT(cam_err_scope_field, cam_scope_get(&scope, cam_scope_n_fields, &value));
    TEST_ASSERT_EQUAL_INT32(0, value);
    TEST_ASSERT_EQUAL_STRING("?", cam_scope_signal_name(cam_scope_n_signals));
    TEST_ASSERT_EQUAL_STRING("u_set_q6", cam_scope_signal_name(cam_scope_u_set_q6));
}

/// Each signal is the member that its name gives.
static void test_signals_are_those_of_the_record(void)
{
    static const int32_t row[][2] = {
        {cam_scope_tick, 5},          {cam_scope_u_set_q6, 313}, {cam_scope_u_actual_nm, -5},
        {cam_scope_u_command_nm, 5},  {cam_scope_turn, -3},      {cam_scope_angle_q32, 77},
        {cam_scope_speed_q32, 11},    {cam_scope_faults, -1},    {cam_scope_counts, 12},
        {cam_scope_index_counts, 13}, {cam_scope_n_index, 14},   {cam_scope_edge_clock, 15},
        {cam_scope_swing_q32, -16}};
    cam_tick_record_t r = record(5, -5, cam_state_ready);
    r.angle.pos_q32 = INT64_C(-3) * 4294967296 + 77;
    r.angle.speed_q32 = 11;
    r.want.faults = UINT32_MAX;
    r.in.encoder = (hal_encoder_t){12, 13, 14, 15};
    r.in.swing_q32 = -16;
    plan.signals = UINT32_MAX >> (32 - cam_scope_n_signals);
    begin_now(5);
    cam_scope_take(&scope, &r);
    TEST_ASSERT_EQUAL_INT32(cam_scope_n_signals, field(cam_scope_field_n_signals));
    for (size_t i = 0; i < sizeof row / sizeof row[0]; i++) {
        TEST_ASSERT_EQUAL_INT32(row[i][1], scope.words[scope.at + (uint32_t)row[i][0]]);
    }
}

/// Whatever an earlier recording has left, only the memory, the wave in it and what is set stay.
static void test_recording_begins_anew_in_each_word(void)
{
    plan.rows = 5;
    scope.number = 9;
    const cam_scope_t fresh = scope;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_begin(&scope, &plan, cam_scope_box, 11, 1234));
    const cam_scope_t wanted = scope;
    TEST_ASSERT_EQUAL_INT(cam_scope_armed, scope.phase);
    TEST_ASSERT_EQUAL_INT(cam_scope_box, scope.use);
    TEST_ASSERT_EQUAL_UINT32(11, scope.at);
    TEST_ASSERT_EQUAL_UINT32(5, scope.ring.most_rows);
    TEST_ASSERT_EQUAL_UINT32(10, scope.number);
    TEST_ASSERT_EQUAL_UINT32(1234, scope.start_tick);
    TEST_ASSERT_EQUAL_UINT32(1234, scope.ring.first_tick);
    TEST_ASSERT_EQUAL_UINT32(1234, scope.last_tick);
    TEST_ASSERT_EQUAL_UINT32(1234, scope.ring.trigger_tick);
    memset(&scope.ring, 3, sizeof scope.ring);
    scope.phase = cam_scope_done;
    scope.end = cam_scope_gap;
    scope.to_row = scope.start_tick = scope.last_tick = 7;
    scope.last.is_there = true;
    scope.number = fresh.number;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_begin(&scope, &plan, cam_scope_box, 11, 1234));
    TEST_ASSERT_EQUAL_MEMORY(&wanted, &scope, sizeof scope);
}

// Rows before and after a trigger

/// @return the rows in order, read in pieces of n bytes
static const int32_t *rows_by(uint32_t n)
{
    static int32_t words[n_memory];
    uint8_t *bytes = (uint8_t *)words;
    const uint32_t n_all = cam_scope_n_recorded(&scope) * 4u;
    for (uint32_t at = 0; at < n_all;) {
        const cam_scope_span_t span = cam_scope_span(&scope, at, n < n_all - at ? n : n_all - at);
        TEST_ASSERT_GREATER_THAN_UINT32(0, span.n);
        memcpy(bytes + at, span.bytes, span.n);
        at += span.n;
    }
    return words;
}

static uint32_t least(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/// The trigger falls in tick `at`, of which the first is 0; the tick's number wraps on the way.
static void expect_recording(uint32_t at, uint32_t before, uint32_t rows)
{
    const uint32_t first = UINT32_MAX - 40u;
    setUp();
    plan.before = before;
    plan.rows = rows;
    begin(first);
    for (uint32_t i = 0; i < at + rows + 3u; i++) {
        take_value(first + i, i < at ? 999 - (int32_t)i : 1000 + (int32_t)i);
    }
    const uint32_t n_before = least(at, before);
    TEST_ASSERT_EQUAL_INT(cam_scope_full, scope.end);
    TEST_ASSERT_EQUAL_UINT32(first + at, scope.ring.trigger_tick);
    TEST_ASSERT_EQUAL_UINT32(n_before, scope.ring.n_before);
    TEST_ASSERT_EQUAL_UINT32(n_before + rows - before, scope.ring.n_rows);
    TEST_ASSERT_EQUAL_UINT32(first + at - n_before, scope.ring.first_tick);
    const int32_t *words = rows_by(1 + at % 9u);
    for (uint32_t k = 0; k < scope.ring.n_rows; k++) {
        const uint32_t i = at - n_before + k;
        TEST_ASSERT_EQUAL_INT32(first + i, words[2u * k]);
        TEST_ASSERT_EQUAL_INT32(i < at ? 999 - (int32_t)i : 1000 + (int32_t)i, words[2u * k + 1u]);
    }
}

/// Every place of the trigger in the ring, every share of it before the trigger.
static void test_rows_before_the_trigger_are_exact_to_the_tick(void)
{
    for (uint32_t at = 1; at < 100u; at++) {
        for (uint32_t before = 0; before < n_memory / 2u; before++) {
            expect_recording(at, before, n_memory / 2u);
        }
        expect_recording(at, 3, 5);
        expect_recording(at, 4, 5);
    }
}

/// Rows of every third tick: the trigger is found in the ticks between them as well, and without
/// rows before it the first row is that of the trigger.
static void test_rows_far_apart_give_the_tick_of_the_trigger(void)
{
    for (uint32_t n = 2; n < 120u; n++) {
        const uint32_t at = n / 2u;
        setUp();
        plan.every = 3;
        plan.before = n % 2u == 0u ? 4 : 0;
        plan.rows = 9;
        begin(0);
        for (uint32_t i = 0; i < 120u; i++) {
            take_value(i, i == at ? 1000 : 0); // for one tick only
        }
        TEST_ASSERT_EQUAL_INT(cam_scope_full, scope.end);
        TEST_ASSERT_EQUAL_UINT32(at, scope.ring.trigger_tick);
        TEST_ASSERT_EQUAL_UINT32(least((at + 2u) / 3u, plan.before), scope.ring.n_before);
        const int32_t *words = rows_by(most_bytes);
        const uint32_t behind = (uint32_t)words[2u * scope.ring.n_before];
        TEST_ASSERT_TRUE(behind >= at && behind < at + (plan.before > 0u ? 3u : 1u));
        for (uint32_t k = 0; k < scope.ring.n_rows; k++) {
            TEST_ASSERT_EQUAL_UINT32(scope.ring.first_tick + 3u * k, words[2u * k]);
        }
    }
}

/// A gap before the trigger costs the rows of before it; one after it ends the recording and is
/// counted.
static void test_a_gap_before_the_trigger_empties_the_ring(void)
{
    plan.before = 8;
    plan.rows = 16;
    begin(0);
    for (uint32_t i = 0; i < 20u; i++) {
        take_value(i, 0);
    }
    for (uint32_t i = 25; i < 29u; i++) {
        take_value(i, i >= 28u ? 1000 : 0);
    }
    TEST_ASSERT_EQUAL_INT(cam_scope_recording, scope.phase);
    TEST_ASSERT_EQUAL_UINT32(3, scope.ring.n_before);
    TEST_ASSERT_EQUAL_UINT32(25, scope.ring.first_tick);
    take_value(31, 0);
    TEST_ASSERT_EQUAL_INT(cam_scope_gap, scope.end);
    TEST_ASSERT_EQUAL_INT32(2, field(cam_scope_field_n_lost));
    TEST_ASSERT_EQUAL_INT32(4, field(cam_scope_field_n_rows));
    plan.before = 0;
    begin(40); // with nothing of what was before
    TEST_ASSERT_EQUAL_UINT32(0, scope.ring.n_before);
    TEST_ASSERT_EQUAL_UINT32(0, scope.ring.n_rows);
}

/// What is beyond the level when the ticks come again was not seen to reach it.
static void test_a_change_across_a_gap_is_no_trigger(void)
{
    begin(0);
    take_value(0, 0);
    take_value(5, 2000);
    TEST_ASSERT_EQUAL_INT(cam_scope_armed, scope.phase);
}

static void test_stop_before_the_trigger_keeps_the_rows_of_before_it(void)
{
    plan.before = 8;
    begin(0);
    for (uint32_t i = 0; i < 20u; i++) {
        take_value(i, 0);
    }
    cam_scope_stop(&scope);
    TEST_ASSERT_EQUAL_INT(cam_scope_stopped, scope.end);
    TEST_ASSERT_EQUAL_UINT32(8, scope.ring.n_rows);
    TEST_ASSERT_EQUAL_UINT32(8, scope.ring.n_before);
    TEST_ASSERT_EQUAL_UINT32(12, scope.ring.first_tick);
    TEST_ASSERT_EQUAL_UINT32(19, scope.ring.trigger_tick);
}

static void test_every_kind_watches_its_value(void)
{
    for (int32_t kind = cam_trigger_time; kind < (int32_t)cam_trigger_n; kind++) {
        setUp();
        static const int32_t levels[] = {0, 6, 1000, 500000000, cam_state_cutting, 0};
        plan.trigger.kind = (cam_trigger_kind_t)kind;
        plan.trigger.level = levels[kind];
        begin(100);
        for (uint32_t i = 0; i < 12u; i++) {
            cam_tick_record_t r = {.tick = 100u + i};
            r.in.actual_nm[hal_axis_u] = i < 6u ? 0 : 1000;
            r.angle.pos_q32 = (INT64_C(5) << 32) + (int64_t)i * 83333334;
            r.want.state = i < 6u ? cam_state_engaging : cam_state_cutting;
            r.want.faults = i < 6u ? 0u : 4u;
            cam_scope_take(&scope, &r);
        }
        TEST_ASSERT_EQUAL_UINT32(106, scope.ring.trigger_tick);
        TEST_ASSERT_EQUAL_UINT32(4, scope.ring.faults);
    }
}

static void test_a_recording_without_room_for_its_rows_is_refused(void)
{
    static const struct {
        uint32_t signals, before, rows, head;
        cam_err_t err;
    } cases[] = {{3, n_memory / 2u, 0, 0, cam_err_scope_before},
                 {3, 3, 3, 0, cam_err_scope_before},
                 {0, 0, 3, 0, cam_err_scope_memory},
                 {3, 0, 3, n_memory + 1, cam_err_scope_memory}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        plan.signals = cases[i].signals;
        plan.before = cases[i].before;
        plan.rows = cases[i].rows;
        TEST_ASSERT_EQUAL_INT(cases[i].err,
                              cam_scope_begin(&scope, &plan, cam_scope_user, cases[i].head, 0));
        TEST_ASSERT_EQUAL_INT(cam_scope_idle, scope.phase);
    }
}

/// Rows before the trigger are of one stay in the wanted state: those of an earlier stay are gone.
static void test_rows_of_an_earlier_stay_are_dropped(void)
{
    plan.from_state = (int32_t)cam_state_ready;
    plan.before = 4;
    plan.rows = 6;
    begin(0);
    take_value(0, 1);
    take_value(1, 2);
    take_in(2, cam_state_off);
    TEST_ASSERT_EQUAL_UINT32(0, scope.ring.n_rows);
    take_value(3, 4);
    take_value(4, 2000);
    take_value(5, 2001);
    TEST_ASSERT_EQUAL_INT32(1, field(cam_scope_field_n_before));
}

// What fires

static bool fires(cam_trigger_t t, int32_t last, int32_t now)
{
    return cam_trigger_fires(&t, (cam_trigger_last_t){.is_there = true, .value = last}, now);
}

static cam_trigger_t level(int32_t at, bool falls)
{
    return (cam_trigger_t){.kind = cam_trigger_level, .level = at, .falls = falls};
}

static cam_trigger_t angle(uint32_t at_q32, bool falls)
{
    return (cam_trigger_t){.kind = cam_trigger_angle, .level = (int32_t)at_q32, .falls = falls};
}

/// All steps between nine values about the level: exactly those that reach it fire.
static void test_level_fires_where_it_is_reached_and_not_beyond(void)
{
    static const int32_t levels[] = {0, 7, -7, INT32_MAX, INT32_MIN + 1};
    for (uint32_t i = 0; i < sizeof levels / sizeof levels[0]; i++) {
        for (int64_t a = -4; a <= 4; a++) {
            for (int64_t b = -4; b <= 4; b++) {
                const int64_t last = levels[i] + a;
                const int64_t now = levels[i] + b;
                if (last != (int32_t)last || now != (int32_t)now) {
                    continue;
                }
                TEST_ASSERT_EQUAL(a < 0 && b >= 0,
                                  fires(level(levels[i], false), (int32_t)last, (int32_t)now));
                TEST_ASSERT_EQUAL(a > 0 && b <= 0,
                                  fires(level(levels[i], true), (int32_t)last, (int32_t)now));
            }
        }
    }
}

/// Turns at steps that divide the turn and steps that do not, in both senses: one pass per turn, in
/// the first tick that is at the angle or behind it.
static void test_angle_fires_once_per_turn_in_its_sense_alone(void)
{
    static const uint32_t steps[] = {1u << 24, 16777259u, 715827883u, 2147483647u, 999999937u};
    static const uint32_t angles[] = {0u, 1u, 1u << 31, 3000000000u, UINT32_MAX};
    for (uint32_t i = 0; i < 25u; i++) {
        const uint32_t step = steps[i % 5u];
        const uint32_t at = angles[i / 5u];
        const uint32_t from = at - step / 3u;
        uint32_t n_up = 0;
        uint32_t n_down = 0;
        for (uint32_t k = 0; k < 1000u; k++) {
            const uint32_t last = from + k * step;
            const bool is_up = fires(angle(at, false), (int32_t)last, (int32_t)(last + step));
            TEST_ASSERT_EQUAL(at - last - 1u < step, is_up);
            n_up += is_up ? 1u : 0u;
            n_down += fires(angle(at, true), (int32_t)last, (int32_t)(last + step)) ? 1u : 0u;
            TEST_ASSERT_EQUAL(
                at - last - 1u < step,
                fires(angle(0u - at, true), (int32_t)(0u - last), (int32_t)(0u - last - step)));
        }
        const uint64_t way = (uint64_t)step * 1000u - step / 3u; // behind the first pass
        TEST_ASSERT_EQUAL_UINT32(1u + (uint32_t)(way >> 32), n_up);
        TEST_ASSERT_EQUAL_UINT32(0, n_down);
    }
}

/// Now and a time need no tick before; to all others a first tick is no change. A state fires from
/// whichever other one, a fault for a new bit of its mask, an angle in the tick that is just there.
static void test_changes_that_fire(void)
{
    enum { first = 99 }; ///< in place of a last value: there is none
    static const struct {
        cam_trigger_kind_t kind;
        int32_t level;
        bool falls;
        int32_t last, now;
        bool fires;
    } rows[] = {
        {cam_trigger_now, 0, false, first, 0, true},
        {cam_trigger_time, 100, false, first, 99, false},
        {cam_trigger_time, 100, false, first, 100, true},
        {cam_trigger_time, 100, false, first, 105, true},
        {cam_trigger_time, INT32_MAX, false, first, INT32_MIN, true},
        {cam_trigger_level, 1, false, first, 1, false},
        {cam_trigger_angle, 1, false, first, 1, false},
        {cam_trigger_angle, 77, false, 76, 77, true},
        {cam_trigger_angle, 77, false, 77, 78, false},
        {cam_trigger_angle, 77, true, 78, 77, true},
        {cam_trigger_angle, 77, true, 77, 76, false},
        {cam_trigger_state, 3, false, first, 3, false},
        {cam_trigger_state, 3, false, 2, 3, true},
        {cam_trigger_state, 3, false, 4, 3, true},
        {cam_trigger_state, 3, false, 3, 3, false},
        {cam_trigger_state, 3, false, 3, 2, false},
        {cam_trigger_state, 3, false, 1, 2, false},
        {cam_trigger_fault, 0, false, first, 1, false},
        {cam_trigger_fault, 0, false, 0, 1, true},
        {cam_trigger_fault, 0, false, 1, 3, true},
        {cam_trigger_fault, 0, false, 0, INT32_MIN, true},
        {cam_trigger_fault, 0, false, 3, 3, false},
        {cam_trigger_fault, 0, false, 3, 1, false},
        {cam_trigger_fault, 8, false, 1, 9, true},
        {cam_trigger_fault, 8, false, 8, 15, false},
        {cam_trigger_fault, 8, false, 0, 7, false},
    };
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const cam_trigger_t t = {
            .kind = rows[i].kind, .level = rows[i].level, .falls = rows[i].falls};
        const cam_trigger_last_t last = {.is_there = rows[i].last != first, .value = rows[i].last};
        TEST_ASSERT_EQUAL(rows[i].fires, cam_trigger_fires(&t, last, rows[i].now));
    }
}
