// SPDX-License-Identifier: Apache-2.0
// What the slow side refuses because the machine cannot do it, before and during motion.
#include "cam_machine.h"
#include "rig_bench.h"

/// In ready the spindle turns, so a value that it must not take is refused at once.
static void test_ready_refuses_what_the_spindle_or_u_cannot_do(void)
{
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_err_u_retract,
                          fixture_rig_set(&rig, cam_param_u_retract_nm, -15000000));
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed,
                          fixture_rig_set(&rig, cam_param_spindle_mrpm, 30000000));
    set(cam_param_spindle_mrpm, 2600000);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed,
                          fixture_rig_set(&rig, cam_param_spindle_limit_mrpm, 2500000));
    set(cam_param_spindle_mrpm, 0);
    set(cam_param_spindle_limit_mrpm, 2550000);
    fixture_part_t fast = part;
    fast.spindle_mrpm = 2600000;
    static fixture_image_t image;
    fixture_image_make(&image, &fast);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed,
                          cam_machine_select_table(&rig.machine, image.bytes, image.size));
    fixture_rig_ticks(&rig, 3);
    TEST_ASSERT_EQUAL_INT32(2500000, hal_host.out.spindle_mrpm);
}

static void test_start_beyond_the_limits_is_refused_before_motion(void)
{
    set(cam_param_spindle_mrpm, 3500000);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed, cam_machine_enable(&rig.machine));
    const cam_feasibility_t why = cam_machine_feasibility(&rig.machine, 0);
    TEST_ASSERT_EQUAL_INT64(3500000, why.needed);
    TEST_ASSERT_EQUAL_INT64(3000000, why.limit);
    TEST_ASSERT_EQUAL_UINT32(3000000, why.highest_mrpm);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed, cam_machine_check_speed(&rig.machine, 0));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_check_speed(&rig.machine, why.highest_mrpm));
    TEST_ASSERT_EQUAL_UINT32(why.highest_mrpm, cam_machine_highest_mrpm(&rig.machine));
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
}

static void test_amplitude_that_the_running_speed_forbids_is_refused_in_the_cut(void)
{
    set(cam_param_u_acceleration_mm_per_s2, 21000);
    bring(cam_state_cutting); // needs 20 600 at amplitude 1
    TEST_ASSERT_EQUAL_INT(cam_err_u_acceleration,
                          cam_machine_set_param(&rig.machine, cam_param_amplitude_ppm, 1100000));
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_set_param(&rig.machine, cam_param_amplitude_ppm, 900000));
}

/// With less than its whole lift a lobe would be cut deeper than drawn.
static void test_lobe_is_cut_with_all_of_its_lift_or_not_at_all(void)
{
    part = fixture_part_swung();
    part.spindle_mrpm = 2500000;
    fixture_rig_init(&rig, &part, 20000);
    const int32_t most = 100000000; // of both, as the rig's spindle is fast
    set(cam_param_swing_speed_mdeg_per_s, most);
    set(cam_param_swing_acceleration_deg_per_s2, most);
    set(cam_param_u_retract_nm, -300000);
    set(cam_param_amplitude_ppm, 999999);
    TEST_ASSERT_EQUAL_INT(cam_err_cam_amplitude, cam_machine_enable(&rig.machine));
    const cam_feasibility_t why = cam_machine_feasibility(&rig.machine, 0);
    TEST_ASSERT_EQUAL_INT64(1000000, why.needed);
    TEST_ASSERT_EQUAL_INT64(999999, why.limit);
    TEST_ASSERT_EQUAL_UINT32(0, why.highest_mrpm);
    set(cam_param_amplitude_ppm, 0);
    TEST_ASSERT_EQUAL_INT(cam_err_cam_amplitude, cam_machine_enable(&rig.machine));
    set(cam_param_amplitude_ppm, 1000000);
    bring(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT(cam_err_cam_amplitude,
                          cam_machine_set_param(&rig.machine, cam_param_amplitude_ppm, 999999));
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_set_param(&rig.machine, cam_param_amplitude_ppm, 1100000));
}

/// The ramps of a ring-helix are made for one speed. Another speed is judged anew, and is never
/// taken during a cut.
static void test_ring_helix_allows_only_speeds_that_z_can_follow(void)
{
    part.is_ring_helix = true;
    fixture_rig_init(&rig, &part, 20000);
    set(cam_param_z_acceleration_mm_per_s2, 800);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    const cam_feasibility_t f = cam_machine_feasibility(&rig.machine, 0);
    TEST_ASSERT_UINT32_WITHIN(2000, 2683000, f.highest_mrpm); // sqrt(800 / 0.4) turns per second
    TEST_ASSERT_EQUAL_INT(cam_err_z_acceleration,
                          fixture_rig_set(&rig, cam_param_spindle_mrpm, 2700000));
    TEST_ASSERT_EQUAL_INT(cam_err_z_acceleration, fixture_rig_set(&rig, cam_param_feed_nm, 200000));
    set(cam_param_spindle_mrpm, (int32_t)f.highest_mrpm);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_cutting, 60000));
    TEST_ASSERT_EQUAL_INT(cam_err_param_state,
                          fixture_rig_set(&rig, cam_param_spindle_mrpm, 1000000));
}
