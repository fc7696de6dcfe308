// SPDX-License-Identifier: Apache-2.0
// A start with a spindle that does not turn steadily: it waits, and gives up as by stop.
#include "cam_log_text.h"
#include "rig_bench.h"

/// Let the spindle gain or lose a share per tick for n ticks, with rare rounds of the main loop.
static void turn(double share, uint32_t n)
{
    rig.lathe.is_spindle_held = true;
    for (uint32_t i = 0; i < n; i++) {
        rig.lathe.rpm *= 1.0 + share;
        fixture_rig_tick(&rig);
        if (i % 100u == 0u) {
            cam_machine_poll(&rig.machine);
        }
    }
}

/// A start whose spindle falls from 2500 r/min by 0.6 % per turn, which takes 480 ticks.
static void start_unsteady(void)
{
    bring(cam_state_ready);
    set(cam_param_ripple_turns, 0);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    turn(-0.006 / 480, 60000);
}

static void test_cut_begins_once_the_spindle_is_steady(void)
{
    start_unsteady();
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, fixture_rig_state());
    TEST_ASSERT_FALSE(g_cam.motion.is_playing);
    TEST_ASSERT_GREATER_THAN_UINT32(10000, fixture_rig_status(&rig).steady.waited_ticks);
    const double ticks_per_turn = 20000 * 60 / (rig.lathe.rpm > 0 ? rig.lathe.rpm : -rig.lathe.rpm);
    turn(0, (uint32_t)(3.5 * ticks_per_turn)); // the turn in progress, two that agree, a plan
    TEST_ASSERT_TRUE(g_cam.motion.is_playing);
    TEST_ASSERT_FALSE(rig.machine.is_unsteady);
    TEST_ASSERT_EQUAL_UINT32(0, fixture_rig_status(&rig).steady.waited_ticks);
}

static void test_start_ends_without_a_steady_spindle(void)
{
    set(cam_param_stopped_ms, 20); // so the patience is 2 s
    start_unsteady();
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, fixture_rig_state());
    TEST_ASSERT_FALSE(rig.machine.is_unsteady);
    turn(-0.006 / 480, 20000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    TEST_ASSERT_TRUE(rig.machine.is_unsteady);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    TEST_ASSERT_EQUAL_UINT32(0, rig.machine.n_parts); // the pass is repeated
    TEST_ASSERT_TRUE(rig.machine.is_cut_short);
    turn(0, 2000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    TEST_ASSERT_FALSE(rig.machine.is_unsteady);
    turn(0, 20000);
    TEST_ASSERT_TRUE(g_cam.motion.is_playing);
}

/// A slow spindle is given the time of its turns: 10 r/min, 6 s each.
static void test_slow_spindle_has_time_for_its_turns(void)
{
    set(cam_param_stopped_ms, 10);
    bring(cam_state_ready);
    turn(-5.521461 / 6000, 6000); // to 1/250
    set(cam_param_ripple_turns, 0);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    turn(0, 200000); // 10 s, and the patience is 1 s
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, fixture_rig_state());
    turn(0, 120000);
    TEST_ASSERT_TRUE(g_cam.motion.is_playing);
}

static void test_ripple_is_learned_before_a_cut_without_rehearsal(void)
{
    static const struct {
        int32_t ripple, rehearse;
        uint32_t turns;
    } cases[] = {{0, 0, 1}, {8, 0, 16}, {8, 40, 1}, {1, 0, 9}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        set(cam_param_rehearse_turns, cases[i].rehearse);
        set(cam_param_ripple_turns, cases[i].ripple);
        TEST_ASSERT_EQUAL_UINT32(cases[i].turns,
                                 atomic_load(&g_cam.config.offered)->play.steady_turns);
    }
    rig.machine.ilc.ripple.n_mean = 2; // known from an earlier part
    set(cam_param_ripple_turns, 8);
    TEST_ASSERT_EQUAL_UINT32(16, atomic_load(&g_cam.config.offered)->play.steady_turns);
    rig.machine.ilc.blending = 0; // it is in force
    set(cam_param_rehearse_turns, 0);
    TEST_ASSERT_EQUAL_UINT32(1, atomic_load(&g_cam.config.offered)->play.steady_turns);
}
