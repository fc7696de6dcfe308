// SPDX-License-Identifier: Apache-2.0
#include "sim_encoder.h"
#include "sim_config.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h> // cos, sin

#define STEP_S 50e-6

static sim_scale_config_t config;
static sim_scale_t scale;

void setUp(void)
{
    config = sim_config_defaults().lathe.scale;
}

static void test_reading_is_older_by_the_latency(void)
{
    static const double us[] = {0.0, 1.0, 4.5, 50.0, 75.0, 1000.0};
    const double f = SIM_TWO_PI * 100.0;
    for (int k = 0; k < 6; k++) {
        config.latency_us = us[k];
        sim_scale_init(&scale, &config, 0.0, STEP_S);
        for (int i = 0; i < 400; i++) {
            const double t_s = i * STEP_S;
            sim_scale_push(&scale, 5e5 * sin(f * t_s), 5e5 * f * cos(f * t_s));
            const double wanted = 5e5 * sin(f * (t_s - us[k] * 1e-6));
            if (i > 30) {
                TEST_ASSERT_DOUBLE_WITHIN(0.004, wanted, sim_scale_read_micro(&scale));
            }
        }
    }
}

static void test_error_repeats_twice_in_a_period(void)
{
    config.error_nm = 30.0;
    config.period_um = 4.0;
    sim_scale_init(&scale, &config, 0.0, STEP_S);
    for (int i = 0; i < 16; i++) {
        const double at = i * 250.0; // an eighth of half a period
        sim_scale_push(&scale, at, 0.0);
        const double wanted = at + 30.0 * sin(SIM_TWO_PI * i / 8.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, wanted, sim_scale_read_micro(&scale));
    }
}

static void test_ideal_scale_shows_what_it_sees(void)
{
    sim_scale_init(&scale, &config, 12.5, STEP_S);
    TEST_ASSERT_TRUE(sim_scale_read_micro(&scale) == 12.5);
    sim_scale_push(&scale, -7.25, 1e6);
    TEST_ASSERT_TRUE(sim_scale_read_micro(&scale) == -7.25);
}
