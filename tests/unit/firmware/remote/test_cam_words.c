// SPDX-License-Identifier: Apache-2.0
// Names and texts of states, faults, errors and parameters; parameters and their ranges; the trace
// ring.
#include "cam_err.h"
#include "cam_tick_inner.h" // cam_trace_capacity, cam_trace_newest, cam_trace_begin_isr
#include "cam_param.h"
#include "cam_recorder.h"
#include "cam_state.h"
#include "cam_table.h"        // cam_crc32
#include "cam_remote_inner.h" // cam_table_store_word
#include "unity.h"
#include <stdio.h> // snprintf
#include <string.h>

static void test_names_are_there_and_differ(void)
{
    for (int i = 0; i < cam_n_states; i++) {
        const char *name = cam_state_name((cam_state_t)i);
        TEST_ASSERT_GREATER_THAN(1, strlen(name));
        for (int k = 0; k < i; k++) {
            TEST_ASSERT_NOT_EQUAL_INT(0, strcmp(name, cam_state_name((cam_state_t)k)));
        }
    }
    for (int i = 0; i < cam_n_faults; i++) {
        TEST_ASSERT_GREATER_THAN(2, strlen(cam_fault_name((cam_fault_t)i)));
        TEST_ASSERT_GREATER_THAN(9, strlen(cam_fault_text((cam_fault_t)i)));
    }
    TEST_ASSERT_EQUAL_STRING("lost_counts", cam_fault_name(cam_fault_lost_counts));
}

/// A number may be any that its word holds, wherever it comes from.
static void test_numbers_beyond_a_list_stand_for_nothing(void)
{
    static const int beyond[] = {0, 1, 2, 30, 100};
    for (size_t i = 0; i < sizeof beyond / sizeof beyond[0]; i++) {
        const int by = beyond[i];
        TEST_ASSERT_EQUAL_STRING("?", cam_state_name((cam_state_t)(cam_n_states + by)));
        TEST_ASSERT_EQUAL_HEX32(0, cam_guard_armed((cam_state_t)(cam_n_states + by)));
        TEST_ASSERT_EQUAL_STRING("?", cam_fault_name((cam_fault_t)(cam_n_faults + by)));
        TEST_ASSERT_EQUAL_STRING("?", cam_fault_text((cam_fault_t)(cam_n_faults + by)));
        TEST_ASSERT_EQUAL_STRING("?", cam_scope_signal_name(cam_scope_n_signals + (uint32_t)by));
        TEST_ASSERT_NULL(cam_param_info((cam_param_id_t)(cam_n_params + by)));
        TEST_ASSERT_FALSE(cam_param_has((cam_param_id_t)(cam_n_params + by), (cam_flag_t)255));
    }
    TEST_ASSERT_EQUAL_STRING("?", cam_fault_text((cam_fault_t)-1));
    TEST_ASSERT_EQUAL_STRING("?", cam_scope_signal_name(UINT32_MAX));
    TEST_ASSERT_NULL(cam_param_info((cam_param_id_t)-1));
    cam_params_t params = cam_param_defaults();
    TEST_ASSERT_EQUAL_INT(cam_n_params, cam_param_find("k3_ns"));
    TEST_ASSERT_EQUAL_INT(cam_err_param_id, cam_param_set(&params, cam_n_params, 0));
}

static void test_err_text_knows_every_error(void)
{
    const size_t n_around = strlen("table:  - home refused until a table is written");
    const char *texts[200];
    int n_known = 0;
    uint32_t crc = 0;
    for (int err = 0; err >= -150; err--) {
        const char *text = cam_err_text((cam_err_t)err);
        if (strcmp(text, "unknown error") != 0) {
            TEST_ASSERT_GREATER_THAN_size_t(err == 0 ? 3u : 9u, strlen(text));
            TEST_ASSERT_TRUE(err <= -20 || strlen(text) + n_around <= 120u); // a line about a table
            for (int i = 0; i < n_known; i++) {
                TEST_ASSERT_NOT_EQUAL_INT(0, strcmp(text, texts[i]));
            }
            texts[n_known++] = text;
            crc = cam_crc32(crc, &(int8_t){(int8_t)err}, 1);
        }
    }
    TEST_ASSERT_EQUAL_INT(98, n_known);
    TEST_ASSERT_EQUAL_HEX32(0x7098CEBD, crc); // tools and records know errors by their numbers
    TEST_ASSERT_EQUAL_STRING("done", cam_err_text(cam_ok));
    TEST_ASSERT_EQUAL_STRING("unknown error", cam_err_text((cam_err_t)5));
}

#define WHAT(name, min, def, max, flags, what) what,
static const char *const whats[cam_n_params] = {CAM_PARAMS(WHAT)};

/// Names, ranges, defaults and flags are those of kept parameters, tools and manuals: a change is
/// made to the sum here as well.
static void test_param_set_takes_its_range_and_nothing_else(void)
{
    uint32_t crc = 0;
    for (int i = 0; i < cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        const cam_param_info_t *info = cam_param_info(id);
        cam_params_t params = cam_param_defaults();
        TEST_ASSERT_EQUAL_INT32(info->def, cam_param_get(&params, id));
        TEST_ASSERT_EQUAL_INT(id, cam_param_find(info->name));
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&params, id, info->min));
        TEST_ASSERT_EQUAL_INT32(info->min, cam_param_get(&params, id));
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&params, id, info->max));
        TEST_ASSERT_EQUAL_INT(cam_err_param_range, cam_param_set(&params, id, info->max + 1));
        TEST_ASSERT_EQUAL_INT(cam_err_param_range, cam_param_set(&params, id, info->min - 1));
        TEST_ASSERT_EQUAL_INT32(info->max, cam_param_get(&params, id));
        TEST_ASSERT_GREATER_THAN(9, strlen(whats[id]));
        char line[120];
        const int n = snprintf(line, sizeof line, "%s %d %d %d %d\n", info->name, (int)info->min,
                               (int)info->def, (int)info->max, (int)info->flags);
        crc = cam_crc32(crc, line, (uint32_t)n);
    }
    TEST_ASSERT_EQUAL_HEX32(0x27D0F240, crc);
}

#define SIGNAL(name, value, what) #name " "
#define FIELD(name, is_set, value, what) #name " " #is_set " "

/// The numbers of signals and fields are part of the CAN protocol: new ones come last, and the sums
/// here change with them.
static void test_signals_and_fields_of_the_recorder_are_those_that_are_known(void)
{
    static const char signals[] = CAM_SCOPE_SIGNALS(SIGNAL);
    static const char fields[] = CAM_SCOPE_FIELDS(FIELD);
    TEST_ASSERT_EQUAL_HEX32(0xD1980BEE, cam_crc32(0, signals, sizeof signals));
    TEST_ASSERT_EQUAL_HEX32(0xDBD32318, cam_crc32(0, fields, sizeof fields));
    TEST_ASSERT_EQUAL_STRING("u_force_q6", cam_scope_signal_name(cam_scope_n_signals - 1));
}

/// Learning sets what it needs and leaves all else; what is out of its range is brought back.
static void test_params_of_learning_and_their_fit(void)
{
    cam_params_t due = cam_param_defaults();
    cam_params_t params = due;
    due.feed_ramp_turns = 60;
    due.observer_bandwidth_mHz = 100000;
    due.rehearse_turns = 40;
    due.learn_harmonics = 16;
    due.ripple_turns = 8;
    cam_param_learn(&params, true);
    TEST_ASSERT_EQUAL_MEMORY(&due, &params, sizeof params);
    params.engage_turns = -7;
    params.feed_ramp_turns = 1000;
    cam_param_fit(&params);
    TEST_ASSERT_EQUAL_INT32(1, params.engage_turns);
    TEST_ASSERT_EQUAL_INT32(100, params.feed_ramp_turns);
}

static cam_trace_t trace;

/// Write the records of ticks, from the number of the next one on.
static void push(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        cam_trace_commit_isr(&trace, cam_trace_begin_isr(&trace));
    }
}

/// Take records up to the newest one. @return how many
static uint32_t pop_from(uint32_t tick)
{
    cam_tick_record_t record;
    uint32_t n = 0;
    while (cam_trace_pop(&trace, &record)) {
        TEST_ASSERT_EQUAL_UINT32(tick + n, record.tick);
        n++;
    }
    return n;
}

/// Close below the wrap of the numbers: a reader in time gets every record, a late one the newest.
/// The tick in progress overwrites the oldest record, which is not given.
static void test_trace_keeps_order_and_counts_what_was_missed(void)
{
    const uint32_t first = UINT32_MAX - 255u; // a whole number of rings below the wrap
    memset(&trace, 0, sizeof trace);
    trace.n_written = trace.n_begun = trace.n_read = first;
    TEST_ASSERT_EQUAL_UINT32(0, pop_from(first));
    push(100);
    TEST_ASSERT_EQUAL_UINT32(first + 99u, cam_trace_newest(&trace)->tick);
    TEST_ASSERT_EQUAL_UINT32(100, pop_from(first));
    push(cam_trace_capacity - 1);
    TEST_ASSERT_EQUAL_UINT32(cam_trace_capacity - 1, pop_from(first + 100u));
    TEST_ASSERT_EQUAL_UINT32(0, trace.n_missed);
    push(cam_trace_capacity + 10);
    const uint32_t oldest = first + 100u + cam_trace_capacity - 1u + 11u;
    TEST_ASSERT_EQUAL_UINT32(cam_trace_capacity - 1, pop_from(oldest));
    TEST_ASSERT_EQUAL_UINT32(11, trace.n_missed);
    memset(&trace, 0, sizeof trace);
    push(cam_trace_capacity);
    cam_tick_record_t *record = cam_trace_begin_isr(&trace);
    TEST_ASSERT_EQUAL_PTR(&trace.ring[0], record);
    TEST_ASSERT_EQUAL_UINT32(cam_trace_capacity - 1, pop_from(1));
    cam_trace_commit_isr(&trace, record);
    TEST_ASSERT_EQUAL_UINT32(1, pop_from(cam_trace_capacity));
}

/// The lowest byte comes first, and all four count.
static void test_offset_of_a_block_has_four_bytes(void)
{
    static const uint8_t bytes[] = {0x01, 0x23, 0x45, 0x89};
    TEST_ASSERT_EQUAL_HEX32(0x89452301, cam_table_store_word(bytes));
}
