// SPDX-License-Identifier: Apache-2.0
// When the axes count as out of the work: in homing, and in the state fault, anew for each fault.
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

enum { retract_q10 = -512000, turning_q32 = 1000 };

/// What a plan of homing sees when all is as it waits for.
typedef struct {
    cam_play_config_t cfg;
    cam_tick_record_t r;
    cam_motion_t m;
} homing_t;

static homing_t homed(void)
{
    const cam_move_limits_t gentle = {.speed_q10 = 4096, .acceleration_q10 = 64};
    homing_t h = {
        .cfg = {.plan_ticks = 8,
                .per_plan_q30 = 1 << 27,
                .u_retract_q10 = retract_q10,
                .turning_q32 = turning_q32,
                .approach = {gentle, gentle, gentle}},
        .r.angle = {.is_synced = true, .speed_q32 = turning_q32},
        .m.state = cam_state_homing,
    };
    h.m.axis[hal_axis_u].pos_q10 = retract_q10;
    return h;
}

static void expect_homing_ends(homing_t h, bool ends)
{
    TEST_ASSERT_FALSE(cam_rest_isr(&h.cfg, &h.r, &h.m));
    TEST_ASSERT_EQUAL_INT(ends ? cam_state_ready : cam_state_homing, h.m.state);
    TEST_ASSERT_EQUAL_INT64(retract_q10, h.m.u_target_q10);
}

/// Every single thing that is not as it should be keeps the state homing.
static void test_homing_ends_when_the_tool_is_out_and_all_stand(void)
{
    expect_homing_ends(homed(), true);
    homing_t h = homed();
    h.m.axis[hal_axis_u].pos_q10++;
    expect_homing_ends(h, false);
    h = homed();
    h.m.axis[hal_axis_u].vel_q10 = 1;
    expect_homing_ends(h, false);
    h = homed();
    h.m.axis[hal_axis_x].vel_q10 = 1024;
    expect_homing_ends(h, false);
    h = homed();
    h.m.axis[hal_axis_z].vel_q10 = -1024;
    expect_homing_ends(h, false);
    h = homed();
    h.m.was_off = true;
    expect_homing_ends(h, false);
    h = homed();
    h.r.angle.is_synced = false;
    expect_homing_ends(h, false);
    h = homed();
    h.r.angle.speed_q32 = turning_q32 - 1;
    expect_homing_ends(h, false);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_clear_is_forgotten_behind_a_fault);
    RUN_TEST(test_homing_ends_when_the_tool_is_out_and_all_stand);
    return UNITY_END();
}
