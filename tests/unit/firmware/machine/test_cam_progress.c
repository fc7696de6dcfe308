// SPDX-License-Identifier: Apache-2.0
// Turns of a pass that are left, against those that the spindle then really makes.
#include "cam_machine.h"
#include "rig_bench.h"

/// @return [turn / 1000] rounded down
static int32_t turns(int64_t turns_q32)
{
    return (int32_t)((turns_q32 >> 8) * 1000 >> 24);
}

static cam_progress_t now(void)
{
    return cam_progress(&rig.machine);
}

/// @return [turn / 1000] where the spindle is
static int32_t place(void)
{
    return turns(fixture_rig_status(&rig).pos_q32);
}

static void step(void)
{
    fixture_rig_tick(&rig);
    cam_machine_poll(&rig.machine);
}

static void steps(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        step();
    }
}

/// As long as nothing happens the main loop is slower than the ticks.
static void wait(void)
{
    fixture_rig_ticks(&rig, 7);
    step();
}

static void start(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    step();
}

/// What is told in this tick comes true within a plan, and what is left only falls.
static void expect_true_end(void)
{
    const int32_t from = place();
    const cam_progress_t told = now();
    TEST_ASSERT_TRUE(told.has_end);
    int32_t last_left = turns(told.left_q32) + 1;
    while (g_cam.motion.state != cam_state_ready) {
        const cam_progress_t p = now();
        const int32_t left = turns(p.left_q32);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(last_left, left);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(turns(p.whole_q32), left);
        last_left = left;
        fixture_rig_ticks(&rig, 7); // of a plan of eight
        cam_machine_poll(&rig.machine);
    }
    TEST_ASSERT_INT32_WITHIN(30, turns(told.left_q32), place() - from);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(50, last_left);
}

static void test_a_cut_ends_where_it_is_told(void)
{
    start();
    until(cam_state_cutting);
    expect_true_end();
}

static void test_before_the_cut_the_whole_of_it_is_told(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    const int32_t told = turns(now().left_q32);
    TEST_ASSERT_EQUAL_INT32(told, turns(now().whole_q32));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    until(cam_state_engaging);
    TEST_ASSERT_INT32_WITHIN(1, told, turns(now().left_q32)); // while the axes approach
    while (turns(now().left_q32) > told - 1) {
        wait();
    }
    TEST_ASSERT_INT32_WITHIN(1, told, turns(now().whole_q32));
    expect_true_end();
}

static void test_an_override_is_in_it(void)
{
    static const int32_t ppm[] = {500000, 1500000};
    for (uint32_t i = 0; i < sizeof ppm / sizeof ppm[0]; i++) {
        setUp();
        set(cam_param_feed_override_ppm, ppm[i]);
        start();
        const int32_t whole = turns(now().whole_q32);
        until(cam_state_cutting);
        TEST_ASSERT_INT32_WITHIN(whole / 1000, whole, turns(now().whole_q32));
        expect_true_end();
    }
}

static void test_a_rehearsal_is_in_it(void)
{
    set(cam_param_rehearse_turns, 20);
    start();
    TEST_ASSERT_EQUAL_INT(cam_state_rehearsing, fixture_rig_state());
    const int32_t whole = turns(now().whole_q32);
    TEST_ASSERT_EQUAL_INT32(whole, turns(now().left_q32));
    until(cam_state_engaging);
    TEST_ASSERT_INT32_WITHIN(2, whole, turns(now().whole_q32));
    TEST_ASSERT_LESS_THAN_INT32(whole - 20000, turns(now().left_q32));
    until(cam_state_cutting);
    TEST_ASSERT_INT32_WITHIN(2, whole, turns(now().whole_q32));
    expect_true_end();
}

/// What is left stands still while Z does, and comes true once it goes on.
static void test_a_hold_counts_as_if_it_were_resumed_at_once(void)
{
    start();
    until(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    until(cam_state_holding);
    for (int i = 0; i < 625; i++) {
        wait();
    }
    const int32_t left = turns(now().left_q32);
    for (int i = 0; i < 625; i++) {
        wait();
    }
    TEST_ASSERT_INT32_WITHIN(1, left, turns(now().left_q32));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_resume(&rig.machine));
    const int32_t from = place();
    until(cam_state_ready);
    TEST_ASSERT_INT32_WITHIN(1100, left + 1000, place() - from); // it waits for a whole turn
}

static void test_a_stop_brings_the_end_near(void)
{
    start();
    until(cam_state_cutting);
    const int32_t before = turns(now().left_q32);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    steps(21);
    TEST_ASSERT_LESS_THAN_INT32(before - 1000, turns(now().left_q32));
    expect_true_end();
}

static void test_rings_end_where_they_are_told(void)
{
    part.is_ring_helix = true;
    fixture_rig_init(&rig, &part, 20000);
    start();
    until(cam_state_cutting);
    expect_true_end();
}

static void test_a_measured_z_has_no_end_before_its_stop(void)
{
    set(cam_param_z_is_measured, 1);
    TEST_ASSERT_FALSE(now().has_end);
    TEST_ASSERT_EQUAL_INT64(0, now().left_q32);
}

/// A table that the interrupt has not taken yet does not count.
static void test_the_speed_is_that_of_the_pass_with_its_override(void)
{
    TEST_ASSERT_EQUAL_UINT32(2500000, now().mrpm);
    set(cam_param_spindle_override_ppm, 800000);
    TEST_ASSERT_UINT32_WITHIN(1, 2000000, now().mrpm);
    rig.machine.has_table = false;
    TEST_ASSERT_FALSE(now().has_end);
    TEST_ASSERT_EQUAL_UINT32(0, now().mrpm);
    cam_machine_init(&rig.machine, &g_cam, 20000, 200000000);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_select_table(&rig.machine, rig.image.bytes, rig.image.size));
    TEST_ASSERT_EQUAL_UINT32(0, now().mrpm);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_UINT32(2500000, now().mrpm);
}

/// What is stopped is not resumed: the end of a hold is near, and told.
static void test_a_stop_of_a_hold_ends_it(void)
{
    start();
    until(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    until(cam_state_holding);
    steps(1000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    steps(20);
    expect_true_end();
}

/// A hold that was asked for before the rehearsal is one of the cut behind it.
static void test_a_rehearsal_is_not_held(void)
{
    set(cam_param_rehearse_turns, 3);
    start();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    while (!g_cam.motion.is_playing) {
        wait();
    }
    TEST_ASSERT_EQUAL_INT(cam_state_rehearsing, fixture_rig_state());
    const int32_t left = turns(now().left_q32);
    const int32_t from = place();
    until(cam_state_engaging);
    TEST_ASSERT_INT32_WITHIN(50, left - turns(now().left_q32), place() - from);
}

/// Behind a rehearsal that was stopped there is no cut.
static void test_a_stopped_rehearsal_is_followed_by_nothing(void)
{
    set(cam_param_rehearse_turns, 1000);
    start();
    while (!g_cam.motion.is_playing || g_cam.motion.scale_q30 < 1 << 29) {
        wait();
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    steps(20);
    expect_true_end();
}

/// A measured Z has an end once it is stopped, and a spindle of the other sense the same speed.
static void test_the_other_sense_and_a_stopped_z_are_told(void)
{
    part.direction = -1;
    fixture_rig_init(&rig, &part, 20000);
    TEST_ASSERT_EQUAL_UINT32(2500000, now().mrpm);
    set(cam_param_z_is_measured, 1);
    rig.lathe.is_held[hal_axis_z] = true;
    start();
    until(cam_state_cutting);
    steps(20);
    TEST_ASSERT_FALSE(now().has_end);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    until(cam_state_disengaging);
    expect_true_end();
}
