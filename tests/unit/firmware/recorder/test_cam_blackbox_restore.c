// SPDX-License-Identifier: Apache-2.0
// The black box after a restart: the contents of the head before its rows, word by word.
#include "cam_recorder.h"
#include "hal_host.h"
#include "unity.h"
#include <string.h> // memcpy

enum { n_head = 14, n_signals = 9, most_rows = 20, tick_hz = 1000 };
enum { n_kept = n_head + most_rows * n_signals, n_words = 2 * n_kept };

/// Words of a head.
enum {
    at_layout,
    at_signals,
    at_hz,
    at_every,
    at_before,
    at_most,
    at_oldest,
    at_rows,
    at_n_before
};

/// Another size than a box of this memory would have: while it was made, a wave had its share.
static const uint32_t good[n_head] = {
    0x31584243, CAM_BLACKBOX_SIGNALS, tick_hz, 3, 7, most_rows, 5, 18, 6, 1111, 2222, 3333,
    44,         cam_scope_full};

static int32_t words[n_words];
static cam_scope_t scope;

void setUp(void)
{
    for (int32_t i = 0; i < n_words; i++) {
        words[i] = 1000000 + i;
    }
    memcpy(words, good, sizeof good);
    cam_scope_init(&scope, (hal_memory_t){.words = words, .n_words = n_words}, tick_hz);
}

/// It is written as it was read.
static void test_the_head_of_a_box_outlives_a_restart(void)
{
    TEST_ASSERT_TRUE(cam_blackbox_restore(&scope, n_kept));
    TEST_ASSERT_TRUE(cam_blackbox_is_unread(&scope));
    TEST_ASSERT_EQUAL_HEX32(CAM_BLACKBOX_SIGNALS, scope.plan.signals);
    const uint32_t found[] = {scope.plan.every,      scope.plan.before,       scope.ring.most_rows,
                              scope.ring.oldest,     scope.ring.n_rows,       scope.ring.n_before,
                              scope.ring.first_tick, scope.ring.trigger_tick, scope.ring.faults,
                              scope.ring.n_lost,     (uint32_t)scope.end};
    TEST_ASSERT_EQUAL_UINT32_ARRAY(&good[at_every], found, sizeof found / sizeof found[0]);
    TEST_ASSERT_EQUAL_UINT32(n_signals, scope.n_signals);
    TEST_ASSERT_EQUAL_UINT32(n_head, scope.at);
    memset(words, 0, sizeof good);
    cam_blackbox_keep(&scope);
    TEST_ASSERT_EQUAL_UINT32_ARRAY(good, words, n_head);
    TEST_ASSERT_EQUAL_UINT32(n_kept, hal_host.slow.n_kept);
}

/// The rows begin with the oldest, and the first one of the memory follows the last.
static void test_rows_are_found_where_they_were(void)
{
    TEST_ASSERT_TRUE(cam_blackbox_restore(&scope, n_kept));
    for (uint32_t row = 0; row < good[at_rows]; row++) {
        const cam_scope_span_t span = cam_scope_span(&scope, row * n_signals * 4u, 4);
        TEST_ASSERT_EQUAL_UINT32(4, span.n);
        const uint32_t place = n_head + (good[at_oldest] + row) % most_rows * n_signals;
        TEST_ASSERT_EQUAL_PTR(&words[place], span.bytes);
    }
}

/// @return whether a head with one word changed is believed
static bool is_believed(uint32_t at, uint32_t value)
{
    setUp();
    words[at] = (int32_t)value;
    return cam_blackbox_restore(&scope, n_kept);
}

static void test_each_word_of_a_head_is_limited(void)
{
    static const struct {
        uint32_t at, good, bad;
    } limits[] = {
        {at_layout, 0x31584243, 0x31584244},
        {at_layout, 0x31584243, 0x31584242},
        {at_signals, CAM_BLACKBOX_SIGNALS, CAM_BLACKBOX_SIGNALS + 1u},
        {at_signals, CAM_BLACKBOX_SIGNALS, CAM_BLACKBOX_SIGNALS - 1u},
        {at_hz, tick_hz, tick_hz + 1},
        {at_hz, tick_hz, tick_hz - 1},
        {at_every, 1, 0},
        {at_most, most_rows, most_rows + 1},
        {at_most, most_rows, most_rows - 1},
        {at_oldest, most_rows - 1, most_rows},
        {at_rows, most_rows, most_rows + 1},
        {at_n_before, 18, 19},
        {n_head - 1, cam_scope_gap, cam_scope_gap + 1},
    };
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        TEST_ASSERT_TRUE(is_believed(limits[i].at, limits[i].good));
        TEST_ASSERT_FALSE(is_believed(limits[i].at, limits[i].bad));
        TEST_ASSERT_NOT_EQUAL_INT(cam_scope_done, scope.phase);
    }
}

/// Whatever a head may hold, the box is sound or it is not taken, and no word is out of reach.
static void test_any_head_is_sound_or_refused(void)
{
    static const uint32_t values[] = {UINT32_MAX, 0x80000000u, 0x7FFFFFFFu, 1000000};
    for (uint32_t i = 0; i < n_head * 4u; i++) {
        const bool is_taken = is_believed(i / 4u, values[i % 4u]);
        for (uint32_t at = 0; is_taken && at < scope.ring.n_rows * n_signals; at++) {
            TEST_ASSERT_EQUAL_UINT32(4, cam_scope_span(&scope, at * 4u, 4).n);
        }
    }
}

static void test_as_many_words_as_the_rows_need_are_in_the_memory(void)
{
    static const uint32_t wrong[] = {0, 1, 13, n_head, n_kept - 1, n_kept + n_signals, UINT32_MAX};
    for (uint32_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        TEST_ASSERT_FALSE(cam_blackbox_restore(&scope, wrong[i]));
    }
    TEST_ASSERT_TRUE(cam_blackbox_restore(&scope, n_kept + n_signals - 1));
    cam_scope_init(&scope, (hal_memory_t){.words = words, .n_words = n_kept}, tick_hz);
    TEST_ASSERT_TRUE(cam_blackbox_restore(&scope, n_kept));
    cam_scope_init(&scope, (hal_memory_t){.words = words, .n_words = n_kept - 1}, tick_hz);
    TEST_ASSERT_FALSE(cam_blackbox_restore(&scope, n_kept));
}
