// SPDX-License-Identifier: Apache-2.0
// In which states a press of the button is used up, after which a new one is wanted, and how long a
// press may be, to the plan.
#include "cam_acknowledge.h"
#include "unity.h"

/// Whatever is done with enabled drives uses the press up; a fault and the chain want a new one.
static void test_every_state_with_enabled_drives_uses_it_up(void)
{
    static const cam_acknowledge_config_t cfg = {.is_demanded = true, .good_plans = 100};
    static const cam_state_t used[] = {cam_state_homing, cam_state_rehearsing,
                                       cam_state_identifying, cam_state_manual, cam_state_holding};
    static cam_tick_record_t r;
    for (uint32_t i = 0; i < 7u; i++) {
        cam_acknowledge_t a = {.phase = cam_acknowledge_given};
        cam_motion_t m = {.state = i < 5u ? used[i] : cam_state_fault, .was_open = i == 6u};
        cam_acknowledge_isr(&a, &cfg, &r, &m);
        TEST_ASSERT_EQUAL_INT(i < 5u ? cam_acknowledge_used : cam_acknowledge_needed, a.phase);
        TEST_ASSERT_EQUAL(i < 5u, m.is_acknowledged);
        TEST_ASSERT_FALSE(m.was_open);
    }
}

/// The least and the longest time of a press both count, one plan less or more does not.
static void test_a_press_of_the_least_or_the_longest_time_counts(void)
{
    static const cam_acknowledge_config_t cfg = {
        .settle_plans = 2, .least_plans = 5, .most_plans = 8, .good_plans = 100};
    for (uint32_t n = 4; n <= 9u; n++) {
        cam_acknowledge_t a = {.phase = cam_acknowledge_armed};
        cam_motion_t m = {.state = cam_state_off};
        for (uint32_t i = 0; i < 20u; i++) {
            const cam_tick_record_t r = {.in.inputs = i < n ? hal_in_acknowledge : 0u};
            cam_acknowledge_isr(&a, &cfg, &r, &m);
        }
        TEST_ASSERT_EQUAL(n >= 5u && n <= 8u, m.is_acknowledged);
    }
}
