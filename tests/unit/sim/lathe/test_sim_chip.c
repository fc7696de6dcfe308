// SPDX-License-Identifier: Apache-2.0
#include "sim_chip.h"
#include "unity.h"

static sim_chip_config_t config;

void setUp(void)
{
    config = sim_chip_defaults();
    config.kc_n_per_mm2 = 700.0;
}

/// 0.5 mm deep, 5 mm/s at 50 turns/s: a chip of 0.05 mm2, 35 N, of which 0.3 are radial.
static void test_force_is_that_of_the_chip(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 10.5, sim_chip_force_n(&config, 0.5, 5.0, 50.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 10.5, sim_chip_force_n(&config, 0.5, -5.0, 50.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 10.5, sim_chip_force_n(&config, 0.5, 5.0, -50.0));
}

static void test_there_is_no_force_in_the_air_or_at_rest(void)
{
    TEST_ASSERT_TRUE(sim_chip_force_n(&config, 0.0, 5.0, 50.0) == 0.0);
    TEST_ASSERT_TRUE(sim_chip_force_n(&config, -0.1, 5.0, 50.0) == 0.0);
    TEST_ASSERT_TRUE(sim_chip_force_n(&config, 0.5, 5.0, 0.0) == 0.0);
    config = sim_chip_defaults();
    TEST_ASSERT_TRUE(sim_chip_force_n(&config, 0.5, 5.0, 50.0) == 0.0);
}

static void test_tool_bends_by_its_stiffness(void)
{
    TEST_ASSERT_TRUE(sim_chip_bend_um(&config, 10.0) == 0.0); // rigid
    config.tool_stiffness_n_per_um = 20.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.5, sim_chip_bend_um(&config, 10.0));
}
