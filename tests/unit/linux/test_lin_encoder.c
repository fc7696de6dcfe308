// SPDX-License-Identifier: Apache-2.0
// The Linux port's encoder: unwrapping, the tick's instant, the index by its edge or its place.
#include "lin_bus.h"
#include "unity.h"

enum { us = 1000, ms = 1000000 };

static lin_encoder_t e;

static void begin(int64_t modulus, uint32_t index)
{
    const lin_encoder_config_t config = {.modulus_counts = modulus,
                                         .counts_per_turn = 1000,
                                         .index = index,
                                         .index_counts = 200,
                                         .max_age_us = 3000};
    lin_encoder_init(&e, &config, 1000);
}

void setUp(void)
{
    begin(0, lin_index_line);
}

static uint32_t at(int64_t ns)
{
    return lin_encoder_at(&e, ns).counts;
}

static void test_counts_are_brought_to_the_instant_by_the_last_two_frames(void)
{
    lin_encoder_receive(&e, 1000, 10 * ms);
    TEST_ASSERT_EQUAL_UINT32(1000, at(11 * ms)); // no speed yet
    lin_encoder_receive(&e, 1050, 11 * ms);
    TEST_ASSERT_EQUAL_UINT32(1075, at(11 * ms + 500 * us));
    TEST_ASSERT_EQUAL_UINT32(1050, at(11 * ms));
    TEST_ASSERT_EQUAL_UINT32(1025, at(10 * ms + 500 * us));
    lin_encoder_receive(&e, 1020, 12 * ms); // turns back
    TEST_ASSERT_EQUAL_UINT32(1005, at(12 * ms + 500 * us));
}

static void test_extrapolation_ends_at_the_greatest_age(void)
{
    lin_encoder_receive(&e, 0, 10 * ms);
    lin_encoder_receive(&e, 100, 11 * ms);
    TEST_ASSERT_TRUE(lin_encoder_is_fresh(&e, 14 * ms));
    TEST_ASSERT_FALSE(lin_encoder_is_fresh(&e, 14 * ms + 1));
    TEST_ASSERT_EQUAL_UINT32(400, at(14 * ms));
    TEST_ASSERT_EQUAL_UINT32(400, at(99 * ms));
    begin(0, lin_index_line);
    TEST_ASSERT_FALSE(lin_encoder_is_fresh(&e, 0)); // nothing heard is not fresh
}

static void test_greatest_age_is_three_ticks_unless_given(void)
{
    const lin_encoder_config_t config = {.counts_per_turn = 1000};
    lin_encoder_init(&e, &config, 500);
    lin_encoder_receive(&e, 0, 10 * ms);
    TEST_ASSERT_TRUE(lin_encoder_is_fresh(&e, 16 * ms));
    TEST_ASSERT_FALSE(lin_encoder_is_fresh(&e, 16 * ms + 1));
}

static void test_delay_of_the_frame_is_taken_off(void)
{
    e.config.delay_ns = 100 * us;
    lin_encoder_receive(&e, 0, 10 * ms);
    lin_encoder_receive(&e, 100, 11 * ms);
    TEST_ASSERT_EQUAL_UINT32(110, at(11 * ms));
}

/// A frame that waited in a queue arrives close behind its neighbour: no speed is measured by it.
static void test_frames_close_together_show_no_speed(void)
{
    lin_encoder_receive(&e, 0, 10 * ms);
    lin_encoder_receive(&e, 100, 12 * ms);
    lin_encoder_receive(&e, 150, 12 * ms + 100 * us);
    TEST_ASSERT_EQUAL_UINT32(150, at(12 * ms + 100 * us));
    TEST_ASSERT_EQUAL_UINT32(221, at(13 * ms + 100 * us)); // 150 counts in 2.1 ms
}

/// An encoder with a clock of its own sends five frames a tick: the speed is still a new one.
static void test_speed_of_frames_that_come_often_is_that_of_now(void)
{
    uint32_t counts = 0;
    int64_t ns = 10 * ms;
    for (uint32_t i = 0; i < 500u; i++, ns += 200 * us) {
        lin_encoder_receive(&e, counts, ns);
        counts += i / 50u; // ever faster
        if (i % 50u > 3u) {
            TEST_ASSERT_EQUAL_UINT32(counts, at(ns + 200 * us));
        }
    }
}

static void test_position_unwraps_at_its_modulus(void)
{
    begin(4000, lin_index_line);
    lin_encoder_receive(&e, 3990, 10 * ms);
    lin_encoder_receive(&e, 10, 11 * ms);
    TEST_ASSERT_EQUAL_UINT32(4010, at(11 * ms));
    lin_encoder_receive(&e, 3980, 12 * ms);
    TEST_ASSERT_EQUAL_UINT32(3980, at(12 * ms));
    begin(0, lin_index_line);
    lin_encoder_receive(&e, UINT32_MAX - 9u, 10 * ms);
    lin_encoder_receive(&e, 40, 11 * ms);
    TEST_ASSERT_EQUAL_UINT32(40, at(11 * ms)); // 32 bits of a 64-bit counter
    TEST_ASSERT_EQUAL_UINT32(65, at(11 * ms + 500 * us));
    lin_encoder_receive(&e, UINT32_MAX - 9u, 12 * ms);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX - 9u, at(12 * ms));
}

static void test_edge_is_brought_to_counts_between_its_frames(void)
{
    lin_encoder_receive(&e, 1000, 10 * ms);
    lin_encoder_receive(&e, 1050, 11 * ms);
    lin_encoder_edge(&e, 11 * ms + 400 * us, true);
    TEST_ASSERT_EQUAL_UINT32(0, lin_encoder_at(&e, 11 * ms + 500 * us).n_index); // not yet known
    lin_encoder_receive(&e, 1110, 12 * ms);
    const hal_encoder_t now = lin_encoder_at(&e, 12 * ms);
    TEST_ASSERT_EQUAL_UINT32(1, now.n_index);
    TEST_ASSERT_EQUAL_UINT32(1074, now.index_counts); // 1050 + 0.4 * 60
    lin_encoder_edge(&e, 11 * ms + 900 * us, true);   // reported late: between frames that arrived
    TEST_ASSERT_EQUAL_UINT32(2, lin_encoder_at(&e, 12 * ms).n_index);
    TEST_ASSERT_EQUAL_UINT32(1104, lin_encoder_at(&e, 12 * ms).index_counts);
}

/// The pulse lies between 500 and 520: its lower edge counts in both senses.
static void test_edge_is_the_same_for_both_senses(void)
{
    lin_encoder_receive(&e, 400, 10 * ms);
    lin_encoder_receive(&e, 480, 11 * ms);
    lin_encoder_edge(&e, 11 * ms + 250 * us, true);
    lin_encoder_edge(&e, 11 * ms + 500 * us, false);
    lin_encoder_receive(&e, 560, 12 * ms);
    TEST_ASSERT_EQUAL_UINT32(1, lin_encoder_at(&e, 12 * ms).n_index);
    TEST_ASSERT_EQUAL_UINT32(500, lin_encoder_at(&e, 12 * ms).index_counts);
    lin_encoder_receive(&e, 540, 13 * ms);
    lin_encoder_edge(&e, 13 * ms + 250 * us, true);  // at 520
    lin_encoder_edge(&e, 13 * ms + 500 * us, false); // at 500
    lin_encoder_receive(&e, 460, 14 * ms);
    TEST_ASSERT_EQUAL_UINT32(2, lin_encoder_at(&e, 14 * ms).n_index);
    TEST_ASSERT_EQUAL_UINT32(500, lin_encoder_at(&e, 14 * ms).index_counts);
}

static void test_edges_without_a_frame_or_with_a_place_are_ignored(void)
{
    lin_encoder_edge(&e, 10 * ms, true);
    TEST_ASSERT_EQUAL_UINT32(0, lin_encoder_at(&e, 10 * ms).n_index);
    begin(0, lin_index_position);
    lin_encoder_receive(&e, 10, 10 * ms);
    lin_encoder_edge(&e, 10 * ms, true);
    TEST_ASSERT_EQUAL_UINT32(0, lin_encoder_at(&e, 10 * ms).n_index);
}

static void test_place_of_the_position_is_an_index_for_both_senses(void)
{
    static const struct {
        uint32_t raw, n_index, index_counts;
    } steps[] = {{150, 0, 0},     {199, 0, 0},     {200, 1, 200}, {1199, 1, 200}, {1201, 2, 1200},
                 {1200, 2, 1200}, {1199, 3, 1200}, {150, 4, 200}, {1250, 6, 1200}};
    begin(2000, lin_index_position);
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        e.config.modulus_counts = 0; // so that long increments are not wrapped
        lin_encoder_receive(&e, steps[i].raw, (10 + (int64_t)i) * ms);
        const hal_encoder_t now = lin_encoder_at(&e, (10 + (int64_t)i) * ms);
        TEST_ASSERT_EQUAL_UINT32(steps[i].n_index, now.n_index);
        TEST_ASSERT_EQUAL_UINT32(steps[i].index_counts, now.index_counts);
    }
}

static void test_place_of_a_wrapping_position_is_the_same_modulo_a_turn(void)
{
    begin(1000, lin_index_position);
    uint32_t n = 0;
    for (int64_t i = 0; i < 500; i++) {
        lin_encoder_receive(&e, (uint32_t)(i * 37 % 1000), i * ms);
        const hal_encoder_t now = lin_encoder_at(&e, i * ms);
        if (now.n_index != n) {
            n = now.n_index;
            TEST_ASSERT_EQUAL_UINT32(200, now.index_counts % 1000u);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(499 * 37 / 1000 + 1, n);
}
