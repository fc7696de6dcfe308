// SPDX-License-Identifier: Apache-2.0
// Hold, overrides and trim as commands: states, refusals, what is kept and what is forgotten.
#include "cam_machine.h"
#include "rig_bench.h"

/// While the feed is held the axes follow the table as in the cut: nothing is switched off.
static void test_disable_and_a_start_do_not_fit_a_hold(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    until(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_disable(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    until(cam_state_holding);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_disable(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_start(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_home(&rig.machine));
    fixture_rig_ticks(&rig, 100);
    TEST_ASSERT_EQUAL_INT(cam_state_holding, fixture_rig_state());
}

/// A rate that the interrupt does not know yet goes with the next configuration, whatever it was
/// made for.
static void test_rate_that_is_due_goes_with_any_configuration(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    rig.machine.is_rate_due = true;
    set(cam_param_phase_udeg, 1000);
    TEST_ASSERT_FALSE(rig.machine.is_rate_due);
}

static void test_hold_needs_a_cut_and_resume_a_hold(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_hold(&rig.machine));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_hold(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    until(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_resume(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    until(cam_state_holding);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_resume(&rig.machine));
    until(cam_state_cutting);
    until(cam_state_ready);
    TEST_ASSERT_EQUAL_UINT32(1, rig.machine.n_parts);
}

static void test_hold_is_forgotten_when_the_cut_ends(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    until(cam_state_holding);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    until(cam_state_ready);
    fixture_rig_tick(&rig);
    cam_machine_poll(&rig.machine);
    TEST_ASSERT_FALSE(rig.machine.is_held);
    TEST_ASSERT_EQUAL_UINT32(0, rig.machine.n_parts); // it was cut short
    fixture_rig_tick(&rig);
    cam_machine_poll(&rig.machine);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    until(cam_state_cutting);
    until(cam_state_ready);
    TEST_ASSERT_EQUAL_UINT32(1, rig.machine.n_parts);
}

/// While the interrupt has not taken the last configuration, a hold waits and is not lost.
static void test_hold_is_handed_over_as_soon_as_there_is_room(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(&rig.machine, cam_param_phase_udeg, 5));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    TEST_ASSERT_TRUE(rig.machine.is_rate_due);
    until(cam_state_holding);
    TEST_ASSERT_FALSE(rig.machine.is_rate_due);
}

static void test_changes_in_the_cut_are_bounded(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    const int32_t limit_nm = rig.machine.params.x_trim_limit_nm;
    TEST_ASSERT_EQUAL_INT(cam_err_trim_limit,
                          cam_machine_set_param(&rig.machine, cam_param_x_trim_nm, -limit_nm - 1));
    TEST_ASSERT_EQUAL_INT64(limit_nm + 1, rig.machine.refusal.why.needed);
    TEST_ASSERT_EQUAL_INT(cam_err_trim_limit, rig.machine.refusal.why.err);
    TEST_ASSERT_EQUAL_INT(cam_param_x_trim_nm, rig.machine.refusal.param);
    TEST_ASSERT_EQUAL_INT64(limit_nm, rig.machine.refusal.why.limit);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_set_param(&rig.machine, cam_param_x_trim_nm, -limit_nm));
    fixture_rig_tick(&rig);
    // 2500 r/min by 1.2 is the limit of the spindle, which a lower one makes too much
    TEST_ASSERT_EQUAL_INT(
        cam_ok, cam_machine_set_param(&rig.machine, cam_param_spindle_override_ppm, 1100000));
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_param_state,
                          cam_machine_set_param(&rig.machine, cam_param_feed_nm, 100000));
    TEST_ASSERT_EQUAL_INT(
        cam_err_param_range,
        cam_machine_set_param(&rig.machine, cam_param_feed_override_ppm, 1500001));
}

static void test_an_infeasible_override_is_refused_with_numbers(void)
{
    rig.machine.params.spindle_limit_mrpm = 2600000;
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    TEST_ASSERT_EQUAL_INT(
        cam_err_spindle_speed,
        cam_machine_set_param(&rig.machine, cam_param_spindle_override_ppm, 1050000));
    TEST_ASSERT_EQUAL_INT64(2625000, rig.machine.refusal.why.needed);
    TEST_ASSERT_EQUAL_INT64(2600000, rig.machine.refusal.why.limit);
    TEST_ASSERT_EQUAL_INT32(1000000, rig.machine.params.spindle_override_ppm);
}

static void test_a_ring_helix_has_its_own_feed_or_none(void)
{
    part.is_ring_helix = true;
    fixture_rig_init(&rig, &part, 20000);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    TEST_ASSERT_EQUAL_INT(cam_err_override_rings,
                          cam_machine_set_param(&rig.machine, cam_param_feed_override_ppm, 900000));
    TEST_ASSERT_EQUAL_INT( // Z would exceed its acceleration by the square of that
        cam_err_override_rings,
        cam_machine_set_param(&rig.machine, cam_param_spindle_override_ppm, 1100000));
    set(cam_param_spindle_override_ppm, 900000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_hold(&rig.machine));
    until(cam_state_holding);
}

static void test_parts_are_set_from_0_on(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_param_range, cam_machine_set_parts(&rig.machine, -1));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_parts(&rig.machine, INT32_MAX));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_parts(&rig.machine, 0));
    TEST_ASSERT_EQUAL_UINT32(0, rig.machine.n_parts);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_parts(&rig.machine, 41));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    until(cam_state_ready);
    TEST_ASSERT_EQUAL_UINT32(42, rig.machine.n_parts);
}
