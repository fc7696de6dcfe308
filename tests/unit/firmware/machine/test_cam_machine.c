// SPDX-License-Identifier: Apache-2.0
// The slow side: what it refuses in which state or because the machine cannot do it, that a refusal
// changes nothing, and a start with a spindle that does not turn steadily.
#include "cam_machine.h"
#include "rig_bench.h"

static cam_machine_t *const m = &rig.machine;
static fixture_image_t other;

static void to_fault(void)
{
    bring(cam_state_cutting);
    hal_host_fault_estop(true);
    fixture_rig_tick(&rig);
}

typedef cam_err_t command_fn(cam_machine_t *machine);

static void test_commands_out_of_order_are_refused_and_change_nothing(void)
{
    static command_fn *const commands[] = {cam_machine_enable, cam_machine_disable,
                                           cam_machine_start, cam_machine_stop, cam_machine_reset};
    static const bool allowed[cam_n_states][5] = {
        [cam_state_off] = {true, false, false, false, false},
        [cam_state_homing] = {false, true, false, false, false},
        [cam_state_ready] = {false, true, true, false, false},
        [cam_state_engaging] = {false, false, false, true, false},
        [cam_state_cutting] = {false, false, false, true, false},
        [cam_state_disengaging] = {false, false, false, false, false},
    };
    for (uint32_t state = 0; state < cam_state_fault; state++) {
        for (uint32_t i = 0; i < 5u; i++) {
            setUp();
            bring((cam_state_t)state);
            const uint32_t n = m->n_requests;
            const cam_err_t err = commands[i](m);
            TEST_ASSERT_EQUAL_INT(allowed[state][i] ? cam_ok : cam_err_state, err);
            TEST_ASSERT_EQUAL_UINT32(n + (allowed[state][i] ? 1u : 0u), m->n_requests);
        }
    }
}

static void test_fault_is_left_by_reset_after_the_retract_only(void)
{
    to_fault();
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_reset(m));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_enable(m));
    hal_host_fault_estop(false); // the latch holds all the same
    fixture_rig_ticks(&rig, 2000);
    TEST_ASSERT_TRUE(fixture_rig_status(&rig).is_retracted);
    TEST_ASSERT_EQUAL_HEX32(hal_out_fault, hal_host.out.outputs);
    hal_host_fault_estop(true);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(m));
    fixture_rig_ticks(&rig, 2);
    const cam_status_t status = fixture_rig_status(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, status.state);
    TEST_ASSERT_EQUAL_HEX32(0, status.faults);
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), status.first_fault); // still reported
    TEST_ASSERT_EQUAL_HEX32(0, hal_host.out.outputs);
    hal_host_fault_estop(false);
    fixture_rig_tick(&rig);
    bring(cam_state_cutting); // homes and cuts anew
}

/// Neither for the work nor by hand, whatever it is that forbids it.
static void test_inputs_forbid_to_enable(void)
{
    static const struct {
        void (*fail)(bool);
        cam_err_t err;
    } inputs[] = {{hal_host_fault_estop, cam_err_estop},
                  {hal_host_fault_drive, cam_err_drive},
                  {hal_host_fault_bus, cam_err_bus}};
    for (uint32_t i = 0; i < sizeof inputs / sizeof inputs[0]; i++) {
        inputs[i].fail(true);
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT(inputs[i].err, cam_machine_enable(m));
        TEST_ASSERT_EQUAL_INT(inputs[i].err, cam_machine_manual(m));
        inputs[i].fail(false);
    }
    fixture_rig_tick(&rig);
    hal_host.slow.force.quantum_un = 20000; // a U that takes forces needs a loop
    m->params.servo_crossover_hz = 0;
    TEST_ASSERT_EQUAL_INT(cam_err_servo_none, cam_machine_enable(m));
    hal_host.slow.force.quantum_un = 0;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(m));
}

/// From outside of the stroke the first set-point would be its edge, and U would jump there.
static void test_enable_is_refused_while_u_stands_outside_its_stroke(void)
{
    const int32_t half_nm = m->params.u_stroke_nm / 2;
    for (int32_t side = -1; side <= 1; side += 2) {
        hal_host.in.axis_nm[hal_axis_u] = side * (half_nm + 1);
        fixture_rig_tick(&rig);
        const uint32_t n = m->n_requests;
        TEST_ASSERT_EQUAL_INT(cam_err_u_place, cam_machine_enable(m));
        TEST_ASSERT_EQUAL_INT(cam_err_u_place, cam_machine_manual(m));
        TEST_ASSERT_EQUAL_UINT32(n, m->n_requests);
        hal_host.in.axis_nm[hal_axis_u] = side * half_nm;
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(m));
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(m));
        fixture_rig_tick(&rig);
    }
}

static void test_request_serial_wraps_without_losing_a_command(void)
{
    m->n_requests = 0xFFFFFEu;
    g_cam.request = 0xFFFFFEu << 8;
    fixture_rig_tick(&rig);
    for (int i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(m));
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT(cam_state_homing, fixture_rig_state());
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(m));
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    }
}

/// A second change, and one between a command and the tick that carries it out, which would be
/// judged for the wrong state.
static void test_changes_wait_for_what_the_interrupt_has_not_taken(void)
{
    expect_set(cam_ok, cam_param_k1_ns, 5);
    expect_set(cam_err_busy, cam_param_k1_ns, 6);
    TEST_ASSERT_EQUAL_INT32(5, m->params.k1_ns);
    expect_select(cam_err_busy);
    const uint32_t before = fixture_rig_status(&rig).config;
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_UINT32(before + 1u, fixture_rig_status(&rig).config);
    expect_set(cam_ok, cam_param_k1_ns, 6);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(m));
    expect_set(cam_err_busy, cam_param_counts_per_turn, 4096);
    expect_select(cam_err_busy);
    fixture_rig_tick(&rig);
    expect_set(cam_err_param_state, cam_param_counts_per_turn, 4096);
}

static void test_parameters_change_only_where_they_may(void)
{
    static const cam_param_id_t ids[] = {cam_param_counts_per_turn, cam_param_k1_ns,
                                         cam_param_z_is_measured,   cam_param_lead_ns,
                                         cam_param_phase_udeg,      cam_param_amplitude_ppm};
    static const bool allowed[cam_n_states][6] = {
        [cam_state_off] = {true, true, true, true, true, true},
        [cam_state_ready] = {false, true, false, true, true, true},
        [cam_state_engaging] = {false, false, false, false, true, true},
        [cam_state_cutting] = {false, false, false, false, true, true},
        [cam_state_disengaging] = {false, false, false, false, true, true},
    };
    for (uint32_t state = 0; state < cam_state_fault; state++) {
        bring((cam_state_t)state);
        for (uint32_t i = 0; i < 6u; i++) {
            expect_set(allowed[state][i] ? cam_ok : cam_err_param_state, ids[i],
                       cam_param_get(&m->params, ids[i]));
            fixture_rig_tick(&rig);
        }
        setUp();
    }
    to_fault();
    expect_set(cam_err_param_state, cam_param_k1_ns, 1);
}

/// The angle would be another one at once: what it is made of stays as long as it is in force.
static void test_what_makes_the_angle_changes_in_off_only(void)
{
    for (int is_manual = 0; is_manual < 2; is_manual++) {
        setUp();
        if (is_manual != 0) {
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(m));
            until(cam_state_manual);
        } else {
            bring(cam_state_ready);
        }
        for (cam_param_id_t id = 0; id < cam_n_params; id++) {
            const bool is_of_angle = cam_param_has(id, cam_flag_off);
            expect_set(is_of_angle ? cam_err_param_state : cam_ok, id,
                       cam_param_get(&m->params, id));
            fixture_rig_tick(&rig);
        }
    }
}

static void test_parameter_errors_leave_everything_as_it_was(void)
{
    const cam_params_t before = m->params;
    const uint32_t generation = m->generation;
    expect_set(cam_err_param_id, cam_n_params, 1);
    expect_set(cam_err_param_range, cam_param_lead_ns, -1);
    expect_set(cam_err_param_tick, cam_param_observer_bandwidth_mHz, 1600001);
    TEST_ASSERT_EQUAL_MEMORY(&before, &m->params, sizeof before);
    TEST_ASSERT_EQUAL_UINT32(generation, m->generation);
}

static void test_without_a_table_nothing_starts(void)
{
    cam_machine_init(m, &g_cam, 20000, hal_clock_hz());
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_no_table, cam_machine_enable(m));
    TEST_ASSERT_EQUAL_INT(cam_err_no_table, cam_machine_feasibility(m).err);
    TEST_ASSERT_EQUAL_INT(cam_n_params, cam_machine_feasibility(m).param);
    TEST_ASSERT_EQUAL_UINT32(0, cam_machine_highest_mrpm(m));
    g_cam.request = 1u << 8 | cam_request_enable;
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    cam_machine_poll(m);
    TEST_ASSERT_FALSE(m->has_table);
    m->n_requests = 1; // that one
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(m));
    until(cam_state_manual);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_jog(m, hal_axis_x, 1000).err);
    fixture_rig_ticks(&rig, 1000);
    TEST_ASSERT_GREATER_THAN_INT32(10000, hal_host.out.axis[hal_axis_x].pos_nm);
    hal_host_fault_estop(true);
    until(cam_state_fault);
    cam_machine_stage_begin(m);
    const uint32_t generation = m->generation;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stage_commit(m)); // there is nothing to judge
    TEST_ASSERT_EQUAL_UINT32(generation + 1u, m->generation);
    TEST_ASSERT_EQUAL_UINT32(m->params.spindle_mrpm, cam_machine_feasibility(m).speed_mrpm);
}

/// A slow tick slows the observer. A measurement over a field bus, at slow ticks, is too old for a
/// following error that follows from the part.
static void test_init_fits_the_parameters_to_the_port(void)
{
    static const struct {
        uint32_t tick_hz;
        bool measures_u;
        int32_t following_nm, bandwidth_mHz;
    } cases[] = {{20000, false, 100000, 200000},
                 {20000, true, 0, 100000},
                 {1000, true, 100000, 50000},
                 {500, false, 100000, 25000}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        hal_host.slow.measures_u = cases[i].measures_u;
        cam_machine_init(m, &g_cam, cases[i].tick_hz, hal_clock_hz());
        TEST_ASSERT_EQUAL_INT32(cases[i].following_nm, m->params.following_limit_nm);
        TEST_ASSERT_EQUAL_INT32(cases[i].bandwidth_mHz, m->params.observer_bandwidth_mHz);
    }
}

static void test_select_table_needs_a_good_one_and_the_right_state(void)
{
    fixture_image_make(&other, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_check_table(m, other.bytes, other.size));
    other.bytes[other.size - 1u] ^= 1u;
    TEST_ASSERT_EQUAL_INT(cam_err_image_crc, cam_machine_check_table(m, other.bytes, other.size));
    TEST_ASSERT_EQUAL_INT(cam_err_image_crc, cam_machine_select_table(m, other.bytes, other.size));
    TEST_ASSERT_EQUAL_PTR(rig.image.bytes, m->table.image);
    bring(cam_state_ready);
    fixture_image_make(&other, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_select_table(m, other.bytes, other.size));
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_PTR(other.bytes, m->table.image);
    fixture_part_t reversed = part;
    reversed.direction = -1;
    fixture_image_make(&rig.image, &reversed);
    expect_select(cam_err_table_sense);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_select_table(m, other.bytes, other.size));
}

static void expect_crc_error(const fixture_image_t *image, bool has_table)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_crc,
                          cam_machine_select_table(m, image->bytes, image->size));
    TEST_ASSERT_EQUAL(has_table, m->has_table);
}

/// The table in use ends when it is selected again and was overwritten; in off and fault without a
/// request. Until a posted request is taken it stays.
static void test_a_damaged_selection_ends_the_table_in_use_alone(void)
{
    static const cam_state_t states[] = {cam_state_off, cam_state_ready, cam_state_fault};
    for (uint32_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        setUp();
        if (states[i] == cam_state_fault) {
            to_fault();
        } else {
            bring(states[i]);
        }
        fixture_image_make(&other, &part);
        other.bytes[1000] ^= 8u;
        expect_crc_error(&other, true);
        const uint32_t n_requests = m->n_requests;
        rig.image.bytes[1000] ^= 8u;
        expect_crc_error(&rig.image, false);
        expect_crc_error(&rig.image, false);
        TEST_ASSERT_EQUAL_UINT32(n_requests + (states[i] == cam_state_ready), m->n_requests);
    }
    setUp();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(m)); // not taken yet
    rig.image.bytes[1000] ^= 8u;
    expect_crc_error(&rig.image, true);
}

/// Two rounds of the check in the background: the first may have passed the damage already.
static void expect_found(bool is_found)
{
    for (uint32_t i = 0; i <= rig.image.size / 512u + 1u; i++) {
        cam_machine_poll(m);
    }
    TEST_ASSERT_EQUAL(is_found, !m->has_table);
}

/// While the interrupt is busy it tries again.
static void test_poll_finds_damage_in_every_state(void)
{
    for (uint32_t state = 0; state < cam_state_fault; state++) {
        setUp();
        bring((cam_state_t)state);
        expect_found(false);
        rig.image.bytes[1000] ^= 8u;
        expect_found(true);
        TEST_ASSERT_EQUAL_INT(state == cam_state_ready ? cam_err_no_table : cam_err_state,
                              cam_machine_start(m));
        fixture_rig_tick(&rig);
        const cam_status_t status = fixture_rig_status(&rig);
        TEST_ASSERT_EQUAL_INT(state == cam_state_off ? cam_state_off : cam_state_fault,
                              status.state);
        TEST_ASSERT_EQUAL_HEX32(state == cam_state_off ? 0 : CAM_FAULT_BIT(table),
                                status.first_fault);
    }
    setUp();
    bring(cam_state_ready);
    rig.image.bytes[1000] ^= 8u;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m)); // not taken yet
    expect_found(false);
    fixture_rig_tick(&rig);
    expect_found(true);
}

/// The command home is an off of a tick or two. The plan forgets the angle, wherever between two
/// plans, which are eight ticks apart, that off falls: ready always rests on an index seen anew.
static void test_home_finds_the_index_anew_in_every_phase_of_the_plan(void)
{
    for (uint32_t phase = 0; phase < 8u; phase++) {
        setUp();
        bring(cam_state_ready);
        fixture_rig_ticks(&rig, phase);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home(m));
        for (int i = 0; i < 10 && fixture_rig_state() != cam_state_homing; i++) {
            fixture_rig_tick(&rig);
            cam_machine_poll(m);
        }
        TEST_ASSERT_EQUAL_INT(cam_state_homing, fixture_rig_state());
        fixture_rig_ticks(&rig, 8);
        TEST_ASSERT_FALSE(fixture_rig_status(&rig).is_synced);
        until(cam_state_ready);
        TEST_ASSERT_TRUE(fixture_rig_status(&rig).is_synced);
    }
}

// Limits

/// In ready the spindle turns, so a value that it must not take is refused at once.
static void test_ready_refuses_what_the_spindle_or_u_cannot_do(void)
{
    bring(cam_state_ready);
    expect_set(cam_err_u_retract, cam_param_u_retract_nm, -15000000);
    expect_set(cam_err_spindle_speed, cam_param_spindle_mrpm, 30000000);
    set(cam_param_spindle_mrpm, 2600000);
    expect_set(cam_err_spindle_speed, cam_param_spindle_limit_mrpm, 2500000);
    set(cam_param_spindle_mrpm, 0);
    set(cam_param_spindle_limit_mrpm, 2550000);
    fixture_part_t fast = part;
    fast.spindle_mrpm = 2600000;
    fixture_image_make(&other, &fast);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed,
                          cam_machine_select_table(m, other.bytes, other.size));
    fixture_rig_ticks(&rig, 3);
    TEST_ASSERT_EQUAL_INT32(2500000, hal_host.out.spindle_mrpm);
}

static void test_start_beyond_the_limits_is_refused_before_motion(void)
{
    set(cam_param_spindle_mrpm, 3500000);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed, cam_machine_enable(m));
    const cam_refusal_t why = cam_machine_feasibility(m);
    TEST_ASSERT_EQUAL_INT64(3500000, why.needed);
    TEST_ASSERT_EQUAL_INT64(3000000, why.limit);
    TEST_ASSERT_EQUAL_UINT32(3000000, why.highest_mrpm);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed, why.err);
    set(cam_param_spindle_mrpm, (int32_t)why.highest_mrpm);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_feasibility(m).err);
    TEST_ASSERT_EQUAL_UINT32(why.highest_mrpm, cam_machine_highest_mrpm(m));
    TEST_ASSERT_EQUAL_UINT32(3030000, m->limit_mrpm);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
}

static void test_amplitude_that_the_running_speed_forbids_is_refused_in_the_cut(void)
{
    set(cam_param_u_acceleration_mm_per_s2, 21000);
    bring(cam_state_cutting); // needs 20 600 at amplitude 1
    expect_set(cam_err_u_acceleration, cam_param_amplitude_ppm, 1100000);
    expect_set(cam_ok, cam_param_amplitude_ppm, 900000);
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
    TEST_ASSERT_EQUAL_INT(cam_err_cam_amplitude, cam_machine_enable(m));
    const cam_refusal_t why = cam_machine_feasibility(m);
    TEST_ASSERT_EQUAL_INT64(1000000, why.needed);
    TEST_ASSERT_EQUAL_INT64(999999, why.limit);
    TEST_ASSERT_EQUAL_UINT32(0, why.highest_mrpm);
    set(cam_param_amplitude_ppm, 0);
    TEST_ASSERT_EQUAL_INT(cam_err_cam_amplitude, cam_machine_enable(m));
    set(cam_param_amplitude_ppm, 1000000);
    bring(cam_state_cutting);
    expect_set(cam_err_cam_amplitude, cam_param_amplitude_ppm, 999999);
    expect_set(cam_ok, cam_param_amplitude_ppm, 1100000);
}

// Steady spindle

/// Let the spindle gain or lose a share per tick for n ticks, with rare rounds of the main loop.
static void turn(double share, uint32_t n)
{
    rig.lathe.is_spindle_held = true;
    for (uint32_t i = 0; i < n; i++) {
        rig.lathe.rpm *= 1.0 + share;
        fixture_rig_tick(&rig);
        if (i % 100u == 0u) {
            cam_machine_poll(m);
        }
    }
}

/// A start whose spindle falls from 2500 r/min by 0.6 % per turn, which takes 480 ticks.
static void start_unsteady(void)
{
    bring(cam_state_ready);
    set(cam_param_ripple_turns, 0);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    turn(-0.006 / 480, 23000);
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
    TEST_ASSERT_FALSE(m->is_unsteady);
    TEST_ASSERT_EQUAL_UINT32(0, fixture_rig_status(&rig).steady.waited_ticks);
}

static void test_start_ends_without_a_steady_spindle(void)
{
    set(cam_param_stopped_ms, 20); // so the patience is 2 s
    start_unsteady();
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, fixture_rig_state());
    TEST_ASSERT_FALSE(m->is_unsteady);
    turn(-0.006 / 480, 20000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    TEST_ASSERT_TRUE(m->is_unsteady);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    TEST_ASSERT_EQUAL_UINT32(0, m->n_parts); // the pass is repeated
    TEST_ASSERT_TRUE(m->is_cut_short);
    turn(0, 2000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    TEST_ASSERT_FALSE(m->is_unsteady);
    turn(0, 20000);
    TEST_ASSERT_TRUE(g_cam.motion.is_playing);
}

/// A slow spindle is given the time of its turns: 10 r/min, 6 s each. So is one whose turns agree:
/// 72 turns of 24 ms take longer than the patience of 1 s.
static void test_slow_spindle_has_time_for_its_turns(void)
{
    set(cam_param_stopped_ms, 10);
    bring(cam_state_ready);
    turn(-5.521461 / 6000, 6000); // to 1/250
    set(cam_param_ripple_turns, 0);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    turn(0, 200000); // 10 s, and the patience is 1 s
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, fixture_rig_state());
    turn(0, 120000);
    TEST_ASSERT_TRUE(g_cam.motion.is_playing);
    setUp();
    set(cam_param_stopped_ms, 10);
    set(cam_param_ripple_turns, 64);
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    turn(0, 30000);
    TEST_ASSERT_GREATER_THAN_UINT32(20000, fixture_rig_status(&rig).steady.waited_ticks);
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, fixture_rig_state());
}

static void expect_turns(uint32_t n)
{
    TEST_ASSERT_EQUAL_UINT32(n, atomic_load(&g_cam.config.offered)->play.steady_turns);
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
        expect_turns(cases[i].turns);
    }
    m->ilc.ripple.n_mean = 2; // known from an earlier part
    set(cam_param_ripple_turns, 8);
    expect_turns(16);
    m->ilc.blending = 0; // it is in force
    set(cam_param_rehearse_turns, 0);
    expect_turns(1);
}
