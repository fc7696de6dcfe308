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

/// A slot has a middle and a width of angle, also across 0, and both ends of its heights.
static void test_slot_is_a_window_of_angle_and_height(void)
{
    config.slot[0] = (sim_chip_slot_t){90.0, 40.0, 10.0, 35.0};
    config.slot[3] = (sim_chip_slot_t){350.0, 30.0, 20.0, 20.0};
    static const struct {
        double deg, z_mm;
        bool is_in;
    } cases[] = {{90.0, 20.0, true},  {70.1, 10.0, true},   {69.9, 10.0, false},
                 {109.9, 35.0, true}, {110.1, 35.0, false}, {90.0, 9.9, false},
                 {90.0, 35.1, false}, {4.9, 20.0, true},    {5.1, 20.0, false},
                 {335.1, 20.0, true}, {0.0, 21.0, false},   {0.0, 0.0, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const bool is_in = sim_chip_is_in_slot(&config, cases[i].deg / 360.0, cases[i].z_mm);
        TEST_ASSERT_EQUAL(cases[i].is_in, is_in);
    }
}
