// SPDX-License-Identifier: Apache-2.0
// Values of the set-points against doubles, with an exact spindle; Z geared to it, along a
// ring-helix, or measured: ramps, exactness, ends, ranges.
#include "cam_fix.h"
#include "cam_plan.h"
#include "play_bench.h"
#include "fixture_newer.h"
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

static void test_feed_of_62000_turns_is_exact_to_a_nanometre(void)
{
    part.n_slices = 130;
    part.log2_knots = 2;
    part.frac_bits = 0;
    part.n_x = 130;
    part.x_frac_bits = 0;
    part.z_first_nm = -999999937;
    part.z_last_nm = 984000063;
    part.feed_nm = 32001;
    part.u = fixture_ellipse;
    part.x = fixture_cylinder;
    fixture_play_init(&f, &part);
    TEST_ASSERT_NOT_NULL(f.config.play.table);
    engage();
    const double fed = ((double)part.z_last_nm - part.z_first_nm) / 32001.0;
    TEST_ASSERT_TRUE(fed > 61990.0);
    for (double turns = 2.0; turns < fed; turns += 0.9973) {
        const double z_nm = part.z_first_nm + 32001.0 * (turns - 1.0);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, z_nm, z_at(turns));
    }
    TEST_ASSERT_EQUAL_DOUBLE(part.z_last_nm, z_at(fed + 2.0));
    TEST_ASSERT_EQUAL_INT(cam_state_disengaging, f.want.state);
    TEST_ASSERT_EQUAL_DOUBLE(part.z_last_nm, z_at(fed + 11.0));
}

/// Up to the middle and down again; a ramp longer than what is fed is as long as that.
static void test_feed_eases_in_and_out_over_its_ramp(void)
{
    static const struct {
        int32_t ramp_turns;
        uint32_t feed_nm;
    } cases[] = {{1, 100000}, {2, 100000}, {5, 100000}, {37, 100000}, {2, 941176}, {100, 1000000}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        part.feed_nm = cases[i].feed_nm;
        fixture_play_init(&f, &part);
        f.params.feed_ramp_turns = cases[i].ramp_turns;
        fixture_play_configure(&f);
        engage();
        const double fed = ((double)part.z_last_nm - part.z_first_nm) / part.feed_nm;
        const double r = fmin(cases[i].ramp_turns, fed);
        TEST_ASSERT_EQUAL_DOUBLE(part.z_first_nm, z_at(-1.0));
        for (double turns = 0.0; turns < fed + r; turns += 0.00713) {
            const double z_nm = part.z_first_nm + part.feed_nm * eased(turns, r, fed);
            TEST_ASSERT_DOUBLE_WITHIN(1.0, z_nm, z_at(turns));
            TEST_ASSERT_EQUAL_INT(cam_state_cutting, f.want.state);
        }
        TEST_ASSERT_EQUAL_DOUBLE(part.z_last_nm, z_at(fed + r + 1e-6));
        TEST_ASSERT_EQUAL_INT(cam_state_disengaging, f.want.state);
    }
}

static void start_at(int32_t z_nm)
{
    fixture_play_init(&f, &part);
    cut_at(z_nm);
}

/// The speed is that of the step before, and half of the acceleration.
static void test_measured_z_is_what_is_played(void)
{
    start_at(0);
    for (int32_t z_nm = 0; z_nm < 1000000; z_nm += 771) {
        f.in.actual_nm[hal_axis_z] = z_nm;
        fixture_play_ticks(&f, rounds);
        TEST_ASSERT_EQUAL_INT32(z_nm, f.want.z_nm);
        TEST_ASSERT_EQUAL_INT64((int64_t)z_nm * 1024, f.axis[hal_axis_z].pos_q10);
        const cam_axis_motion_t *u = &f.motion.axis[hal_axis_u];
        const double step_nm =
            (double)(f.axis[hal_axis_u].pos_q10 - f.before[hal_axis_u].pos_q10) / 1024.0;
        TEST_ASSERT_DOUBLE_WITHIN(0.03, fixture_play_u_nm(&f, f.angle.pos_q32, z_nm),
                                  (double)f.axis[hal_axis_u].pos_q10 / 1024.0);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, step_nm + u->acc_q10 / 2048.0, u->vel_q10 / 1024.0);
        TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
    }
    fixture_play_ticks(&f, 20000); // only stop ends the cut
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, f.want.state);
}

/// Others lead Z, so no override changes where the cut is or ends.
static void test_an_override_is_nothing_to_a_measured_z(void)
{
    start_at(0);
    const int64_t end_q32 = f.plan.disengage_at_q32;
    const int32_t requested_q30 = f.plan.feed_motion.requested_q30;
    f.config.play.feed_rate_q30 = requested_q30 / 2;
    fixture_play_ticks(&f, rounds);
    TEST_ASSERT_EQUAL_INT64(end_q32, f.plan.disengage_at_q32);
    TEST_ASSERT_EQUAL_INT32(requested_q30, f.plan.feed_motion.requested_q30);
}

/// Z runs ahead of the helix by 0.16 mm in the middle.
static void ahead(double z_nm, double w[3])
{
    const double k = 6.283185307179586 / 1e6; // of the short skirt's height
    w[0] = 0.5 * (1.0 - cos(k * z_nm)) / k;
    w[1] = 0.5 * sin(k * z_nm);
    w[2] = 0.5 * k * cos(k * z_nm);
}

/// The way belongs to a geared Z: what is measured is the height itself.
static void test_a_measured_z_has_no_way(void)
{
    int64_t height_q32[2];
    for (int i = 0; i < 2; i++) {
        fixture_play_init(&f, &part);
        if (i == 1) {
            fixture_newer_way(&f.image, ahead, 15, 4);
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(f.image.bytes, f.image.size, &f.table));
            TEST_ASSERT_NOT_NULL(f.table.way.knots);
        }
        cut_at(500000);
        fixture_play_ticks(&f, rounds);
        TEST_ASSERT_EQUAL_INT64(INT64_C(500000) * 1024, f.axis[hal_axis_z].pos_q10);
        height_q32[i] = f.motion.height_q32;
    }
    TEST_ASSERT_TRUE(height_q32[0] > INT64_C(1) << 32);
    TEST_ASSERT_EQUAL_INT64(height_q32[0], height_q32[1]);
}

/// @return the faults that one plan detects, reported in the ticks up to the next one
static uint32_t faults_within_a_plan(void)
{
    uint32_t faults = 0;
    for (int i = 0; i <= FIXTURE_PLAN_TICKS; i++) {
        fixture_play_tick(&f);
        faults |= i > 0 ? f.want.faults : 0u; // the first tick may still report the plan before
    }
    return faults;
}

/// Z moves to a place by a few micrometres per plan. @return faults on the way there
static uint32_t carry_z_to(int32_t z_nm)
{
    int32_t *const at_nm = &f.in.actual_nm[hal_axis_z];
    uint32_t faults = 0;
    while (*at_nm != z_nm) {
        const int32_t left_nm = z_nm - *at_nm;
        *at_nm += left_nm > 20000 ? 20000 : left_nm < -20000 ? -20000 : left_nm;
        faults |= faults_within_a_plan();
    }
    return faults;
}

static void test_measured_z_beyond_table_and_margin_is_a_fault(void)
{
    static const int32_t z_nm[] = {-100000, 1100000};
    for (int i = 0; i < 2; i++) {
        start_at(0);
        TEST_ASSERT_EQUAL_HEX32(0, carry_z_to(z_nm[i]));
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(z_range), carry_z_to(z_nm[i] + (i == 0 ? -1 : 1)));
    }
}

/// A jump further than the margin within a plan is a fault, in either direction and however far,
/// and X is led to no place of the wrong height before the guard takes over.
static void test_measured_z_that_jumps_is_a_fault(void)
{
    static const int32_t to_nm[] = {600000,  400000, 600001,    399999,
                                    1400000, 100000, INT32_MIN, INT32_MAX};
    for (int i = 0; i < 8; i++) {
        start_at(0);
        TEST_ASSERT_EQUAL_HEX32(0, carry_z_to(500000));
        TEST_ASSERT_EQUAL_HEX32(0, faults_within_a_plan() | faults_within_a_plan()); // Z rests
        const int64_t x_q10 = f.motion.axis[hal_axis_x].pos_q10;
        f.in.actual_nm[hal_axis_z] = to_nm[i];
        TEST_ASSERT_EQUAL_HEX32(i < 2 ? 0u : CAM_FAULT_BIT(z_range), faults_within_a_plan());
        if (i >= 2) {
            TEST_ASSERT_INT64_WITHIN(1024 * 100, x_q10, f.motion.axis[hal_axis_x].pos_q10);
            TEST_ASSERT_EQUAL_INT32(0, f.motion.axis[hal_axis_z].vel_q10);
        }
    }
}

static void test_geared_z_off_its_place_by_more_than_the_margin_is_a_fault(void)
{
    fixture_play_init(&f, &part);
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    fixture_play_ticks(&f, 3000);
    f.angle.speed_q32 = 0;
    fixture_play_ticks(&f, rounds);
    f.is_axes_held = true;
    static const int32_t off_nm[] = {0, 100000, -100000, 100001, -100001};
    for (int i = 0; i < 5; i++) {
        f.in.actual_nm[hal_axis_z] = f.want.z_nm + off_nm[i];
        TEST_ASSERT_EQUAL_HEX32(i < 3 ? 0u : CAM_FAULT_BIT(z_range), faults_within_a_plan());
    }
}

static const double turn_q32 = 4294967296.0;

/// 2500 r/min at 0.1 mm and 2000 mm/s2: the ramp is 0.0960 turns.
static void begin(void)
{
    part.is_ring_helix = true;
    fixture_play_init(&f, &part);
    TEST_ASSERT_TRUE(f.config.play.rings.is_on);
    engage();
}

/// @return [turn] since the path began
static double turns_of(int64_t pos_q32)
{
    return (double)(pos_q32 - f.plan.feed_at_q32) / turn_q32;
}

/// @return [nm] Z of the law in double
static double exact_nm(double turns)
{
    const double span_nm = (double)part.z_last_nm - part.z_first_nm;
    const double r = f.config.play.rings.ramp_q32 / turn_q32;
    const double length = 2.0 * ceil(span_nm / part.feed_nm) + 1.0;
    const double at = fmin(fmax(turns, 0.0), length);
    const double ring_nm = fmin(floor(at / 2.0) * part.feed_nm, span_nm);
    const double step_nm = fmin(part.feed_nm, span_nm - ring_nm);
    const double share = fmod(floor(at), 2.0) == 0.0 ? 0.0 : at - floor(at);
    const double near = fmin(share, 1.0 - share);
    const double fed = (near < r ? near * near / (2.0 * r) : near - r / 2.0) / (1.0 - r);
    return part.z_first_nm + ring_nm + step_nm * (share <= 0.5 ? fed : 1.0 - fed);
}

/// Between two plans Z moves linearly: off by the acceleration times (8 ticks)^2 / 8 at most,
/// 2000 mm/s2 * (0.4 ms)^2 / 8 = 40 nm, and two roundings.
static void test_whole_path_in_ticks_is_within_a_plan_of_the_exact_one(void)
{
    begin();
    double worst_nm = 0.0;
    while (f.want.state != cam_state_ready) {
        fixture_play_tick(&f);
        const double z_nm = (double)f.axis[hal_axis_z].pos_q10 / 1024.0;
        worst_nm = fmax(worst_nm, fabs(z_nm - exact_nm(turns_of(f.angle.pos_q32))));
        TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
    }
    TEST_ASSERT_TRUE(worst_nm < 42.0);
    TEST_ASSERT_TRUE(worst_nm > 30.0); // the bound is nearly reached, so it hides no error
    TEST_ASSERT_EQUAL_INT64((int64_t)part.z_last_nm * 1024, f.axis[hal_axis_z].pos_q10);
}

/// @return [turn] length of the path after a stop at `turns`
static double stopped_at(double turns)
{
    begin();
    while (turns_of(f.angle.pos_q32) < turns) {
        fixture_play_tick(&f);
    }
    fixture_play_do(&f, cam_request_stop);
    return (double)(f.plan.disengage_at_q32 - f.plan.feed_at_q32) / turn_q32;
}

static void test_stop_goes_on_to_the_end_of_a_ring(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(1.0, stopped_at(0.3));   // in the first ring
    TEST_ASSERT_EQUAL_DOUBLE(3.0, stopped_at(1.3));   // in a turn of the helix: the ring behind it
    TEST_ASSERT_EQUAL_DOUBLE(3.0, stopped_at(2.3));   // in that ring
    TEST_ASSERT_EQUAL_DOUBLE(5.0, stopped_at(2.999)); // the turn behind it is planned already
    TEST_ASSERT_EQUAL_DOUBLE(21.0, stopped_at(20.5)); // in the last ring: as planned
    TEST_ASSERT_EQUAL_DOUBLE(3.0, stopped_at(1.3));
    while (f.want.state != cam_state_disengaging) {
        fixture_play_tick(&f);
    }
    TEST_ASSERT_EQUAL_INT64((int64_t)(part.z_first_nm + 100000) * 1024, f.axis[hal_axis_z].pos_q10);
    while (f.want.state != cam_state_ready) {
        fixture_play_tick(&f);
        TEST_ASSERT_EQUAL_INT64(0, f.axis[hal_axis_z].pos_q10 - f.before[hal_axis_z].pos_q10);
    }
}

/// A held feed rests where the next ring begins and goes on from there, without a step, to the same
/// end.
static void test_hold_rests_before_a_ring_and_goes_on_from_it(void)
{
    begin();
    const int32_t rate_q30 = f.config.play.feed_rate_q30;
    while (turns_of(f.angle.pos_q32) < 6.3) {
        fixture_play_tick(&f);
    }
    f.config.play.feed_rate_q30 = 0;
    for (int i = 0; i < 100000 && f.want.state != cam_state_holding; i++) {
        fixture_play_tick(&f);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_holding, f.want.state);
    fixture_play_ticks(&f, 100);
    const int64_t rest_q10 = f.axis[hal_axis_z].pos_q10;
    TEST_ASSERT_EQUAL_INT64((int64_t)(part.z_first_nm + 400000) * 1024, rest_q10);
    fixture_play_ticks(&f, 480 * 9 + 77);
    TEST_ASSERT_EQUAL_INT64(rest_q10, f.axis[hal_axis_z].pos_q10);
    f.config.play.feed_rate_q30 = rate_q30;
    double most_nm = 0.0;
    while (f.want.state != cam_state_ready) {
        fixture_play_tick(&f);
        const int64_t step_q10 = f.axis[hal_axis_z].pos_q10 - f.before[hal_axis_z].pos_q10;
        most_nm = fmax(most_nm, fabs((double)step_q10 / 1024.0));
        TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
    }
    TEST_ASSERT_TRUE(most_nm < 1.12 * part.feed_nm / 480.0); // the feed less its ramps
    TEST_ASSERT_EQUAL_INT64((int64_t)part.z_last_nm * 1024, f.axis[hal_axis_z].pos_q10);
}

/// The ramps of the path are made anew for another speed and feed.
static void test_ramps_fit_the_speed_in_force(void)
{
    part.is_ring_helix = true;
    fixture_play_init(&f, &part);
    const uint32_t at_2500 = f.config.play.rings.ramp_q32;
    f.params.spindle_mrpm = 1000000;
    fixture_play_configure(&f);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.0140854, f.config.play.rings.ramp_q32 / turn_q32);
    f.params.spindle_mrpm = 2500000;
    fixture_play_configure(&f);
    TEST_ASSERT_EQUAL_UINT32(at_2500, f.config.play.rings.ramp_q32);
    f.params.feed_nm = 250000;
    fixture_play_configure(&f);
    TEST_ASSERT_GREATER_THAN_UINT32(at_2500, f.config.play.rings.ramp_q32);
    TEST_ASSERT_EQUAL_INT32(250000, f.config.play.rings.feed_nm);
    TEST_ASSERT_EQUAL_INT64(9 * CAM_TURN_Q32, f.config.play.feed_q32);
}
