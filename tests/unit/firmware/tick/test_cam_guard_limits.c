// SPDX-License-Identifier: Apache-2.0
// The guard alone: each fault at its limit and one step beyond, in every state, as FAULTS.md has
// it.
#include "cam_build.h"
#include "cam_guard.h"
#include "unity.h"
#include <string.h>

static cam_config_t config;
static const cam_guard_config_t *cfg = &config.guard;
static cam_guard_t guard;
static cam_sense_t in;
static cam_angle_t angle;
static cam_want_t want;
static cam_motion_t motion;

void setUp(void)
{
    const cam_params_t params = cam_param_defaults();
    memset(&config, 0, sizeof config);
    memset(&guard, 0, sizeof guard);
    memset(&motion, 0, sizeof motion);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_build_config(&config, &params, NULL, 3030000, 20000, 200000000));
    in = (cam_sense_t){.inputs = hal_in_drive_ready};
    angle = (cam_angle_t){.speed_q32 = 8947849, .is_synced = true};
    want = (cam_want_t){.spindle_mrpm = 2500000};
}

/// A tick behind a plan. @return what is written
static cam_want_t tick(void)
{
    cam_tick_record_t r = {.in = in, .angle = angle, .want = want};
    r.want.faults |= angle.faults | cam_sense_faults(&in) | cam_guard_plan_isr(&guard, cfg, &r);
    cam_guard_step_isr(&guard, cfg, &r, &motion);
    return r.want;
}

/// Set up a machine in a state without any fault.
static void begin(cam_state_t state)
{
    setUp();
    want.state = state;
    for (int i = 0; i < 3; i++) {
        (void)tick();
    }
    TEST_ASSERT_EQUAL_HEX32(0, guard.faults);
}

/// Bring the machine to the limit of one fault with `beyond` = 0, or one step beyond it with 1.
static void cause(cam_fault_t fault, int32_t beyond)
{
    const uint32_t mask = beyond != 0 ? UINT32_C(1) << fault : 0u;
    switch (fault) {
    case cam_fault_estop:
        in.inputs |= beyond != 0 ? (uint32_t)hal_in_estop : 0u;
        break;
    case cam_fault_drive:
        in.inputs &= beyond != 0 ? ~(uint32_t)hal_in_drive_ready : UINT32_MAX;
        break;
    case cam_fault_bus:
        in.inputs |= beyond != 0 ? (uint32_t)hal_in_bus_lost : 0u;
        break;
    case cam_fault_late_tick:
    case cam_fault_encoder_jump:
    case cam_fault_lost_counts:
    case cam_fault_index_missing:
        angle.faults = mask;
        break;
    case cam_fault_z_range:
    case cam_fault_table:
    case cam_fault_swing:
    case cam_fault_command:
    case cam_fault_corrupt:
    case cam_fault_u_travel:
    case cam_fault_u_runaway:
    case cam_fault_u_force:
        want.faults = mask;
        break;
    case cam_fault_reverse:
        angle.speed_q32 = -17896 - beyond;
        break;
    case cam_fault_spindle_stopped:
        angle.speed_q32 = 17895;
        guard.n_stopped =
            (want.state == cam_state_homing ? 200000u : 2000u) - cfg->plan_ticks + (uint32_t)beyond;
        break;
    case cam_fault_overspeed:
        angle.speed_q32 = 10844792 + beyond; // 3030 r/min
        break;
    case cam_fault_following_error:
        in.actual_nm[hal_axis_u] = 100000 + beyond;
        break;
    case cam_fault_setpoint_speed: // with the speed of the step before: no acceleration
        guard.u_step_q6 = cfg->u_vel_q6;
        want.u_set_q6 = guard.u_set_q6 + cfg->u_vel_q6 + beyond;
        break;
    case cam_fault_setpoint_acceleration:
        want.u_set_q6 = guard.u_set_q6 - cfg->u_acc_q6 - beyond;
        break;
    case cam_fault_setpoint_range:
        guard.u_set_q6 = want.u_set_q6 = cfg->u_range_q6 + beyond;
        break;
    case cam_n_faults:
        break;
    }
}

/// The table of FAULTS.md, column "armed in", by hand: o off, h homing, r ready, w in work, f
/// fault, m manual.
static bool is_armed(cam_fault_t fault, cam_state_t state)
{
    static const char *const armed[cam_n_faults] = {
        [cam_fault_estop] = "hrwfm",
        [cam_fault_drive] = "hrwfm",
        [cam_fault_bus] = "hrwfm",
        [cam_fault_late_tick] = "hrwm",
        [cam_fault_encoder_jump] = "rw",
        [cam_fault_lost_counts] = "rw",
        [cam_fault_index_missing] = "hrw",
        [cam_fault_reverse] = "w",
        [cam_fault_spindle_stopped] = "hw",
        [cam_fault_overspeed] = "w",
        [cam_fault_following_error] = "rwm",
        [cam_fault_setpoint_speed] = "rwm",
        [cam_fault_setpoint_acceleration] = "rwm",
        [cam_fault_setpoint_range] = "rwm",
        [cam_fault_z_range] = "w",
        [cam_fault_table] = "hrwm",
        [cam_fault_swing] = "w",
        [cam_fault_command] = "hrwfm",
        [cam_fault_corrupt] = "",
        [cam_fault_u_travel] = "hrwfm",
        [cam_fault_u_runaway] = "hrwfm",
        [cam_fault_u_force] = "hrwfm",
    };
    static const char letter[cam_n_states] = "ohrwwwfwrmw";
    return strchr(armed[fault], letter[state]) != NULL;
}

static void test_fault_beyond_its_limit_is_latched_at_once_where_it_is_armed(void)
{
    for (int fault = 0; fault < cam_n_faults; fault++) {
        for (int state = 0; state < cam_n_states; state++) {
            begin((cam_state_t)state);
            cause((cam_fault_t)fault, 1);
            const cam_want_t safe = tick();
            const bool armed = is_armed((cam_fault_t)fault, (cam_state_t)state);
            const uint32_t wanted = armed ? UINT32_C(1) << fault : 0u;
            TEST_ASSERT_EQUAL_HEX32_MESSAGE(wanted, guard.faults,
                                            cam_fault_name((cam_fault_t)fault));
            TEST_ASSERT_EQUAL_INT(armed ? cam_state_fault : (cam_state_t)state, safe.state);
            TEST_ASSERT_EQUAL_UINT32(armed ? 1u : 0u, cam_guard_count(&guard, (cam_fault_t)fault));
            const bool is_entered = armed && state != cam_state_fault;
            TEST_ASSERT_EQUAL_HEX32(is_entered ? wanted : 0u, guard.first_faults);
        }
    }
}

static void test_fault_at_its_limit_is_none_in_any_state(void)
{
    for (int fault = 0; fault < cam_n_faults; fault++) {
        for (int state = 0; state < cam_n_states; state++) {
            begin((cam_state_t)state);
            cause((cam_fault_t)fault, 0);
            const cam_want_t safe = tick();
            TEST_ASSERT_EQUAL_HEX32_MESSAGE(0, guard.faults, cam_fault_name((cam_fault_t)fault));
            TEST_ASSERT_EQUAL_INT(state, safe.state);
        }
    }
}

static void test_armed_mask_of_every_state_is_the_manuals(void)
{
    for (int state = 0; state < cam_n_states; state++) {
        for (int fault = 0; fault < cam_n_faults; fault++) {
            const uint32_t bit = cam_guard_armed((cam_state_t)state) >> fault & 1u;
            TEST_ASSERT_EQUAL_UINT32(is_armed((cam_fault_t)fault, (cam_state_t)state), bit);
        }
    }
}

/// U that moves by time lags behind drives that differ from what was believed.
static void test_following_error_out_of_the_cut_has_a_limit_of_its_own(void)
{
    cam_guard_config_t wide = *cfg;
    wide.approach_nm = 150000;
    for (int i = 0; i < 4; i++) {
        begin(cam_state_engaging);
        motion.is_playing = i % 2 != 0;
        in.actual_nm[hal_axis_u] = i < 2 ? 150000 : 150001;
        const cam_guard_config_t *const usual = cfg;
        cfg = &wide;
        (void)tick();
        cfg = usual;
        TEST_ASSERT_EQUAL_HEX32(i == 0 ? 0u : CAM_FAULT_BIT(following_error), guard.faults);
    }
}

/// A U that presses on its stop is far from its set-point, and its force is limited.
static void test_following_error_at_the_stop_is_accepted_in_manual_only(void)
{
    for (int i = 0; i < 3; i++) {
        begin(i < 2 ? cam_state_manual : cam_state_cutting);
        motion.is_playing = i == 2;
        motion.u_press_q6 = i == 0 ? 0 : 20000 * 64;
        in.actual_nm[hal_axis_u] = 10000000;
        (void)tick();
        TEST_ASSERT_EQUAL_HEX32(i == 1 ? 0u : CAM_FAULT_BIT(following_error), guard.faults);
    }
}

/// A spindle may stand when the work begins; once its encoder has advanced, it must not stand.
static void test_encoder_that_stands_ends_the_work_where_it_has_advanced(void)
{
    for (int state = 0; state < cam_n_states; state++) {
        begin(cam_state_off);
        angle.is_still = true;
        want.state = (cam_state_t)state;
        (void)tick();
        TEST_ASSERT_EQUAL_HEX32(0, guard.faults);
        angle.is_still = false;
        (void)tick();
        angle.is_still = true;
        (void)tick();
        const bool is_in_work = is_armed(cam_fault_reverse, (cam_state_t)state);
        TEST_ASSERT_EQUAL_HEX32(is_in_work ? CAM_FAULT_BIT(spindle_stopped) : 0u, guard.faults);
    }
}

static void test_limits_of_the_other_sign_are_the_same(void)
{
    begin(cam_state_cutting);
    in.actual_nm[hal_axis_u] = -100001;
    (void)tick();
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(following_error), guard.faults);
    begin(cam_state_cutting);
    want.u_set_q6 = cfg->u_acc_q6 + 1;
    (void)tick();
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(setpoint_acceleration), guard.faults);
    begin(cam_state_cutting);
    guard.u_step_q6 = -cfg->u_vel_q6;
    want.u_set_q6 = -cfg->u_vel_q6 - 1;
    (void)tick();
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(setpoint_speed), guard.faults);
    begin(cam_state_cutting);
    guard.u_set_q6 = want.u_set_q6 = -cfg->u_range_q6 - 1;
    (void)tick();
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(setpoint_range), guard.faults);
}

/// Checked limits: 1/16 above the parameter and three nanometres.
static void test_limits_are_those_of_the_parameters(void)
{
    TEST_ASSERT_INT32_WITHIN(1, 21253 * 64, cfg->u_vel_q6);   // 400 mm/s at 20 kHz
    TEST_ASSERT_INT32_WITHIN(7, 667 * 64 + 4, cfg->u_acc_q6); // 250 m/s2: 664.06 + 3
    TEST_ASSERT_EQUAL_INT32(600000 * 64, cfg->u_range_q6);    // half of 1.2 mm
}

static void test_fault_with_a_set_point_far_off_writes_from_the_last_good_place(void)
{
    static const int32_t far_q6[] = {INT32_MAX, INT32_MIN, 1 << 30, -(1 << 30)};
    for (int i = 0; i < 4; i++) {
        begin(cam_state_cutting);
        want.u_set_q6 = far_q6[i];
        motion.axis[hal_axis_u].vel_q10 = INT32_MAX; // the feed-forward would multiply it
        const cam_want_t safe = tick();
        TEST_ASSERT_EQUAL_INT(cam_state_fault, safe.state);
        TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(setpoint_speed), guard.faults);
        TEST_ASSERT_EQUAL_INT32(0, safe.u_set_q6);
        TEST_ASSERT_EQUAL_INT32(0, motion.axis[hal_axis_u].vel_q10);
    }
}

/// At the limit of acceleration the tick of the fault goes on with the speed of the last step and
/// the acceleration that was told; behind it the acceleration falls within the jerk of the window.
static void test_retract_goes_on_with_speed_and_acceleration_of_the_last_step(void)
{
    begin(cam_state_cutting);
    const int32_t a_q6 = cfg->u.acceleration_q10 / 16;
    int32_t at_q6 = 0;
    for (int32_t n = 1; n <= 5; n++) { // constant acceleration: the end of a step is a/2 faster
        at_q6 += n * a_q6;
        want.u_set_q6 = at_q6;
        motion.axis[hal_axis_u] = (cam_axis_motion_t){.pos_q10 = (int64_t)at_q6 * 16,
                                                      .vel_q10 = (n * a_q6 + a_q6 / 2) * 16,
                                                      .acc_q10 = a_q6 * 16};
        (void)tick();
        TEST_ASSERT_EQUAL_HEX32(0, guard.faults);
    }
    want.u_set_q6 = at_q6 + 6 * a_q6;
    in.inputs |= hal_in_estop;
    TEST_ASSERT_EQUAL_INT32(at_q6 + 6 * a_q6, tick().u_set_q6);
    TEST_ASSERT_EQUAL_INT32(a_q6 * 16, motion.axis[hal_axis_u].acc_q10);
    want.state = cam_state_fault;
    int32_t last_q6 = guard.u_set_q6;
    int32_t step_q6 = 6 * a_q6;
    int32_t acc_q6 = a_q6;
    const int32_t jerk_q6 = 2 * a_q6 >> cfg->leave.log2_window;
    for (int i = 0; i < 40; i++) {
        const int32_t now_q6 = tick().u_set_q6;
        const int32_t now_acc_q6 = now_q6 - last_q6 - step_q6;
        TEST_ASSERT_INT32_WITHIN(jerk_q6 + 4, acc_q6, now_acc_q6);
        TEST_ASSERT_INT32_WITHIN(2, now_acc_q6, motion.axis[hal_axis_u].acc_q10 / 16);
        step_q6 = now_q6 - last_q6;
        last_q6 = now_q6;
        acc_q6 = now_acc_q6;
    }
    TEST_ASSERT_LESS_THAN_INT32(0, step_q6);
}
