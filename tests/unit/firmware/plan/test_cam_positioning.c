// SPDX-License-Identifier: Apache-2.0
// When the axes count as out of the work: in homing, and in the state fault, anew for each fault.
#include "cam_positioning.h"
#include "unity.h"

static void test_clear_is_forgotten_behind_a_fault(void)
{
    static const cam_state_t states[] = {cam_state_off, cam_state_homing, cam_state_ready};
    static cam_play_config_t cfg;
    static cam_tick_record_t r;
    for (uint32_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        cam_motion_t m = {.state = states[i], .is_clear = true};
        (void)cam_positioning_isr(&cfg, &r, &m);
        TEST_ASSERT_FALSE(m.is_clear);
    }
    cam_motion_t m = {.state = cam_state_fault};
    (void)cam_positioning_isr(&cfg, &r, &m);
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
    const cam_motion_limits_t gentle = {.speed_q10 = 4096, .acceleration_q10 = 64};
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
    TEST_ASSERT_FALSE(cam_positioning_isr(&h.cfg, &h.r, &h.m));
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

enum {
    clear_nm = 50000,
    first_nm = -3000,
    origin_nm = 1000,
    begin_q10 = (first_nm + origin_nm) * 1024
};

/// @return an engaging controller with U at 0, X clear of the work and Z where the cut begins
static homing_t approaching(void)
{
    static const cam_knot_t knots[2];
    static const cam_table_t table = {.x = {.knots = knots, .n_slices = 2, .span_nm = 1000000}};
    homing_t h = homed();
    h.cfg.table = &table;
    h.cfg.u_retract_q10 = 0;
    h.cfg.x_clear_q10 = clear_nm * 1024;
    h.cfg.z_first_nm = first_nm;
    h.cfg.z_origin_nm = origin_nm;
    h.m.state = cam_state_engaging;
    h.m.axis[hal_axis_u].pos_q10 = 0;
    h.m.axis[hal_axis_x].pos_q10 = clear_nm * 1024;
    h.m.axis[hal_axis_z].pos_q10 = begin_q10;
    return h;
}

/// The tool nears the work only where it will cut: an X that is not off it moves out while Z comes
/// to rest, then Z moves while X comes to rest.
static void test_one_of_x_and_z_moves_at_a_time(void)
{
    homing_t h = approaching();
    h.m.axis[hal_axis_x].pos_q10 -= 1024;
    h.m.axis[hal_axis_z] = (cam_axis_motion_t){.pos_q10 = begin_q10 + 7 * 1024, .vel_q10 = 800};
    TEST_ASSERT_FALSE(cam_positioning_isr(&h.cfg, &h.r, &h.m));
    TEST_ASSERT_GREATER_THAN_INT32(0, h.m.axis[hal_axis_x].vel_q10);
    TEST_ASSERT_LESS_THAN_INT32(800, h.m.axis[hal_axis_z].vel_q10);
    h = approaching();
    h.m.axis[hal_axis_z].pos_q10 += 700 * 1024;
    h.m.axis[hal_axis_x].vel_q10 = 800;
    TEST_ASSERT_FALSE(cam_positioning_isr(&h.cfg, &h.r, &h.m));
    TEST_ASSERT_LESS_THAN_INT32(0, h.m.axis[hal_axis_z].vel_q10);
    TEST_ASSERT_LESS_THAN_INT32(800, h.m.axis[hal_axis_x].vel_q10);
    TEST_ASSERT_GREATER_OR_EQUAL_INT32(0, h.m.axis[hal_axis_x].vel_q10);
    h = approaching(); // Z is there, X moves to the work
    TEST_ASSERT_FALSE(cam_positioning_isr(&h.cfg, &h.r, &h.m));
    TEST_ASSERT_EQUAL_INT32(0, h.m.axis[hal_axis_z].vel_q10);
    TEST_ASSERT_LESS_THAN_INT32(0, h.m.axis[hal_axis_x].vel_q10);
    for (int32_t vel_q10 = -2048; vel_q10 <= 2048; vel_q10 += 4096) { // Z only passes it
        h = approaching();
        h.m.axis[hal_axis_z].vel_q10 = vel_q10;
        TEST_ASSERT_FALSE(cam_positioning_isr(&h.cfg, &h.r, &h.m));
        TEST_ASSERT_EQUAL_INT32(0, h.m.axis[hal_axis_x].vel_q10);
    }
    h = approaching(); // at the place where the cut begins an X that is not off the work may stay
    h.m.axis[hal_axis_x].pos_q10 = 0;
    TEST_ASSERT_TRUE(cam_positioning_isr(&h.cfg, &h.r, &h.m));
    h = approaching(); // U has to be at 0 as well
    h.m.axis[hal_axis_x].pos_q10 = 0;
    h.m.axis[hal_axis_u].pos_q10 = -1;
    TEST_ASSERT_FALSE(cam_positioning_isr(&h.cfg, &h.r, &h.m));
    TEST_ASSERT_EQUAL_INT64(0, h.m.u_target_q10);
}

/// Over a Z that others move X waits for U, and Z's set-point is where it is measured, whatever its
/// glide was in the middle of; in the state fault, too.
static void test_a_measured_z_is_never_led(void)
{
    for (int i = 0; i < 3; i++) {
        homing_t h = approaching();
        h.cfg.is_z_measured = true;
        h.m.state = i == 2 ? cam_state_fault : cam_state_engaging;
        h.m.axis[hal_axis_u].pos_q10 = i == 0 ? -1024 : 0;
        h.m.axis[hal_axis_z] = (cam_axis_motion_t){.pos_q10 = 4321 * 1024, .vel_q10 = 900};
        cam_jerk_filter_begin_isr(&h.m.filter[hal_axis_z], &h.m.axis[hal_axis_z], 2);
        h.m.is_filtering = true;
        h.r.in.actual_nm[hal_axis_z] = 4321;
        (void)cam_positioning_isr(&h.cfg, &h.r, &h.m);
        TEST_ASSERT_EQUAL_INT64(4321 * 1024, h.m.axis[hal_axis_z].pos_q10);
        TEST_ASSERT_EQUAL_INT32(0, h.m.axis[hal_axis_z].vel_q10);
        TEST_ASSERT_EQUAL(i == 1, h.m.axis[hal_axis_x].vel_q10 < 0);
    }
}

/// The tool swings back to 0 behind a fault, and until then it is not out of the work.
static void test_swing_comes_to_rest_behind_a_fault(void)
{
    homing_t h = homed();
    h.cfg.swing.is_swung = true;
    h.cfg.swing.full =
        (cam_swing_limits_t){.speed_q32 = 1 << 20, .step_q32 = 1 << 18, .gain_q32 = 1 << 24};
    h.m.state = cam_state_fault;
    h.m.swing.set.pos_q32 = 1 << 26;
    for (int i = 0; !h.m.swing.is_there; i++) {
        TEST_ASSERT_LESS_THAN_INT(10000, i);
        TEST_ASSERT_FALSE(h.m.is_clear);
        (void)cam_positioning_isr(&h.cfg, &h.r, &h.m);
    }
    TEST_ASSERT_INT32_WITHIN(1 << 10, 0, h.m.swing.set.pos_q32);
    TEST_ASSERT_TRUE(h.m.is_clear);
}

/// In off the axes follow what is measured; nothing plans them.
static void test_in_off_no_axis_is_moved(void)
{
    homing_t h = homed();
    h.m.state = cam_state_off;
    h.m.u_target_q10 = 77;
    TEST_ASSERT_FALSE(cam_positioning_isr(&h.cfg, &h.r, &h.m));
    TEST_ASSERT_EQUAL_INT64(77, h.m.u_target_q10);
    TEST_ASSERT_EQUAL_INT64(0, h.m.axis[hal_axis_x].vel_q10);
}
