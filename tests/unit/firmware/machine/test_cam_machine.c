// SPDX-License-Identifier: Apache-2.0
// The slow side: what it refuses in which state, and that a refusal changes nothing.
#include "cam_machine.h"
#include "cam_machine_jog.h"
#include "rig_bench.h"

static fixture_image_t other;

static void to_fault(void)
{
    bring(cam_state_cutting);
    hal_host_fault_estop(true);
    fixture_rig_tick(&rig);
}

typedef cam_err_t command_fn(cam_machine_t *m);

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
            const uint32_t n = rig.machine.n_requests;
            const cam_err_t err = commands[i](&rig.machine);
            TEST_ASSERT_EQUAL_INT(allowed[state][i] ? cam_ok : cam_err_state, err);
            TEST_ASSERT_EQUAL_UINT32(n + (allowed[state][i] ? 1u : 0u), rig.machine.n_requests);
        }
    }
}

static void test_fault_is_left_by_reset_after_the_retract_only(void)
{
    to_fault();
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_reset(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_enable(&rig.machine));
    hal_host_fault_estop(false); // the latch holds all the same
    fixture_rig_ticks(&rig, 2000);
    TEST_ASSERT_TRUE(fixture_rig_status(&rig).is_retracted);
    TEST_ASSERT_EQUAL_HEX32(hal_out_fault, hal_host.out.outputs);
    hal_host_fault_estop(true);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&rig.machine));
    fixture_rig_ticks(&rig, 2);
    const cam_status_t status = fixture_rig_status(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, status.state);
    TEST_ASSERT_EQUAL_HEX32(0, status.faults);
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop),
                            status.first_fault); // the cause is still reported
    TEST_ASSERT_EQUAL_UINT32(1, status.fault_count[cam_fault_estop]);
    TEST_ASSERT_EQUAL_HEX32(0, hal_host.out.outputs);
    TEST_ASSERT_EQUAL_INT(cam_err_estop, cam_machine_enable(&rig.machine));
    hal_host_fault_estop(false);
    hal_host_fault_drive(true);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_drive, cam_machine_enable(&rig.machine));
    hal_host_fault_drive(false);
    hal_host_fault_bus(true);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_bus, cam_machine_enable(&rig.machine));
    hal_host_fault_bus(false);
    fixture_rig_tick(&rig);
    bring(cam_state_cutting); // homes and cuts anew
}

/// From outside of the stroke the first set-point would be its edge, and U would jump there.
static void test_enable_is_refused_while_u_stands_outside_its_stroke(void)
{
    const int32_t half_nm = rig.machine.params.u_stroke_nm / 2;
    const int32_t sides[] = {1, -1};
    for (uint32_t i = 0; i < 2u; i++) {
        hal_host.in.axis_nm[hal_axis_u] = sides[i] * (half_nm + 1);
        fixture_rig_tick(&rig);
        const uint32_t n = rig.machine.n_requests;
        TEST_ASSERT_EQUAL_INT(cam_err_u_place, cam_machine_enable(&rig.machine));
        TEST_ASSERT_EQUAL_UINT32(n, rig.machine.n_requests);
        hal_host.in.axis_nm[hal_axis_u] = sides[i] * half_nm;
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(&rig.machine));
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&rig.machine));
        fixture_rig_tick(&rig);
    }
}

/// A slow drive whose command would pass the end of a motion by more than the stroke holds.
static void test_enable_is_refused_where_the_feed_forward_needs_more_stroke(void)
{
    set(cam_param_u_speed_um_per_s, 1000000);
    set(cam_param_u_jerk_m_per_s3, 160000);
    set(cam_param_k1_ns, 4500000);
    TEST_ASSERT_EQUAL_INT(cam_err_u_command, cam_machine_enable(&rig.machine));
    const cam_feasibility_t *why = &rig.machine.refusal.why;
    TEST_ASSERT_EQUAL_INT(cam_err_u_command, why->err);
    TEST_ASSERT_EQUAL_INT64(600000, why->limit);
    set(cam_param_u_stroke_nm, 2 * (int32_t)why->needed);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(&rig.machine));
}

static void test_request_serial_wraps_without_losing_a_command(void)
{
    rig.machine.n_requests = 0xFFFFFEu;
    g_cam.request = 0xFFFFFEu << 8;
    fixture_rig_tick(&rig);
    for (int i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(&rig.machine));
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT(cam_state_homing, fixture_rig_state());
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&rig.machine));
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    }
}

static void test_second_change_before_the_first_was_taken_is_busy(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(&rig.machine, cam_param_k1_ns, 5));
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_set_param(&rig.machine, cam_param_k1_ns, 6));
    TEST_ASSERT_EQUAL_INT32(5, rig.machine.params.k1_ns);
    TEST_ASSERT_EQUAL_INT(cam_err_busy,
                          cam_machine_select_table(&rig.machine, rig.image.bytes, rig.image.size));
    const uint32_t before = fixture_rig_status(&rig).config;
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_UINT32(before + 1u, fixture_rig_status(&rig).config);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(&rig.machine, cam_param_k1_ns, 6));
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
            const int32_t old = cam_param_get(&rig.machine.params, ids[i]);
            const cam_err_t err = cam_machine_set_param(&rig.machine, ids[i], old);
            TEST_ASSERT_EQUAL_INT(allowed[state][i] ? cam_ok : cam_err_param_state, err);
            fixture_rig_tick(&rig);
        }
        setUp();
    }
    to_fault();
    TEST_ASSERT_EQUAL_INT(cam_err_param_state,
                          cam_machine_set_param(&rig.machine, cam_param_k1_ns, 1));
}

/// The angle would be another one at once: what it is made of stays as long as it is in force.
static void test_what_makes_the_angle_changes_in_off_only(void)
{
    static const cam_state_t states[] = {cam_state_ready, cam_state_manual};
    for (uint32_t k = 0; k < sizeof states / sizeof states[0]; k++) {
        setUp();
        if (states[k] == cam_state_manual) {
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(&rig.machine));
            fixture_rig_ticks(&rig, 20);
            TEST_ASSERT_EQUAL_INT(states[k], fixture_rig_state());
        } else {
            bring(states[k]);
        }
        for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
            const int32_t old = cam_param_get(&rig.machine.params, (cam_param_id_t)id);
            const cam_err_t err = cam_machine_set_param(&rig.machine, (cam_param_id_t)id, old);
            const bool is_of_angle = id == (uint32_t)cam_param_counts_per_turn ||
                                     id == (uint32_t)cam_param_encoder_sign ||
                                     id == (uint32_t)cam_param_index_offset_udeg ||
                                     id == (uint32_t)cam_param_observer_bandwidth_mHz ||
                                     id == (uint32_t)cam_param_z_is_measured;
            TEST_ASSERT_EQUAL_INT_MESSAGE(is_of_angle ? cam_err_param_state : cam_ok, err,
                                          cam_param_info((cam_param_id_t)id)->name);
            fixture_rig_tick(&rig);
        }
    }
}

static void test_parameter_errors_leave_everything_as_it_was(void)
{
    const cam_params_t before = rig.machine.params;
    const uint32_t generation = rig.machine.generation;
    TEST_ASSERT_EQUAL_INT(cam_err_param_id, cam_machine_set_param(&rig.machine, cam_n_params, 1));
    TEST_ASSERT_EQUAL_INT(cam_err_param_range,
                          cam_machine_set_param(&rig.machine, cam_param_lead_ns, -1));
    TEST_ASSERT_EQUAL_INT(
        cam_err_param_tick,
        cam_machine_set_param(&rig.machine, cam_param_observer_bandwidth_mHz, 1600001));
    TEST_ASSERT_EQUAL_MEMORY(&before, &rig.machine.params, sizeof before);
    TEST_ASSERT_EQUAL_UINT32(generation, rig.machine.generation);
}

/// A change between a command and the tick that carries it out would be judged for the wrong state.
static void test_changes_wait_for_a_pending_command(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_busy,
                          cam_machine_set_param(&rig.machine, cam_param_counts_per_turn, 4096));
    TEST_ASSERT_EQUAL_INT(cam_err_busy,
                          cam_machine_select_table(&rig.machine, rig.image.bytes, rig.image.size));
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_param_state,
                          cam_machine_set_param(&rig.machine, cam_param_counts_per_turn, 4096));
}

static void test_without_a_table_nothing_starts(void)
{
    cam_machine_init(&rig.machine, &g_cam, 20000, hal_clock_hz());
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_no_table, cam_machine_enable(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_no_table, cam_machine_feasibility(&rig.machine, 1000).err);
    TEST_ASSERT_EQUAL_INT(cam_err_no_table, cam_machine_check_speed(&rig.machine, 1000));
    TEST_ASSERT_EQUAL_UINT32(0, cam_machine_highest_mrpm(&rig.machine));
    g_cam.request = 1u << 8 | cam_request_enable;
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
    cam_machine_poll(&rig.machine);
    TEST_ASSERT_FALSE(rig.machine.has_table);
}

static void test_init_at_a_slow_tick_slows_the_observer(void)
{
    cam_machine_init(&rig.machine, &g_cam, 500, hal_clock_hz());
    TEST_ASSERT_EQUAL_INT32(25000, rig.machine.params.observer_bandwidth_mHz);
}

/// A measurement over a field bus, at slow ticks, is too old for a limit that follows from the
/// part.
static void test_init_derives_the_following_error_where_u_is_measured_at_a_quick_tick(void)
{
    cam_machine_init(&rig.machine, &g_cam, 20000, hal_clock_hz());
    TEST_ASSERT_EQUAL_INT32(100000, rig.machine.params.following_limit_nm);
    hal_host.slow.measures_u = true;
    cam_machine_init(&rig.machine, &g_cam, 20000, hal_clock_hz());
    TEST_ASSERT_EQUAL_INT32(0, rig.machine.params.following_limit_nm);
    cam_machine_init(&rig.machine, &g_cam, 1000, hal_clock_hz());
    TEST_ASSERT_EQUAL_INT32(100000, rig.machine.params.following_limit_nm);
    hal_host.slow.measures_u = false;
}

static void test_select_table_needs_a_good_one_and_the_right_state(void)
{
    fixture_image_make(&other, &part);
    other.bytes[other.size - 1u] ^= 1u;
    TEST_ASSERT_EQUAL_INT(cam_err_image_crc,
                          cam_machine_select_table(&rig.machine, other.bytes, other.size));
    TEST_ASSERT_EQUAL_PTR(rig.image.bytes, rig.machine.table.image);
    bring(cam_state_ready);
    fixture_image_make(&other, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_select_table(&rig.machine, other.bytes, other.size));
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_PTR(other.bytes, rig.machine.table.image);
    fixture_part_t reversed = part;
    reversed.direction = -1;
    fixture_image_make(&rig.image, &reversed);
    TEST_ASSERT_EQUAL_INT(cam_err_table_sense,
                          cam_machine_select_table(&rig.machine, rig.image.bytes, rig.image.size));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_err_state,
                          cam_machine_select_table(&rig.machine, other.bytes, other.size));
}

static void poll_round(void)
{
    for (uint32_t i = 0; i <= rig.image.size / 1024u; i++) {
        cam_machine_poll(&rig.machine);
    }
}

static void test_poll_finds_damage_in_every_state(void)
{
    for (uint32_t state = 0; state < cam_state_fault; state++) {
        setUp();
        bring((cam_state_t)state);
        poll_round();
        TEST_ASSERT_TRUE(rig.machine.has_table);
        rig.image.bytes[1000] ^= 8u;
        poll_round();
        poll_round(); // the first round may have passed the byte already
        TEST_ASSERT_FALSE(rig.machine.has_table);
        TEST_ASSERT_EQUAL_INT(state == cam_state_ready ? cam_err_no_table : cam_err_state,
                              cam_machine_start(&rig.machine));
        fixture_rig_tick(&rig);
        const cam_status_t status = fixture_rig_status(&rig);
        TEST_ASSERT_EQUAL_INT(state == cam_state_off ? cam_state_off : cam_state_fault,
                              status.state);
        TEST_ASSERT_EQUAL_HEX32(state == cam_state_off ? 0 : CAM_FAULT_BIT(table),
                                status.first_fault);
    }
}

static void test_poll_tries_again_when_the_interrupt_is_busy(void)
{
    bring(cam_state_ready);
    rig.image.bytes[1000] ^= 8u;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine)); // not taken yet
    poll_round();
    poll_round();
    TEST_ASSERT_TRUE(rig.machine.has_table);
    fixture_rig_tick(&rig);
    poll_round();
    poll_round();
    TEST_ASSERT_FALSE(rig.machine.has_table);
}

/// The command home is an off of a tick or two. The plan forgets the angle, wherever between two
/// plans that off falls, so that ready always rests on an index that was seen anew.
static void test_home_finds_the_index_anew_in_every_phase_of_the_plan(void)
{
    for (uint32_t phase = 0; phase < 16u; phase++) {
        setUp();
        bring(cam_state_ready);
        fixture_rig_ticks(&rig, phase);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home(&rig.machine));
        bool was_homing = false;
        bool was_forgotten = false;
        cam_status_t status = {0};
        for (int i = 0; i < 5000 && !(was_homing && status.state == cam_state_ready); i++) {
            fixture_rig_tick(&rig);
            cam_machine_poll(&rig.machine);
            status = fixture_rig_status(&rig);
            was_homing = was_homing || status.state == cam_state_homing;
            was_forgotten = was_forgotten || (was_homing && !status.is_synced);
        }
        TEST_ASSERT_EQUAL_INT(cam_state_ready, status.state);
        TEST_ASSERT_TRUE(was_homing && was_forgotten && status.is_synced);
    }
}
