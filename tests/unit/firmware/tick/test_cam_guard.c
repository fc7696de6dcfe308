// SPDX-License-Identifier: Apache-2.0
// The guard alone: each fault at its limit and one step beyond, in every state, as FAULTS.md has
// it, and how it brakes the command.
#include "cam_build.h"
#include "cam_tick_inner.h" // cam_guard_t, cam_guard_plan_isr
#include "cam_param.h"
#include "unity.h"
#include <string.h>

static cam_config_t config;
static const cam_guard_config_t *cfg = &config.guard;
static cam_guard_t guard;
static cam_sense_t in;
static cam_angle_t angle;
static cam_want_t want;
static cam_motion_t motion;
static int32_t lead_nm;        ///< command minus set-point
static int32_t sense;          ///< +1 or -1: side of U on which a limit is exceeded
static hal_setpoint_t written; ///< what the last tick wrote to U
static uint32_t n_ticks;

/// Set up the guard alone, without a controller.
static void reset(void)
{
    const cam_params_t params = cam_param_defaults();
    memset(&config, 0, sizeof config);
    memset(&guard, 0, sizeof guard);
    memset(&motion, 0, sizeof motion);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_build_config(&config, &params, NULL, 3030000, 20000, 200000000).err);
    cam_config_learn(&config);
    lead_nm = 0;
    n_ticks = 0;
    in = (cam_sense_t){.inputs = hal_in_drive_ready};
    angle = (cam_angle_t){.speed_q32 = 8947849, .is_synced = true};
    want = (cam_want_t){.spindle_mrpm = 2500000};
}

/// A tick after a plan. @return what is written
static cam_want_t tick(void)
{
    cam_tick_record_t r = {.tick = n_ticks++, .in = in, .angle = angle, .want = want};
    const int32_t u_nm = (cam_sat_add(want.u_set_q6, 32) >> 6) + lead_nm;
    motion.faults = want.faults | cam_guard_plan_isr(&guard, cfg, &config.play, &r);
    cam_guard_step_isr(&guard, cfg, &r, u_nm, &motion);
    written = r.out[hal_axis_u];
    return r.want;
}

/// U at rest there, before the next tick.
static void place(int32_t set_q6)
{
    want.u_set_q6 = set_q6;
    motion.u = (cam_u_t){.set_q6 = set_q6, .nm = (set_q6 + 32) >> 6};
}

/// Set up a machine in a state without any fault.
static void begin(cam_state_t state)
{
    reset();
    want.state = motion.state = state;
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
    case cam_fault_u_travel:
    case cam_fault_u_runaway:
    case cam_fault_u_force:
        want.faults = mask;
        break;
    case cam_fault_reverse:
        angle.speed_q32 = -17896 - beyond;
        break;
    case cam_fault_command: // its set-point is within the stroke
        want.faults = want.state == cam_state_fault ? mask : 0u; // there of a plan
        place(sense * (cfg->range_nm - 100) * 64);
        lead_nm = sense * (100 + beyond);
        break;
    case cam_fault_spindle_stopped:
        angle.speed_q32 = 17895;
        guard.n_stopped = (want.state == cam_state_homing ? 200000u : 2000u) -
                          (uint32_t)config.play.plan_ticks + (uint32_t)beyond;
        break;
    case cam_fault_overspeed:
        angle.speed_q32 = 10844792 + beyond; // 3030 r/min
        break;
    case cam_fault_following_error:
        in.actual_nm[hal_axis_u] = sense * (100000 + beyond);
        break;
    case cam_fault_setpoint_speed: // with the speed of the step before: no acceleration
        motion.u.set_step_q6 = sense * cfg->u_vel_q6;
        motion.u.step_nm = motion.u.set_step_q6 / 64;
        want.u_set_q6 = sense * (cfg->u_vel_q6 + beyond);
        break;
    case cam_fault_setpoint_acceleration:
        want.u_set_q6 = sense * (cfg->u_acc_q6 + beyond);
        break;
    case cam_fault_setpoint_range:
        place(sense * (cfg->range_nm + beyond) * 64);
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
        [cam_fault_setpoint_range] = "hrwm",
        [cam_fault_z_range] = "w",
        [cam_fault_table] = "hrwm",
        [cam_fault_swing] = "w",
        [cam_fault_command] = "hrwfm",
        [cam_fault_u_travel] = "hrwfm",
        [cam_fault_u_runaway] = "hrwfm",
        [cam_fault_u_force] = "hrwfm",
    };
    static const char letter[cam_n_states] = "ohrwwwfwrmw";
    return strchr(armed[fault], letter[state]) != NULL;
}

/// @return the outputs of a tick in which a fault is armed or not; some disable the drives at once
static uint32_t outputs_of(cam_fault_t fault, cam_state_t state, bool is_fault)
{
    const uint32_t lamp = is_fault || state == cam_state_fault ? (uint32_t)hal_out_fault : 0u;
    const bool is_cut = state == cam_state_cutting || state == cam_state_holding;
    const bool is_lost = fault == cam_fault_drive || fault == cam_fault_u_runaway;
    const bool is_off = state == cam_state_off || (is_fault && is_lost);
    const uint32_t in_cut = is_cut && !is_fault ? (uint32_t)hal_out_in_cut : 0u;
    return lamp | in_cut | (is_off ? 0u : (uint32_t)hal_out_enable);
}

/// Cause a fault, or bring the machine to its limit: what the tick writes is that of the state.
static void expect_reaction(cam_fault_t fault, cam_state_t state, int32_t beyond)
{
    begin(state);
    cause(fault, beyond);
    const cam_want_t safe = tick();
    const bool is_fault = beyond != 0 && is_armed(fault, state);
    const bool is_entered = is_fault && state != cam_state_fault;
    const uint32_t wanted = is_fault ? UINT32_C(1) << fault : 0u;
    const char *name = cam_fault_name(fault);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(wanted, guard.faults, name);
    TEST_ASSERT_EQUAL_INT_MESSAGE(is_fault ? cam_state_fault : state, safe.state, name);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(is_entered ? wanted : 0u, guard.first_faults, name);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(outputs_of(fault, state, is_fault), safe.outputs, name);
    TEST_ASSERT_EQUAL_INT32_MESSAGE(is_fault || state == cam_state_fault ? 0 : 2500000,
                                    safe.spindle_mrpm, name);
    TEST_ASSERT_EQUAL_INT(state == cam_state_off, safe.is_retracted);
}

static void test_fault_beyond_its_limit_is_latched_at_once_where_it_is_armed(void)
{
    for (int fault = 0; fault < cam_n_faults; fault++) {
        for (int state = 0; state < cam_n_states; state++) {
            for (sense = -1; sense <= 1; sense += 2) {
                expect_reaction((cam_fault_t)fault, (cam_state_t)state, 1);
                expect_reaction((cam_fault_t)fault, (cam_state_t)state, 0);
            }
        }
    }
}

/// U that moves by time lags behind drives that differ from what was believed, and U that presses
/// on its stop, with limited force, is far from its set-point.
static void test_following_error_out_of_the_cut_has_a_limit_of_its_own(void)
{
    static const struct {
        bool is_playing;
        int32_t press_q6, actual_nm;
        bool is_accepted;
    } cases[] = {
        {false, 0, 150000, true},   {false, 0, 150001, false},    {true, 0, 150000, false},
        {false, 1, 10000000, true}, {false, 0, -10000000, false}, {true, 1, 10000000, false},
        {false, 0, -150000, true},  {false, -1, -10000000, true},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin(cam_state_engaging);
        config.guard.approach_nm = 150000;
        motion.is_playing = cases[i].is_playing;
        motion.u_press_q6 = cases[i].press_q6;
        in.actual_nm[hal_axis_u] = cases[i].actual_nm;
        (void)tick();
        TEST_ASSERT_EQUAL_HEX32(cases[i].is_accepted ? 0u : CAM_FAULT_BIT(following_error),
                                guard.faults);
    }
}

/// An encoder that stops is a fault in the work only.
static void test_encoder_that_stops_ends_the_work(void)
{
    for (int state = 0; state < cam_n_states; state++) {
        begin((cam_state_t)state);
        angle.has_stopped = true;
        (void)tick();
        const bool is_in_work = is_armed(cam_fault_reverse, (cam_state_t)state);
        TEST_ASSERT_EQUAL_HEX32(is_in_work ? CAM_FAULT_BIT(spindle_stopped) : 0u, guard.faults);
    }
}

/// [place, its last step, command wanted, off time, whether it is accepted]
static void test_limits_of_the_command_hold_to_the_nanometre(void)
{
    static const struct {
        int32_t nm, step_nm, want_nm;
        bool is_off_time, is_accepted;
    } cases[] = {
        {0, 0, 50, false, true},         {0, 0, 51, false, false},
        {0, 970, 1000, false, true},     {0, 970, 1001, false, false},
        {99990, 0, 100000, false, true}, {99990, 0, 100001, false, false},
        {0, 0, 400, true, true},         {0, 0, 401, true, false},
    };
    for (size_t k = 0; k < 2u * sizeof cases / sizeof cases[0]; k++) {
        const size_t i = k / 2u;
        const int32_t sign = k % 2u == 0u ? 1 : -1;
        const int32_t want_nm = sign * cases[i].want_nm;
        begin(cam_state_cutting);
        config.guard.range_nm = 100000;
        config.guard.step_nm = 1000;
        config.guard.change_nm = 50;
        config.guard.change_off_nm = 400;
        motion.u.nm = sign * cases[i].nm;
        motion.u.step_nm = sign * cases[i].step_nm;
        lead_nm = want_nm;
        angle.is_off_time = cases[i].is_off_time;
        (void)tick();
        const int32_t step_nm = want_nm - sign * cases[i].nm;
        TEST_ASSERT_EQUAL_HEX32(cases[i].is_accepted ? 0u : CAM_FAULT_BIT(command), guard.faults);
        if (cases[i].is_accepted) {
            TEST_ASSERT_EQUAL_INT32(want_nm, written.pos_nm);
            TEST_ASSERT_EQUAL_INT32(want_nm, motion.u.nm);
            TEST_ASSERT_EQUAL_INT32(step_nm, motion.u.step_nm);
            TEST_ASSERT_EQUAL_INT32(step_nm - sign * cases[i].step_nm, motion.u.change_nm);
        }
    }
}

/// In off nothing is a motion: the command is where U stands, in its stroke.
static void test_off_follows_u_without_a_step(void)
{
    static const int32_t places_nm[][2] = {
        {-70000, -70000}, {70000, 70000}, {5000000, 600000}, {-5000000, -600000}};
    begin(cam_state_off);
    motion.u.home_nm = 300;
    for (size_t i = 0; i < 4u; i++) {
        want.u_set_q6 = places_nm[i][0] * 64;
        (void)tick();
        TEST_ASSERT_EQUAL_INT32(places_nm[i][1] - 300, written.pos_nm);
        TEST_ASSERT_EQUAL_INT32(places_nm[i][1], motion.u.nm);
        TEST_ASSERT_EQUAL_INT32(0, motion.u.step_nm);
        TEST_ASSERT_EQUAL_INT32(0, motion.u.set_step_q6);
    }
}

/// What the scale should show is the set-point of one lead ago, between two ticks by its share. A
/// home that is found meanwhile is no motion.
static void test_due_set_point_is_that_of_one_lead_ago_from_any_home(void)
{
    begin(cam_state_ready);
    config.guard.due_ticks = 3;
    config.guard.due_part_q31 = 1 << 30; // a half
    int32_t home_nm = 0;
    for (int32_t n = 0; n < 200; n++) {
        home_nm += n == 100 ? 12345678 : 0;
        motion.u.home_nm = home_nm;
        motion.u.set_q6 += n == 100 ? home_nm * 64 : 0;
        motion.u.nm += n == 100 ? home_nm : 0;
        want.u_set_q6 = 640 * n + 64 * home_nm;
        config.guard.range_nm = 15000000;
        in.actual_nm[hal_axis_u] = home_nm + 10 * n - 35;
        const cam_want_t done = tick();
        TEST_ASSERT_EQUAL_HEX32(0, guard.faults);
        TEST_ASSERT_EQUAL_INT32(n < 4 ? done.u_due_q6 : 640 * n - 2240 + 64 * home_nm,
                                done.u_due_q6);
    }
}

static void test_fault_with_a_set_point_far_off_retracts_from_the_last_good_place(void)
{
    static const int32_t far_q6[] = {INT32_MAX, INT32_MIN, 1 << 30, -(1 << 30)};
    for (int i = 0; i < 4; i++) {
        begin(cam_state_cutting);
        want.u_set_q6 = far_q6[i];
        motion.axis[hal_axis_u].vel_q10 = INT32_MAX; // of the set-point that is not accepted
        const cam_want_t safe = tick();
        TEST_ASSERT_EQUAL_INT(cam_state_fault, safe.state);
        TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(setpoint_speed), guard.faults);
        const int32_t jerk_nm = 2 * cfg->u.acceleration_q10 / 1024 >> cfg->u.log2_window;
        TEST_ASSERT_INT32_WITHIN(jerk_nm + 1, 0, written.pos_nm);
        TEST_ASSERT_EQUAL_INT32(written.pos_nm * 64, safe.u_set_q6);
    }
}

/// From the tick of the fault on the command continues with the speed of its last step, whatever
/// the set-point was: in a motion by time with its acceleration, in the cut and in a wave without.
/// The acceleration changes within the jerk of the window. In the cut a step that is beyond U's
/// acceleration, by friction's reversal or a late tick, is not continued, but the smaller one of
/// the last two. A home is no motion.
static void test_retract_continues_from_the_last_command(void)
{
    static const struct {
        cam_state_t state;
        int32_t step_nm, change_nm;             // of the last command
        int32_t first_step_nm, first_change_nm; // with which the retract begins
    } cases[] = {
        {cam_state_cutting, 2000, 0, 2000, 0},      {cam_state_cutting, 2000, 300, 2000, 0},
        {cam_state_cutting, 2000, -300, 2000, 0},   {cam_state_cutting, -2000, -300, -2000, 0},
        {cam_state_cutting, 2000, 5000, 2000, 0},   {cam_state_cutting, 2000, 1500, 500, 0},
        {cam_state_cutting, -2000, -1900, -100, 0}, {cam_state_cutting, -2000, -2300, 300, 0},
        {cam_state_cutting, 300, -1700, 300, 0},    {cam_state_cutting, 1000, 2000, 1000, 0},
        {cam_state_identifying, 300, 500, 300, 0},  {cam_state_homing, 2000, 0, 2000, 0},
        {cam_state_homing, 2000, 300, 2000, 300},   {cam_state_homing, -2000, 300, -2000, 300},
        {cam_state_manual, 2000, -300, 2000, -300}, {cam_state_homing, 2000, 5000, 2000, 625},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin(cases[i].state);
        const int32_t a_nm = cfg->u.acceleration_q10 / 1024;
        const int32_t jerk_nm = (2 * a_nm >> cfg->u.log2_window) + 2;
        int32_t change_nm = cases[i].first_change_nm;
        motion.is_playing = cases[i].state == cam_state_cutting;
        motion.u = (cam_u_t){.home_nm = 1000000,
                             .set_q6 = 100000 * 64,
                             .nm = 120000,
                             .step_nm = cases[i].step_nm,
                             .change_nm = cases[i].change_nm};
        in.inputs |= hal_in_estop;
        int32_t last_nm = 120000;
        int32_t step_nm = cases[i].first_step_nm;
        for (int n = 0; n < 40; n++) {
            const cam_want_t safe = tick();
            want.state = cam_state_fault;
            const int32_t now_nm = written.pos_nm + 1000000;
            TEST_ASSERT_INT32_WITHIN(jerk_nm, change_nm, now_nm - last_nm - step_nm);
            TEST_ASSERT_INT32_WITHIN(2, now_nm - last_nm - step_nm, written.acc_q10 / 1024);
            TEST_ASSERT_EQUAL_INT32(now_nm * 64, safe.u_set_q6);
            change_nm = now_nm - last_nm - step_nm;
            step_nm = now_nm - last_nm;
            last_nm = now_nm;
        }
        TEST_ASSERT_LESS_THAN_INT32(0, step_nm);
    }
}

/// Towards the end of the stroke too fast to brake, the command stops there, and retracts from
/// there. From beyond it never moves farther out.
static void test_retract_stops_at_the_end_of_the_stroke(void)
{
    static const int32_t places_nm[][2] = {{599000, 600000}, {600000, 600000}, {700000, 700000}};
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        for (size_t i = 0; i < 3u; i++) {
            begin(cam_state_cutting);
            motion.u = (cam_u_t){.nm = sign * places_nm[i][0], .step_nm = sign * 5000};
            in.inputs |= hal_in_estop;
            for (int n = 0; n < 300; n++) {
                (void)tick();
                want.state = cam_state_fault;
                TEST_ASSERT_LESS_OR_EQUAL_INT32(places_nm[i][1], sign * written.pos_nm);
                TEST_ASSERT_TRUE(n > 0 || sign * written.pos_nm == places_nm[i][1]);
                const int32_t left_nm = n < 9 ? -1 : 5000; // from rest, not from farther out
                TEST_ASSERT_LESS_THAN_INT32(places_nm[i][1] - left_nm, sign * written.pos_nm);
            }
            TEST_ASSERT_EQUAL_INT32(-500000, written.pos_nm);
        }
    }
}

/// At a limit switch U retracts; out of the work, at the lower one, it brakes where it is. Beyond
/// its travel it is let go at once.
static void test_u_that_takes_forces_is_held_at_a_limit_switch(void)
{
    static const struct {
        uint32_t line;
        int32_t from_nm, ends_nm, within_nm;
    } cases[] = {{hal_in_limit_u_low, 1000, -500000, 0},
                 {hal_in_limit_u_high, 1000, -500000, 0},
                 {hal_in_limit_u_high, -520000, -500000, 0},
                 {hal_in_limit_u_low, -520000, -540000, 19000}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin(cam_state_cutting);
        motion.u = (cam_u_t){.nm = cases[i].from_nm, .step_nm = -1000};
        in.inputs |= cases[i].line;
        want.faults = CAM_FAULT_BIT(u_travel);
        for (int n = 0; n < 300; n++) {
            TEST_ASSERT_EQUAL_HEX32(hal_out_fault | hal_out_enable, tick().outputs);
            want.state = cam_state_fault;
        }
        TEST_ASSERT_INT32_WITHIN(cases[i].within_nm, cases[i].ends_nm, written.pos_nm);
        motion.is_u_beyond = true;
        TEST_ASSERT_EQUAL_HEX32(hal_out_fault, tick().outputs);
    }
}

/// With a frozen scale U is held while it is pushed outwards, unless it cannot be or is out.
static void test_u_with_a_frozen_scale_is_held_while_it_is_pushed(void)
{
    static const struct {
        uint32_t faults, on, off;
        int32_t nm;
        bool is_beyond, is_held;
    } cases[] = {
        {0, 0, 0, 0, false, true},
        {CAM_FAULT_BIT(u_travel), hal_in_limit_u_high, 0, 0, false, true},
        {CAM_FAULT_BIT(u_travel), 0, 0, 0, true, false},
        {0, hal_in_limit_u_low, 0, 0, false, false},
        {0, 0, hal_in_drive_ready, 0, false, false},
        {0, 0, 0, -500000, false, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin(cam_state_cutting);
        motion.u = (cam_u_t){.nm = cases[i].nm};
        want.faults = CAM_FAULT_BIT(u_runaway) | cases[i].faults;
        motion.u_blind_ticks = 3;
        motion.is_u_beyond = cases[i].is_beyond;
        in.inputs = (in.inputs | cases[i].on) & ~cases[i].off;
        const uint32_t enable = cases[i].is_held ? (uint32_t)hal_out_enable : 0u;
        TEST_ASSERT_EQUAL_HEX32(hal_out_fault | enable, tick().outputs);
        TEST_ASSERT_EQUAL_UINT32(cases[i].is_held ? 3 : 0, motion.u_blind_ticks);
        want.state = cam_state_fault;
        motion.u_blind_ticks = 0;
        TEST_ASSERT_EQUAL_HEX32(hal_out_fault, tick().outputs);
    }
    motion.u_blind_ticks = 1;
    want.state = motion.state = cam_state_off;
    TEST_ASSERT_EQUAL_HEX32(0, tick().outputs);
    TEST_ASSERT_EQUAL_UINT32(0, motion.u_blind_ticks);
}

/// Faults of one tick are all reported. A drive that is lost while U retracts drops enable at once,
/// and its return does not set it again.
static void test_faults_add_up_until_off(void)
{
    const uint32_t both = CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(encoder_jump);
    begin(cam_state_cutting);
    in.inputs |= hal_in_estop;
    angle.faults = CAM_FAULT_BIT(encoder_jump);
    (void)tick();
    want.state = cam_state_fault;
    TEST_ASSERT_EQUAL_HEX32(hal_out_fault | hal_out_enable, tick().outputs);
    TEST_ASSERT_EQUAL_HEX32(both, guard.first_faults);
    in.inputs = 0;
    for (int i = 0; i < 10; i++) {
        TEST_ASSERT_EQUAL_HEX32(hal_out_fault, tick().outputs);
        in.inputs = hal_in_drive_ready;
    }
    TEST_ASSERT_EQUAL_HEX32(both, guard.first_faults);
    TEST_ASSERT_EQUAL_HEX32(both | CAM_FAULT_BIT(drive), guard.faults);
}

/// In ready the spindle may stand: its time counts from the start of the work on.
static void test_time_of_standing_counts_in_the_work_only(void)
{
    begin(cam_state_ready);
    angle.speed_q32 = 0;
    for (int i = 0; i < 4000; i++) {
        (void)tick();
    }
    want.state = cam_state_engaging;
    int n_plans = 0;
    while (guard.faults == 0u && n_plans < 1000) {
        (void)tick();
        n_plans++;
    }
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(spindle_stopped), guard.faults);
    TEST_ASSERT_EQUAL_INT(2000 / 8 + 1, n_plans);
}

/// A fault in the first enabled tick finds U at rest, whatever U did before the last fault.
static void test_off_forgets_the_motion_before_it(void)
{
    begin(cam_state_off);
    motion.u =
        (cam_u_t){.set_q6 = 64, .set_step_q6 = 6400, .nm = 1, .step_nm = 100, .change_nm = 1};
    (void)tick();
    want = (cam_want_t){.state = cam_state_manual, .faults = CAM_FAULT_BIT(late_tick)};
    motion.is_by_hand = true;
    const cam_want_t safe = tick();
    TEST_ASSERT_EQUAL_INT(cam_state_fault, safe.state);
    TEST_ASSERT_EQUAL_INT32(0, safe.u_set_q6);
    TEST_ASSERT_EQUAL_INT32(0, motion.axis[hal_axis_u].vel_q10);
    TEST_ASSERT_EQUAL_INT32(0, motion.axis[hal_axis_u].acc_q10);
}
