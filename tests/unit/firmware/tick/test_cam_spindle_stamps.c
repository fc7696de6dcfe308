// SPDX-License-Identifier: Apache-2.0
// Edges with time stamps take the quantisation out of the measured angle, and a ripple that was
// learned is taken off before the observer. The true angle is that of the test's own spindle.
#include "cam_fix.h"
#include "cam_build.h"
#include "cam_tick_inner.h" // cam_spindle_t, cam_spindle_step_isr
#include "hal_host.h"
#include "unity.h"
#include <math.h>

enum { tick_hz = 20000, clock_hz = 200000000, counts_per_turn = 1000 };
static const double pi = 3.14159265358979323846;
static const double turn_q32 = 4294967296.0;

static cam_params_t params;
static cam_config_t config;
static cam_spindle_t spindle;
static cam_sense_t in;
static cam_angle_t angle;
static double t_s;
static double most_measured, most_observed; ///< [turn] largest errors of judged ticks

void setUp(void)
{
    hal_host_reset(tick_hz);
    hal_host.slow.has_edge_time = true;
    params = cam_param_defaults();
    params.counts_per_turn = counts_per_turn;
    params.observer_bandwidth_mHz = 200000;
}

void tearDown(void)
{
    hal_host.slow.has_edge_time = false;
}

static void build(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_build_config(&config, &params, NULL, 0, tick_hz, clock_hz).err);
    spindle = (cam_spindle_t){0};
    t_s = 0.0;
    in = (cam_sense_t){0};
    cam_spindle_step_isr(&spindle, &config.spindle, &in, 0, &angle); // counts from here on
}

/// True angle [turn] of a spindle with a ripple of its speed.
static double true_turn(double t, double turns_per_s, double ripple)
{
    const double turn = turns_per_s * t;
    return turn + ripple / (4.0 * pi) * sin(4.0 * pi * turn);
}

/// Time [s] of the last edge before t: where the true angle passed the boundary of its count.
static double edge_s(double t, double turns_per_s, double ripple)
{
    const double counts = true_turn(t, turns_per_s, ripple) * counts_per_turn;
    const double edge = turns_per_s > 0.0 ? floor(counts) : ceil(counts);
    double at = t;
    for (int i = 0; i < 8; i++) { // the ripple is small, so each step leaves a hundredth
        const double off = true_turn(at, turns_per_s, ripple) * counts_per_turn - edge;
        at -= off / (counts_per_turn * turns_per_s);
    }
    return at;
}

static double off_turns(uint32_t q32, double turn)
{
    const double exact = (turn - floor(turn)) * turn_q32;
    return (double)(int32_t)(q32 - (uint32_t)(uint64_t)llround(exact)) / turn_q32;
}

/// Turn for some seconds; the last half of them is judged.
static void turn(double seconds, double turns_per_s, double ripple)
{
    const int n = (int)(seconds * tick_hz);
    most_measured = 0.0;
    most_observed = 0.0;
    for (int i = 0; i < n; i++) {
        t_s += 1.0 / tick_hz;
        const double turns = true_turn(t_s, turns_per_s, ripple);
        in.clock = (uint32_t)(uint64_t)llround(t_s * clock_hz);
        in.encoder.counts = (uint32_t)(int32_t)floor(turns * counts_per_turn);
        in.encoder.edge_clock =
            (uint32_t)(int64_t)llround(edge_s(t_s, turns_per_s, ripple) * clock_hz);
        cam_spindle_step_isr(&spindle, &config.spindle, &in, 0, &angle);
        if (i > n / 2) {
            const double measured = fabs(off_turns(angle.measured_q32, turns));
            const double smooth = turns_per_s * t_s; // without the ripple
            const double observed = fabs(off_turns(cam_angle_of_pos(angle.pos_q32), smooth));
            most_measured = fmax(most_measured, measured);
            most_observed = fmax(most_observed, observed);
        }
    }
}

/// Half a count is left without stamps, and where edges are rarer than every fourth tick.
static void test_stamps_take_the_counts_out_of_the_angle_in_both_senses(void)
{
    static const struct {
        double turns_per_s;
        bool has_edge_time;
        double least, most; ///< [counts] largest error of the measured angle
    } cases[] = {{49.7, true, 0.0, 0.01},  {-49.7, true, 0.0, 0.01},  {17.3, true, 0.0, 0.01},
                 {-17.3, true, 0.0, 0.01}, {17.3, false, 0.45, 0.51}, {1.0, true, 0.45, 0.51}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        hal_host.slow.has_edge_time = cases[i].has_edge_time;
        build();
        turn(1.0, cases[i].turns_per_s, 0.0);
        const double counts = most_measured * counts_per_turn;
        TEST_ASSERT_TRUE(counts >= cases[i].least && counts < cases[i].most);
        TEST_ASSERT_TRUE(cases[i].least > 0.0 || most_observed < 0.01 / counts_per_turn);
    }
}

static void test_a_standing_spindle_is_in_the_middle_of_its_count(void)
{
    build();
    turn(1.0, 1.0, 0.0);
    for (int i = 0; i < 1000; i++) {
        in.clock += clock_hz / tick_hz;
        cam_spindle_step_isr(&spindle, &config.spindle, &in, 0, &angle);
    }
    const double counts = (double)in.encoder.counts + 0.5;
    TEST_ASSERT_TRUE(fabs(off_turns(angle.measured_q32, counts / counts_per_turn)) < 1e-8);
}

/// A spindle that stood is taken to have come forwards: its first edge is the begin of a count.
static void test_first_edge_from_rest_is_the_begin_of_its_count(void)
{
    build();
    in.clock += clock_hz / tick_hz;
    in.encoder.counts++;
    in.encoder.edge_clock = in.clock;
    cam_spindle_step_isr(&spindle, &config.spindle, &in, 0, &angle);
    const double counts = (double)in.encoder.counts;
    TEST_ASSERT_TRUE(fabs(off_turns(angle.measured_q32, counts / counts_per_turn)) < 1e-8);
}

/// A stamp from nowhere is never worth more than two counts.
static void test_a_wrong_stamp_is_limited(void)
{
    build();
    turn(0.2, 49.7, 0.0);
    for (uint32_t age = 0; age < 6u * 10000u; age += 97u) {
        cam_spindle_t s = spindle;
        cam_sense_t wrong = in;
        wrong.clock += clock_hz / tick_hz;
        wrong.encoder.counts += counts_per_turn * 50 / tick_hz;
        wrong.encoder.edge_clock = wrong.clock - age;
        cam_spindle_step_isr(&s, &config.spindle, &wrong, 0, &angle);
        const double counts = (double)wrong.encoder.counts + 0.5;
        TEST_ASSERT_TRUE(fabs(off_turns(angle.measured_q32, counts / counts_per_turn)) <
                         1.51 / counts_per_turn);
    }
}

/// At half a turn per tick an edge that is three ticks old contradicts the speed: what the speed
/// makes of the age is beyond a turn, and counts for a count and a half still.
static void test_an_edge_that_contradicts_the_speed_is_limited(void)
{
    static const int64_t half_a_turn_q64[] = {INT64_C(0x7FFFFFF000000000),
                                              -INT64_C(0x7FFFFFF000000000)};
    for (uint32_t i = 0; i < 2; i++) {
        build();
        turn(0.2, 49.7, 0.0);
        cam_sense_t wrong = in;
        spindle.speed_q64 = half_a_turn_q64[i];
        wrong.clock += clock_hz / tick_hz;
        wrong.encoder.edge_clock = wrong.clock - 3u * (clock_hz / tick_hz);
        cam_spindle_step_isr(&spindle, &config.spindle, &wrong, 0, &angle);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(encoder_jump), angle.faults);
        const double counts = (double)spindle.in_turn + 0.5;
        TEST_ASSERT_TRUE(fabs(off_turns(angle.measured_q32, counts / counts_per_turn)) <
                         1.51 / counts_per_turn);
    }
}

/// With the deviation learned the observer turns evenly: a ripple of 0.2 % twice a turn, of which
/// it misses a fifth, is followed to what the knots of the table leave.
static void test_a_learned_ripple_leaves_the_observer_even(void)
{
    build();
    turn(0.5, 49.7, 0.002);
    const double before = most_observed; // the angle ripple itself is 0.16 mturn
    TEST_ASSERT_TRUE(before > 5e-5);
    cam_learned_t learned = {0};
    for (int i = 0; i <= cam_learned_points; i++) {
        const double d_turn = 0.002 / (4.0 * pi) * sin(4.0 * pi * i / cam_learned_points);
        learned.dm[i] = (int16_t)lround(d_turn * 8388608.0);
    }
    build();
    config.learned = learned;
    cam_config_learn(&config);
    turn(0.5, 49.7, 0.002);
    TEST_ASSERT_TRUE(most_observed < 1.5e-6); // of d at an angle that itself is off by d
}
