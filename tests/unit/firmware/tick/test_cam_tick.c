// SPDX-License-Identifier: Apache-2.0
// The tick of a whole controller: from power-on every record of a session replays to the bit, and a
// position beyond +-2^30 nm is limited and its drive counts as not ready.
#include "cam_machine_inner.h" // cam_machine_home_axis, cam_machine_jog, cam_machine_jog_poll
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"
#include <stdlib.h>
#include <string.h>

enum { log_capacity = 60000, max_configs = 64, tick_hz = 20000 };

static fixture_rig_t rig;
static fixture_part_t part;
static cam_config_t configs[max_configs]; ///< by generation
static cam_t replayed;
static cam_tick_record_t *records; ///< the log

/// A controller at power-on, whose records are kept.
void setUp(void)
{
    part = fixture_part_short();
    memset(&rig, 0, sizeof rig);
    memset(configs, 0, sizeof configs);
    rig.lathe.ramp_rpm = 2500.0 * 10.0 / tick_hz;
    records = calloc(log_capacity, sizeof *records);
    TEST_ASSERT_NOT_NULL(records);
    rig.log = records;
    rig.log_capacity = log_capacity;
    hal_host_reset(tick_hz);
    hal_host.in.axis_nm[hal_axis_x] = 46500000; // not far from the work
    cam_machine_init(&rig.machine, &g_cam, tick_hz, hal_clock_hz());
    fixture_encoder_init(&rig.lathe.encoder, rig.machine.params.counts_per_turn, 1, 1000u, 1234);
    configs[g_cam.config.offered->generation] = *g_cam.config.offered;
}

void tearDown(void)
{
    free(records);
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

static void select_table(void)
{
    fixture_image_make(&rig.image, &part);
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
    select_table();
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
        const cam_tick_record_t *r = &records[i];
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

/// Let the feed rest or go on, as the main loop does.
static void hold(bool is_held)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, is_held ? cam_machine_hold(&rig.machine)
                                          : cam_machine_resume(&rig.machine));
    keep_config();
    TEST_ASSERT_LESS_THAN_UINT32(
        20000, fixture_rig_until(&rig, is_held ? cam_state_holding : cam_state_cutting, 20000));
}

/// With changes of parameters in the cut, overrides, hold and trim, then a stop,
/// a fault, its reset and the begin of another cut.
static void test_session_with_changes_stop_fault_and_reset_replays_bit_for_bit(void)
{
    prepare();
    cut_with_changes();
    set(cam_param_feed_override_ppm, 500000);
    fixture_rig_ticks(&rig, 700);
    set(cam_param_spindle_override_ppm, 900000);
    set(cam_param_x_trim_nm, -3000);
    hold(true);
    fixture_rig_ticks(&rig, 700);
    hold(false);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    fixture_rig_ticks(&rig, 1500);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
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
    select_table();
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

static void test_ticks_of_a_turn_in_the_cut_are_collected_for_learning(void)
{
    enum { ticks_per_turn = 60 * tick_hz / 2500 };
    prepare();
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    cam_turn_t turn;
    const cam_turn_bin_t *bin = NULL;
    for (int i = 0; i < 4 && bin == NULL; i++) {
        bin = cam_turn_bins_take(&g_cam.bins, &turn); // learning begins with the first call
        (void)cam_turn_bins_release(&g_cam.bins);
        fixture_rig_ticks(&rig, ticks_per_turn);
    }
    TEST_ASSERT_NOT_NULL(bin);
    int32_t n = 0;
    for (uint32_t i = 0; i < cam_turn_bins_n; i++) {
        n += bin[i].n;
    }
    TEST_ASSERT_GREATER_THAN_INT32(0, n);
}

static void test_session_of_a_force_drive_replays_bit_for_bit(void)
{
    prepare();
    hal_host.slow.force.quantum_un = 20000;
    set(cam_param_servo_crossover_hz, 400);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    fixture_rig_ticks(&rig, 700);
    hal_host.slow.force.quantum_un = 0;
    TEST_ASSERT_TRUE(g_cam.force.is_on);
    expect_replay();
}

static hal_axis_t far_axis; ///< axis whose position far_isr() replaces
static int32_t far_nm;

/// In the place of cam_isr(): one axis is measured elsewhere.
static void far_isr(void)
{
    hal_host.in.axis_nm[far_axis] = far_nm;
    cam_isr();
}

/// Measure an axis elsewhere for a tick. @return whether the tick senses drives that are ready
static bool is_ready_at(hal_axis_t axis, int32_t nm, int32_t sensed_nm)
{
    far_axis = axis;
    far_nm = nm;
    rig.isr = far_isr;
    fixture_rig_tick(&rig);
    rig.isr = NULL;
    TEST_ASSERT_EQUAL_INT32(sensed_nm, rig.last.in.actual_nm[axis]);
    return (rig.last.in.inputs & (uint32_t)hal_in_drive_ready) != 0u;
}

/// It is a fault, and in off a reason not to enable.
static void test_position_beyond_a_metre_is_a_drive_that_is_not_ready(void)
{
    enum { most_nm = 1 << 30 };
    for (uint32_t i = 0; i < 2u * hal_n_axes; i++) {
        const hal_axis_t axis = (hal_axis_t)(i / 2u);
        const bool is_low = i % 2u != 0u;
        fixture_rig_init(&rig, &part, tick_hz);
        TEST_ASSERT_FALSE(is_ready_at(axis, -most_nm - 1, -most_nm));
        TEST_ASSERT_EQUAL_INT(cam_err_drive, cam_machine_enable(&rig.machine));
        TEST_ASSERT_TRUE(is_ready_at(axis, -most_nm, -most_nm));
        TEST_ASSERT_TRUE(is_ready_at(axis, most_nm - 1, most_nm - 1));
        fixture_rig_init(&rig, &part, tick_hz);
        TEST_ASSERT_TRUE(fixture_rig_bring(&rig, is_low ? cam_state_cutting : cam_state_ready));
        TEST_ASSERT_FALSE(is_low ? is_ready_at(axis, INT32_MIN, -most_nm)
                                 : is_ready_at(axis, most_nm, most_nm - 1));
        TEST_ASSERT_EQUAL_INT(cam_state_fault, rig.last.want.state);
        TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(drive), rig.last.want.faults);
        TEST_ASSERT_BITS_LOW(hal_out_enable, rig.last.want.outputs);
    }
}
