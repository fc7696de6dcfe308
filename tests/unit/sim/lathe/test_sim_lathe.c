// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_config.h" // sim_config_load
#include "sim_units.h"  // sim_round, SIM_TWO_PI
#include "unity.h"
#include <math.h>  // cos, fabs, llround, sin
#include <stdio.h> // snprintf

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

/// Set-points that turn the spindle and move U by a sine over the angle.
static sim_setpoints_t turning(double swing_nm, double rad_per_s)
{
    const double angle = SIM_TWO_PI * sim_fraction(2.0 * lathe.spindle.turn);
    sim_setpoints_t set = {.spindle_rad_per_s = rad_per_s};
    set.micro[hal_axis_u] = (int32_t)llround(swing_nm * cos(angle));
    set.micro[hal_axis_x] = 49900000;
    set.micro[hal_axis_z] = (int32_t)llround(lathe.spindle.turn * 1e5);
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        set.is_enabled[i] = true;
    }
    return set;
}

/// Fletcher's sum of whole numbers, which every computer makes alike.
static void add(uint64_t sum[2], int64_t value)
{
    sum[0] += (uint64_t)value;
    sum[1] += sum[0];
}

/// All that a controller or a gauge sees of two seconds of turning, in 1e-3 nm and 1e-12 turns.
static uint64_t seen_of(const char *name)
{
    char path[300];
    common_error_t error;
    sim_config_t file = sim_config_defaults();
    (void)snprintf(path, sizeof path, HOST_SIM_DIR "/machines/%s.toml", name);
    TEST_ASSERT_TRUE_MESSAGE(sim_config_load(&file, path, &error), error.text);
    config = file.lathe;
    init();
    uint64_t sum[2] = {0, 0};
    for (int i = 0; i < 40000; i++) {
        sim_setpoints_t set = turning(150000.0, 200.0);
        set.is_enabled[hal_axis_u] = i % 9000 < 8000;
        const hal_encoder_t reading = sim_lathe_encoder(&lathe);
        const sim_sample_t at = sim_lathe_sample(&lathe, 0.0);
        add(sum, reading.counts);
        add(sum, reading.index_counts);
        add(sum, llround(at.turn * 1e12));
        add(sum, llround(at.u_nm * 1e3));
        add(sum, llround(at.x_nm * 1e3));
        for (int k = 0; k < hal_n_axes; k++) {
            add(sum, sim_lathe_measured_micro(&lathe, k));
        }
        sim_lathe_step(&lathe, &set);
        if (i % 7000 == 6999) {
            sim_lathe_linger(&lathe, &set, 33e-6);
        }
    }
    return sum[0] ^ (sum[1] << 1);
}

/// The numbers are those of the simulator before it knew friction, modes and scales.
static void test_machines_without_effects_move_as_they_always_did(void)
{
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x683A852231ADA92E), seen_of("default"));
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x9172C42B362106B1), seen_of("rough"));
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x702C0FDA52A77883), seen_of("piezo"));
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x09EC5F2F9271EFBE), seen_of("cam"));
}

/// Let the lathe turn until it has settled.
static void settle(void)
{
    for (int i = 0; i < 20000; i++) {
        const sim_setpoints_t set = turning(0.0, 100.0);
        sim_lathe_step(&lathe, &set);
    }
}

static void test_run_out_moves_the_part_once_and_twice_per_turn(void)
{
    config.runout_um = 3.0;
    config.runout_2_um = 0.5;
    init();
    settle();
    for (int i = 0; i < 2000; i++) {
        const sim_setpoints_t set = turning(0.0, 100.0);
        sim_lathe_step(&lathe, &set);
        const double angle = SIM_TWO_PI * lathe.spindle.turn;
        const double wanted = 3000.0 * cos(angle) + 500.0 * cos(2.0 * angle);
        const double x_nm = lathe.drive[hal_axis_x].pos_micro;
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, wanted, sim_lathe_sample(&lathe, 0.0).x_nm - x_nm);
    }
}

/// 700 N/mm2, 0.5 mm deep, 0.1 mm per turn, 0.3 of it: 10.5 N or 7 m/s2 against 300 Hz, 1.97 um.
static void test_chip_pushes_u_back_and_bends_the_tool(void)
{
    config.chip.kc_n_per_mm2 = 700.0;
    config.chip.tool_stiffness_n_per_um = 20.0;
    config.drive[hal_axis_u].quantum_micro = 0.0;
    config.spindle.ripple = 0.0;
    init();
    settle();
    for (int i = 0; i < 2000; i++) {
        const sim_setpoints_t set = turning(0.0, 100.0);
        sim_lathe_step(&lathe, &set);
        sim_lathe_bite(&lathe, 0.5);
    }
    const double w = SIM_TWO_PI * 300.0;
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 10.5, lathe.chip_n);
    TEST_ASSERT_DOUBLE_WITHIN(5.0, -7e9 / (w * w), lathe.drive[hal_axis_u].pos_micro);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, lathe.drive[hal_axis_u].pos_micro - 525.0,
                              sim_lathe_sample(&lathe, 0.0).u_nm);
    sim_lathe_bite(&lathe, -0.1);
    TEST_ASSERT_TRUE(lathe.chip_n == 0.0);
}

/// [nm] largest difference of tip and scale while U swings
static double largest_between_nm(void)
{
    double largest = 0.0;
    init();
    for (int i = 0; i < 20000; i++) {
        const sim_setpoints_t set = turning(1e5, 200.0);
        sim_lathe_step(&lathe, &set);
        const double scale_nm = sim_lathe_measured_micro(&lathe, hal_axis_u);
        const double between = fabs(sim_lathe_sample(&lathe, 0.0).u_nm - scale_nm);
        largest = i > 15000 && between > largest ? between : largest;
    }
    return largest;
}

/// 63.7 Hz and 0.1 mm are 16.0 m/s2; a mode of 1000 Hz moves the tip by 0.41 um of that.
static void test_scale_sees_only_the_modes_that_lie_on_it(void)
{
    config.drive[hal_axis_u].quantum_micro = 1.0;
    config.mode[0].hz = 1000.0;
    TEST_ASSERT_DOUBLE_WITHIN(25.0, 407.0, largest_between_nm());
    config.mode[0].is_on_scale = 1.0;
    TEST_ASSERT_DOUBLE_WITHIN(0.6, 0.0, largest_between_nm());
}

/// [ns] largest error of the time stamps against the angle of the edge, in steady turning
static double worst_stamp_ns(double sign, double eccentricity_counts)
{
    config.encoder.sign = sign;
    config.encoder.has_time_stamps = 1.0;
    config.encoder.eccentricity_counts = eccentricity_counts;
    config.spindle.ripple = 0.0;
    init();
    settle();
    double worst = 0.0;
    for (int i = 0; i < 4000; i++) {
        const sim_setpoints_t set = turning(0.0, 100.0);
        sim_lathe_step(&lathe, &set);
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
    settle();
    double before = 0.0;
    int n_kept = 0;
    for (int i = 0; i < 400; i++) {
        const int64_t counts = lathe.encoder.counts;
        const sim_setpoints_t set = turning(0.0, 100.0);
        sim_lathe_step(&lathe, &set);
        (void)sim_lathe_encoder(&lathe);
        if (i > 0 && counts == lathe.encoder.counts) {
            n_kept++;
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, before + 50e-6, lathe.encoder.edge_age_s);
        }
        before = lathe.encoder.edge_age_s;
    }
    TEST_ASSERT_TRUE(n_kept > 300);
}
