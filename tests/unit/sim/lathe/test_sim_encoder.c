// SPDX-License-Identifier: Apache-2.0
#include "sim_encoder.h"
#include "sim_config.h"
#include "unity.h"
#include <math.h> // sqrt

static sim_encoder_config_t config;
static sim_encoder_t encoder;

void setUp(void)
{
    config = sim_config_defaults().lathe.encoder;
}

static void init_at(double turn)
{
    sim_encoder_init(&encoder, &config, turn, 1);
}

/// Turn to an angle in steps of a tick at high speed.
static hal_encoder_t go(double from, double to)
{
    const int n = 1 + (int)(fabs(to - from) / 0.003);
    hal_encoder_t reading = encoder.reading;
    for (int i = 1; i <= n; i++) {
        reading = sim_encoder_read(&encoder, from + (to - from) * i / n);
    }
    return reading;
}

static void test_read_counts_follow_the_turn_and_wrap(void)
{
    init_at(0.0);
    TEST_ASSERT_EQUAL_UINT32(4294467296u, encoder.reading.counts);
    TEST_ASSERT_EQUAL_UINT32(4294467296u + 2500u, go(0.0, 0.25).counts);
    TEST_ASSERT_EQUAL_UINT32(1000u, go(0.25, 50.1).counts); // beyond 2^32
    config.sign = -1.0;
    config.start_counts = 100.0;
    init_at(0.0);
    TEST_ASSERT_EQUAL_UINT32(100u - 2500u, go(0.0, 0.25).counts);
}

/// The edge at 0.3 has the same number in both senses; the next ones are a turn apart.
static void test_index_is_the_same_edge_for_both_senses(void)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        config.sign = sign;
        init_at(0.0);
        const uint32_t edge = 4294467296u + (uint32_t)(sign * 3000);
        const double turns[] = {0.0, 0.5, 0.1, 0.9, 7.9, -2.1};
        const uint32_t n_index[] = {1, 2, 3, 10, 20};
        const int32_t counts[] = {0, 0, 0, 70000, -20000};
        for (int i = 0; i < 5; i++) {
            const hal_encoder_t now = go(turns[i], turns[i + 1]);
            TEST_ASSERT_EQUAL_UINT32(n_index[i], now.n_index);
            TEST_ASSERT_EQUAL_UINT32(edge + (uint32_t)(sign * counts[i]), now.index_counts);
        }
    }
}

static void test_eccentricity_errs_once_per_turn(void)
{
    config.eccentricity_counts = 20.0;
    config.eccentricity_turn = 0.1;
    init_at(0.0);
    const uint32_t at = (uint32_t)config.start_counts;
    TEST_ASSERT_EQUAL_UINT32(at + 3520u, go(0.0, 0.35001).counts);
    TEST_ASSERT_EQUAL_UINT32(at + 8480u, go(0.35001, 0.85001).counts);
    TEST_ASSERT_EQUAL_UINT32(at + 11000u, go(0.85001, 1.10001).counts);
}

static void test_jitter_has_the_rms_and_repeats_with_the_seed(void)
{
    enum { n = 20000 };
    config.jitter_counts = 3.0;
    config.start_counts = 0.0;
    sim_encoder_t again;
    init_at(0.05);
    sim_encoder_init(&again, &config, 0.05, 1);
    double sum = 0.0;
    double sum2 = 0.0;
    for (int i = 0; i < n; i++) {
        const double off = (int32_t)sim_encoder_read(&encoder, 0.05).counts + 0.5 - 500.0;
        TEST_ASSERT_EQUAL_UINT32(encoder.reading.counts, sim_encoder_read(&again, 0.05).counts);
        sum += off;
        sum2 += off * off;
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.0, sum / n);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 3.0, sqrt(sum2 / n));
}

static void test_jitter_differs_with_the_seed(void)
{
    sim_random_t a = sim_random_seeded(1);
    sim_random_t b = sim_random_seeded(2);
    sim_random_t zero = sim_random_seeded(0);
    TEST_ASSERT_TRUE(sim_random_next(&a) != sim_random_next(&b));
    TEST_ASSERT_TRUE(sim_random_next(&zero) != 0u);
}
