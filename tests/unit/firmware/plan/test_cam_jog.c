// SPDX-License-Identifier: Apache-2.0
// Axes by hand in whole ticks: jog, step, dead man, limits of motion, faults, and homing by a
// switch or an index. test_cam_jog_isr.c has single orders.
#include "fixture_random.h"
#include "jog_bench.h"

static void jog(hal_axis_t axis, int32_t um_per_s)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(&rig.machine, axis, um_per_s).err);
    fixture_rig_tick(&rig);
}

static void test_manual_holds_all_axes_and_the_spindle(void)
{
    static const int32_t at_nm[hal_n_axes] = {123456, 50 * mm, -7 * mm};
    memcpy(hal_host.in.axis_nm, at_nm, sizeof at_nm);
    fixture_rig_ticks(&rig, 20);
    to_manual();
    fixture_rig_ticks(&rig, 3000);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        TEST_ASSERT_EQUAL_INT32(at_nm[i], port_nm((hal_axis_t)i));
    }
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
        to_manual_at_zero();
        const hal_axis_t axis = (hal_axis_t)i;
        jog(axis, 1000);
        fixture_rig_ticks(&rig, patience_ticks - 2u * 8u);
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

/// Afterwards a jog of speed 0 changes nothing of an axis at rest, and stops one that runs.
static void test_step_ends_at_its_distance(void)
{
    static const int32_t steps_nm[] = {100000, -1, 12345, -3 * mm, 1};
    to_manual();
    for (uint32_t i = 0; i < 5u; i++) {
        const int32_t from_nm = port_nm(hal_axis_x);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_step(&rig.machine, hal_axis_x, steps_nm[i]).err);
        TEST_ASSERT_EQUAL_INT(cam_jog_done, until_rest());
        TEST_ASSERT_EQUAL_INT32(from_nm + steps_nm[i], port_nm(hal_axis_x));
    }
    jog(hal_axis_x, 0);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_jog_done, jog_state().end);
    jog(hal_axis_x, 1000);
    fixture_rig_ticks(&rig, 20);
    jog(hal_axis_x, 0);
    TEST_ASSERT_EQUAL_INT(cam_jog_stopped, until_rest());
}

/// Jogs, reversals, stops and steps of all axes at random, with limits of travel: speed and
/// acceleration stay within the axis's gentle limits, travel within its limits, and no fault comes.
/// 2 mm/s and 10 mm/s are 100 and 500 nm per tick. X and Z change their speed once per plan by
/// 0.5 m/s2 times 0.4 ms, 10 nm per tick, U by a quarter of 250 m/s2 in one tick, 156 nm per
/// tick; a step is rounded to whole nanometres, and has the rest of a division by eight.
static void test_random_orders_stay_within_speed_acceleration_and_travel(void)
{
    static const struct {
        int32_t low_nm, high_nm, most_um_per_s, most_step_nm, most_change_nm;
    } limits[hal_n_axes] = {{-600000, 600000, 2000, 103, 159},
                            {-2 * mm, 3 * mm, 10000, 503, 13},
                            {-mm, mm, 10000, 503, 13}};
    set(cam_param_x_low_nm, limits[hal_axis_x].low_nm);
    set(cam_param_x_high_nm, limits[hal_axis_x].high_nm);
    set(cam_param_z_low_nm, limits[hal_axis_z].low_nm);
    set(cam_param_z_high_nm, limits[hal_axis_z].high_nm);
    to_manual_at_zero();
    motion_t motion[hal_n_axes];
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        motion[i] = motion_of((hal_axis_t)i);
    }
    fixture_random_t random = {.state = 77};
    for (int n = 0; n < 200; n++) {
        const hal_axis_t axis = (hal_axis_t)(fixture_random_u32(&random) % (uint32_t)hal_n_axes);
        const int32_t most = limits[axis].most_um_per_s;
        const int32_t um_per_s = (int32_t)fixture_random_range(&random, -most, most);
        (void)cam_machine_jog(&rig.machine, axis, um_per_s);
        if (n % 5 == 0) {
            (void)cam_machine_step(&rig.machine, axis, um_per_s * 100);
        }
        const uint32_t ticks = 1u + fixture_random_u32(&random) % 1500u;
        for (uint32_t k = 0; k < ticks; k++) {
            fixture_rig_tick(&rig);
            for (uint32_t i = 0; i < hal_n_axes; i++) {
                watch(&motion[i], (hal_axis_t)i);
                TEST_ASSERT_TRUE(motion[i].last_nm >= limits[i].low_nm);
                TEST_ASSERT_TRUE(motion[i].last_nm <= limits[i].high_nm);
            }
        }
    }
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        TEST_ASSERT_LESS_OR_EQUAL_INT32(limits[i].most_step_nm, motion[i].most_step_nm);
        TEST_ASSERT_GREATER_OR_EQUAL_INT32(limits[i].most_step_nm * 4 / 5 - 3,
                                           motion[i].most_step_nm);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(limits[i].most_change_nm, motion[i].most_change_nm);
    }
}

/// Nothing retracts: an operator beside the machine is not surprised by a motion.
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

static void set_home(hal_axis_t axis, int32_t method, int32_t sense, int32_t place_nm)
{
    static const cam_param_id_t first[] = {cam_param_u_home, cam_param_x_home, cam_param_z_home};
    const cam_param_id_t id = first[axis];
    set(id, method);
    set((cam_param_id_t)(id + 1), sense);
    set((cam_param_id_t)(id + 4), place_nm);
}

static cam_jog_end_t home_end(hal_axis_t axis)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, axis));
    return until_rest();
}

/// Home an axis. @return [nm] its position when the port counts `at_nm`
static int32_t homed_nm(hal_axis_t axis, int32_t at_nm)
{
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_jog_done, home_end(axis));
    TEST_ASSERT_EQUAL_HEX32(1u << axis, jog_state().homed & 1u << axis);
    return cam_machine_position_nm(&rig.machine, axis) + at_nm - port_nm(axis);
}

/// From both sides, on the switch and off it, in both senses, at every phase of the plan: the
/// switch's edge has the number that was set, within the distance of a plan and a tick at the slow
/// speed.
static void test_home_by_switch_finds_its_edge_from_anywhere(void)
{
    static const int32_t starts_nm[] = {-4 * mm, -123457, 5 * mm};
    for (uint32_t i = 0; i < 12u; i++) {
        setUp();
        const int32_t sense = i % 2u == 0u ? 1 : -1;
        const hal_axis_t axis = i % 4u < 2u ? hal_axis_x : hal_axis_z;
        const int32_t edge_nm = 100000 + (int32_t)i * 77;
        rig.lathe.home[axis] = (ideal_home_t){.side = sense, .edge_nm = edge_nm};
        hal_host.in.axis_nm[axis] = sense * starts_nm[i / 4u];
        set_home(axis, 2, sense, 321 * mm);
        fixture_rig_ticks(&rig, i);
        TEST_ASSERT_INT32_WITHIN(451, 321 * mm, homed_nm(axis, edge_nm));
    }
}

/// The index after the switch decides, within the distance of a plan at the slow speed, wherever
/// the switch is between two indices.
static void test_home_by_index_is_that_of_the_index(void)
{
    for (int32_t edge_nm = 100000; edge_nm < 4 * mm; edge_nm += 650000) {
        setUp();
        rig.lathe.home[hal_axis_x] =
            (ideal_home_t){.side = 1, .edge_nm = 10 * mm + edge_nm, .pitch_nm = 5 * mm};
        hal_host.in.axis_nm[hal_axis_x] = 9 * mm;
        set_home(hal_axis_x, 3, 1, 0);
        fixture_rig_ticks(&rig, (uint32_t)edge_nm % 8u);
        TEST_ASSERT_INT32_WITHIN(451, 0, homed_nm(hal_axis_x, 10 * mm));
    }
}

/// Set-points of the port continue evenly while U's origin is shifted twice.
static void test_home_of_u_shifts_its_origin_without_a_motion(void)
{
    static const int32_t edges_nm[] = {300000, -150000, 650000};
    for (uint32_t i = 0; i < 3u; i++) {
        setUp();
        rig.lathe.home[hal_axis_u] = (ideal_home_t){.side = 1, .edge_nm = edges_nm[i]};
        set_home(hal_axis_u, 2, 1, 200000);
        to_manual();
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, hal_axis_u));
        motion_t motion = motion_of(hal_axis_u);
        for (int k = 0; k < 60000 && (k < 40 || jog_state().phase != cam_jog_rest); k++) {
            if (k % 1000 == 0) {
                cam_machine_keep_alive(&rig.machine);
            }
            fixture_rig_tick(&rig);
            watch(&motion, hal_axis_u);
        }
        TEST_ASSERT_EQUAL_INT(cam_jog_done, jog_state().end);
        TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(53, motion.most_step_nm); // 1 mm/s
        fixture_rig_ticks(&rig, 1000);
        const int32_t beyond_nm = port_nm(hal_axis_u) - edges_nm[i];
        const int32_t u_nm = fixture_rig_status(&rig).u_actual_nm;
        TEST_ASSERT_INT32_WITHIN(60, 200000, u_nm - beyond_nm); // 0.1 mm/s in a plan
    }
}

/// The last row would put U outside of its stroke where it stands.
static void test_home_that_fails_ends_and_is_none(void)
{
    static const struct {
        hal_axis_t axis;
        int32_t method, sense, place_nm;
        ideal_home_t home;
        cam_jog_end_t end;
    } rows[] = {
        {hal_axis_x, 2, 1, 0, {0}, cam_jog_no_switch},
        {hal_axis_x, 2, 1, 0, {.side = 1, .edge_nm = -100 * mm}, cam_jog_no_release},
        {hal_axis_x, 3, 1, 0, {.side = 1, .edge_nm = 100000}, cam_jog_no_index},
        {hal_axis_u, 2, -1, 0, {0}, cam_jog_no_switch},
        {hal_axis_u, 2, 1, 700000, {.side = 1, .edge_nm = 100000}, cam_jog_no_stroke},
    };
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        setUp();
        rig.lathe.home[rows[i].axis] = rows[i].home;
        set_home(rows[i].axis, rows[i].method, rows[i].sense, rows[i].place_nm);
        set(cam_param_x_home_travel_nm, 2 * mm);
        to_manual_at_zero();
        TEST_ASSERT_EQUAL_INT(rows[i].end, home_end(rows[i].axis));
        TEST_ASSERT_TRUE(i > 0u || port_nm(hal_axis_x) == 2 * mm); // all of its travel
        TEST_ASSERT_EQUAL_HEX32(0, jog_state().homed);
        TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    }
}
