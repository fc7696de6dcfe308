// SPDX-License-Identifier: Apache-2.0
// That the axes are clear of the work is known in the state fault only, and anew for each.
#include "cam_rest.h"
#include "unity.h"

void setUp(void) {}

void tearDown(void) {}

static void test_clear_is_forgotten_behind_a_fault(void)
{
    static const cam_state_t states[] = {cam_state_off, cam_state_homing, cam_state_ready};
    static cam_play_config_t cfg;
    static cam_tick_record_t r;
    for (uint32_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        cam_motion_t m = {.state = states[i], .is_clear = true};
        (void)cam_rest_isr(&cfg, &r, &m);
        TEST_ASSERT_FALSE(m.is_clear);
    }
    cam_motion_t m = {.state = cam_state_fault};
    (void)cam_rest_isr(&cfg, &r, &m);
    TEST_ASSERT_TRUE(m.is_clear); // X and Z stand where they are to be
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_clear_is_forgotten_behind_a_fault);
    return UNITY_END();
}
