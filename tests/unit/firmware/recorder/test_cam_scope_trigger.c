// SPDX-License-Identifier: Apache-2.0
// Rows before and behind a trigger, wherever it falls in the ring, and every way to read them.
#include "cam_scope.h"
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

static void take(uint32_t tick, int32_t watched)
{
    cam_tick_record_t r = {.tick = tick};
    r.want.state = cam_state_ready;
    r.in.actual_nm[hal_axis_u] = watched;
    cam_scope_take(&scope, &r);
}

static void begin(uint32_t tick)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_begin(&scope, &plan, cam_scope_user, 0, tick));
}

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
        take(first + i, i < at ? 999 - (int32_t)i : 1000 + (int32_t)i);
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

/// Rows of every third tick: the trigger is found in the ticks between them as well.
static void test_rows_far_apart_tell_the_tick_of_the_trigger(void)
{
    for (uint32_t at = 1; at < 60u; at++) {
        setUp();
        plan.every = 3;
        plan.before = 4;
        plan.rows = 9;
        begin(0);
        for (uint32_t i = 0; i < 120u; i++) {
            take(i, i == at ? 1000 : 0); // for one tick only
        }
        TEST_ASSERT_EQUAL_INT(cam_scope_full, scope.end);
        TEST_ASSERT_EQUAL_UINT32(at, scope.ring.trigger_tick);
        TEST_ASSERT_EQUAL_UINT32(least((at + 2u) / 3u, 4), scope.ring.n_before);
        const int32_t *words = rows_by(most_bytes);
        const uint32_t behind = (uint32_t)words[2u * scope.ring.n_before];
        TEST_ASSERT_TRUE(behind >= at && behind < at + 3u);
        for (uint32_t k = 0; k < scope.ring.n_rows; k++) {
            TEST_ASSERT_EQUAL_UINT32(scope.ring.first_tick + 3u * k, words[2u * k]);
        }
    }
}

static void test_without_rows_before_it_the_first_row_is_that_of_the_trigger(void)
{
    plan.every = 7;
    begin(0);
    for (uint32_t i = 0; i < 300u; i++) {
        take(i, i >= 17u ? 1000 : 0);
    }
    TEST_ASSERT_EQUAL_UINT32(17, scope.ring.first_tick);
    TEST_ASSERT_EQUAL_INT32(24, rows_by(most_bytes)[2]);
}

/// A gap before the trigger costs the rows of before it; one behind it ends the recording.
static void test_a_gap_before_the_trigger_empties_the_ring(void)
{
    plan.before = 8;
    plan.rows = 16;
    begin(0);
    for (uint32_t i = 0; i < 20u; i++) {
        take(i, 0);
    }
    for (uint32_t i = 25; i < 29u; i++) {
        take(i, i >= 28u ? 1000 : 0);
    }
    TEST_ASSERT_EQUAL_INT(cam_scope_recording, scope.phase);
    TEST_ASSERT_EQUAL_UINT32(3, scope.ring.n_before);
    TEST_ASSERT_EQUAL_UINT32(25, scope.ring.first_tick);
    take(31, 0);
    TEST_ASSERT_EQUAL_INT(cam_scope_gap, scope.end);
    TEST_ASSERT_EQUAL_UINT32(2, scope.ring.n_lost);
    plan.before = 0;
    begin(40); // with nothing of what was before
    TEST_ASSERT_EQUAL_UINT32(0, scope.ring.n_before);
    TEST_ASSERT_EQUAL_UINT32(0, scope.ring.n_rows);
}

/// What is beyond the level when the ticks come again was not seen to reach it.
static void test_a_change_across_a_gap_is_no_trigger(void)
{
    begin(0);
    take(0, 0);
    take(5, 2000);
    TEST_ASSERT_EQUAL_INT(cam_scope_armed, scope.phase);
}

static void test_stop_before_the_trigger_keeps_the_rows_of_before_it(void)
{
    plan.before = 8;
    begin(0);
    for (uint32_t i = 0; i < 20u; i++) {
        take(i, 0);
    }
    cam_scope_stop(&scope);
    TEST_ASSERT_EQUAL_INT(cam_scope_stopped, scope.end);
    TEST_ASSERT_EQUAL_UINT32(8, scope.ring.n_rows);
    TEST_ASSERT_EQUAL_UINT32(8, scope.ring.n_before);
    TEST_ASSERT_EQUAL_UINT32(12, scope.ring.first_tick);
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

static void test_a_recording_without_room_behind_the_trigger_is_refused(void)
{
    plan.before = n_memory / 2u;
    TEST_ASSERT_EQUAL_INT(cam_err_scope_before,
                          cam_scope_begin(&scope, &plan, cam_scope_user, 0, 0));
    plan.before = 3;
    plan.rows = 3;
    TEST_ASSERT_EQUAL_INT(cam_err_scope_before,
                          cam_scope_begin(&scope, &plan, cam_scope_user, 0, 0));
    TEST_ASSERT_EQUAL_INT(cam_scope_idle, scope.phase);
    plan.before = 0;
    plan.signals = 0;
    TEST_ASSERT_EQUAL_INT(cam_err_scope_memory,
                          cam_scope_begin(&scope, &plan, cam_scope_user, 0, 0));
}

static void test_fields_set_the_trigger(void)
{
    static const struct {
        uint32_t field;
        int32_t value;
        cam_err_t err;
    } cases[] = {
        {cam_scope_field_before, 7, cam_ok},
        {cam_scope_field_before, -1, cam_err_scope_range},
        {cam_scope_field_trigger, cam_trigger_fault, cam_ok},
        {cam_scope_field_trigger, cam_trigger_n, cam_err_scope_range},
        {cam_scope_field_trigger, -1, cam_err_scope_range},
        {cam_scope_field_watched, cam_scope_n_signals - 1, cam_ok},
        {cam_scope_field_watched, cam_scope_n_signals, cam_err_scope_range},
        {cam_scope_field_watched, -1, cam_err_scope_range},
        {cam_scope_field_level, INT32_MIN, cam_ok},
        {cam_scope_field_edge, 1, cam_ok},
        {cam_scope_field_edge, 2, cam_err_scope_range},
        {cam_scope_field_use, 1, cam_err_scope_field},
        {cam_scope_field_place_nm, 1, cam_err_scope_field},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        int32_t value = 0;
        TEST_ASSERT_EQUAL_INT(cases[i].err, cam_scope_set(&scope, cases[i].field, cases[i].value));
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_get(&scope, cases[i].field, &value));
        if (cases[i].err == cam_ok) {
            TEST_ASSERT_EQUAL_INT32(cases[i].value, value);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(7, scope.set.before);
    TEST_ASSERT_TRUE(scope.set.trigger.falls);
}

/// Rows before the trigger are of one stay in the wanted state: those of an earlier stay are gone.
static void test_rows_of_an_earlier_stay_are_dropped(void)
{
    plan.from_state = (int32_t)cam_state_ready;
    plan.before = 4;
    plan.rows = 6;
    begin(0);
    take(0, 1);
    take(1, 2);
    cam_tick_record_t elsewhere = {.tick = 2};
    elsewhere.want.state = cam_state_off;
    cam_scope_take(&scope, &elsewhere);
    TEST_ASSERT_EQUAL_UINT32(0, scope.ring.n_rows);
    take(3, 4);
    take(4, 2000);
    take(5, 2001);
    int32_t n_before = -1;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_get(&scope, cam_scope_field_n_before, &n_before));
    TEST_ASSERT_EQUAL_INT32(1, n_before);
}
