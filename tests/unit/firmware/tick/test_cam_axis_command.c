// SPDX-License-Identifier: Apache-2.0
// What the axes are to be commanded: feed-forward and correction of U in the cut, the set-point
// itself outside of it, and what a plan may command X and Z. The guard's part of it is in
// test_cam_guard.c; test_cam_u_command.c judges both on a whole controller.
#include "cam_tick_inner.h"
#include "unity.h"
#include <string.h> // memset

static cam_axis_command_config_t cfg;
static cam_motion_t motion;
static cam_tick_record_t r;

void setUp(void)
{
    memset(&motion, 0, sizeof motion);
    memset(&r, 0, sizeof r);
    cfg = (cam_axis_command_config_t){
        .vel_q10 = {0, 1024000, 1024000}, .change_q10 = {0, 10240, 10240}, .jump_q10 = {0, 32, 32}};
    motion.state = cam_state_cutting;
    motion.is_playing = true;
}

/// @return [nm] the command of U for a set-point
static int32_t command(int32_t set_nm)
{
    r.want.u_set_q6 = set_nm * 64;
    return cam_axis_command_isr(&cfg, &r, &motion);
}

static int32_t command_by_time(int32_t set_nm)
{
    motion.is_playing = false;
    const int32_t nm = command(set_nm);
    motion.is_playing = true;
    return nm;
}

/// 2.5 ticks of 100 nm per tick, 3 ticks^2 of -8 nm per tick^2, and 7 nm that were learned. A
/// motion by time is commanded to its set-point.
static void test_command_is_set_point_feed_forward_and_correction(void)
{
    cfg.in_cut.k1_q16 = 163840;
    cfg.in_cut.k2_q16 = 196608;
    motion.axis[hal_axis_u] = (cam_axis_motion_t){.vel_q10 = 102400, .acc_q10 = -8192};
    motion.c_q6 = 7 * 64 + 31;
    TEST_ASSERT_EQUAL_INT32(5000 + 250 - 24 + 7, command(5000));
    motion.c_q6 = 7 * 64 + 32; // half a nanometre is rounded up
    TEST_ASSERT_EQUAL_INT32(5234, command(5000));
    TEST_ASSERT_EQUAL_INT32(5000, command_by_time(5000));
}

/// In the cut the command leads by the friction, in full from 4 nm per tick on.
static void test_friction_is_led_in_the_sense_of_the_motion(void)
{
    static const struct {
        int32_t vel_q10, nm;
    } cases[] = {{0, 0},         {2048, 400},   {4096, 800},
                 {1 << 20, 800}, {-2048, -400}, {-(1 << 20), -800}};
    cfg.in_cut.friction_q14 = 800 * 16384;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        motion.axis[hal_axis_u].vel_q10 = cases[i].vel_q10;
        TEST_ASSERT_EQUAL_INT32(5000 + cases[i].nm, command(5000));
        TEST_ASSERT_EQUAL_INT32(5000, command_by_time(5000));
    }
}

/// In the cut the command leads by a share of the set-point and by a mean against the force of the
/// chip.
static void test_command_leads_against_the_force_of_the_chip(void)
{
    cfg.in_cut.chip_q32 = -(1 << 28); // a sixteenth
    cfg.in_cut.chip_q6 = 30 * 64;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_EQUAL_INT32(sign * 4500 + 30, command(sign * 4800));
        TEST_ASSERT_EQUAL_INT32(sign * 4800, command_by_time(sign * 4800));
    }
}

/// A feed-forward beyond every word is a command beyond every stroke, of the same sign.
static void test_feed_forward_beyond_a_word_is_beyond_every_stroke(void)
{
    static const int32_t most[] = {-INT32_MAX, INT32_MAX};
    cfg.in_cut.k1_q16 = cfg.in_cut.k2_q16 = INT32_MAX / 2;
    for (size_t i = 0; i < 2u; i++) {
        motion.axis[hal_axis_u] = (cam_axis_motion_t){.vel_q10 = most[i], .acc_q10 = most[i]};
        TEST_ASSERT_INT32_WITHIN(64, i == 0u ? -(1 << 24) : 1 << 24, command(0));
    }
}

/// What a plan makes of an axis, from its speed before. @return the fault
static uint32_t plan(uint32_t axis, int32_t before_q10, int32_t vel_q10, int64_t jump_q10)
{
    cam_axis_motion_t before[hal_n_axes] = {[hal_axis_x] = {.pos_q10 = 9000, .vel_q10 = 7},
                                            [hal_axis_z] = {.pos_q10 = 9000, .vel_q10 = 7}};
    before[axis].vel_q10 = before_q10;
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        motion.axis[i] = before[i];
    }
    motion.is_filtering = true;
    motion.axis[axis] = (cam_axis_motion_t){.pos_q10 = 9000 + jump_q10, .vel_q10 = vel_q10};
    return cam_axis_command_plan_isr(&cfg, &motion, before);
}

static void test_plan_is_commanded_within_speed_change_and_position(void)
{
    static const struct {
        int32_t before_q10, vel_q10;
        int64_t jump_q10;
        bool is_commanded;
    } cases[] = {
        {0, 10240, 0, true},
        {0, 10241, 0, false},
        {1020000, 1024000, 0, true},
        {1020000, 1024001, 0, false},
        {0, 0, 32, true},
        {0, 0, 33, false},
        {0, 0, INT64_MAX / 2, false},
        {2000000, 1999999, 0, true}, // faster than the limit: it may brake
        {2000000, 2000001, 0, false},
        {2000000, 1989759, 0, false}, // ... by no more than the change
    };
    for (size_t k = 0; k < 4u * sizeof cases / sizeof cases[0]; k++) {
        const size_t i = k / 4u;
        const int32_t sign = k % 2u == 0u ? 1 : -1;
        const uint32_t axis = k % 4u < 2u ? hal_axis_x : hal_axis_z;
        const int32_t before_q10 = sign * cases[i].before_q10;
        const int32_t vel_q10 = sign * cases[i].vel_q10;
        const uint32_t faults = plan(axis, before_q10, vel_q10, sign * cases[i].jump_q10);
        const int32_t is_q10 = cases[i].is_commanded ? vel_q10 : before_q10;
        TEST_ASSERT_EQUAL_HEX32(cases[i].is_commanded ? 0u : CAM_FAULT_BIT(command), faults);
        TEST_ASSERT_EQUAL_INT32(is_q10, motion.axis[axis].vel_q10);
        TEST_ASSERT_EQUAL_INT32(is_q10 - before_q10, motion.change_q10[axis]);
        TEST_ASSERT_TRUE(motion.is_filtering == cases[i].is_commanded);
    }
}

/// In off X and Z follow what moves them.
static void test_plan_in_off_is_commanded_without_limits(void)
{
    motion.state = cam_state_off;
    TEST_ASSERT_EQUAL_HEX32(0, plan(hal_axis_x, 0, INT32_MAX, 1 << 30));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, motion.axis[hal_axis_x].vel_q10);
}

/// X and Z are rounded down to whole nanometres.
static void test_axes_have_speed_and_acceleration_of_their_set_points(void)
{
    motion.axis[hal_axis_x] = (cam_axis_motion_t){.pos_q10 = -1, .vel_q10 = 7, .acc_q10 = 8};
    motion.axis[hal_axis_z] = (cam_axis_motion_t){.pos_q10 = 2047};
    (void)command(1005);
    TEST_ASSERT_EQUAL_INT32(-1, r.out[hal_axis_x].pos_nm);
    TEST_ASSERT_EQUAL_INT32(7, r.out[hal_axis_x].vel_q10);
    TEST_ASSERT_EQUAL_INT32(8, r.out[hal_axis_x].acc_q10);
    TEST_ASSERT_EQUAL_INT32(1, r.out[hal_axis_z].pos_nm);
}

/// The amount of the least number is no number: it counts as the largest one.
static void test_axis_at_the_end_of_its_word_may_brake(void)
{
    cam_axis_motion_t before[hal_n_axes] = {0};
    cfg.vel_q10[hal_axis_x] = 1000;
    before[hal_axis_x].vel_q10 = INT32_MIN;
    motion.axis[hal_axis_x].vel_q10 = INT32_MIN + 1;
    TEST_ASSERT_EQUAL_HEX32(0, cam_axis_command_plan_isr(&cfg, &motion, before));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN + 1, motion.axis[hal_axis_x].vel_q10);
}
