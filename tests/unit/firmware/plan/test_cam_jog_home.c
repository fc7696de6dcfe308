// SPDX-License-Identifier: Apache-2.0
// Homing of axes in whole ticks: by switch, by index, where they stand; what is not found.
#include "jog_bench.h"

static void set_home(hal_axis_t axis, int32_t method, int32_t sense, int32_t place_nm)
{
    static const cam_param_id_t first[] = {cam_param_u_home, cam_param_x_home, cam_param_z_home};
    const cam_param_id_t id = first[axis];
    set(id, method);
    set((cam_param_id_t)(id + 1), sense);
    set((cam_param_id_t)(id + 4), place_nm);
}

static void home(hal_axis_t axis)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, axis));
    TEST_ASSERT_EQUAL_INT(cam_jog_done, until_rest());
    TEST_ASSERT_EQUAL_HEX32(1u << axis, jog_state().homed & 1u << axis);
}

/// From both sides, on the switch and off it, in both senses, at every phase of the plan: the
/// switch's edge has the number that was set, within what the slow speed covers in a plan and a
/// tick.
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
        to_manual();
        home(axis);
        const int32_t place_nm = cam_machine_position_nm(&rig.machine, axis);
        const int32_t edge_by_machine_nm = place_nm + edge_nm - port_nm(axis);
        TEST_ASSERT_INT32_WITHIN(451, 321 * mm, edge_by_machine_nm);
    }
}

/// The index behind the switch decides, to what the slow speed covers in a plan, wherever the
/// switch itself lies between two indices.
static void test_home_by_index_is_that_of_the_index(void)
{
    for (int32_t edge_nm = 100000; edge_nm < 4 * mm; edge_nm += 650000) {
        setUp();
        rig.lathe.home[hal_axis_x] =
            (ideal_home_t){.side = 1, .edge_nm = 10 * mm + edge_nm, .pitch_nm = 5 * mm};
        hal_host.in.axis_nm[hal_axis_x] = 9 * mm;
        set_home(hal_axis_x, 3, 1, 0);
        fixture_rig_ticks(&rig, (uint32_t)edge_nm % 8u);
        to_manual();
        home(hal_axis_x);
        const int32_t place_nm = cam_machine_position_nm(&rig.machine, hal_axis_x);
        TEST_ASSERT_INT32_WITHIN(451, 0, place_nm + 10 * mm - port_nm(hal_axis_x));
    }
}

static void test_home_here_needs_no_motion(void)
{
    hal_host.in.axis_nm[hal_axis_z] = 4 * mm;
    set_home(hal_axis_z, 1, 1, -50 * mm);
    to_manual();
    home(hal_axis_z);
    TEST_ASSERT_EQUAL_INT32(4 * mm, port_nm(hal_axis_z));
    TEST_ASSERT_EQUAL_INT32(-50 * mm, cam_machine_position_nm(&rig.machine, hal_axis_z));
}

/// Set-points of the port go on evenly while the controller's numbers of U change twice.
static void test_home_of_u_changes_its_number_and_moves_nothing_by_that(void)
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

/// A U that was homed is cut with like one whose zero was right from the start.
static void test_cut_with_a_homed_u_is_offset_by_its_home(void)
{
    rig.lathe.home[hal_axis_u] = (ideal_home_t){.side = 1, .edge_nm = 350000};
    set_home(hal_axis_u, 2, 1, 100000);
    to_manual();
    home(hal_axis_u);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&rig.machine));
    fixture_rig_ticks(&rig, 20);
    bring(cam_state_cutting);
    fixture_rig_ticks(&rig, 1000);
    const int32_t set_nm = rig.last.want.u_set_q6 >> 6;
    TEST_ASSERT_INT32_WITHIN(100, 250000, port_nm(hal_axis_u) - set_nm);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
}

static void test_home_that_is_not_found_ends_after_its_travel_and_is_none(void)
{
    set_home(hal_axis_x, 2, 1, 0);
    set(cam_param_x_home_travel_nm, 2 * mm);
    set_home(hal_axis_u, 2, -1, 0);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, hal_axis_x));
    TEST_ASSERT_EQUAL_INT(cam_jog_no_switch, until_rest());
    TEST_ASSERT_EQUAL_INT32(2 * mm, port_nm(hal_axis_x));
    rig.lathe.home[hal_axis_x] = (ideal_home_t){.side = 1, .edge_nm = -100 * mm}; // stuck
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, hal_axis_x));
    TEST_ASSERT_EQUAL_INT(cam_jog_no_release, until_rest());
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, hal_axis_u));
    TEST_ASSERT_EQUAL_INT(cam_jog_no_switch, until_rest());
    TEST_ASSERT_EQUAL_HEX32(0, jog_state().homed);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
}

/// The switch is left only by moving back from it.
static void test_home_switch_that_bounces_is_not_left_yet(void)
{
    const ideal_home_t home = {.side = 1, .edge_nm = 100000};
    rig.lathe.home[hal_axis_x] = home;
    set_home(hal_axis_x, 2, 1, 0);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, hal_axis_x));
    for (uint32_t i = 0; i < 4000u && jog_state().phase != cam_jog_release; i++) {
        fixture_rig_tick(&rig);
    }
    rig.lathe.home[hal_axis_x].edge_nm = 100 * mm;
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_jog_release, jog_state().phase);
    rig.lathe.home[hal_axis_x] = home;
    TEST_ASSERT_EQUAL_INT(cam_jog_done, until_rest());
}

static void test_home_without_an_index_ends_and_is_none(void)
{
    rig.lathe.home[hal_axis_x] = (ideal_home_t){.side = 1, .edge_nm = 100000};
    set_home(hal_axis_x, 3, 1, 0);
    set(cam_param_x_home_travel_nm, 200000);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, hal_axis_x));
    TEST_ASSERT_EQUAL_INT(cam_jog_no_index, until_rest());
    TEST_ASSERT_EQUAL_HEX32(0, jog_state().homed);
}

/// A U that the port counts beyond the words of its set-points: neither its search nor its home
/// would be told to the drive as it is.
static void test_home_of_u_from_far_away_is_refused(void)
{
    static const cam_jog_phase_t begins[] = {cam_jog_search, cam_jog_here};
    for (int i = 0; i < 4; i++) {
        const int32_t far_nm = i % 2 == 0 ? 35 * mm : -35 * mm;
        cam_jog_t h = {0};
        cam_motion_t m = {.state = cam_state_manual};
        cam_tick_record_t r = {.in.inputs = hal_in_drive_ready};
        cam_play_config_t cfg = {.plan_ticks = 8, .per_plan_q30 = 1 << 27};
        cfg.jog.u_end_q10 = 500000 * INT64_C(1024);
        cfg.jog.order = (cam_jog_order_t){.serial = 1u,
                                          .until = 100u,
                                          .begin = begins[i / 2],
                                          .axis = hal_axis_u,
                                          .sense = 1,
                                          .distance_q10 = mm * INT64_C(1024)};
        r.in.actual_nm[hal_axis_u] = far_nm;
        m.axis[hal_axis_u].pos_q10 = far_nm * INT64_C(1024);
        TEST_ASSERT_EQUAL_INT32(0, cam_jog_isr(&h, &cfg, &r, &m));
        TEST_ASSERT_EQUAL_INT(cam_jog_no_stroke, h.end);
        TEST_ASSERT_EQUAL_HEX32(0, h.homed);
    }
}

/// The number at the switch would put U outside of its stroke where it stands.
static void test_home_of_u_beyond_its_stroke_is_refused(void)
{
    rig.lathe.home[hal_axis_u] = (ideal_home_t){.side = 1, .edge_nm = 100000};
    set_home(hal_axis_u, 2, 1, 700000);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&rig.machine, hal_axis_u));
    TEST_ASSERT_EQUAL_INT(cam_jog_no_stroke, until_rest());
    TEST_ASSERT_EQUAL_HEX32(0, jog_state().homed | fixture_rig_status(&rig).faults);
}
