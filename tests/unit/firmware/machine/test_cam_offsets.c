// SPDX-License-Identifier: Apache-2.0
// Where the part lies: datum, tools, and what homing is demanded for.
#include "cam_feasible.h" // cam_demand_clearance_nm
#include "fixture_newer.h"
#include "jog_bench.h"
#include <string.h>

static void home_here(hal_axis_t axis)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), axis));
    fixture_rig_ticks(&rig, 20);
    cam_machine_jog_poll(machine());
    fixture_rig_ticks(&rig, 20);
}

static void disable(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(machine()));
    fixture_rig_ticks(&rig, 200);
}

static int64_t origin_nm(hal_axis_t axis)
{
    return cam_offsets_origin_nm(&machine()->offsets, &machine()->params, axis);
}

/// Only an axis that was homed has a shift; that of U is in its set-point.
static void test_shift_is_that_of_an_axis_that_was_homed(void)
{
    static const struct {
        hal_axis_t axis;
        uint32_t known;
        int32_t method, shift_nm;
    } cases[] = {{hal_axis_x, 7, 1, 700},
                 {hal_axis_x, 0, 1, 0},
                 {hal_axis_x, 7, 0, 0},
                 {hal_axis_z, 7, 1, 700},
                 {hal_axis_u, 7, 1, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const cam_offsets_t h = {.known = cases[i].known, .home_nm = {300, 300, 300}};
        cam_params_t p = cam_param_defaults();
        p.u_home = p.x_home = p.z_home = cases[i].method;
        p.u_home_nm = p.x_home_nm = p.z_home_nm = 1000;
        TEST_ASSERT_EQUAL_INT32(cases[i].shift_nm, cam_offsets_shift_nm(&h, &p, cases[i].axis));
    }
}

static void test_each_axis_has_its_parameters(void)
{
    cam_params_t p = cam_param_defaults();
    const int32_t first[] = {cam_param_u_home, cam_param_x_home, cam_param_z_home};
    for (int i = cam_param_u_jog_um_per_s; i < cam_n_params; i++) {
        const cam_param_info_t *info = cam_param_info((cam_param_id_t)i);
        const int32_t value = info->min + 2 + i;
        TEST_ASSERT_EQUAL_INT(
            cam_ok, cam_param_set(&p, (cam_param_id_t)i, value < info->max ? value : info->max));
    }
    p.tool = 0;
    for (uint32_t i = 0; i < 3u; i++) {
        const cam_offsets_axis_t a = cam_offsets_axis(&p, (hal_axis_t)i);
        const int32_t found[] = {a.method, a.sense, a.search_um_per_s, a.slow_um_per_s, a.home_nm};
        for (int k = 0; k < 5; k++) {
            TEST_ASSERT_EQUAL_INT32(cam_param_get(&p, (cam_param_id_t)(first[i] + k)), found[k]);
        }
    }
    const int32_t linear_nm[][4] = {{p.x_home_travel_nm, p.x_low_nm, p.x_high_nm, p.x_datum_nm},
                                    {p.z_home_travel_nm, p.z_low_nm, p.z_high_nm, p.z_datum_nm}};
    for (uint32_t i = 0; i < 2u; i++) {
        const cam_offsets_axis_t a = cam_offsets_axis(&p, i == 0u ? hal_axis_x : hal_axis_z);
        const int32_t found_nm[] = {a.way_nm, a.low_nm, a.high_nm, a.datum_nm};
        TEST_ASSERT_EQUAL_INT32_ARRAY(linear_nm[i], found_nm, 4);
    }
    const int32_t tool_nm[][2] = {{p.tool_1_x_nm, p.tool_1_z_nm},
                                  {p.tool_2_x_nm, p.tool_2_z_nm},
                                  {p.tool_3_x_nm, p.tool_3_z_nm},
                                  {p.tool_4_x_nm, p.tool_4_z_nm}};
    for (p.tool = 1; p.tool <= 4; p.tool++) {
        TEST_ASSERT_EQUAL_INT32(tool_nm[p.tool - 1][0], cam_offsets_axis(&p, hal_axis_x).tool_nm);
        TEST_ASSERT_EQUAL_INT32(tool_nm[p.tool - 1][1], cam_offsets_axis(&p, hal_axis_z).tool_nm);
    }
}

/// The tool touches a diameter: from now on X of the part is half of it plus U, whatever the port
/// counts, and no set-point of the port moves.
static void test_zero_moves_the_part_not_the_axes(void)
{
    for (int32_t i = 0; i < 3; i++) {
        setUp();
        const int32_t x_nm = (17 + 30 * i) * mm;
        const int32_t z_nm = -5 * mm * i;
        hal_host.in.axis_nm[hal_axis_x] = x_nm;
        hal_host.in.axis_nm[hal_axis_z] = z_nm;
        hal_host.in.axis_nm[hal_axis_u] = 40000;
        fixture_rig_tick(&rig);
        to_manual();
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_zero(machine(), hal_axis_x, 92 * mm).err);
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_zero(machine(), hal_axis_z, -3 * mm).err);
        fixture_rig_ticks(&rig, 100);
        TEST_ASSERT_EQUAL_INT32(x_nm, port_nm(hal_axis_x));
        TEST_ASSERT_EQUAL_INT32(z_nm, port_nm(hal_axis_z));
        TEST_ASSERT_EQUAL_INT32(-3 * mm, fixture_rig_status(&rig).z_nm);
        TEST_ASSERT_EQUAL_INT64(x_nm - 46 * mm - 40000, origin_nm(hal_axis_x));
        TEST_ASSERT_EQUAL_INT64(z_nm + 3 * mm, origin_nm(hal_axis_z));
    }
}

/// The same cut at another position of the machine: every set-point is off by the datum, to the
/// bit.
static void test_cut_at_another_position_is_the_same_cut(void)
{
    enum { n = 3000 };
    static hal_setpoint_t plain[n][hal_n_axes];
    for (int32_t run = 0; run < 2; run++) {
        setUp();
        const int32_t by_nm = run * 12345678;
        hal_host.in.axis_nm[hal_axis_x] = 50 * mm - by_nm;
        hal_host.in.axis_nm[hal_axis_z] = -mm + 2 * by_nm;
        fixture_rig_tick(&rig);
        set(cam_param_x_datum_nm, by_nm);
        set(cam_param_z_datum_nm, -3 * by_nm);
        set(cam_param_tool, run);
        set(cam_param_tool_1_z_nm, by_nm);
        bring(cam_state_cutting);
        for (uint32_t i = 0; i < n; i++) {
            fixture_rig_tick(&rig);
            if (run == 0) {
                memcpy(plain[i], rig.last.out, sizeof plain[i]);
                continue;
            }
            hal_setpoint_t out[hal_n_axes];
            memcpy(out, rig.last.out, sizeof out);
            out[hal_axis_x].pos_nm += by_nm;
            out[hal_axis_z].pos_nm -= 2 * by_nm;
            TEST_ASSERT_EQUAL_MEMORY(plain[i], out, sizeof out);
        }
    }
}

static void test_measured_z_is_read_from_its_datum_on(void)
{
    set(cam_param_z_is_measured, 1);
    set(cam_param_z_datum_nm, -100 * mm);
    hal_host.in.axis_nm[hal_axis_z] = 100 * mm;
    rig.lathe.is_held[hal_axis_z] = true;
    bring(cam_state_cutting);
    for (int i = 0; i < 4000; i++) {
        hal_host.in.axis_nm[hal_axis_z] += 50;
        fixture_rig_tick(&rig);
    }
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    TEST_ASSERT_INT32_WITHIN(1000, 200000, rig.last.want.z_nm);
}

static void test_tool_moves_the_part_by_its_offset(void)
{
    set(cam_param_tool_2_x_nm, 4 * mm);
    set(cam_param_tool_2_z_nm, -7 * mm);
    const int64_t x_nm = origin_nm(hal_axis_x);
    const int64_t z_nm = origin_nm(hal_axis_z);
    to_manual();
    set(cam_param_tool, 2);
    TEST_ASSERT_EQUAL_INT64(x_nm - 4 * mm, origin_nm(hal_axis_x));
    TEST_ASSERT_EQUAL_INT64(z_nm + 7 * mm, origin_nm(hal_axis_z));
    // Zero with this tool makes a datum that holds for all of them.
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_zero(machine(), hal_axis_z, 0).err);
    TEST_ASSERT_EQUAL_INT32(7 * mm, machine()->params.z_datum_nm);
}

static void test_zero_is_refused_where_it_cannot_be(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_hand_axis, cam_machine_zero(machine(), hal_axis_u, 0).err);
    set(cam_param_x_home, 1);
    TEST_ASSERT_EQUAL_INT(cam_err_not_homed, cam_machine_zero(machine(), hal_axis_x, 0).err);
    hal_host.in.axis_nm[hal_axis_z] = 1050 * mm;
    fixture_rig_tick(&rig);
    const cam_verdict_t verdict = cam_machine_zero(machine(), hal_axis_z, 0);
    TEST_ASSERT_EQUAL_INT(cam_err_param_range, verdict.err);
    TEST_ASSERT_EQUAL_INT32(0, verdict.value);
    hal_host.in.axis_nm[hal_axis_z] = 0;
    fixture_rig_tick(&rig);
    bring(cam_state_engaging);
    TEST_ASSERT_EQUAL_INT(cam_err_param_state, cam_machine_zero(machine(), hal_axis_z, 0).err);
}

/// A measured Z, which others lead, needs no home of its own.
static void test_homing_required_refuses_until_every_axis_is_homed(void)
{
    static const hal_axis_t axes[] = {hal_axis_x, hal_axis_u};
    set(cam_param_homing_required, 1);
    bring(cam_state_ready); // no axis has a method of homing: their positions are known
    disable();
    set(cam_param_x_home, 1);
    set(cam_param_u_home, 1);
    for (uint32_t i = 0; i < 2u; i++) {
        TEST_ASSERT_EQUAL_INT(cam_err_not_homed, cam_machine_enable(machine()));
        to_manual();
        home_here(axes[i]);
        disable();
    }
    bring(cam_state_ready);
    disable();
    set(cam_param_z_home, 2);
    TEST_ASSERT_EQUAL_INT(cam_err_not_homed, cam_machine_enable(machine()));
    set(cam_param_homing_required, 0);
    bring(cam_state_ready);
    disable();
    set(cam_param_homing_required, 1);
    set(cam_param_z_is_measured, 1);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(machine()));
}

/// Swapped by mistake, the limits do not switch the travel off.
static void test_part_beyond_the_travel_is_refused_before_motion(void)
{
    for (int32_t sense = -1; sense <= 1; sense += 2) {
        setUp();
        set(cam_param_z_low_nm, sense * 10 * mm);
        set(cam_param_z_high_nm, -sense * 10 * mm);
        set(cam_param_z_datum_nm, -9500000); // the part, 1 mm long, would end at 10.5 mm
        TEST_ASSERT_EQUAL_INT(cam_err_travel, cam_machine_enable(machine()));
        set(cam_param_z_datum_nm, -8 * mm);
        bring(cam_state_ready);
        set(cam_param_z_datum_nm, 10500000);
        TEST_ASSERT_EQUAL_INT(cam_err_travel, cam_machine_start(machine()));
    }
}

/// A first pass that X cannot reach is not made up for by the last one.
static void test_every_pass_lies_in_the_travel_of_x(void)
{
    static const fixture_pass_t two[] = {{100000, 300000, 2500000, 0}, {0, 300000, 2500000, 0}};
    fixture_newer_passes(&rig.image, two, 2);
    expect_select(cam_ok);
    fixture_rig_ticks(&rig, 2);
    const cam_table_t *t = &machine()->table;
    const int32_t most_nm = t->x_max_nm + (int32_t)cam_demand_clearance_nm(t, &machine()->params);
    set(cam_param_x_low_nm, t->x_min_nm - mm);
    set(cam_param_x_high_nm, most_nm + 99000);
    TEST_ASSERT_EQUAL_INT(cam_err_travel, cam_machine_enable(machine()));
    set(cam_param_x_high_nm, most_nm + 101000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(machine()));
}

/// Between the tick that finds a home and the configuration that knows it the positions are not
/// known, and no cut begins. While the interrupt has not taken the last configuration, the home
/// waits for it.
static void test_a_home_that_was_found_waits_for_room(void)
{
    set(cam_param_x_home, 1);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_x));
    fixture_rig_ticks(&rig, 40);
    expect_set(cam_ok, cam_param_phase_udeg, 5);
    cam_machine_jog_poll(machine());
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(machine()));
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_enable(machine()));
    cam_machine_poll(machine());
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(machine()));
}

/// @return [nm] position of X after an emergency stop in homing, which is reset
static int32_t x_after_a_fault_in_homing(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(machine()));
    fixture_rig_ticks(&rig, 200);
    hal_host_fault_estop(true);
    fixture_rig_ticks(&rig, 20000);
    hal_host_fault_estop(false);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(machine()));
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    return port_nm(hal_axis_x);
}

/// Each fault moves X off by its clearance, as far as its travel goes, where that is known.
static void test_faults_again_and_again_leave_x_within_its_travel(void)
{
    set(cam_param_x_clearance_nm, 4 * mm);
    hal_host.in.axis_nm[hal_axis_x] = 60 * mm;
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT32(64 * mm, x_after_a_fault_in_homing());
    set(cam_param_x_low_nm, 10 * mm);
    set(cam_param_x_high_nm, 70 * mm);
    TEST_ASSERT_EQUAL_INT32(68 * mm, x_after_a_fault_in_homing());
    TEST_ASSERT_EQUAL_INT32(70 * mm, x_after_a_fault_in_homing());
    TEST_ASSERT_EQUAL_INT32(70 * mm, x_after_a_fault_in_homing());
    set(cam_param_x_high_nm, 69 * mm); // it stands beyond, and stays
    TEST_ASSERT_EQUAL_INT32(70 * mm, x_after_a_fault_in_homing());
    set(cam_param_x_home, 1); // not homed: its position is not known
    TEST_ASSERT_EQUAL_INT32(74 * mm, x_after_a_fault_in_homing());
    set(cam_param_x_home_nm, 55 * mm); // by the machine, which counts 19 mm less than the port
    to_manual();
    home_here(hal_axis_x);
    disable();
    set(cam_param_x_high_nm, 60 * mm);
    TEST_ASSERT_EQUAL_INT32(78 * mm, x_after_a_fault_in_homing());
    TEST_ASSERT_EQUAL_INT32(79 * mm, x_after_a_fault_in_homing());
}
