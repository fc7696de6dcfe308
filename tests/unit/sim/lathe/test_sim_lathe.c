// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_config.h"
#include "sim_units.h" // sim_round, SIM_TWO_PI
#include "unity.h"
#include <math.h> // fabs, sin

static sim_lathe_config_t config;
static sim_lathe_t lathe;

void setUp(void)
{
    config = sim_config_defaults().lathe;
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

/// @return [counts] of the disc at an angle, from the index on, which is on an edge
static double disc_counts(double turn)
{
    const sim_encoder_config_t *c = &config.encoder;
    const double off = sin(SIM_TWO_PI * (turn - c->eccentricity_turn)) -
                       sin(SIM_TWO_PI * (c->index_turn - c->eccentricity_turn));
    return c->counts_per_turn * (turn - c->index_turn) + c->eccentricity_counts * off;
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
        const double place = disc_counts(edge);
        const double off = fabs(place - sim_round(place));
        worst = i > 10 && off > worst ? off : worst;
        TEST_ASSERT_TRUE(lathe.encoder.edge_age_s >= 0.0);
        TEST_ASSERT_TRUE(lathe.encoder.edge_age_s < 1e-5); // an edge every 6.3 us
    }
    return worst / (config.encoder.counts_per_turn * 100.0 / SIM_TWO_PI) * 1e9;
}

static void test_time_stamps_are_those_of_the_edges(void)
{
    config.encoder.index_turn = 0.30001; // with 10 000 counts a tenth of one past an edge
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

/// What the gauge sees: the drives, a tip that swings and is bent away by the chip, and the run-out
/// of the spindle, once and twice a turn.
static void test_sample_has_modes_bending_and_run_out(void)
{
    config.chip.tool_stiffness_n_per_um = 20.0;
    config.runout_um = 3.0;
    config.runout_2_um = 1.0;
    config.mode[0].hz = 800.0;
    config.mode[0].share = 0.5;
    config.mode[1].hz = 1200.0;
    config.mode[1].share = -0.25;
    init();
    lathe.mode[0].pos_micro = 60.0;
    lathe.mode[1].pos_micro = 40.0;
    lathe.drive[hal_axis_u].pos_micro = 100.0;
    lathe.drive[hal_axis_z].pos_micro = -7e6;
    lathe.drive[sim_lathe_swing].pos_micro = 2.5e6;
    lathe.chip_n = 30.0;
    static const double x_nm[][2] = {{4.0, 4000.0}, {4.25, -1000.0}, {4.5, -2000.0}};
    for (int i = 0; i < 3; i++) {
        lathe.spindle.turn = x_nm[i][0];
        const sim_sample_t at = sim_lathe_sample(&lathe, 1.5);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 50e6 + x_nm[i][1], at.x_nm);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 100.0 + 30.0 - 10.0 - 1500.0, at.u_nm);
        TEST_ASSERT_TRUE(at.t_s == 1.5 && at.turn == x_nm[i][0]);
        TEST_ASSERT_TRUE(at.z_nm == -7e6 && at.swing_deg == 2.5);
    }
}
