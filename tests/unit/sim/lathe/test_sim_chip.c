// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_config.h"
#include "unity.h"

static sim_chip_config_t config;

void setUp(void)
{
    config = sim_config_defaults().lathe.chip;
    config.kc_n_per_mm2 = 700.0;
}

/// 700 N/mm2 on a chip 0.2 mm deep and 0.1 mm thick, 0.3 of it in the direction of U.
static void test_force_is_that_of_the_chip(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 4.2, sim_chip_force_n(&config, 0.2, -5.0, 50.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 4.2, sim_chip_force_n(&config, 0.2, 5.0, -50.0));
    // There is none in the air or at rest.
    TEST_ASSERT_TRUE(sim_chip_force_n(&config, 0.0, 5.0, 50.0) == 0.0);
    TEST_ASSERT_TRUE(sim_chip_force_n(&config, -0.1, 5.0, 50.0) == 0.0);
    TEST_ASSERT_TRUE(sim_chip_force_n(&config, 0.5, 5.0, 0.0) == 0.0);
    config = sim_config_defaults().lathe.chip;
    TEST_ASSERT_TRUE(sim_chip_force_n(&config, 0.5, 5.0, 50.0) == 0.0);
}
