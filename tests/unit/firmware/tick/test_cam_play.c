// SPDX-License-Identifier: Apache-2.0
// Values of the set-points against doubles, with an exact spindle.
#include "cam_fix.h"
#include "cam_plan.h"
#include "play_bench.h"
#include <math.h>
#include <stdlib.h>

static double nm(const cam_axis_motion_t *axes, hal_axis_t axis)
{
    return (double)axes[axis].pos_q10 / 1024.0;
}

/// Cut at a measured Z that stands, so that angle and time are the only variables.
static void cut_long_at(int32_t z_nm)
{
    cut_at(z_nm);
    fixture_play_ticks(&f, 70); // the instant that is read ahead lies behind the engagement as well
}

static void test_u_with_lead_is_read_at_the_angle_to_come(void)
{
    static const int32_t lead_ns[] = {0, 50000, 137500, 3000000};
    for (int i = 0; i < 4; i++) {
        setUp();
        f.params.lead_ns = lead_ns[i];
        f.params.phase_udeg = 30000000;
        f.params.amplitude_ppm = 750000;
        cut_long_at(437000);
        for (int k = 0; k < 1000; k++) {
            f.angle.speed_q32 = 500000 + 9451 * k;
            fixture_play_tick(&f);
            const double ahead = f.angle.speed_q32 * (lead_ns[i] / 50000.0);
            const int64_t at = f.angle.pos_q32 + llround(ahead) - llround(CAM_TURN_Q32 / 12.0);
            const double wanted = 0.75 * fixture_play_u_nm(&f, at, 437000);
            TEST_ASSERT_DOUBLE_WITHIN(0.03, wanted, nm(f.axis, hal_axis_u));
        }
    }
}

/// Between two plans the envelope is straight: 8 ticks of 480 a turn below the smooth step, whose
/// second derivative is at most 5.774.
static double sagitta(int32_t turns)
{
    const double travel = FIXTURE_PLAN_TICKS / 480.0 / turns;
    return 5.774 * travel * travel / 8.0;
}

/// @return the smooth step as a drive X with a lag is commanded it, both as shares of the step: a
/// lag of up to a sixteenth is inverted, the rest is compensated for by reading ahead
static double commanded(double s, double lag)
{
    const double d = fmin(lag, 1.0 / 16.0);
    const double at = s + lag - d;
    const double q = at <= 0.0 || at >= 1.0 ? 0.0 : at * (1.0 - at);
    return fixture_play_smooth(at) + d * (30.0 * q * q + 15.0 * d * q * (1.0 - 2.0 * at));
}

static void test_xz_with_lag_are_read_ahead(void)
{
    static const int32_t lag_ns[] = {0, 1000000, 7777777};
    for (int i = 0; i < 3; i++) {
        setUp();
        f.params.xz_lag_ns = lag_ns[i];
        fixture_play_configure(&f);
        TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_engaging));
        TEST_ASSERT_TRUE(fixture_play_approach(&f));
        while (f.want.state != cam_state_disengaging) {
            fixture_play_tick(&f);
            const double at = (double)f.angle.pos_q32 + f.angle.speed_q32 * (lag_ns[i] / 50000.0);
            const double turns = (at - (double)f.plan.feed_at_q32) / 4294967296.0;
            const double lag = lag_ns[i] / 50000.0 / 480.0; // turns
            const double envelope = commanded((turns - lag) / 10.0 + 1.0, lag / 10.0) *
                                    (1.0 - commanded((turns - lag - 12.0) / 10.0, lag / 10.0));
            const double z_nm = nm(f.axis, hal_axis_z);
            // whole nanometres, and the sagitta of the ramps: 0.22 nm per tick^2
            TEST_ASSERT_DOUBLE_WITHIN(1.0 + 0.22 * FIXTURE_PLAN_TICKS * FIXTURE_PLAN_TICKS / 8.0,
                                      1e5 * eased(turns, 2.0, 10.0), z_nm);
            TEST_ASSERT_DOUBLE_WITHIN(0.05 + 2e6 * sagitta(10),
                                      fixture_play_x_nm(&f, z_nm) + 1e6 * (1.0 - envelope),
                                      nm(f.axis, hal_axis_x));
        }
    }
}

static void test_envelope_while_engaging_and_disengaging_is_the_smooth_step(void)
{
    static const int32_t turns[] = {1, 7, 100};
    for (int i = 0; i < 3; i++) {
        setUp();
        f.params.engage_turns = turns[i];
        f.params.disengage_turns = turns[2 - i];
        f.params.amplitude_ppm = 600000;
        fixture_play_configure(&f);
        TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_engaging));
        TEST_ASSERT_TRUE(fixture_play_approach(&f));
        for (fixture_play_tick(&f); f.want.state != cam_state_ready; fixture_play_tick(&f)) {
            const double since = fixture_play_turns(f.angle.pos_q32 - f.plan.engage_at_q32);
            const double left = fixture_play_turns(f.angle.pos_q32 - f.plan.disengage_at_q32);
            const double envelope = fixture_play_smooth(since / turns[i]) *
                                    (1.0 - fixture_play_smooth(left / turns[2 - i]));
            const double u_nm = fixture_play_u_nm(&f, f.angle.pos_q32, f.want.z_nm);
            const int32_t shortest = turns[i] < turns[2 - i] ? turns[i] : turns[2 - i];
            TEST_ASSERT_DOUBLE_WITHIN(0.05 + 0.6 * fabs(u_nm) * sagitta(shortest),
                                      0.6 * envelope * u_nm, nm(f.axis, hal_axis_u));
        }
    }
}

static void test_phase_changed_in_the_cut_is_ramped_the_short_way(void)
{
    f.params.phase_udeg = 170000000;
    cut_long_at(0);
    f.params.phase_udeg = -170000000; // 20 degrees onwards at 100 degrees per second: 0.2 s
    f.params.phase_rate_udeg_per_s = 100000000;
    fixture_play_configure(&f);
    const double step = 100.0 / 360.0 / FIXTURE_PLAY_HZ * 4294967296.0;
    uint32_t n = 0;
    while (f.motion.phase_q32 != f.config.play.phase_q32 && n < 5000) {
        const uint32_t before = (uint32_t)f.motion.phase_q32;
        fixture_play_tick(&f);
        const int32_t moved = cam_wrap_diff((uint32_t)f.motion.phase_q32, before);
        TEST_ASSERT_TRUE(moved >= -FIXTURE_PLAN_TICKS && moved <= step + 1.0); // rounded
        n++;
    }
    TEST_ASSERT_UINT32_WITHIN(2 * FIXTURE_PLAN_TICKS, 4000, n);
}

static void test_amplitude_changed_in_the_cut_is_ramped(void)
{
    static const int32_t goal_ppm[] = {0, 1250000, 1000000};
    cut_long_at(0);
    for (int i = 0; i < 3; i++) {
        const int32_t from_ppm = f.params.amplitude_ppm;
        f.params.amplitude_ppm = goal_ppm[i];
        f.params.amplitude_rate_ppm_per_s = 10000000;
        fixture_play_configure(&f);
        uint32_t n = 0;
        while (f.plan.amplitude_q30 != f.config.play.amplitude_q30 && n < 5000) {
            const int32_t before = f.plan.amplitude_q30;
            fixture_play_tick(&f);
            // 10 / 20 000 per tick
            TEST_ASSERT_INT32_WITHIN(536872 * FIXTURE_PLAN_TICKS, before, f.plan.amplitude_q30);
            n++;
        }
        TEST_ASSERT_UINT32_WITHIN(2 * FIXTURE_PLAN_TICKS,
                                  (uint32_t)abs(goal_ppm[i] - from_ppm) / 500u, n);
        fixture_play_ticks(&f, 2 * FIXTURE_PLAN_TICKS);
        const double u_nm = fixture_play_u_nm(&f, f.angle.pos_q32, 0);
        TEST_ASSERT_DOUBLE_WITHIN(0.05, goal_ppm[i] * 1e-6 * u_nm, nm(f.axis, hal_axis_u));
    }
}
