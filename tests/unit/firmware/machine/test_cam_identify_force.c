// SPDX-License-Identifier: Apache-2.0
// Excitation of a U that takes forces by a wave of force: what reaches the output, how it ends, and
// what is refused. The machine of these tests follows its set-points, whatever the force.
#include "cam_machine_identify.h"
#include "cam_machine_scope.h"
#include "cam_table.h"
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"

enum { tick_hz = 20000, n = 64, fade = 16, largest_mn = 10000, patience = 40000 };

static fixture_rig_t rig;
static int32_t wave_mn[n];

static void set(cam_param_id_t id, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, id, value));
}

/// A tick with the main loop after it.
static void go_on(bool is_alive)
{
    fixture_rig_tick(&rig);
    cam_machine_poll(&rig.machine);
    if (is_alive) {
        cam_machine_keep_alive(&rig.machine);
    }
}

static void set_place(int32_t nm)
{
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_scope_set(&rig.machine, cam_scope_field_place_nm, nm));
}

static int32_t field(uint32_t which)
{
    int32_t value = -1;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_get(&rig.machine, which, &value));
    return value;
}

static cam_err_t set_unit(int32_t unit)
{
    return cam_machine_scope_set(&rig.machine, cam_scope_field_wave_unit, unit);
}

static void load(void)
{
    const uint8_t *bytes = (const uint8_t *)wave_mn;
    cam_machine_t *m = &rig.machine;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(m, sizeof wave_mn));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(m, 0, bytes, sizeof wave_mn));
    const uint32_t crc = cam_crc32(0, bytes, sizeof wave_mn);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_end(m, crc));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_unit(1));
}

/// A loop of 1 Hz without an integral: at rest where it should be, U gets no force of it.
void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_rig_init(&rig, &part, tick_hz);
    hal_host.slow.force.quantum_un = 20000;
    hal_host.in.axis_nm[hal_axis_x] = 60000000; // clear of the part
    set(cam_param_servo_integral_mHz, 0);
    set(cam_param_servo_crossover_hz, 1);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    for (int32_t i = 0; i < n; i++) {
        wave_mn[i] = i % 2 == 0 ? largest_mn - 100 * i : 50 * i - largest_mn;
    }
    load();
}

/// Play, up to the first tick in which U is at its position.
static void begin(uint32_t n_periods)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(&rig.machine, n_periods, fade).err);
    int32_t left = patience;
    const cam_axis_motion_t *u = &g_cam.motion.axis[hal_axis_u];
    while (left-- > 0 && (fixture_rig_state() != cam_state_identifying || u->pos_q10 != 0)) {
        go_on(true);
        TEST_ASSERT_EQUAL_INT32(0, g_cam.motion.u_push_q6);
    }
    TEST_ASSERT_GREATER_THAN_INT32(0, left);
}

/// @return [mN / 64] force of a tick at the position of the wave
static int32_t next_q6(bool is_alive)
{
    go_on(is_alive);
    TEST_ASSERT_EQUAL_INT32(0, fixture_rig_status(&rig).u_set_q6);
    TEST_ASSERT_EQUAL_INT32(rig.last.force_q6, hal_host.out.force_q6);
    return rig.last.force_q6;
}

/// Up to the tick before the force of the first sample of the first period in full.
static void skip_the_rise(uint32_t n_periods)
{
    int32_t left = patience;
    do {
        (void)next_q6(true);
    } while (left-- > 0 && g_cam.play.excite.n_left >= n_periods * n);
    TEST_ASSERT_GREATER_THAN_INT32(0, left);
}

static void expect_end(cam_excited_t excited, cam_state_t state)
{
    for (uint32_t i = 0; i < 20u; i++) {
        go_on(true);
    }
    TEST_ASSERT_EQUAL_INT(cam_identify_none, rig.machine.identify.phase);
    TEST_ASSERT_EQUAL_INT(excited, field(cam_scope_field_excited));
    TEST_ASSERT_EQUAL_INT(state, fixture_rig_state());
}

/// Sample by sample in the tick after the one that plays it, then nothing from one tick to the
/// next, though the last sample is large.
static void test_force_is_the_samples_and_ends_at_once(void)
{
    enum { n_periods = 2 };
    begin(n_periods);
    skip_the_rise(n_periods);
    for (int32_t i = 0; i < n_periods * n; i++) {
        TEST_ASSERT_EQUAL_INT(cam_state_identifying, fixture_rig_state());
        TEST_ASSERT_EQUAL_INT32(64 * wave_mn[i % n], next_q6(true));
    }
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT32(0, g_cam.motion.u_push_q6);
    go_on(true);
    TEST_ASSERT_INT32_WITHIN(2, 0, rig.last.force_q6);
    expect_end(cam_excited_done, cam_state_ready);
    TEST_ASSERT_EQUAL_UINT32(0, rig.machine.identify.n_fall);
    TEST_ASSERT_EQUAL_UINT32(0, fixture_rig_status(&rig).faults);
}

static void test_stop_and_disable_take_the_force_away_at_once(void)
{
    for (int i = 0; i < 2; i++) {
        setUp();
        begin(100);
        skip_the_rise(100);
        TEST_ASSERT_EQUAL_INT(cam_ok, i == 0 ? cam_machine_stop(&rig.machine)
                                             : cam_machine_disable(&rig.machine));
        (void)next_q6(true); // the tick that obeys still writes the force of the last one
        TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
        go_on(true);
        TEST_ASSERT_INT32_WITHIN(2, 0, rig.last.force_q6);
        expect_end(cam_excited_stopped, i == 0 ? cam_state_ready : cam_state_off);
    }
}

static void test_silence_takes_the_force_away(void)
{
    begin(1000);
    const int32_t longest = tick_hz / 1000 * cam_identify_patience_ms;
    int32_t ticks = 0;
    while (fixture_rig_state() == cam_state_identifying && ticks < 2 * longest) {
        go_on(false);
        ticks++;
    }
    TEST_ASSERT_INT32_WITHIN(4, longest, ticks);
    go_on(false);
    TEST_ASSERT_INT32_WITHIN(2, 0, rig.last.force_q6);
    expect_end(cam_excited_silent, cam_state_ready);
}

/// The tick of a fault is the last with the force of the wave: the next one retracts U, with a
/// force that is that of its set-point.
/// U retracts to where it plays the wave, so its own force is none.
static void test_fault_takes_the_force_away(void)
{
    set(cam_param_u_retract_nm, 0);
    begin(1000);
    skip_the_rise(1000);
    hal_host_fault_estop(true);
    (void)next_q6(true);
    TEST_ASSERT_EQUAL_INT(cam_state_fault, fixture_rig_state());
    go_on(true);
    TEST_ASSERT_INT32_WITHIN(2, 0, rig.last.force_q6);
}

/// The force that is set at a fault must not act when the next excitation begins.
static void test_force_of_a_fault_is_forgotten(void)
{
    g_cam.motion.u_push_q6 = 64 * largest_mn;
    g_cam.motion.dwell_ticks = patience; // the wave does not play yet
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(&rig.machine, 1, fade).err);
    for (int i = 0; i < 10; i++) {
        go_on(true);
        TEST_ASSERT_INT32_WITHIN(2, 0, rig.last.force_q6);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_identifying, fixture_rig_state());
}

/// The force limit is that of the samples: a loop that pushes as well is cut at it.
static void test_force_limit_acts_on_the_sum(void)
{
    set(cam_param_servo_runaway_nm, 10000000);
    const int32_t limit_mn = rig.machine.params.servo_force_limit_mn;
    wave_mn[0] = limit_mn;
    load();
    begin(2);
    skip_the_rise(2);
    rig.lathe.error_nm[hal_axis_u] = -20000; // the loop pushes towards plus
    TEST_ASSERT_EQUAL_INT32(64 * limit_mn, next_q6(true));
    TEST_ASSERT_TRUE(g_cam.force.servo.is_limited);
}

/// 1 N per ms are 50 mN per tick.
static void test_rate_of_the_force_acts(void)
{
    set(cam_param_servo_force_rate_n_per_ms, 1);
    begin(2);
    int32_t last_q6 = next_q6(true);
    int32_t most_q6 = 0;
    for (uint32_t i = 0; i < 2u * n; i++) {
        const int32_t now_q6 = next_q6(true);
        const int32_t change_q6 = now_q6 > last_q6 ? now_q6 - last_q6 : last_q6 - now_q6;
        most_q6 = change_q6 > most_q6 ? change_q6 : most_q6;
        last_q6 = now_q6;
    }
    TEST_ASSERT_EQUAL_INT32(50 * 64, most_q6);
}

static void expect_refused(cam_err_t err, int32_t value)
{
    const cam_verdict_t v = cam_machine_excite(&rig.machine, 1, fade);
    TEST_ASSERT_EQUAL_INT(err, v.err);
    TEST_ASSERT_EQUAL_INT32(value, v.value);
}

static void test_wave_beyond_the_force_limit_or_out_of_the_stroke_is_refused(void)
{
    const int32_t limit_mn = rig.machine.params.servo_force_limit_mn;
    wave_mn[5] = -limit_mn - 1;
    load();
    expect_refused(cam_err_wave_force, limit_mn + 1);
    wave_mn[5] = -limit_mn;
    load();
    const int32_t end_nm = rig.machine.params.u_stroke_nm / 2;
    set_place(-end_nm - 1);
    expect_refused(cam_err_wave_stroke, -end_nm - 1);
    set_place(-end_nm);
    expect_refused(cam_ok, 0); // whatever its speed and acceleration would be as nanometres
}

/// Half the clearance of X at the end of U's travel, wherever the wave plays; U may be as far off.
static void test_x_must_be_clear_of_all_of_us_travel(void)
{
    const cam_config_t *cfg = g_cam.config.in_use;
    const int32_t clear_nm =
        (int32_t)(cfg->play.x_clear_q10 / 1024) - rig.machine.params.x_clearance_nm / 2;
    const int32_t travel_nm = rig.machine.params.u_stroke_nm / 2 + cfg->guard.approach_nm;
    set_place(-300000);
    g_cam.motion.axis[hal_axis_x].pos_q10 = (int64_t)(clear_nm + travel_nm - 1) * 1024;
    fixture_rig_ticks(&rig, 2);
    expect_refused(cam_err_wave_clear, clear_nm + travel_nm);
    g_cam.motion.axis[hal_axis_x].pos_q10 = (int64_t)(clear_nm + travel_nm) * 1024;
    fixture_rig_ticks(&rig, 2);
    expect_refused(cam_ok, 0);
    go_on(true);
    TEST_ASSERT_EQUAL_INT32(2 * travel_nm, g_cam.config.in_use->guard.following_nm);
}

static void test_unit_is_one_of_two_and_a_force_needs_its_port(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_scope_range, set_unit(2));
    TEST_ASSERT_EQUAL_INT(cam_err_scope_range, set_unit(-1));
    TEST_ASSERT_EQUAL_INT32(1, field(cam_scope_field_wave_unit));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_unit(0));
    hal_host.slow.force.quantum_un = 0;
    TEST_ASSERT_EQUAL_INT(cam_err_wave_unit, set_unit(1));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_unit(0));
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_wave_unit));
}

/// A tool that knows nothing of forces downloads nanometres.
static void test_samples_of_the_next_wave_are_nanometres(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(&rig.machine, sizeof wave_mn));
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_wave_unit));
}
