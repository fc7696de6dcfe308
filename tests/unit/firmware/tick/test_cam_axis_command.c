// SPDX-License-Identifier: Apache-2.0
// The last word on what the axes are told, by itself: feed-forward and correction, limits of place,
// step and change of step, what takes the place of a refused command, and what a plan may command X
// and Z. test_cam_u_command.c judges the same on a whole controller.
#include "cam_axis_command.h"
#include "unity.h"
#include <string.h> // memset

static cam_axis_command_t command;
static cam_axis_command_config_t cfg;
static cam_motion_t motion;
static cam_tick_record_t r;

void setUp(void)
{
    memset(&command, 0, sizeof command);
    memset(&motion, 0, sizeof motion);
    memset(&r, 0, sizeof r);
    cfg = (cam_axis_command_config_t){.range_nm = 100000,
                                      .step_nm = 1000,
                                      .change_nm = 50,
                                      .change_off_nm = 400,
                                      .vel_q10 = {0, 1024000, 1024000},
                                      .change_q10 = {0, 10240, 10240},
                                      .jump_q10 = {0, 32, 32}};
    motion.state = cam_state_cutting;
    motion.is_playing = true;
}

static void told(int32_t nm, int32_t step_nm)
{
    command.u = (cam_u_command_t){.nm = nm, .step_nm = step_nm};
}

/// U's set-point of the tick. @return whether it was told
static bool commands(int32_t set_nm, bool is_new)
{
    command.is_fault = motion.state == cam_state_fault && !is_new;
    r.want.u_set_q6 = set_nm * 64;
    return cam_axis_command_isr(&command, &cfg, &r, &motion);
}

static void expect_told(int32_t nm, int32_t step_nm)
{
    TEST_ASSERT_EQUAL_INT32(nm, command.u.nm);
    TEST_ASSERT_EQUAL_INT32(step_nm, command.u.step_nm);
}

/// 2.5 ticks of 100 nm per tick, 3 ticks^2 of -8 nm per tick^2, and 7 nm that were learned.
static void test_command_is_set_point_feed_forward_and_correction(void)
{
    told(5200, 33);
    cfg.by_time.k1_q16 = cfg.in_cut.k1_q16 = 163840;
    cfg.by_time.k2_q16 = cfg.in_cut.k2_q16 = 196608;
    motion.axis[hal_axis_u] = (cam_axis_motion_t){.vel_q10 = 102400, .acc_q10 = -8192};
    motion.c_q6 = 7 * 64 + 31;
    TEST_ASSERT_TRUE(commands(5000, false));
    expect_told(5000 + 250 - 24 + 7, 33);
    told(5200, 33);
    motion.c_q6 = 7 * 64 + 32; // half a nanometre is rounded up
    TEST_ASSERT_TRUE(commands(5000, false));
    expect_told(5234, 34);
}

/// In the cut the command leads by the friction, in full from 4 nm per tick on; in motions by time
/// it does not.
static void test_friction_is_led_in_the_sense_of_the_motion(void)
{
    static const struct {
        int32_t vel_q10, nm;
    } cases[] = {{0, 0},         {2048, 400},   {4096, 800},
                 {1 << 20, 800}, {-2048, -400}, {-(1 << 20), -800}};
    cfg.in_cut.friction_q6 = 800 * 64;
    cfg.change_nm = 1000;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        told(5000, 0);
        motion.axis[hal_axis_u].vel_q10 = cases[i].vel_q10;
        TEST_ASSERT_TRUE(commands(5000, false));
        expect_told(5000 + cases[i].nm, cases[i].nm);
        told(5000, 0);
        motion.is_playing = false;
        motion.state = cam_state_ready;
        TEST_ASSERT_TRUE(commands(5000, false));
        expect_told(5000, 0);
        motion.is_playing = true;
    }
}

/// In the cut the command leads by a share of the set-point and by a mean against the force of the
/// chip; in motions by time it does not.
static void test_command_leads_against_the_force_of_the_chip(void)
{
    cfg.in_cut.chip_q32 = -(1 << 28); // a sixteenth
    cfg.in_cut.chip_q6 = 30 * 64;
    cfg.change_nm = 1000;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        told(sign * 4800, 0);
        TEST_ASSERT_TRUE(commands(sign * 4800, false));
        expect_told(sign * 4500 + 30, sign * -300 + 30);
    }
    told(4800, 0);
    motion.is_playing = false;
    motion.state = cam_state_ready;
    TEST_ASSERT_TRUE(commands(4800, false));
    expect_told(4800, 0);
}

/// Out of the work nothing is corrected, whatever the last tick of the cut has left behind.
static void test_correction_belongs_to_play(void)
{
    told(0, 0);
    motion.c_q6 = 640;
    motion.is_playing = false;
    motion.state = cam_state_ready;
    TEST_ASSERT_TRUE(commands(3, false));
    expect_told(3, 3);
}

/// [place, its last step, command wanted, off time, whether it may be told]
static void test_limits_hold_to_the_nanometre(void)
{
    static const struct {
        int32_t nm, step_nm, want_nm;
        bool is_off_time, is_told;
    } cases[] = {
        {0, 0, 50, false, true},           {0, 0, 51, false, false},
        {0, 0, -50, false, true},          {0, 0, -51, false, false},
        {0, 970, 1000, false, true},       {0, 970, 1001, false, false},
        {0, -970, -1000, false, true},     {0, -970, -1001, false, false},
        {99990, 0, 100000, false, true},   {99990, 0, 100001, false, false},
        {-99990, 0, -100000, false, true}, {-99990, 0, -100001, false, false},
        {0, 0, 400, true, true},           {0, 0, 401, true, false},
        {0, 0, -400, true, true},          {0, 0, -401, true, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        told(cases[i].nm, cases[i].step_nm);
        r.angle.is_off_time = cases[i].is_off_time;
        TEST_ASSERT_TRUE(commands(cases[i].want_nm, false) == cases[i].is_told);
        const int32_t step_nm = cases[i].want_nm - cases[i].nm;
        expect_told(cases[i].is_told ? cases[i].want_nm : cases[i].nm,
                    cases[i].is_told ? step_nm : cases[i].step_nm);
    }
}

/// A feed-forward beyond every word is a command beyond every stroke, of the same sign.
static void test_feed_forward_beyond_a_word_is_refused(void)
{
    static const int32_t most[] = {-INT32_MAX, INT32_MAX};
    for (size_t i = 0; i < 2u; i++) {
        told(0, 0);
        cfg.by_time.k1_q16 = cfg.in_cut.k1_q16 = INT32_MAX / 2;
        cfg.by_time.k2_q16 = cfg.in_cut.k2_q16 = INT32_MAX / 2;
        cfg.step_nm = cfg.change_nm = INT32_MAX / 2;
        motion.axis[hal_axis_u] = (cam_axis_motion_t){.vel_q10 = most[i], .acc_q10 = most[i]};
        TEST_ASSERT_FALSE(commands(0, false));
        motion.state = cam_state_fault;
        command.is_fault = true;
        cam_axis_command_nearest_isr(&command, &cfg, &r, &motion);
        TEST_ASSERT_EQUAL_INT32(i == 0u ? -100000 : 100000, command.u.nm);
    }
}

/// In off nothing is a motion: the set-point of U is where it stands, in its stroke, and the speeds
/// of the last plan are forgotten, even in an off that is shorter than a plan.
static void test_off_follows_u_without_a_step(void)
{
    static const int32_t places_nm[][2] = {
        {-70000, -70000}, {70000, 70000}, {5000000, 100000}, {-5000000, -100000}};
    command.vel_q10[hal_axis_x] = command.vel_q10[hal_axis_z] = 1000;
    motion.is_playing = false;
    motion.state = cam_state_off;
    for (size_t i = 0; i < 4u; i++) {
        TEST_ASSERT_TRUE(commands(places_nm[i][0], false));
        expect_told(places_nm[i][1], 0);
    }
    TEST_ASSERT_EQUAL_INT32(0, command.vel_q10[hal_axis_x]);
    TEST_ASSERT_EQUAL_INT32(0, command.vel_q10[hal_axis_z]);
}

/// The command goes on with its last step, whatever the set-point of the retract is.
static void test_tick_of_a_fault_goes_on_and_the_difference_fades(void)
{
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        setUp();
        told(sign * 10000, sign * 300);
        motion.is_playing = false;
        motion.c_q6 = 12345; // of the cut that has ended
        motion.state = cam_state_fault;
        TEST_ASSERT_TRUE(commands(sign * 10140, true));
        expect_told(sign * 10300, sign * 300);
        TEST_ASSERT_EQUAL_INT32(sign * 160 * 64, command.fading_q6);
        cfg.change_nm = 400;
        int32_t last_q6 = 160 * 64;
        for (int i = 0; i < 120; i++) {
            TEST_ASSERT_TRUE(commands(sign * 10140, false));
            last_q6 = last_q6 > 0 ? last_q6 - last_q6 / 16 - 1 : 0;
            TEST_ASSERT_EQUAL_INT32(sign * last_q6, command.fading_q6);
            TEST_ASSERT_EQUAL_INT32((sign * (10140 * 64 + last_q6) + 32) >> 6, command.u.nm);
        }
        expect_told(sign * 10140, 0);
    }
}

/// Behind a new fault U is told where its last step leads, as far as step and stroke allow.
static void test_new_fault_tells_the_last_step_within_the_limits(void)
{
    static const int32_t cases[][4] = {// place, step -> place, step
                                       {1000, 200, 1200, 200},
                                       {99900, 200, 100000, 100},
                                       {-99900, -200, -100000, -100}};
    motion.state = cam_state_fault;
    motion.is_playing = false;
    for (size_t i = 0; i < 3u; i++) {
        told(cases[i][0], cases[i][1]);
        r.want.u_set_q6 = 777 * 64;
        command.is_fault = false;
        cam_axis_command_nearest_isr(&command, &cfg, &r, &motion);
        TEST_ASSERT_TRUE(command.is_fault);
        expect_told(cases[i][2], cases[i][3]);
        TEST_ASSERT_EQUAL_INT32((cases[i][2] - 777) * 64, command.fading_q6);
    }
}

/// In state fault the nearest place to what was wanted is told: by the change of step, the step and
/// the stroke, of which the stroke comes last. Beyond it U goes no farther, and back by steps.
static void test_refused_command_is_followed_as_far_as_the_limits_allow(void)
{
    static const int32_t cases[][5] = {
        // place, step, wanted -> place, step
        {0, 0, 5000, 50, 50},
        {0, 0, -5000, -50, -50},
        {0, 990, 5000, 1000, 1000},
        {0, -990, -5000, -1000, -1000},
        {99980, 0, 200000, 100000, 20},
        {-99980, 0, -200000, -100000, -20},
        {300000, 0, 0, 299950, -50},
        {-300000, 0, 0, -299950, 50},
        {300000, 0, 400000, 300000, 0},
        {-300000, 0, -400000, -300000, 0},
        {100100, -990, 0, 99100, -1000},
        {-100100, 990, 0, -99100, 1000},
        {300000, -1000, -300000, 299000, -1000},
    };
    motion.state = cam_state_fault;
    motion.is_playing = false;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        told(cases[i][0], cases[i][1]);
        command.fading_q6 = 0;
        TEST_ASSERT_FALSE(commands(cases[i][2], false));
        cam_axis_command_nearest_isr(&command, &cfg, &r, &motion);
        expect_told(cases[i][3], cases[i][4]);
        TEST_ASSERT_EQUAL_INT32((cases[i][3] - cases[i][2]) * 64, command.fading_q6);
    }
}

/// What a plan makes of an axis, from its speed before. @return the fault
static uint32_t plan(uint32_t axis, int32_t before_q10, int32_t vel_q10, int64_t jump_q10)
{
    const cam_axis_motion_t before[hal_n_axes] = {[hal_axis_x] = {.pos_q10 = 9000, .vel_q10 = 7},
                                                  [hal_axis_z] = {.pos_q10 = 9000, .vel_q10 = 7}};
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        motion.axis[i] = before[i];
        command.vel_q10[i] = before[i].vel_q10;
    }
    motion.is_filtering = true;
    command.vel_q10[axis] = before_q10;
    motion.axis[axis] = (cam_axis_motion_t){.pos_q10 = 9000 + jump_q10, .vel_q10 = vel_q10};
    return cam_axis_command_plan_isr(&command, &cfg, &motion, before);
}

static void test_plan_tells_what_is_within_speed_change_and_place(void)
{
    static const struct {
        int32_t before_q10, vel_q10;
        int64_t jump_q10;
        bool is_told;
    } cases[] = {
        {0, 10240, 0, true},
        {0, 10241, 0, false},
        {0, -10240, 0, true},
        {0, -10241, 0, false},
        {1020000, 1024000, 0, true},
        {1020000, 1024001, 0, false},
        {-1020000, -1024000, 0, true},
        {-1020000, -1024001, 0, false},
        {0, 0, 32, true},
        {0, 0, 33, false},
        {0, 0, -32, true},
        {0, 0, -33, false},
        {0, 0, INT64_MAX / 2, false},
        {2000000, 1999999, 0, true}, // faster than the limit: it may brake
        {2000000, 2000001, 0, false},
        {2000000, 1989759, 0, false}, // ... by no more than the change
        {-2000000, -1999999, 0, true},
        {-2000000, -2000001, 0, false},
        {-2000000, -1989759, 0, false},
    };
    for (uint32_t axis = (uint32_t)hal_axis_x; axis <= (uint32_t)hal_axis_z; axis++) {
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
            const uint32_t faults =
                plan(axis, cases[i].before_q10, cases[i].vel_q10, cases[i].jump_q10);
            const int32_t is_q10 = cases[i].is_told ? cases[i].vel_q10 : 7;
            TEST_ASSERT_EQUAL_HEX32(cases[i].is_told ? 0u : CAM_FAULT_BIT(command), faults);
            TEST_ASSERT_EQUAL_INT32(is_q10, motion.axis[axis].vel_q10);
            TEST_ASSERT_EQUAL_INT32(is_q10, command.vel_q10[axis]);
            TEST_ASSERT_EQUAL_INT32(is_q10 - cases[i].before_q10, motion.change_q10[axis]);
            TEST_ASSERT_TRUE(motion.is_filtering == cases[i].is_told);
        }
    }
}

/// In off X and Z follow what moves them.
static void test_plan_in_off_is_told_as_it_is(void)
{
    motion.state = cam_state_off;
    TEST_ASSERT_EQUAL_HEX32(0, plan(hal_axis_x, 0, INT32_MAX, 1 << 30));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, command.vel_q10[hal_axis_x]);
}

/// U is written in the port's numbers, X and Z rounded down to whole nanometres.
static void test_axes_are_written_in_the_numbers_of_the_port(void)
{
    told(1000, 5);
    motion.u_home_nm = 400;
    motion.axis[hal_axis_x] = (cam_axis_motion_t){.pos_q10 = -1, .vel_q10 = 7, .acc_q10 = 8};
    motion.axis[hal_axis_z] = (cam_axis_motion_t){.pos_q10 = 2047};
    TEST_ASSERT_TRUE(commands(1005, false));
    TEST_ASSERT_EQUAL_INT32(605, r.out[hal_axis_u].pos_nm);
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
    command.vel_q10[hal_axis_x] = INT32_MIN;
    motion.axis[hal_axis_x].vel_q10 = INT32_MIN + 1;
    TEST_ASSERT_EQUAL_HEX32(0, cam_axis_command_plan_isr(&command, &cfg, &motion, before));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN + 1, command.vel_q10[hal_axis_x]);
}
