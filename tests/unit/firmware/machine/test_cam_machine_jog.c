// SPDX-License-Identifier: Apache-2.0
// Commands of the state manual: their order, limits and refusals; replay of a session by hand.
#include "cam_demand.h"        // cam_demand_clearance_nm
#include "cam_machine_inner.h" // cam_machine_request
#include "jog_bench.h"
#include <string.h>

static void test_commands_by_hand_are_refused_in_every_other_state(void)
{
    static const cam_state_t states[] = {cam_state_off, cam_state_homing, cam_state_ready,
                                         cam_state_engaging, cam_state_cutting};
    for (uint32_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        setUp();
        bring(states[i]);
        const uint32_t generation = machine()->generation;
        TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_jog(machine(), hal_axis_x, 100).err);
        TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_step(machine(), hal_axis_x, 100).err);
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
    TEST_ASSERT_EQUAL_INT(cam_err_param_state,
                          cam_machine_set_param(machine(), cam_param_counts_per_turn, 4096));
    static const cam_request_t wrong[] = {cam_request_enable, cam_request_start, cam_request_reset,
                                          cam_request_identify, cam_request_manual};
    for (uint32_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        cam_machine_request(machine(), wrong[i]);
        fixture_rig_ticks(&rig, 20);
        TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
    }
}

/// Gains and limits of U wait until it rests; nothing is cut, so a slow U is accepted.
static void test_gains_and_limits_of_a_jogged_u_wait_until_it_rests(void)
{
    static const cam_param_id_t ids[] = {cam_param_k1_ns,
                                         cam_param_k2_us2,
                                         cam_param_u_stroke_nm,
                                         cam_param_u_speed_um_per_s,
                                         cam_param_u_acceleration_mm_per_s2,
                                         cam_param_u_jerk_m_per_s3};
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(machine(), hal_axis_u, 1000).err);
    fixture_rig_ticks(&rig, 100);
    for (uint32_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        const int32_t old = cam_param_get(&machine()->params, ids[i]);
        TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_set_param(machine(), ids[i], old + 1));
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(machine()));
    (void)until_rest();
    set(cam_param_k2_us2, 1);
    set(cam_param_k2_us2, 0);
    set(cam_param_u_speed_um_per_s, 5000);
    TEST_ASSERT_EQUAL_INT(cam_err_u_speed, cam_machine_check_speed(machine(), 0));
}

static void test_manual_is_refused_for_what_enable_is(void)
{
    hal_host_fault_estop(true);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_estop, cam_machine_manual(machine()));
    hal_host_fault_estop(false);
    hal_host_fault_drive(true);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_drive, cam_machine_manual(machine()));
    hal_host_fault_drive(false);
    hal_host_fault_bus(true);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_bus, cam_machine_manual(machine()));
    hal_host_fault_bus(false);
    hal_host.in.axis_nm[hal_axis_u] = machine()->params.u_stroke_nm;
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_u_place, cam_machine_manual(machine()));
}

static void test_manual_needs_no_table(void)
{
    cam_machine_init(machine(), &g_cam, 20000, hal_clock_hz());
    fixture_rig_tick(&rig);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(machine(), hal_axis_x, 1000).err);
    fixture_rig_ticks(&rig, 1000);
    TEST_ASSERT_GREATER_THAN_INT32(10000, hal_host.out.axis[hal_axis_x].pos_nm);
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
    TEST_ASSERT_EQUAL_INT(cam_err_hand_axis, cam_machine_jog(machine(), hal_n_axes, 1).err);
    TEST_ASSERT_EQUAL_INT(cam_err_home_none, cam_machine_home_axis(machine(), hal_axis_x));
    TEST_ASSERT_EQUAL_UINT32(0, fixture_rig_status(&rig).jog.serial);
}

/// A drive that can hardly brake is not jogged faster than it brakes within what is looked ahead.
static void test_jog_is_no_faster_than_the_axis_can_brake(void)
{
    set(cam_param_x_acceleration_mm_per_s2, 10);
    set(cam_param_x_jog_um_per_s, 100000);
    to_manual();
    const cam_verdict_t verdict = cam_machine_jog(machine(), hal_axis_x, 100000);
    TEST_ASSERT_EQUAL_INT(cam_err_hand_speed, verdict.err);
    TEST_ASSERT_INT32_WITHIN(50, 3385, verdict.value); // root of 2 * 2.73 mm/s2 * 2.097 mm
}

static void test_measured_z_is_not_moved_by_hand(void)
{
    set(cam_param_z_is_measured, 1);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_err_hand_axis, cam_machine_jog(machine(), hal_axis_z, 100).err);
}

static void test_one_order_after_the_other(void)
{
    set(cam_param_x_home, 2);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_step(machine(), hal_axis_z, 5 * mm).err);
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_stop(machine()));
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_err_hand_moves, cam_machine_jog(machine(), hal_axis_x, 1).err);
    TEST_ASSERT_EQUAL_INT(cam_err_hand_moves, cam_machine_step(machine(), hal_axis_z, 1).err);
    TEST_ASSERT_EQUAL_INT(cam_err_hand_moves, cam_machine_home_axis(machine(), hal_axis_x));
    TEST_ASSERT_EQUAL_INT(cam_err_hand_moves, cam_machine_zero(machine(), hal_axis_z, 0).err);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(machine()));
    fixture_rig_ticks(&rig, 200);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_x));
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_err_hand_moves, cam_machine_jog(machine(), hal_axis_x, 1).err);
}

/// An order that was not taken before the state was left is not begun in the next manual.
static void test_order_is_not_kept_for_the_next_manual(void)
{
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(machine(), hal_axis_x, 1000).err);
    cam_machine_request(machine(), cam_request_disable);
    fixture_rig_ticks(&rig, 200);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    const int32_t x_nm = hal_host.out.axis[hal_axis_x].pos_nm;
    to_manual();
    fixture_rig_ticks(&rig, 2000);
    TEST_ASSERT_EQUAL_INT32(x_nm, hal_host.out.axis[hal_axis_x].pos_nm);
}

/// A parameter may change while an axis moves; its order goes on.
static void test_order_outlives_a_new_configuration(void)
{
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(machine(), hal_axis_x, 1000).err);
    fixture_rig_ticks(&rig, 200);
    set(cam_param_phase_udeg, 1000);
    fixture_rig_ticks(&rig, 200);
    TEST_ASSERT_GREATER_THAN_INT32(0, hal_host.out.axis[hal_axis_x].vel_q10);
}

static void test_jog_without_travel_limits_ends_at_one_metre(void)
{
    hal_host.in.axis_nm[hal_axis_x] = 999900000;
    fixture_rig_tick(&rig);
    to_manual();
    for (uint32_t i = 0; i < 10u; i++) {
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(machine(), hal_axis_x, 10000).err);
        fixture_rig_ticks(&rig, 1000);
    }
    TEST_ASSERT_INT32_WITHIN(10, 1000 * mm - 10, port_nm(hal_axis_x)); // less room to brake
    TEST_ASSERT_EQUAL_INT(cam_jog_limit, jog_state().end);
}

/// The search has changed U's numbers, so U is not cut with before its home is found.
static void test_u_whose_search_failed_is_not_cut_with(void)
{
    set(cam_param_u_home, 2);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_u));
    TEST_ASSERT_EQUAL_INT(cam_jog_no_switch, until_rest());
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(machine()));
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_err_not_homed, cam_machine_enable(machine()));
    set(cam_param_u_home, 0);
    TEST_ASSERT_EQUAL_INT(cam_err_not_homed, cam_machine_enable(machine()));
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
    set(cam_param_rehearse_turns, 0);
    hal_host.in.axis_nm[hal_axis_x] = 46500000;
    bring(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT(cam_err_travel,
                          cam_machine_set_param(machine(), cam_param_x_trim_nm, -20000));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(machine(), cam_param_x_trim_nm, -2000));
}

/// An order waits for what is posted and for a stop to be taken, not for the axis to rest.
static void test_orders_wait_for_requests_and_not_for_rest(void)
{
    to_manual();
    machine()->n_requests++; // something is posted and not carried out
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_jog(machine(), hal_axis_x, 100).err);
    machine()->n_requests--;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_step(machine(), hal_axis_z, 5 * mm).err);
    fixture_rig_ticks(&rig, 400);
    TEST_ASSERT_EQUAL_INT(cam_err_hand_moves, cam_machine_jog(machine(), hal_axis_z, -100).err);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(machine()));
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_jog(machine(), hal_axis_z, -100).err);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_NOT_EQUAL_INT32(0, hal_host.out.axis[hal_axis_z].vel_q10); // it brakes
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(machine(), hal_axis_z, -100).err);
}

/// Whether U was searched is remembered of U alone, of a search alone and of one that began; what
/// comes behind it does not make it forgotten.
static void test_only_a_search_of_u_makes_its_home_lost(void)
{
    set(cam_param_x_home, 2);
    set(cam_param_u_home, 1);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_x));
    TEST_ASSERT_FALSE(machine()->offsets.has_searched_u);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(machine()));
    (void)until_rest();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_u)); // it is here
    TEST_ASSERT_FALSE(machine()->offsets.has_searched_u);
    (void)until_rest();
    set(cam_param_u_home, 2);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(machine(), cam_param_phase_udeg, 5));
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_home_axis(machine(), hal_axis_u));
    TEST_ASSERT_FALSE(machine()->offsets.has_searched_u);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_u));
    TEST_ASSERT_TRUE(machine()->offsets.has_searched_u);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(machine()));
    (void)until_rest();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(machine(), hal_axis_x));
    TEST_ASSERT_TRUE(machine()->offsets.has_searched_u);
}

/// Limits of the travel hold from the home on, which an axis without a home always has.
static void test_travel_holds_where_the_place_is_known(void)
{
    set(cam_param_x_low_nm, -2 * mm);
    set(cam_param_x_high_nm, 3 * mm);
    set(cam_param_x_home, 2);
    to_manual();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_step(machine(), hal_axis_x, 4 * mm).err);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(machine()));
    (void)until_rest();
    set(cam_param_x_home, 0);
    TEST_ASSERT_EQUAL_INT(cam_err_travel, cam_machine_step(machine(), hal_axis_x, 4 * mm).err);
}

/// A session by hand, with homes, a datum, a fault and a cut, replays from its records and
/// configurations to the bit.
static void test_session_by_hand_replays_bit_for_bit(void)
{
    enum { capacity = 60000, max_configs = 64 };
    static cam_config_t configs[max_configs];
    static cam_t replayed;
    memset(configs, 0, sizeof configs);
    memset(&replayed, 0, sizeof replayed);
    const fixture_part_t short_part = fixture_part_short();
    memset(&rig, 0, sizeof rig);
    rig.log = calloc(capacity, sizeof *rig.log);
    TEST_ASSERT_NOT_NULL(rig.log);
    rig.lathe.ramp_rpm = 1.25;
    rig.log_capacity = capacity;
    rig.lathe.home[hal_axis_u] = (ideal_home_t){.side = 1, .edge_nm = 50000};
    rig.lathe.home[hal_axis_x] = (ideal_home_t){.side = 1, .edge_nm = 60 * mm, .pitch_nm = mm};
    hal_host_reset(20000);
    hal_host.in.axis_nm[hal_axis_x] = 59900000;
    cam_machine_init(machine(), &g_cam, 20000, hal_clock_hz());
    fixture_encoder_init(&rig.lathe.encoder, machine()->params.counts_per_turn, 1, 1000u, 1234);
    configs[0] = *g_cam.config.offered;
    TEST_ASSERT_EQUAL_UINT32(1, configs[0].generation);
    configs[1] = configs[0];
    fixture_rig_ticks(&rig, 2);
    fixture_image_make(&rig.image, &short_part);
    static const struct {
        cam_param_id_t id;
        int32_t value;
    } sets[] = {{cam_param_u_home, 2},          {cam_param_x_home, 3},
                {cam_param_x_home_nm, 60 * mm}, {cam_param_x_home_slow_um_per_s, 10000},
                {cam_param_lead_ns, 50000},     {cam_param_z_datum_nm, mm}};
    enum { n_sets = sizeof sets / sizeof sets[0] };
    enum { table = n_sets, manual, home_x, home_u, jog, off, enable, start, n_steps };
    for (uint32_t step = 0; step < n_steps; step++) {
        cam_err_t err = cam_ok;
        if (step < n_sets) {
            err = cam_machine_set_param(machine(), sets[step].id, sets[step].value);
        } else if (step == table) {
            err = cam_machine_select_table(machine(), rig.image.bytes, rig.image.size);
        } else if (step == manual) {
            err = cam_machine_manual(machine());
        } else if (step == home_x || step == home_u) {
            err = cam_machine_home_axis(machine(), step == home_x ? hal_axis_x : hal_axis_u);
        } else if (step == jog) {
            err = cam_machine_jog(machine(), hal_axis_z, -3000).err;
        } else if (step == off) {
            err = cam_machine_disable(machine());
        } else {
            err = step == enable ? cam_machine_enable(machine()) : cam_machine_start(machine());
        }
        TEST_ASSERT_EQUAL_INT(cam_ok, err);
        const uint32_t n_ticks = step <= table ? 1u : step == start ? 6000u : 5000u;
        for (uint32_t i = 0; i < n_ticks; i++) {
            const cam_config_t *now = g_cam.config.offered;
            TEST_ASSERT_LESS_THAN_UINT32(max_configs, now->generation);
            configs[now->generation] = *now;
            fixture_rig_tick(&rig);
            if (i % 1000u == 999u) {
                cam_machine_keep_alive(machine());
            }
            cam_machine_jog_poll(machine());
        }
    }
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, rig.last.want.state);
    TEST_ASSERT_EQUAL_HEX32(3u, fixture_rig_status(&rig).jog.homed); // U and X
    TEST_ASSERT_LESS_THAN_UINT32(capacity, rig.n_log);
    uint32_t generation = 0;
    cam_config_t *half = &replayed.config.half[0];
    for (uint32_t i = 0; i < rig.n_log; i++) {
        const cam_tick_record_t *r = &rig.log[i];
        if (r->config != generation) {
            *half = configs[r->config];
            half->play.table = half->play.table != NULL ? &half->table : NULL;
            generation = r->config;
        }
        cam_tick_record_t done = {.tick = r->tick, .in = r->in};
        cam_tick_steps_isr(&replayed, half, &done);
        TEST_ASSERT_EQUAL_MEMORY(r->out, done.out, sizeof done.out);
        TEST_ASSERT_EQUAL_INT32(r->want.u_set_q6, done.want.u_set_q6);
        TEST_ASSERT_EQUAL_INT32(r->want.u_due_q6, done.want.u_due_q6);
        TEST_ASSERT_EQUAL_INT32(r->want.z_nm, done.want.z_nm);
        TEST_ASSERT_EQUAL_HEX32(r->want.faults, done.want.faults);
        TEST_ASSERT_EQUAL_INT(r->want.state, done.want.state);
    }
    free(rig.log);
}
