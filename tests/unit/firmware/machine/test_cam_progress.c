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
static int32_t position(void)
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
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    step();
}

/// What is read in this tick comes true within a plan, and what is left only falls.
static void expect_true_end(void)
{
    const int32_t from = position();
    const cam_progress_t first = now();
    TEST_ASSERT_TRUE(first.has_end);
    int32_t last_left = turns(first.left_q32) + 1;
    while (g_cam.motion.state != cam_state_ready) {
        const cam_progress_t p = now();
        const int32_t left = turns(p.left_q32);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(last_left, left);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(turns(p.whole_q32), left);
        last_left = left;
        fixture_rig_ticks(&rig, 7); // of a plan of eight
        cam_machine_poll(&rig.machine);
    }
    TEST_ASSERT_INT32_WITHIN(30, turns(first.left_q32), position() - from);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(50, last_left);
}

static void start_cut(void)
{
    start();
    until(cam_state_cutting);
}

static void hold(void)
{
    start_cut();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    until(cam_state_holding);
}

static void stop(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    steps(20);
    expect_true_end();
}

/// With a plain helix and with rings, and with overrides of the feed.
static void test_a_cut_ends_where_it_should(void)
{
    static const struct {
        bool is_ring_helix;
        int32_t override_ppm;
    } cases[] = {{false, 1000000}, {true, 1000000}, {false, 500000}, {false, 1500000}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        part.is_ring_helix = cases[i].is_ring_helix;
        fixture_rig_init(&rig, &part, 20000);
        set(cam_param_feed_override_ppm, cases[i].override_ppm);
        start();
        const int32_t whole = turns(now().whole_q32);
        until(cam_state_cutting);
        TEST_ASSERT_INT32_WITHIN(whole / 1000, whole, turns(now().whole_q32));
        expect_true_end();
    }
}

static void test_before_the_cut_the_whole_of_it_is_left(void)
{
    bring(cam_state_ready);
    const int32_t due = turns(now().left_q32);
    TEST_ASSERT_EQUAL_INT64(now().left_q32, now().whole_q32);
    set(cam_param_feed_override_ppm, 0); // a hold, which counts as the full rate
    TEST_ASSERT_EQUAL_INT32(due, turns(now().left_q32));
    set(cam_param_feed_override_ppm, 1000000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    until(cam_state_engaging);
    TEST_ASSERT_INT32_WITHIN(1, due, turns(now().left_q32)); // while the axes approach
    while (turns(now().left_q32) > due - 1) {
        wait();
    }
    TEST_ASSERT_INT32_WITHIN(1, due, turns(now().whole_q32));
    expect_true_end();
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

/// What is left stands still while Z does, and comes true once it goes on, rings or not.
static void test_a_hold_counts_as_if_it_were_resumed_at_once(void)
{
    for (int i = 0; i < 2; i++) {
        part.is_ring_helix = i == 1;
        fixture_rig_init(&rig, &part, 20000);
        hold();
        int32_t left[2];
        for (int k = 0; k < 2; k++) {
            for (int n = 0; n < 625; n++) {
                wait();
            }
            left[k] = turns(now().left_q32);
        }
        TEST_ASSERT_INT32_WITHIN(1, left[0], left[1]);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_resume(&rig.machine));
        const int32_t from = position();
        until(cam_state_ready);
        // it waits for a whole turn
        TEST_ASSERT_INT32_WITHIN(1100, left[0] + 1000, position() - from);
    }
}

/// Of the cut and of a hold, which is not resumed then.
static void test_a_stop_brings_the_end_near(void)
{
    start_cut();
    const int32_t before = turns(now().left_q32);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    steps(21);
    TEST_ASSERT_LESS_THAN_INT32(before - 1000, turns(now().left_q32));
    expect_true_end();
    setUp();
    hold();
    steps(1000);
    stop();
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
    expect_select(cam_ok);
    TEST_ASSERT_EQUAL_UINT32(0, now().mrpm);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_UINT32(2500000, now().mrpm);
}

/// A hold that was asked for before the rehearsal is one of the cut after it. After a rehearsal
/// that was stopped there is no cut.
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
    const int32_t from = position();
    until(cam_state_engaging);
    TEST_ASSERT_INT32_WITHIN(50, left - turns(now().left_q32), position() - from);
    setUp();
    set(cam_param_rehearse_turns, 1000);
    start();
    while (!g_cam.motion.is_playing || g_cam.motion.scale_q30 < 1 << 29) {
        wait();
    }
    stop();
}

/// A measured Z has an end once it is stopped, and a spindle of the other sense the same speed.
static void test_a_measured_z_has_an_end_once_it_is_stopped(void)
{
    part.direction = -1;
    fixture_rig_init(&rig, &part, 20000);
    TEST_ASSERT_EQUAL_UINT32(2500000, now().mrpm);
    set(cam_param_z_is_measured, 1);
    TEST_ASSERT_FALSE(now().has_end);
    TEST_ASSERT_EQUAL_INT64(0, now().left_q32);
    rig.lathe.is_held[hal_axis_z] = true;
    start_cut();
    steps(20);
    TEST_ASSERT_FALSE(now().has_end);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    until(cam_state_disengaging);
    expect_true_end();
}
