// SPDX-License-Identifier: Apache-2.0
// Home switches, indices and zeros of the simulated lathe; test_missing_live.py homes by them.
#include "sim_home.h"
#include "unity.h"

static void test_look_sees_the_switch_on_its_side_and_an_index_for_a_while(void)
{
    sim_home_t home;
    const sim_home_config_t c = {.switch_mm = 10.0, .side = -1.0, .pitch_mm = 5.0, .zero_mm = 1.0};
    sim_home_init(&home, &c, 12.0);
    sim_home_look(&home, 11.5, 2);
    TEST_ASSERT_FALSE(home.is_on || home.is_seen);
    sim_home_look(&home, 10.9, 2); // an index is at 11
    TEST_ASSERT_TRUE(!home.is_on && home.is_seen);
    sim_home_look(&home, 10.0, 2);
    TEST_ASSERT_TRUE(home.is_on && home.is_seen);
    sim_home_look(&home, 9.0, 2);
    TEST_ASSERT_TRUE(home.is_on && !home.is_seen);
    TEST_ASSERT_EQUAL_INT32(1000000, home.zero_nm);
}

static void test_look_without_switch_and_index_sees_nothing(void)
{
    sim_home_t home;
    const sim_home_config_t c = {.switch_mm = 0.0};
    sim_home_init(&home, &c, -5.0);
    for (int i = -5; i < 5; i++) {
        sim_home_look(&home, i, 8);
        TEST_ASSERT_FALSE(home.is_on || home.is_seen);
    }
}
