// SPDX-License-Identifier: Apache-2.0
// The force of U on a mass of this test: 1.5 kg at 20 kHz, the force of a tick acts for the tick
// after the next one.
#include "cam_build.h"
#include "cam_tick_inner.h"     // cam_force_t, cam_force_step_isr, cam_force_watch_isr
#include "cam_feasible_inner.h" // cam_servo_setup, cam_servo_needed_mn
#include "hal_host.h"
#include "unity.h"
#include <math.h>   // sin, fabs, sqrt
#include <stddef.h> // NULL

#define TICK_S 50e-6
#define MASS_KG 1.5

static cam_config_t cfg;
static cam_force_t force;
static cam_tick_record_t r;
static cam_motion_t m;
static double pos_nm, vel_nm_per_s, waiting_n, push_n, drag_n_s_per_m;
static int32_t line_nm; ///< end of the travel
static bool is_on, is_frozen, is_blocked;

static cam_params_t p;

static void configure(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_build_config(&cfg, &p, NULL, 0, 20000, 200000000).err);
    line_nm = p.u_stroke_nm / 2 + cfg.guard.approach_nm;
}

void setUp(void)
{
    hal_host_reset(20000);
    hal_host.slow.force.quantum_un = 20000;
    p = cam_param_defaults();
    p.servo_crossover_hz = 430;
    p.servo_pole_hz = 4000;
    p.servo_force_delay_ns = 75000;
    configure();
    force = (cam_force_t){0};
    r = (cam_tick_record_t){0};
    m = (cam_motion_t){.state = cam_state_ready};
    pos_nm = vel_nm_per_s = waiting_n = push_n = drag_n_s_per_m = 0.0;
    is_on = is_frozen = is_blocked = false;
}

/// A tick of the two stages, and of the mass. @return faults
static uint32_t tick(int32_t set_nm)
{
    if (!is_frozen) {
        r.in.actual_nm[hal_axis_u] = (int32_t)lround(pos_nm);
    }
    m.u.nm = set_nm;
    cam_force_step_isr(&force, &cfg.force, &r, is_on, &m);
    const uint32_t faults = cam_force_watch_isr(&force, &cfg.force, &r, &m);
    const double drag_n = drag_n_s_per_m * vel_nm_per_s * 1e-9;
    const double nm_per_s2 = (push_n - drag_n + waiting_n) / MASS_KG * 1e9;
    if (!is_blocked) {
        pos_nm += vel_nm_per_s * TICK_S + 0.5 * nm_per_s2 * TICK_S * TICK_S;
        vel_nm_per_s += nm_per_s2 * TICK_S;
    }
    waiting_n = r.force_q6 / 64e3;
    return faults;
}

/// @return ticks until a fault, at most n; the fault must be that one
static uint32_t until_fault(uint32_t mask, uint32_t n)
{
    for (uint32_t i = 1; i <= n; i++) {
        const uint32_t faults = tick(0);
        if (faults != 0u) {
            TEST_ASSERT_EQUAL_HEX32(mask, faults);
            return i;
        }
    }
    return n + 1u;
}

/// A U at rest at its set-point, with a loop that has just begun, needs no force at all.
static void test_only_an_identification_pushes(void)
{
    is_on = true;
    TEST_ASSERT_EQUAL_HEX32(0, tick(0));
    TEST_ASSERT_EQUAL_INT32(0, r.force_q6);
    setUp();
    is_on = true;
    m.state = cam_state_identifying;
    m.u_push_q6 = 1;
    TEST_ASSERT_EQUAL_HEX32(0, tick(0));
    TEST_ASSERT_EQUAL_INT32(1, r.force_q6);
}

static void let_settle(void)
{
    is_on = true;
    TEST_ASSERT_EQUAL_UINT32(2001, until_fault(0, 2000));
}

/// A reading outside the word of nm / 64 counts as its end: the force pulls U back.
static void test_reading_beyond_the_word_pulls_u_back(void)
{
    static const int32_t readings_nm[] = {INT32_MAX, 1 << 25, -(1 << 25) - 1, INT32_MIN};
    is_on = is_frozen = true;
    for (size_t i = 0; i < sizeof readings_nm / sizeof readings_nm[0]; i++) {
        force = (cam_force_t){0};
        r = (cam_tick_record_t){.in.actual_nm[hal_axis_u] = readings_nm[i]};
        for (int n = 0; n < 40; n++) {
            (void)tick(0);
        }
        const int32_t most_q6 = cfg.force.servo.limit_q6;
        TEST_ASSERT_EQUAL_INT32(readings_nm[i] > 0 ? -most_q6 : most_q6, r.force_q6);
    }
}

static void test_off_there_is_no_force_and_no_fault(void)
{
    pos_nm = 400000.0;
    r.in.inputs = hal_in_limit_u_low;
    force = (cam_force_t){.vel_q24 = 5, .still_nm = 6, .n_still = 7, .n_limited = 8};
    for (int i = 0; i < 100; i++) {
        TEST_ASSERT_EQUAL_HEX32(0, tick(0));
        TEST_ASSERT_EQUAL_INT32(0, r.force_q6);
    }
    TEST_ASSERT_EQUAL_INT64(INT64_C(400000) << 24, force.pos_q24);
    TEST_ASSERT_EQUAL_INT64(0, force.vel_q24);
    TEST_ASSERT_EQUAL_INT32(400000, force.still_nm);
    TEST_ASSERT_EQUAL_UINT32(0, force.n_still | force.n_limited);
}

static void test_it_follows_the_set_point_within_its_supervision(void)
{
    const double w = 2.0 * 3.14159265358979 * 100.0; // 0.5 mm at 3000 r/min, twice a turn
    is_on = true;
    double worst_nm = 0.0;
    for (int i = 0; i < 8000; i++) {
        const double size_nm = 500e3 * fmin(1.0, i / 4000.0);
        const double at = w * (i * TICK_S + 75e-6); // due when its force acts
        m.axis[hal_axis_u].vel_q10 = (int32_t)(size_nm * w * cos(at) * TICK_S * 1024.0);
        m.axis[hal_axis_u].acc_q10 =
            (int32_t)(-size_nm * w * w * sin(at) * TICK_S * TICK_S * 1024.0);
        TEST_ASSERT_EQUAL_HEX32(0, tick((int32_t)(size_nm * sin(at))));
        if (i > 6000) {
            worst_nm = fmax(worst_nm, fabs(pos_nm - size_nm * sin(w * (i + 1) * TICK_S)));
        }
    }
    TEST_ASSERT_TRUE(worst_nm < 2000.0);
}

/// The deviation is d / (m (2 pi 300 Hz)^2), here of the force limit.
static void test_weak_force_is_supervised_more_closely(void)
{
    static const struct {
        int32_t set_nm, limit_mn;
        double accepted_nm;
    } cases[] = {
        {0, 200000, 37527.0}, {0, 600000, 50000.0}, {0, 100000, 18763.5}, {70000, 200000, 70000.0}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        p = cam_param_defaults();
        p.servo_crossover_hz = 400;
        p.u_acceleration_mm_per_s2 = 60000;
        p.servo_runaway_nm = cases[i].set_nm;
        p.servo_force_limit_mn = cases[i].limit_mn;
        configure();
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * cases[i].accepted_nm, cases[i].accepted_nm,
                                  cfg.force.runaway_q6 / 64.0);
    }
}

/// 400 N s/m hold 1.5 kg at 50 mm/s under 20 N, as the observer expects.
static void test_drag_is_no_unknown_force(void)
{
    p = cam_param_defaults();
    p.servo_crossover_hz = 400;
    p.servo_drag_mn_s_per_m = 400000;
    p.u_acceleration_mm_per_s2 = 50000;
    p.servo_runaway_nm = 1000;
    configure();
    drag_n_s_per_m = 400.0;
    m.state = cam_state_manual; // it leaves its stroke
    is_on = true;
    double set_nm = 0.0;
    for (int i = 0; i < 2000; i++) {
        const double nm_per_s = 50e6 * fmin(1.0, i / 1000.0); // 1 m/s2
        set_nm += nm_per_s * TICK_S;
        m.axis[hal_axis_u].vel_q10 = (int32_t)(nm_per_s * TICK_S * 1024.0);
        m.axis[hal_axis_u].acc_q10 = i < 1000 ? (int32_t)(1e9 * TICK_S * TICK_S * 1024.0) : 0;
        TEST_ASSERT_EQUAL_HEX32(0, tick((int32_t)set_nm));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 20.0, r.force_q6 / 64e3);
}

/// The deviation is d / (m (2 pi 300 Hz)^2): 50 um at 266 N.
static void test_unknown_force_is_accepted_up_to_its_limit(void)
{
    for (int i = 0; i < 2; i++) {
        setUp();
        let_settle();
        push_n = i == 0 ? 60.0 : 310.0;
        const uint32_t n = until_fault(CAM_FAULT_BIT(u_runaway), 2000);
        TEST_ASSERT_UINT32_WITHIN(i == 0 ? 0 : 30, i == 0 ? 2001 : 40, n);
    }
}

/// Follow 0.2 mm twice a turn until the scale freezes, and on. @return ticks from there to the
/// fault
static uint32_t freeze(double rpm, double at_turn, uint32_t n)
{
    const double w = 2.0 * rpm * 2.0 * 3.14159265358979 / 60.0;
    const double amplitude_nm = 100000.0;
    is_on = true;
    const uint32_t begin = (uint32_t)(at_turn * 60.0 / rpm / TICK_S);
    for (uint32_t i = 0; i < begin + n; i++) {
        const double t = i * TICK_S;
        const double set_nm = amplitude_nm * (1.0 - cos(w * t));
        m.axis[hal_axis_u].vel_q10 = (int32_t)(amplitude_nm * w * sin(w * t) * TICK_S * 1024.0);
        m.axis[hal_axis_u].acc_q10 =
            (int32_t)(amplitude_nm * w * w * cos(w * t) * TICK_S * TICK_S * 1024.0);
        is_frozen = i >= begin;
        const uint32_t faults = tick((int32_t)lround(set_nm));
        if (faults != 0u) {
            TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(u_runaway), faults);
            TEST_ASSERT_TRUE(is_frozen);
            return i - begin;
        }
    }
    return n;
}

/// Without its scale U leaves the work for 5 ms, by its mass, with a quarter of its speed at least,
/// off by 5 mm/s or a tenth of its speed before. By hand it is let go.
static void test_frozen_u_leaves_the_work_by_its_mass(void)
{
    static const double speeds_rpm[] = {250.0, 1000.0, 3000.0};
    for (uint32_t i = 0; i < 12u; i++) {
        const double rpm = speeds_rpm[i % 3u];
        const double at_turn = i % 2u == 0u ? 2.1 : 2.35; // inwards, outwards
        setUp();
        p.servo_friction_mn = 1000;
        configure();
        m.is_by_hand = i >= 6u;
        (void)freeze(rpm, at_turn, 1000);
        TEST_ASSERT_EQUAL_UINT32(i < 6u ? 100 : 0, m.u_blind_ticks);
        const double due_nm_per_s = fmin(-100e6, vel_nm_per_s);
        const double within_nm_per_s = fmax(fabs(vel_nm_per_s) * 0.1, 5e6);
        is_on = false; // as the guard answers the fault
        m.state = cam_state_fault;
        for (uint32_t n = m.u_blind_ticks; n > 0u; n--) {
            TEST_ASSERT_EQUAL_UINT32(n, m.u_blind_ticks);
            TEST_ASSERT_EQUAL_HEX32(0, tick(0));
            TEST_ASSERT_INT32_WITHIN(cfg.force.servo.limit_q6, 0, r.force_q6);
            TEST_ASSERT_LESS_OR_EQUAL_INT32(0, r.force_q6);
        }
        TEST_ASSERT_EQUAL_HEX32(0, tick(0));
        TEST_ASSERT_EQUAL_INT32(0, r.force_q6);
        if (i < 6u) {
            TEST_ASSERT_DOUBLE_WITHIN(within_nm_per_s, due_nm_per_s, vel_nm_per_s);
        }
    }
}

/// The force is within its limit, also of a hot motor, and never inwards; a U that was blocked is
/// not thrown faster than it may move.
static void test_force_without_the_scale_is_limited(void)
{
    p.servo_force_rate_n_per_ms = 100;
    configure();
    for (int is_hot = 0; is_hot <= 1; is_hot++) {
        force.servo.is_hot = is_hot != 0;
        force.servo.heat_q54 = is_hot != 0 ? INT64_C(1) << 54 : 0;
        force.servo.force_q6 = 300000 * 64;
        force.excess_q10 = INT32_MAX;
        m.u_blind_ticks = 1;
        (void)tick(0);
        TEST_ASSERT_EQUAL_INT32(is_hot != 0 ? -300000 * 64 : -600000 * 64, r.force_q6);
    }
    setUp();
    is_on = is_frozen = true;
    force.driven_q10 = INT32_MAX / 2;
    force.speed_q10 = INT32_MAX / 2;
    for (int n = 0; n < 20 && m.u_blind_ticks == 0u; n++) {
        (void)tick(1000000);
    }
    const double most_nm_per_s = 400e6 + 100e6; // its limit, and the speed of leaving
    TEST_ASSERT_DOUBLE_WITHIN(1e6, most_nm_per_s, force.excess_q10 / 1024.0 / TICK_S);
}

/// On a flank at once, at a turning point once U must have left it.
static void test_frozen_scale_is_found_at_any_speed(void)
{
    static const struct {
        double rpm, at_turn;
        uint32_t most_ticks;
    } cases[] = {{3000.0, 2.1, 6}, {1000.0, 2.1, 6},  {250.0, 2.1, 6},  {60.0, 2.1, 52},
                 {3000.0, 2.0, 8}, {1000.0, 2.0, 25}, {250.0, 2.0, 88}, {60.0, 2.0, 310}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        p.servo_friction_mn = 1000;
        configure();
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(cases[i].most_ticks,
                                         freeze(cases[i].rpm, cases[i].at_turn, 1000));
    }
}

/// Under a steady force of 180 N/kg.
static void test_turning_points_are_no_frozen_scale(void)
{
    static const double speeds_rpm[] = {50.0, 250.0, 3000.0};
    for (uint32_t i = 0; i < 3u; i++) {
        setUp();
        p.servo_runaway_nm = 200000;
        configure();
        push_n = 180.0 * MASS_KG;
        (void)freeze(speeds_rpm[i], 8.0, 0);
    }
}

/// A slide that sticks moves only after its force has changed by twice the friction, which may be
/// stated a tenth too small; what it needs to hold a weight before the set-point moves does not
/// count.
static void test_u_that_sticks_is_no_frozen_scale(void)
{
    static const struct {
        double share; // the loop adds 0.15
        uint32_t n_before;
        uint32_t faults;
    } cases[] = {{0.8, 0, 0}, {1.0, 0, CAM_FAULT_BIT(u_runaway)}, {3.0, 100, 0}};
    for (int i = 0; i < 6; i++) {
        const double sign = i < 3 ? 1.0 : -1.0;
        setUp();
        p.servo_friction_mn = 6000;
        p.servo_integral_mHz = 0;
        configure();
        let_settle();
        is_blocked = true;
        const double nm_per_s2 = sign * cases[i % 3].share * 13.2 / MASS_KG * 1e9;
        m.axis[hal_axis_u].acc_q10 = (int32_t)(nm_per_s2 * TICK_S * TICK_S * 1024.0);
        uint32_t faults = 0;
        for (uint32_t n = 0; n < 400u; n++) {
            faults |= tick(n < cases[i % 3].n_before ? 0 : (int32_t)(sign * 160.0));
        }
        TEST_ASSERT_EQUAL_HEX32(cases[i % 3].faults, faults);
    }
    setUp(); // what 6 m/s2 of friction hold that nobody stated
    p.servo_integral_mHz = 0;
    configure();
    let_settle();
    is_blocked = true;
    m.axis[hal_axis_u].acc_q10 = (int32_t)(10.5e9 * TICK_S * TICK_S * 1024.0);
    for (int n = 0; n < 400; n++) {
        TEST_ASSERT_EQUAL_HEX32(0, tick(160));
    }
}

/// A wave of force must move U, though its set-point rests.
static void test_frozen_scale_is_found_by_a_wave_of_force(void)
{
    for (int i = 0; i < 2; i++) {
        setUp();
        let_settle();
        m.state = cam_state_identifying;
        is_frozen = i == 0;
        uint32_t faults = 0;
        for (int n = 0; n < 200 && faults == 0u; n++) {
            m.u_push_q6 = n % 20 < 10 ? 60 * 64000 : -60 * 64000;
            faults = tick(0);
        }
        TEST_ASSERT_EQUAL_HEX32(i == 0 ? CAM_FAULT_BIT(u_runaway) : 0u, faults);
    }
}

/// In manual the way back must be open.
static void test_travel_ends_beyond_the_following_error(void)
{
    static const struct {
        int32_t beyond_nm;
        cam_state_t state;
        uint32_t faults;
    } cases[] = {{0, cam_state_ready, 0},
                 {1, cam_state_ready, CAM_FAULT_BIT(u_travel)},
                 {1, cam_state_manual, 0}};
    for (uint32_t i = 0; i < 6u; i++) {
        const int32_t sign = i < 3u ? 1 : -1;
        setUp();
        let_settle();
        m.state = cases[i % 3u].state;
        pos_nm = sign * (line_nm + cases[i % 3u].beyond_nm);
        force.pos_q24 = (int64_t)pos_nm * (1 << 24); // arrived there slowly
        force.vel_q24 = 0;
        TEST_ASSERT_EQUAL_HEX32(cases[i % 3u].faults, tick(sign * line_nm));
        TEST_ASSERT_EQUAL(cases[i % 3u].faults != 0u, m.is_u_beyond);
    }
}

/// With half of 600 N 1.5 kg brake at 200 m/s2: from 200 mm/s within 0.1 mm.
static void test_speed_must_leave_room_to_brake(void)
{
    for (int by_nm = -1000; by_nm <= 1000; by_nm += 2000) {
        setUp();
        let_settle();
        pos_nm = line_nm - 100000 + by_nm;
        vel_nm_per_s = 200e6;
        force.pos_q24 = (int64_t)pos_nm << 24;
        force.vel_q24 = (int64_t)10000 << 24;
        TEST_ASSERT_EQUAL_HEX32(by_nm > 0 ? CAM_FAULT_BIT(u_travel) : 0u, tick((int32_t)pos_nm));
    }
}

static void test_limit_switch_stops_u_and_in_manual_lets_it_go_back(void)
{
    static const struct {
        uint32_t line;
        int32_t vel_q10;
        bool is_by_hand, is_fault;
    } cases[] = {
        {hal_in_limit_u_low, 0, false, true},     {hal_in_limit_u_high, 0, false, true},
        {hal_in_limit_u_low, 100, false, true},   {hal_in_limit_u_low, -100, true, true},
        {hal_in_limit_u_low, 100, true, false},   {hal_in_limit_u_high, 100, true, true},
        {hal_in_limit_u_high, -100, true, false}, {hal_in_limit_u_high, 0, true, false},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        let_settle();
        m.state = cases[i].is_by_hand ? cam_state_manual : cam_state_ready;
        m.axis[hal_axis_u].vel_q10 = cases[i].vel_q10;
        r.in.inputs = cases[i].line;
        TEST_ASSERT_EQUAL_HEX32(cases[i].is_fault ? CAM_FAULT_BIT(u_travel) : 0u, tick(0));
        TEST_ASSERT_FALSE(m.is_u_beyond);
    }
}

static void test_force_at_its_limit_for_too_long_is_a_fault(void)
{
    p.servo_runaway_nm = 10000000;
    configure();
    let_settle();
    is_blocked = true;
    pos_nm = -300000.0; // so far off that the force reaches its limit
    const uint32_t n = until_fault(CAM_FAULT_BIT(u_force), 2000);
    TEST_ASSERT_UINT32_WITHIN(25, 401, n); // 20 ms
}

/// With 10 um a reading that stands under 13 N would be that of a frozen scale.
static void test_u_at_its_stop_presses_with_limited_force_and_is_no_fault(void)
{
    enum { press_q6 = 20000 * 64 };
    p.servo_runaway_nm = 10000;
    configure();
    force.servo.most_q6 = press_q6;
    m.u_press_q6 = press_q6;
    force.n_limited = 8; // from the ticks before
    m.state = cam_state_manual;
    let_settle();
    is_blocked = true;
    pos_nm = -300000.0;
    TEST_ASSERT_EQUAL_UINT32(2001, until_fault(0, 2000));
    TEST_ASSERT_EQUAL_INT32(press_q6, r.force_q6);
    TEST_ASSERT_EQUAL_UINT32(0, force.n_limited);
    pos_nm = 300000.0; // the integral has not wound up
    TEST_ASSERT_EQUAL_UINT32(11, until_fault(0, 10));
    TEST_ASSERT_EQUAL_INT32(-press_q6, r.force_q6);
    m.axis[hal_axis_u].vel_q10 = 100;
    r.in.inputs = hal_in_limit_u_high;
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(u_travel), tick(0));
}

static void test_shift_of_the_origin_is_no_motion(void)
{
    let_settle();
    pos_nm += 5e6;
    m.u.home_nm = 5000000;
    cfg.force.travel_nm = 10000000;
    TEST_ASSERT_EQUAL_HEX32(0, tick(5000000));
}

static void test_delay_of_the_force_includes_the_latency_of_the_output(void)
{
    p = cam_param_defaults();
    cam_servo_config_t made;
    p.servo_crossover_hz = 300;
    p.servo_force_delay_ns = 60000;
    hal_host.slow.force.latency_ns = 60000;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_servo_setup(&p, 20000, &made).err);
    hal_host.slow.force.latency_ns = 60001;
    const cam_refusal_t refusal = cam_servo_setup(&p, 20000, &made);
    TEST_ASSERT_EQUAL_INT(cam_err_servo, refusal.err);
    TEST_ASSERT_EQUAL_INT(cam_param_servo_force_delay_ns, refusal.param);
}

/// 1.5 kg at 250 m/s2, and with friction, drag at 400 mm/s and a spring over half of 1 mm.
static void test_limits_of_u_fit_the_force(void)
{
    cam_servo_config_t made;
    p = cam_param_defaults();
    p.servo_crossover_hz = 300;
    for (int i = 0; i < 2; i++) {
        p.servo_force_limit_mn = i == 0 ? 375000 : 375000 + 5000 + 8000 + 2000;
        TEST_ASSERT_EQUAL_INT64(p.servo_force_limit_mn, cam_servo_needed_mn(&p));
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_servo_setup(&p, 20000, &made).err);
        p.servo_force_limit_mn--;
        TEST_ASSERT_EQUAL_INT(cam_err_servo_force, cam_servo_setup(&p, 20000, &made).err);
        p.servo_friction_mn = 5000;
        p.servo_drag_mn_s_per_m = 20000;
        p.u_speed_um_per_s = 400000;
        p.servo_stiffness_n_per_m = 4000;
        p.u_stroke_nm = 1000000;
    }
}

/// 1 mN accelerates 31 g by 129 nm per tick^2 at 500 Hz, more than 2^7.
static void test_mass_too_light_for_the_observer_at_a_slow_rate_is_refused(void)
{
    static const struct {
        int32_t rate_hz, mass_g;
        cam_err_t err;
    } cases[] = {{500, 31, cam_err_servo}, {500, 32, cam_ok}, {884, 10, cam_ok}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        p = cam_param_defaults();
        p.servo_crossover_hz = 10;
        p.servo_pole_hz = 100;
        p.servo_integral_mHz = 1000;
        p.servo_notch_hz = 0;
        p.servo_mass_g = cases[i].mass_g;
        cam_servo_config_t made;
        const cam_refusal_t refusal = cam_servo_setup(&p, (uint32_t)cases[i].rate_hz, &made);
        TEST_ASSERT_EQUAL_INT(cases[i].err, refusal.err);
        TEST_ASSERT_TRUE(cases[i].err == cam_ok || refusal.param == cam_param_servo_mass_g);
    }
}

/// U that presses on its stop may be far from its observer for any time.
static void test_observer_that_is_farther_off_than_its_word_wraps(void)
{
    is_on = true;
    m.state = cam_state_manual;
    m.u_press_q6 = 64;
    force.pos_q24 = INT64_MAX;
    force.vel_q24 = INT64_MAX;
    TEST_ASSERT_EQUAL_HEX32(0, tick(0));
    TEST_ASSERT_EQUAL_INT64(-2 + cfg.force.pos_q18, force.pos_q24); // 1 / 64 nm off
}

/// Without a loop the mass is not checked; at 625 Hz, 10 g would leave nothing of the word.
static void test_acceleration_of_a_light_mass_without_a_loop_fits_its_word(void)
{
    p = cam_param_defaults();
    p.servo_mass_g = 10;
    p.observer_bandwidth_mHz = 1000;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_build_config(&cfg, &p, NULL, 0, 625, 200000000).err);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cfg.force.motion_q24);
}
