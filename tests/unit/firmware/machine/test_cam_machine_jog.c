// SPDX-License-Identifier: Apache-2.0
// Commands of the state manual: their order, limits and refusals; limits that change while axes
// move or stand beyond them: no axis leaps, none moves on for ever.
#include "cam_feasible.h"      // cam_demand_clearance_nm
#include "cam_machine_inner.h" // cam_machine_request
#include "jog_bench.h"

static void expect_jog(cam_err_t err, hal_axis_t axis, int32_t um_per_s)
{
    TEST_ASSERT_EQUAL_INT(err, cam_machine_jog(machine(), axis, um_per_s).err);
}

static void expect_step(cam_err_t err, hal_axis_t axis, int32_t by_nm)
{
    TEST_ASSERT_EQUAL_INT(err, cam_machine_step(machine(), axis, by_nm).err);
}

static void stop_and_rest(void)
{
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(machine()));
    (void)until_rest();
}

static void test_commands_by_hand_are_refused_in_every_other_state(void)
{
    static const cam_state_t states[] = {cam_state_off, cam_state_homing, cam_state_ready,
                                         cam_state_engaging, cam_state_cutting};
    for (uint32_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        setUp();
        bring(states[i]);
        const uint32_t generation = machine()->generation;
        expect_jog(cam_err_state, hal_axis_x, 100);
        expect_step(cam_err_state, hal_axis_x, 100);
        TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_home_axis(machine(), hal_axis_x));
        cam_machine_keep_alive(machine());
        TEST_ASSERT_EQUAL_UINT32(generation, machine()->generation);
        if (states[i] != cam_state_off) {
            TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_manual(machine()));
        }
    }
}

static void test_commands_of_other_states_are_refused_by_hand(void)
{
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_enable(machine()));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_start(machine()));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_reset(machine()));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_manual(machine()));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_may_exchange(machine()));
    expect_set(cam_err_param_state, cam_param_counts_per_turn, 4096);
    static const cam_request_t wrong[] = {cam_request_enable, cam_request_start, cam_request_reset,
                                          cam_request_identify, cam_request_manual};
    for (uint32_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        cam_machine_request(machine(), wrong[i]);
        fixture_rig_ticks(&rig, 20);
        TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
    }
}

/// U is judged in every tick, so its gains and limits wait until it rests; nothing is cut, so a
/// slow U is accepted.
static void test_gains_and_limits_of_a_jogged_u_wait_until_it_rests(void)
{
    static const struct {
        cam_param_id_t id;
        int32_t value;
    } changes[] = {{cam_param_u_stroke_nm, 1100000},
                   {cam_param_u_speed_um_per_s, 5000},
                   {cam_param_u_acceleration_mm_per_s2, 1000},
                   {cam_param_u_jerk_m_per_s3, 1000000},
                   {cam_param_k1_ns, 1},
                   {cam_param_k2_us2, 1}};
    enum { n_changes = sizeof changes / sizeof changes[0] };
    to_manual();
    expect_jog(cam_ok, hal_axis_u, 1000);
    fixture_rig_ticks(&rig, 100);
    for (uint32_t i = 0; i < n_changes; i++) {
        expect_set(cam_err_busy, changes[i].id, changes[i].value);
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(machine()));
    (void)until_rest();
    for (uint32_t i = 0; i < n_changes; i++) {
        set(changes[i].id, changes[i].value);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT(cam_err_u_speed, cam_machine_feasibility(machine()).err);
}

static void test_refusals_carry_the_limit(void)
{
    set(cam_param_x_low_nm, -2 * mm);
    set(cam_param_x_high_nm, 3 * mm);
    to_manual();
    cam_verdict_t verdict = cam_machine_jog(machine(), hal_axis_x, -10001);
    TEST_ASSERT_EQUAL_INT(cam_err_hand_speed, verdict.err);
    TEST_ASSERT_EQUAL_INT32(10000, verdict.value);
    verdict = cam_machine_step(machine(), hal_axis_x, 3 * mm + 1);
    TEST_ASSERT_EQUAL_INT(cam_err_travel, verdict.err);
    TEST_ASSERT_INT32_WITHIN(20, 3 * mm, verdict.value);
    verdict = cam_machine_step(machine(), hal_axis_u, -700000);
    TEST_ASSERT_EQUAL_INT(cam_err_travel, verdict.err);
    TEST_ASSERT_INT32_WITHIN(200, -600000, verdict.value);
    expect_jog(cam_err_hand_axis, hal_n_axes, 1);
    TEST_ASSERT_EQUAL_INT(cam_err_home_none, cam_machine_home_axis(machine(), hal_axis_x));
    for (int32_t method = 4; method <= 5; method++) { // a stop: U would press with all its force
        set(cam_param_u_home, method);
        TEST_ASSERT_EQUAL_INT(cam_err_home_none, cam_machine_home_axis(machine(), hal_axis_u));
    }
    expect_set(cam_err_param_range, cam_param_x_home, 4);
    TEST_ASSERT_EQUAL_UINT32(0, fixture_rig_status(&rig).jog.serial);
    // Limits of the travel hold from the home on, which an axis without a home always has.
    set(cam_param_x_home, 2);
    expect_step(cam_ok, hal_axis_x, 4 * mm);
    stop_and_rest();
    set(cam_param_x_home, 0);
    expect_step(cam_err_travel, hal_axis_x, 4 * mm);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(machine()));
    fixture_rig_ticks(&rig, 20);
    set(cam_param_z_is_measured, 1); // others move it
    to_manual();
    expect_jog(cam_err_hand_axis, hal_axis_z, 100);
}

/// U presses on its stop by the force for it, but no more than its motor has when it is hot.
static void test_search_of_a_stop_presses_by_what_the_motor_has(void)
{
    static const struct {
        int32_t method, home_mn, continuous_mn, limit_mn, press_mn;
    } rows[] = {
        {4, 1000, 2000, 3000, 1000}, {5, 3000, 2000, 4000, 2000}, {5, 3000, 2500, 900, 900}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        setUp();
        to_manual();
        hal_host.slow.force.quantum_un = 20000;
        cam_params_t *p = &machine()->params;
        p->u_home = rows[i].method;
        p->u_home_force_mn = rows[i].home_mn;
        p->servo_continuous_mn = rows[i].continuous_mn;
        p->servo_force_limit_mn = rows[i].limit_mn;
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_u));
        const cam_jog_config_t *jog = &cam_machine_newest_config(machine())->play.jog;
        const cam_jog_order_t *o = &jog->order;
        TEST_ASSERT_EQUAL_INT32(64 * rows[i].press_mn, o->press_q6);
        TEST_ASSERT_EQUAL(rows[i].method == 5, o->has_index);
        TEST_ASSERT_EQUAL_UINT32(50, o->still_plans); // 20 ms
        TEST_ASSERT_EQUAL_INT64(jog->u_end_q10, o->high_q10);
        TEST_ASSERT_EQUAL_INT64(-jog->u_end_q10, o->low_q10);
    }
}

/// To the end itself U may go, and not a nanometre further.
static void test_step_reaches_the_end_of_the_travel(void)
{
    to_manual();
    for (int32_t sense = -1; sense <= 1; sense += 2) {
        const cam_verdict_t beyond = cam_machine_step(machine(), hal_axis_u, sense * 2 * mm);
        TEST_ASSERT_EQUAL_INT(cam_err_travel, beyond.err);
        const int32_t room_nm = beyond.value - port_nm(hal_axis_u);
        expect_step(cam_err_travel, hal_axis_u, room_nm + sense);
        expect_step(cam_ok, hal_axis_u, room_nm);
        TEST_ASSERT_EQUAL_INT(cam_jog_done, until_rest());
        TEST_ASSERT_EQUAL_INT32(beyond.value, port_nm(hal_axis_u));
    }
}

/// A drive that can hardly brake is not jogged faster than it brakes within what is looked ahead.
static void test_jog_is_no_faster_than_the_axis_can_brake(void)
{
    set(cam_param_x_acceleration_mm_per_s2, 10);
    set(cam_param_x_jog_um_per_s, 100000);
    to_manual();
    set(cam_param_u_acceleration_mm_per_s2, 100);
    set(cam_param_u_jog_um_per_s, 100000);
    for (hal_axis_t axis = hal_axis_u; axis <= hal_axis_x; axis++) {
        const cam_verdict_t verdict = cam_machine_jog(machine(), axis, 100000);
        TEST_ASSERT_EQUAL_INT(cam_err_hand_speed, verdict.err);
        // roots of 2 * 25.4 and 2 * 2.73 mm/s2 * 2.097 mm
        TEST_ASSERT_INT32_WITHIN(50, axis == hal_axis_u ? 10310 : 3385, verdict.value);
    }
}

/// An order waits for what is posted and for a stop to be taken, not for the axis to rest.
static void test_one_order_after_the_other(void)
{
    set(cam_param_x_home, 2);
    to_manual();
    machine()->n_requests++; // something is posted and not carried out
    expect_jog(cam_err_busy, hal_axis_x, 100);
    machine()->n_requests--;
    expect_step(cam_ok, hal_axis_z, 5 * mm);
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_stop(machine()));
    fixture_rig_ticks(&rig, 400);
    expect_jog(cam_err_hand_moves, hal_axis_x, 1);
    expect_jog(cam_err_hand_moves, hal_axis_z, -100);
    expect_step(cam_err_hand_moves, hal_axis_z, 1);
    TEST_ASSERT_EQUAL_INT(cam_err_hand_moves, cam_machine_home_axis(machine(), hal_axis_x));
    TEST_ASSERT_EQUAL_INT(cam_err_hand_moves, cam_machine_zero(machine(), hal_axis_z, 0).err);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(machine()));
    expect_jog(cam_err_busy, hal_axis_z, -100);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_NOT_EQUAL_INT32(0, hal_host.out.axis[hal_axis_z].vel_q10); // it brakes
    expect_jog(cam_ok, hal_axis_z, -100);
    stop_and_rest();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_x));
    fixture_rig_ticks(&rig, 20);
    expect_jog(cam_err_hand_moves, hal_axis_x, 1);
}

/// An order goes on when a parameter changes. One that was not taken before the state was left is
/// not begun in the next manual.
static void test_order_is_not_kept_for_the_next_manual(void)
{
    to_manual();
    expect_jog(cam_ok, hal_axis_x, 1000);
    fixture_rig_ticks(&rig, 200);
    set(cam_param_phase_udeg, 1000);
    fixture_rig_ticks(&rig, 200);
    TEST_ASSERT_GREATER_THAN_INT32(0, hal_host.out.axis[hal_axis_x].vel_q10);
    stop_and_rest();
    expect_jog(cam_ok, hal_axis_x, 1000);
    cam_machine_request(machine(), cam_request_disable);
    fixture_rig_ticks(&rig, 200);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    const int32_t x_nm = hal_host.out.axis[hal_axis_x].pos_nm;
    to_manual();
    fixture_rig_ticks(&rig, 2000);
    TEST_ASSERT_EQUAL_INT32(x_nm, hal_host.out.axis[hal_axis_x].pos_nm);
}

static void test_jog_without_travel_limits_ends_at_one_metre(void)
{
    hal_host.in.axis_nm[hal_axis_x] = 999900000;
    fixture_rig_tick(&rig);
    to_manual();
    for (uint32_t i = 0; i < 10u; i++) {
        expect_jog(cam_ok, hal_axis_x, 10000);
        fixture_rig_ticks(&rig, 1000);
    }
    TEST_ASSERT_INT32_WITHIN(10, 1000 * mm - 10, port_nm(hal_axis_x)); // less room to brake
    TEST_ASSERT_EQUAL_INT(cam_jog_limit, jog_state().end);
}

/// X needs room for the smallest radius, for its clearance and for a rehearsal, trims included.
static void test_work_out_of_the_travel_of_x_is_refused(void)
{
    const int32_t clear_nm = cam_demand_clearance_nm(&machine()->table, &machine()->params);
    set(cam_param_x_low_nm, 45995000); // the skirt's smallest radius is 45.9928 mm
    set(cam_param_x_high_nm, 46 * mm + clear_nm + 50000);
    TEST_ASSERT_EQUAL_INT(cam_err_travel, cam_machine_enable(machine()));
    set(cam_param_x_low_nm, 45980000);
    set(cam_param_rehearse_turns, 3);
    TEST_ASSERT_EQUAL_INT(cam_err_travel, cam_machine_enable(machine()));
    const cam_status_t status = fixture_rig_status(&rig);
    machine()->table.speed.knots = machine()->table.u.knots; // a modulated speed is not rehearsed
    TEST_ASSERT_TRUE(cam_machine_is_x_in_travel(machine(), &status, 0));
    machine()->table.speed.knots = NULL;
    set(cam_param_rehearse_turns, 0);
    hal_host.in.axis_nm[hal_axis_x] = 46500000;
    bring(cam_state_cutting);
    expect_set(cam_err_travel, cam_param_x_trim_nm, -20000);
    expect_set(cam_ok, cam_param_x_trim_nm, -2000);
}

/// The search has changed U's numbers, so U is not cut with before its home is found. This is
/// remembered of U alone, of a search alone and of one that began; what follows does not make it
/// forgotten.
static void test_only_a_search_of_u_makes_its_home_lost(void)
{
    set(cam_param_x_home, 2);
    set(cam_param_u_home, 1);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_x));
    TEST_ASSERT_FALSE(machine()->offsets.has_searched_u);
    stop_and_rest();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_u)); // it is here
    TEST_ASSERT_FALSE(machine()->offsets.has_searched_u);
    (void)until_rest();
    set(cam_param_u_home, 2);
    expect_set(cam_ok, cam_param_phase_udeg, 5);
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_home_axis(machine(), hal_axis_u));
    TEST_ASSERT_FALSE(machine()->offsets.has_searched_u);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_u));
    TEST_ASSERT_TRUE(machine()->offsets.has_searched_u);
    TEST_ASSERT_EQUAL_INT(cam_jog_no_switch, until_rest());
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_x));
    TEST_ASSERT_TRUE(machine()->offsets.has_searched_u);
    stop_and_rest();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(machine()));
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_err_not_homed, cam_machine_enable(machine()));
    set(cam_param_u_home, 0);
    TEST_ASSERT_EQUAL_INT(cam_err_not_homed, cam_machine_enable(machine()));
}

// Limits that change

/// Jog an axis for 2000 ticks; it still moves.
static void jog(hal_axis_t axis, int32_t um_per_s)
{
    to_manual();
    expect_jog(cam_ok, axis, um_per_s);
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
        expect_step(cam_ok, hal_axis_u, places_nm[i]);
        TEST_ASSERT_EQUAL_INT(cam_jog_done, until_rest());
        TEST_ASSERT_EQUAL_INT32(places_nm[i], port_nm(hal_axis_u));
        expect_set(cam_err_u_place, cam_param_u_stroke_nm, 399998);
        TEST_ASSERT_EQUAL_INT(cam_param_u_stroke_nm, machine()->refusal.param);
        TEST_ASSERT_EQUAL_INT64(200000, machine()->refusal.needed);
        TEST_ASSERT_EQUAL_INT64(199999, machine()->refusal.limit);
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
