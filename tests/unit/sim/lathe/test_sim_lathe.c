// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_units.h" // sim_round, SIM_TWO_PI
#include "unity.h"
#include <math.h> // fabs, sin

static sim_lathe_config_t config;
static sim_lathe_t lathe;

void setUp(void)
{
    config = sim_lathe_defaults();
}

static void init(void)
{
    sim_lathe_init(&lathe, &config, 1.0 / config.tick_hz, 50e6, 0.0, 1);
}

/// Let the lathe turn for n ticks.
static void turn(int n)
{
    const sim_setpoints_t set = {.spindle_rad_per_s = 100.0};
    for (int i = 0; i < n; i++) {
        sim_lathe_step(&lathe, &set);
    }
}

/// [ns] largest error of the time stamps against the angle of the edge, in steady turning
static double worst_stamp_ns(double sign, double eccentricity_counts)
{
    config.encoder.sign = sign;
    config.encoder.has_time_stamps = 1.0;
    config.encoder.eccentricity_counts = eccentricity_counts;
    config.spindle.ripple = 0.0;
    init();
    turn(20000); // until it has settled
    double worst = 0.0;
    for (int i = 0; i < 4000; i++) {
        turn(1);
        (void)sim_lathe_encoder(&lathe);
        const double edge = lathe.spindle.turn - lathe.encoder.edge_age_s * 100.0 / SIM_TWO_PI;
        const double error =
            eccentricity_counts *
            sin(SIM_TWO_PI * sim_fraction(edge - config.encoder.eccentricity_turn));
        const double place = config.encoder.counts_per_turn * edge + error;
        const double off = fabs(place - sim_round(place));
        worst = i > 10 && off > worst ? off : worst;
        TEST_ASSERT_TRUE(lathe.encoder.edge_age_s >= 0.0);
        TEST_ASSERT_TRUE(lathe.encoder.edge_age_s < 1e-5); // an edge every 6.3 us
    }
    return worst / (config.encoder.counts_per_turn * 100.0 / SIM_TWO_PI) * 1e9;
}

static void test_time_stamps_are_those_of_the_edges(void)
{
    TEST_ASSERT_TRUE(worst_stamp_ns(1.0, 0.0) < 0.1);
    TEST_ASSERT_TRUE(worst_stamp_ns(-1.0, 0.0) < 0.1);
    TEST_ASSERT_TRUE(worst_stamp_ns(1.0, 20.0) < 0.1);
}

static void test_old_edge_keeps_its_time(void)
{
    config.encoder.has_time_stamps = 1.0;
    config.encoder.counts_per_turn = 64.0;
    config.spindle.ripple = 0.0;
    init();
    turn(20000); // until it has settled
    double before = 0.0;
    int n_kept = 0;
    for (int i = 0; i < 400; i++) {
        const int64_t counts = lathe.encoder.counts;
        turn(1);
        (void)sim_lathe_encoder(&lathe);
        if (i > 0 && counts == lathe.encoder.counts) {
            n_kept++;
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, before + 50e-6, lathe.encoder.edge_age_s);
        }
        before = lathe.encoder.edge_age_s;
    }
    TEST_ASSERT_TRUE(n_kept > 300);
}
