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

static void expect_index(uint32_t n, uint32_t counts, int64_t ns)
{
    const hal_encoder_t now = lin_encoder_at(&e, ns);
    TEST_ASSERT_EQUAL_UINT32(n, now.n_index);
    TEST_ASSERT_EQUAL_UINT32(counts, now.index_counts);
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
    e.config.delay_ns = 100 * us; // of the frame, taken off
    lin_encoder_receive(&e, 1110, 13 * ms);
    TEST_ASSERT_EQUAL_UINT32(1120, at(13 * ms));
}

static void expect_fresh_until(int64_t ns)
{
    TEST_ASSERT_TRUE(lin_encoder_is_fresh(&e, ns));
    TEST_ASSERT_FALSE(lin_encoder_is_fresh(&e, ns + 1));
}

/// The greatest age is three ticks unless it is given.
static void test_extrapolation_ends_at_the_greatest_age(void)
{
    TEST_ASSERT_FALSE(lin_encoder_is_fresh(&e, 0)); // nothing heard is not fresh
    lin_encoder_receive(&e, 0, 10 * ms);
    lin_encoder_receive(&e, 100, 11 * ms);
    expect_fresh_until(14 * ms);
    TEST_ASSERT_EQUAL_UINT32(400, at(14 * ms));
    TEST_ASSERT_EQUAL_UINT32(400, at(99 * ms));
    lin_encoder_init(&e, &(lin_encoder_config_t){.counts_per_turn = 1000}, 500);
    lin_encoder_receive(&e, 0, 10 * ms);
    expect_fresh_until(16 * ms);
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
    lin_encoder_edge(&e, 10 * ms, true); // no frame was received: ignored
    lin_encoder_receive(&e, 1000, 10 * ms);
    lin_encoder_receive(&e, 1050, 11 * ms);
    lin_encoder_edge(&e, 11 * ms + 400 * us, true);
    expect_index(0, 0, 11 * ms + 500 * us); // not yet known
    lin_encoder_receive(&e, 1110, 12 * ms);
    expect_index(1, 1074, 12 * ms);                 // 1050 + 0.4 * 60
    lin_encoder_edge(&e, 11 * ms + 900 * us, true); // reported late: between frames that arrived
    expect_index(2, 1104, 12 * ms);
}

/// The pulse lies between 500 and 520: its lower edge counts in both senses.
static void test_edge_is_the_same_for_both_senses(void)
{
    lin_encoder_receive(&e, 400, 10 * ms);
    lin_encoder_receive(&e, 480, 11 * ms);
    lin_encoder_edge(&e, 11 * ms + 250 * us, true);
    lin_encoder_edge(&e, 11 * ms + 500 * us, false);
    lin_encoder_receive(&e, 560, 12 * ms);
    expect_index(1, 500, 12 * ms);
    lin_encoder_receive(&e, 540, 13 * ms);
    lin_encoder_edge(&e, 13 * ms + 250 * us, true);  // at 520
    lin_encoder_edge(&e, 13 * ms + 500 * us, false); // at 500
    lin_encoder_receive(&e, 460, 14 * ms);
    expect_index(2, 500, 14 * ms);
}

static void test_place_of_the_position_is_an_index_for_both_senses(void)
{
    static const uint32_t steps[][3] = {// raw, index edges, counts of the last
                                        {150, 0, 0},     {199, 0, 0},     {200, 1, 200},
                                        {1199, 1, 200},  {1201, 2, 1200}, {1200, 2, 1200},
                                        {1199, 3, 1200}, {150, 4, 200},   {1250, 6, 1200}};
    begin(0, lin_index_position);
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        lin_encoder_receive(&e, steps[i][0], (10 + (int64_t)i) * ms);
        lin_encoder_edge(&e, (10 + (int64_t)i) * ms, true); // of no interest
        expect_index(steps[i][1], steps[i][2], (10 + (int64_t)i) * ms);
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
