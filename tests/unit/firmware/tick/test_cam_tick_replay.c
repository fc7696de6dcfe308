// SPDX-License-Identifier: Apache-2.0
// From power-on: every record of a session with changes of parameters and table replays to the bit.
#include "cam_machine_jog.h"
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"
#include <stdlib.h>
#include <string.h>

enum { log_capacity = 60000, max_configs = 64, tick_hz = 20000 };

static fixture_rig_t rig;
static cam_config_t configs[max_configs]; ///< by generation
static cam_t replayed;
static cam_config_t at_start;

void setUp(void)
{
    memset(&rig, 0, sizeof rig);
    memset(configs, 0, sizeof configs);
    rig.lathe.ramp_rpm = 2500.0 * 10.0 / tick_hz;
    rig.log = calloc(log_capacity, sizeof *rig.log);
    TEST_ASSERT_NOT_NULL(rig.log);
    rig.log_capacity = log_capacity;
    hal_host_reset(tick_hz);
    hal_host.in.axis_nm[hal_axis_x] = 46500000; // not far from the work
    cam_machine_init(&rig.machine, &g_cam, tick_hz, hal_clock_hz());
    fixture_encoder_init(&rig.lathe.encoder, rig.machine.params.counts_per_turn, 1, 1000u, 1234);
    at_start = *g_cam.config.offered;
    configs[at_start.generation] = at_start;
}

void tearDown(void)
{
    free(rig.log);
}

/// Keep the configuration that is offered: the next tick takes it.
static void keep_config(void)
{
    const cam_config_t *now = g_cam.config.offered;
    TEST_ASSERT_LESS_THAN_UINT32(max_configs, now->generation);
    configs[now->generation] = *now;
}

static void set(cam_param_id_t id, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(&rig.machine, id, value));
    keep_config();
    fixture_rig_tick(&rig);
}

static void select_table(const fixture_part_t *part)
{
    fixture_image_make(&rig.image, part);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_select_table(&rig.machine, rig.image.bytes, rig.image.size));
    keep_config();
    fixture_rig_tick(&rig);
}

static void prepare(void)
{
    fixture_rig_ticks(&rig, 3);
    set(cam_param_lead_ns, 50000);
    set(cam_param_xz_lag_ns, 400000);
    set(cam_param_k1_ns, 100000);
    set(cam_param_k2_us2, 1000);
    set(cam_param_following_limit_nm, 1000000);
    const fixture_part_t part = fixture_part_short();
    select_table(&part);
}

static void cut_with_changes(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    fixture_rig_ticks(&rig, 700);
    set(cam_param_phase_udeg, 1000000);
    fixture_rig_ticks(&rig, 55);
    set(cam_param_amplitude_ppm, 800000);
    fixture_rig_ticks(&rig, 333);
    hal_host_fault_late(30);
    fixture_rig_ticks(&rig, 333);
    set(cam_param_amplitude_ppm, 1100000);
}

/// Same configurations at the same ticks. All fields but `in` must agree; padding is not compared.
static void expect_replay(void)
{
    memset(&replayed, 0, sizeof replayed);
    TEST_ASSERT_GREATER_THAN_UINT32(1000, rig.n_log);
    TEST_ASSERT_LESS_THAN_UINT32(log_capacity, rig.n_log);
    uint32_t n_configs = 0;
    cam_config_t *half = &replayed.config.half[0];
    for (uint32_t i = 0; i < rig.n_log; i++) {
        const cam_tick_record_t *r = &rig.log[i];
        TEST_ASSERT_EQUAL_UINT32(i, r->tick);
        if (half->generation != r->config) {
            *half = configs[r->config];
            half->play.table = half->play.table != NULL ? &half->table : NULL;
            n_configs++;
        }
        cam_tick_record_t done = {.tick = r->tick, .in = r->in};
        cam_tick_steps_isr(&replayed, &replayed.config.half[0], &done);
        TEST_ASSERT_EQUAL_UINT32(r->config, done.config);
        TEST_ASSERT_EQUAL_INT64(r->angle.pos_q32, done.angle.pos_q32);
        TEST_ASSERT_EQUAL_INT32(r->angle.speed_q32, done.angle.speed_q32);
        TEST_ASSERT_EQUAL_INT32(r->want.z_nm, done.want.z_nm);
        TEST_ASSERT_EQUAL_INT32(r->want.u_set_q6, done.want.u_set_q6);
        TEST_ASSERT_EQUAL_INT32(r->want.u_due_q6, done.want.u_due_q6);
        TEST_ASSERT_EQUAL_MEMORY(r->out, done.out, sizeof done.out);
        TEST_ASSERT_EQUAL_INT32(r->want.spindle_mrpm, done.want.spindle_mrpm);
        TEST_ASSERT_EQUAL_HEX32(r->want.outputs, done.want.outputs);
        TEST_ASSERT_EQUAL_HEX32(r->want.faults, done.want.faults);
        TEST_ASSERT_EQUAL_INT(r->want.state, done.want.state);
    }
    TEST_ASSERT_EQUAL_UINT32(rig.machine.generation, n_configs);
}

static void test_session_with_changes_in_the_cut_replays_bit_for_bit(void)
{
    prepare();
    cut_with_changes();
    TEST_ASSERT_LESS_THAN_UINT32(20000, fixture_rig_until(&rig, cam_state_ready, 20000));
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&rig.machine));
    fixture_rig_ticks(&rig, 3000);
    TEST_ASSERT_EQUAL_INT(cam_state_off, rig.last.want.state);
    expect_replay();
}

static void test_session_with_stop_fault_and_reset_replays_bit_for_bit(void)
{
    prepare();
    cut_with_changes();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    fixture_rig_ticks(&rig, 1500);
    hal_host_fault_estop(true);
    fixture_rig_ticks(&rig, 4000);
    hal_host_fault_estop(false);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&rig.machine));
    fixture_rig_ticks(&rig, 3000);
    TEST_ASSERT_EQUAL_INT(cam_state_off, rig.last.want.state);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_engaging)); // homed anew
    fixture_rig_ticks(&rig, 3000);
    TEST_ASSERT_EQUAL_HEX32(0, rig.last.want.faults);
    expect_replay();
}

/// Let the feed rest or go on, as the main loop does.
static void hold(bool is_held)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, is_held ? cam_machine_hold(&rig.machine)
                                          : cam_machine_resume(&rig.machine));
    keep_config();
    TEST_ASSERT_LESS_THAN_UINT32(
        20000, fixture_rig_until(&rig, is_held ? cam_state_holding : cam_state_cutting, 20000));
}

static void test_session_with_overrides_hold_trim_and_switches_replays_bit_for_bit(void)
{
    prepare();
    set(cam_param_switch_1_per_turn, 2);
    set(cam_param_switch_1_off_udeg, 90000000);
    set(cam_param_switch_2_per_turn, 1);
    set(cam_param_switch_2_off_udeg, 200000000);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    set(cam_param_feed_override_ppm, 500000);
    fixture_rig_ticks(&rig, 700);
    set(cam_param_spindle_override_ppm, 900000);
    set(cam_param_x_trim_nm, -3000);
    hold(true);
    fixture_rig_ticks(&rig, 700);
    hold(false);
    set(cam_param_feed_override_ppm, 1000000);
    TEST_ASSERT_LESS_THAN_UINT32(20000, fixture_rig_until(&rig, cam_state_ready, 20000));
    set(cam_param_switch_2_per_turn, 0);
    fixture_rig_ticks(&rig, 700);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    uint32_t seen = 0;
    for (uint32_t i = 0; i < rig.n_log; i++) {
        seen |= rig.log[i].want.outputs;
    }
    TEST_ASSERT_EQUAL_HEX32(3u * hal_out_switch_1, seen & 3u * hal_out_switch_1);
    expect_replay();
}

/// The speed of the spindle goes twice per turn from 0.7 to 1.4 of 2000 r/min.
static void test_session_with_a_modulated_spindle_replays_bit_for_bit(void)
{
    fixture_part_t part = fixture_part_modulated();
    part.spindle_mrpm = 2000000;
    rig.lathe.ramp_rpm = 50.0;
    fixture_rig_ticks(&rig, 3);
    set(cam_param_spindle_acceleration_mrad_per_s2, 2000000000);
    set(cam_param_spindle_lag_us, 100);
    set(cam_param_lead_ns, 50000);
    set(cam_param_xz_lag_ns, 400000);
    set(cam_param_k2_us2, 1000);
    set(cam_param_following_limit_nm, 1000000);
    select_table(&part);
    cut_with_changes();
    int32_t least = INT32_MAX;
    int32_t most = 0;
    for (int i = 0; i < 600; i++) {
        fixture_rig_tick(&rig);
        least = rig.last.want.spindle_mrpm < least ? rig.last.want.spindle_mrpm : least;
        most = rig.last.want.spindle_mrpm > most ? rig.last.want.spindle_mrpm : most;
    }
    TEST_ASSERT_INT32_WITHIN(60000, 2850000, most);
    TEST_ASSERT_INT32_WITHIN(60000, 1350000, least);
    TEST_ASSERT_LESS_THAN_UINT32(20000, fixture_rig_until(&rig, cam_state_ready, 20000));
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    expect_replay();
}

/// With homes, a datum and a cut.
static void test_session_by_hand_replays_bit_for_bit(void)
{
    enum { mm = 1000000, manual, home_x, home_u, jog, off, enable, start };
    cam_machine_t *m = &rig.machine;
    rig.lathe.home[hal_axis_u] = (ideal_home_t){.side = 1, .edge_nm = 50000};
    rig.lathe.home[hal_axis_x] = (ideal_home_t){.side = 1, .edge_nm = 60 * mm, .pitch_nm = mm};
    hal_host.in.axis_nm[hal_axis_x] = 59900000;
    fixture_rig_tick(&rig); // takes the configuration of the start
    set(cam_param_u_home, 2);
    set(cam_param_x_home, 3);
    set(cam_param_x_home_nm, 60 * mm);
    set(cam_param_x_home_slow_um_per_s, 10000);
    set(cam_param_lead_ns, 50000);
    set(cam_param_z_datum_nm, mm);
    const fixture_part_t part = fixture_part_short();
    select_table(&part);
    for (uint32_t step = manual; step <= start; step++) {
        const hal_axis_t axis = step == home_x ? hal_axis_x : hal_axis_u;
        TEST_ASSERT_EQUAL_INT(cam_ok, step == manual   ? cam_machine_manual(m)
                                      : step == jog    ? cam_machine_jog(m, hal_axis_z, -3000).err
                                      : step == off    ? cam_machine_disable(m)
                                      : step == enable ? cam_machine_enable(m)
                                      : step == start  ? cam_machine_start(m)
                                                       : cam_machine_home_axis(m, axis));
        for (uint32_t i = 1; i <= 5000u; i++) {
            keep_config();
            fixture_rig_tick(&rig);
            if (i % 1000u == 0u) {
                cam_machine_keep_alive(m);
            }
            cam_machine_jog_poll(m);
        }
    }
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, rig.last.want.state);
    TEST_ASSERT_EQUAL_HEX32(3u, fixture_rig_status(&rig).jog.homed); // U and X
    expect_replay();
}

static void test_trace_switched_off_and_on_has_a_gap_and_goes_on(void)
{
    prepare();
    set(cam_param_trace_on, 0);
    const uint32_t n = rig.n_log;
    const uint32_t tick = fixture_rig_status(&rig).tick;
    fixture_rig_ticks(&rig, 1000);
    TEST_ASSERT_EQUAL_UINT32(n, rig.n_log);
    set(cam_param_trace_on, 1);
    TEST_ASSERT_EQUAL_UINT32(n + 1u, rig.n_log);
    TEST_ASSERT_EQUAL_UINT32(tick + 1001u, rig.last.tick);
    TEST_ASSERT_EQUAL_UINT32(0, g_cam.trace.n_dropped);
}
