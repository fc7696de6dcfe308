// SPDX-License-Identifier: Apache-2.0
// Limits that change while axes move or stand beyond them: no axis leaps, none moves on for ever.
#include "jog_bench.h"

/// Jog an axis for 2000 ticks; it still moves.
static void jog(hal_axis_t axis, int32_t um_per_s)
{
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(machine(), axis, um_per_s).err);
    for (uint32_t i = 0; i < 10u; i++) {
        fixture_rig_ticks(&rig, 200);
        cam_machine_keep_alive(machine());
    }
}

/// They brake with a quarter of their 2 m/s2, that is by 10 nm per tick from plan to plan.
static void test_x_and_z_brake_to_a_lower_limit(void)
{
    static const cam_param_id_t limits[hal_n_axes] = {
        [hal_axis_x] = cam_param_x_speed_um_per_s, [hal_axis_z] = cam_param_z_speed_um_per_s};
    for (uint32_t axis = (uint32_t)hal_axis_x; axis <= (uint32_t)hal_axis_z; axis++) {
        for (int32_t sense = -1; sense <= 1; sense += 2) {
            setUp();
            jog((hal_axis_t)axis, 10000 * sense);
            set(limits[axis], 1000);
            motion_t seen = motion_of((hal_axis_t)axis);
            seen.step_nm = 500 * sense;
            for (uint32_t i = 0; i < 2000u; i++) {
                fixture_rig_tick(&rig);
                watch(&seen, (hal_axis_t)axis);
            }
            TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
            TEST_ASSERT_LESS_OR_EQUAL_INT32(50, labs((long)seen.step_nm));
            TEST_ASSERT_LESS_OR_EQUAL_INT32(11, seen.most_change_nm);
        }
    }
}

/// The stroke ends no nearer than where U stands; in off it may, and enabling is refused then.
static void test_stroke_keeps_where_u_stands(void)
{
    static const int32_t places_nm[] = {-200000, 200000};
    for (size_t i = 0; i < 2u; i++) {
        setUp();
        to_manual();
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_step(machine(), hal_axis_u, places_nm[i]).err);
        TEST_ASSERT_EQUAL_INT(cam_jog_done, until_rest());
        TEST_ASSERT_EQUAL_INT32(places_nm[i], port_nm(hal_axis_u));
        TEST_ASSERT_EQUAL_INT(cam_err_u_place,
                              cam_machine_set_param(machine(), cam_param_u_stroke_nm, 399998));
        TEST_ASSERT_EQUAL_INT(cam_param_u_stroke_nm, machine()->refusal.param);
        TEST_ASSERT_EQUAL_INT64(200000, machine()->refusal.why.needed);
        TEST_ASSERT_EQUAL_INT64(199999, machine()->refusal.why.limit);
        set(cam_param_u_stroke_nm, 400000);
        fixture_rig_ticks(&rig, 100);
        TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
        TEST_ASSERT_EQUAL_INT32(places_nm[i], port_nm(hal_axis_u));
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(machine()));
        fixture_rig_ticks(&rig, 20);
        set(cam_param_u_stroke_nm, 300000);
        TEST_ASSERT_EQUAL_INT(cam_err_u_place, cam_machine_manual(machine()));
    }
}
