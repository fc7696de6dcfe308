// SPDX-License-Identifier: Apache-2.0
// Axes by hand in whole ticks: jog, step, dead man, limits of motion, disable and faults.
#include "fixture_random.h"
#include "jog_bench.h"

static void jog(hal_axis_t axis, int32_t um_per_s)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(&rig.machine, axis, um_per_s).err);
    fixture_rig_tick(&rig);
}

static bool is_between(int32_t v, int32_t low, int32_t high)
{
    return v >= low && v <= high;
}

static void test_manual_holds_all_axes_and_the_spindle(void)
{
    hal_host.in.axis_nm[hal_axis_x] = 50 * mm;
    hal_host.in.axis_nm[hal_axis_z] = -7 * mm;
    hal_host.in.axis_nm[hal_axis_u] = 123456;
    fixture_rig_ticks(&rig, 20);
    to_manual();
    fixture_rig_ticks(&rig, 3000);
    TEST_ASSERT_EQUAL_INT32(50 * mm, port_nm(hal_axis_x));
    TEST_ASSERT_EQUAL_INT32(-7 * mm, port_nm(hal_axis_z));
    TEST_ASSERT_EQUAL_INT32(123456, port_nm(hal_axis_u));
    TEST_ASSERT_EQUAL_INT32(0, hal_host.out.spindle_mrpm);
    TEST_ASSERT_EQUAL_HEX32(hal_out_enable, hal_host.out.outputs);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&rig.machine));
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    TEST_ASSERT_EQUAL_HEX32(0, hal_host.out.outputs);
}

/// The slow side hangs: nothing but ticks. The axis has stopped when the order is too old and the
/// axis has braked.
static void test_jog_without_its_commander_stops_by_the_interrupt_alone(void)
{
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        setUp();
        to_manual();
        const hal_axis_t axis = (hal_axis_t)i;
        jog(axis, 1000);
        const uint32_t n_moving = patience_ticks - 2u * 8u;
        fixture_rig_ticks(&rig, n_moving);
        TEST_ASSERT_EQUAL_INT(cam_jog_runs, jog_state().end);
        TEST_ASSERT_INT32_WITHIN(1, 50, hal_host.out.axis[axis].vel_q10 / 1024);
        fixture_rig_ticks(&rig, 40 + 400); // 1 mm/s, braked by 0.5 m/s2 in 2 ms
        const int32_t at_nm = port_nm(axis);
        TEST_ASSERT_EQUAL_INT(cam_jog_silent, jog_state().end);
        TEST_ASSERT_INT32_WITHIN(4000, 250000, at_nm);
        fixture_rig_ticks(&rig, 5000);
        TEST_ASSERT_EQUAL_INT32(at_nm, port_nm(axis));
        TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
    }
}

static void test_jog_repeated_in_time_goes_on_at_its_speed(void)
{
    to_manual();
    jog(hal_axis_z, -5000);
    fixture_rig_ticks(&rig, 1000);
    const int32_t from_nm = port_nm(hal_axis_z);
    for (int i = 0; i < 10; i++) {
        jog(hal_axis_z, -5000);
        fixture_rig_ticks(&rig, 1999);
    }
    TEST_ASSERT_INT32_WITHIN(1000, from_nm - 5 * mm, port_nm(hal_axis_z));
}

/// A stop, and a jog of another axis, brake what moves.
static void test_another_order_brakes_the_axis_of_the_last(void)
{
    to_manual();
    jog(hal_axis_x, 10000);
    fixture_rig_ticks(&rig, 1000);
    jog(hal_axis_z, 10000);
    fixture_rig_ticks(&rig, 1000);
    TEST_ASSERT_EQUAL_INT32(0, hal_host.out.axis[hal_axis_x].vel_q10);
    TEST_ASSERT_GREATER_THAN_INT32(0, hal_host.out.axis[hal_axis_z].vel_q10);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    fixture_rig_ticks(&rig, 1000);
    TEST_ASSERT_EQUAL_INT32(0, hal_host.out.axis[hal_axis_z].vel_q10);
    TEST_ASSERT_EQUAL_INT(cam_jog_stopped, jog_state().end);
}

static void test_step_ends_where_it_was_ordered_to(void)
{
    static const int32_t steps_nm[] = {100000, -1, 12345, -3 * mm, 1};
    to_manual();
    for (uint32_t i = 0; i < 5u; i++) {
        const int32_t from_nm = port_nm(hal_axis_x);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_step(&rig.machine, hal_axis_x, steps_nm[i]).err);
        TEST_ASSERT_EQUAL_INT(cam_jog_done, until_rest());
        TEST_ASSERT_EQUAL_INT32(from_nm + steps_nm[i], port_nm(hal_axis_x));
    }
}

/// An order that comes too late finds no home.
static void test_order_that_is_already_too_old_is_not_begun(void)
{
    set(cam_param_x_home, 1);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, hal_axis_x));
    cam_config_t *config = (cam_config_t *)(uintptr_t)g_cam.config.offered;
    config->play.jog.order.until = fixture_rig_status(&rig).tick - 1u;
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_jog_silent, jog_state().end);
    TEST_ASSERT_EQUAL_HEX32(0, jog_state().homed);
}

/// Jogs, reversals, stops and steps of all axes at random, with limits of travel: speed and
/// acceleration stay within the axis's gentle limits, travel within its limits, and no fault comes.
static void test_random_orders_stay_within_speed_acceleration_and_travel(void)
{
    set(cam_param_x_low_nm, -2 * mm);
    set(cam_param_x_high_nm, 3 * mm);
    set(cam_param_z_low_nm, -1 * mm);
    set(cam_param_z_high_nm, 1 * mm);
    to_manual();
    const int32_t low_nm[] = {-600000, -2 * mm, -mm};
    const int32_t high_nm[] = {600000, 3 * mm, mm};
    const int32_t most_um_per_s[] = {2000, 10000, 10000};
    motion_t motion[hal_n_axes];
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        motion[i] = motion_of((hal_axis_t)i);
    }
    fixture_random_t random = {.state = 77};
    for (int n = 0; n < 400; n++) {
        const uint32_t axis = fixture_random_u32(&random) % (uint32_t)hal_n_axes;
        const uint32_t span = 2u * (uint32_t)most_um_per_s[axis] + 1u;
        const int32_t um_per_s =
            (int32_t)(fixture_random_u32(&random) % span) - most_um_per_s[axis];
        (void)cam_machine_jog(&rig.machine, (hal_axis_t)axis, um_per_s);
        if (n % 5 == 0) {
            (void)cam_machine_step(&rig.machine, (hal_axis_t)axis, um_per_s * 100);
        }
        const uint32_t ticks = 1u + fixture_random_u32(&random) % 1500u;
        for (uint32_t k = 0; k < ticks; k++) {
            fixture_rig_tick(&rig);
            for (uint32_t i = 0; i < hal_n_axes; i++) {
                watch(&motion[i], (hal_axis_t)i);
                TEST_ASSERT_TRUE(motion[i].last_nm >= low_nm[i] && motion[i].last_nm <= high_nm[i]);
            }
        }
    }
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
    // 2 mm/s and 10 mm/s are 100 and 500 nm per tick. X and Z change their speed once per plan by
    // 0.5 m/s2 times 0.4 ms, 10 nm per tick, U by a quarter of 250 m/s2 in one tick, 156 nm per
    // tick; a step is rounded to whole nanometres, and has the rest of a division by eight.
    TEST_ASSERT_TRUE(is_between(motion[hal_axis_u].most_step_nm, 80, 103));
    TEST_ASSERT_TRUE(is_between(motion[hal_axis_x].most_step_nm, 400, 503));
    TEST_ASSERT_TRUE(is_between(motion[hal_axis_z].most_step_nm, 400, 503));
    TEST_ASSERT_LESS_OR_EQUAL_INT32(159, motion[hal_axis_u].most_change_nm);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(13, motion[hal_axis_x].most_change_nm);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(13, motion[hal_axis_z].most_change_nm);
}

static void test_jog_to_the_limit_rests_there_and_comes_back(void)
{
    set(cam_param_z_low_nm, -mm);
    set(cam_param_z_high_nm, mm);
    to_manual();
    for (int i = 0; i < 10; i++) {
        jog(hal_axis_z, 10000);
        fixture_rig_ticks(&rig, 500);
    }
    TEST_ASSERT_EQUAL_INT(cam_jog_limit, jog_state().end);
    TEST_ASSERT_INT32_WITHIN(20, mm, port_nm(hal_axis_z));
    TEST_ASSERT_LESS_OR_EQUAL_INT32(mm, port_nm(hal_axis_z));
    jog(hal_axis_z, -10000);
    fixture_rig_ticks(&rig, 1000);
    TEST_ASSERT_LESS_THAN_INT32(mm - 100000, port_nm(hal_axis_z));
}

/// The command of U runs ahead by the feed-forward, here of three drives, up to the slowest one.
static void test_jog_of_u_to_its_limit_leaves_room_for_the_feed_forward(void)
{
    static const int32_t gains[][2] = {{742723, 281448}, {350000, 0}, {1500000, 0}};
    for (int i = 0; i < 6; i++) {
        setUp();
        const int32_t sense = i < 3 ? 1 : -1;
        set(cam_param_k1_ns, gains[i % 3][0]);
        set(cam_param_k2_us2, gains[i % 3][1]);
        set(cam_param_following_limit_nm, 10000000); // the machine of the rig has no lag
        to_manual();
        for (int k = 0; k < 80; k++) {
            jog(hal_axis_u, sense * 2000);
            fixture_rig_ticks(&rig, 200);
        }
        TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
        TEST_ASSERT_EQUAL_INT(cam_jog_limit, jog_state().end);
        TEST_ASSERT_GREATER_THAN_INT32(590000, sense * port_nm(hal_axis_u));
    }
}

static void test_disable_brakes_before_the_enable_drops(void)
{
    to_manual();
    jog(hal_axis_x, 10000);
    fixture_rig_ticks(&rig, 1000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&rig.machine));
    fixture_rig_ticks(&rig, 100);
    TEST_ASSERT_EQUAL_HEX32(hal_out_enable, hal_host.out.outputs);
    fixture_rig_ticks(&rig, 1000);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
}

/// Nothing leaves anything: whoever stands beside the machine is not surprised by a motion.
static void test_fault_by_hand_brakes_all_axes_where_they_are(void)
{
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        setUp();
        to_manual();
        jog((hal_axis_t)i, 2000);
        fixture_rig_ticks(&rig, 1000);
        int32_t at_nm[hal_n_axes];
        for (uint32_t k = 0; k < hal_n_axes; k++) {
            at_nm[k] = port_nm((hal_axis_t)k);
        }
        hal_host_fault_estop(true);
        fixture_rig_ticks(&rig, 2000);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), fixture_rig_status(&rig).faults);
        TEST_ASSERT_EQUAL_HEX32(hal_out_fault, hal_host.out.outputs);
        for (uint32_t k = 0; k < hal_n_axes; k++) {
            // v^2 / 2 a, and half of the window at the speed: 4 um and 6 um
            TEST_ASSERT_INT32_WITHIN(k == i ? 12000 : 0, at_nm[k], port_nm((hal_axis_t)k));
        }
        hal_host_fault_estop(false);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&rig.machine));
        fixture_rig_ticks(&rig, 20);
        bring(cam_state_ready); // and a fault there retracts again
        hal_host_fault_estop(true);
        const int32_t x_nm = port_nm(hal_axis_x);
        fixture_rig_ticks(&rig, 8000);
        TEST_ASSERT_GREATER_THAN_INT32(x_nm + mm / 2, port_nm(hal_axis_x));
    }
}

/// A jog of speed 0 stops what runs; of an axis at rest it changes nothing.
static void test_a_stop_at_rest_leaves_what_came_of_the_order_before(void)
{
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_step(&rig.machine, hal_axis_x, 20000).err);
    TEST_ASSERT_EQUAL_INT(cam_jog_done, until_rest());
    jog(hal_axis_x, 0);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_jog_done, jog_state().end);
    jog(hal_axis_x, 1000);
    fixture_rig_ticks(&rig, 20);
    jog(hal_axis_x, 0);
    TEST_ASSERT_EQUAL_INT(cam_jog_stopped, until_rest());
}

/// An order holds before its tick, not in it.
static void test_order_holds_to_the_tick_before_its_last(void)
{
    static cam_play_config_t cfg;
    const cam_tick_record_t r = {.tick = 5000};
    for (uint32_t until = 4999; until <= 5002u; until++) {
        cfg.jog.order = (cam_jog_order_t){
            .serial = 7, .until = until, .begin = cam_jog_jog, .axis = hal_axis_x, .sense = 1};
        cam_jog_t h = {0};
        cam_motion_t m = {.state = cam_state_manual};
        (void)cam_jog_isr(&h, &cfg, &r, &m);
        TEST_ASSERT_EQUAL_UINT32(7, h.serial);
        TEST_ASSERT_EQUAL(until <= 5000u, h.end == cam_jog_silent);
    }
}

/// By hand the tool may go anywhere: a fault behind it finds nothing that counts as out of the
/// work.
static void test_nothing_counts_as_clear_by_hand(void)
{
    to_manual();
    g_cam.motion.is_clear = true;
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_FALSE(g_cam.motion.is_clear);
}
