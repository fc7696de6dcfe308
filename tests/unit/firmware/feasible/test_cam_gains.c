// SPDX-License-Identifier: Apache-2.0
// Windows that follow from jerks, and gains that are refused, against MATHS.md (212), (213) in
// double.
#include "cam_feasible.h"
#include "hal_host.h"
#include "rig_bench.h"
#include <math.h>

static cam_params_t usual(void)
{
    cam_params_t p = cam_param_defaults();
    p.k1_ns = 742723; // 300 Hz, 0.7
    p.k2_us2 = 281448;
    return p;
}

static void test_derived_windows_are_those_of_the_manual(void)
{
    const cam_params_t p = usual();
    TEST_ASSERT_EQUAL_UINT32(4, cam_gains_log2_window(&p, hal_axis_u, 20000)); // 0.8 ms
    TEST_ASSERT_EQUAL_UINT32(4, cam_gains_log2_window(&p, hal_axis_x, 20000)); // 6.4 ms
    TEST_ASSERT_EQUAL_UINT32(1, cam_gains_log2_window(&p, hal_axis_u, 1000));  // 2 ticks
    TEST_ASSERT_EQUAL_UINT32(3, cam_gains_log2_window(&p, hal_axis_z, 1000));
    cam_params_t slow = p;
    slow.k1_ns = 1700000;
    TEST_ASSERT_EQUAL_UINT32(6, cam_gains_log2_window(&slow, hal_axis_u, 20000)); // 3.2 ms
}

static void test_window_of_a_jerk_keeps_it_and_half_of_it_does_not(void)
{
    static const int32_t jerks[] = {200000, 300000, 625000, 1000000, 5000000};
    for (int i = 0; i < 5; i++) {
        cam_params_t p = usual();
        p.k1_ns = p.k2_us2 = 0;
        p.u_jerk_m_per_s3 = jerks[i];
        const double window_s =
            ldexp(1.0 / 20000.0, (int)cam_gains_log2_window(&p, hal_axis_u, 20000));
        const double jerk = 2.0 * 250.0 / window_s;
        TEST_ASSERT_TRUE(jerk <= jerks[i] * (1.0 + 1e-9));
        TEST_ASSERT_TRUE(2.0 * jerk > jerks[i]);
    }
}

/// What is at the bound is built, what is one beyond it is refused, and the refusal names both.
static void test_bounds_are_the_last_that_are_accepted(void)
{
    static const cam_param_id_t gains[] = {cam_param_k1_ns, cam_param_k2_us2};
    static const uint32_t hz[] = {1000, 20000, 100000};
    for (int i = 0; i < 6; i++) {
        cam_params_t p = usual();
        p.k1_ns = p.k2_us2 = 0;
        p.u_jerk_m_per_s3 = 20000000; // a window that does not grow with the gains
        const int64_t bound = cam_gains_bound(&p, gains[i % 2], hz[i / 2]);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&p, gains[i % 2], (int32_t)bound));
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_gains_check(&p, hz[i / 2]).err);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&p, gains[i % 2], (int32_t)bound + 1));
        TEST_ASSERT_EQUAL_INT(cam_err_gain, cam_gains_check(&p, hz[i / 2]).err);
        TEST_ASSERT_EQUAL_INT(gains[i % 2], cam_gains_check(&p, hz[i / 2]).param);
    }
}

static void test_refused_gain_is_named_with_the_largest_that_would_do(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_gain, fixture_rig_set(&rig, cam_param_k2_us2, 30000000));
    const cam_refusal_t *refusal = &rig.machine.refusal;
    TEST_ASSERT_EQUAL_INT(cam_err_gain, refusal->err);
    TEST_ASSERT_EQUAL_INT(cam_param_k2_us2, refusal->param);
    TEST_ASSERT_EQUAL_INT64(30000000, refusal->needed);
    TEST_ASSERT_EQUAL_INT64(2560000, refusal->limit); // 0.4 m/s * 3.2 ms / (2 * 250 m/s2)
    TEST_ASSERT_EQUAL_INT32(0, rig.machine.params.k2_us2);
    set(cam_param_k2_us2, 2560000);
    set(cam_param_u_friction_nm, 10001); // of a drive that takes positions
    set(cam_param_u_friction_nm, 0);
    hal_host.slow.force.quantum_un = 20000;
    TEST_ASSERT_EQUAL_INT(cam_err_gain, fixture_rig_set(&rig, cam_param_u_friction_nm, 10001));
    TEST_ASSERT_EQUAL_INT(cam_param_u_friction_nm, refusal->param);
    TEST_ASSERT_EQUAL_INT64(10000, refusal->limit); // reversed in a tick, as fast as U: 0.4 m/s
    set(cam_param_u_friction_nm, 10000);
}

/// The least jerk of an axis is that of the longest window, 64 ticks of U or plans of X and Z:
/// twice its acceleration in that time, rounded up. A jerk of 0 is a derived one.
static void test_least_jerk_is_that_of_the_longest_window_of_its_axis(void)
{
    static const cam_param_id_t jerks[] = {cam_param_u_jerk_m_per_s3, cam_param_x_jerk_m_per_s3,
                                           cam_param_z_jerk_m_per_s3};
    static const uint32_t hz[] = {1000, 20000, 100000};
    for (int i = 0; i < 3; i++) {
        cam_params_t p = usual();
        p.k1_ns = p.k2_us2 = 0;
        p.x_acceleration_mm_per_s2 = 1700;
        p.z_acceleration_mm_per_s2 = 2300;
        const double accelerations[] = {p.u_acceleration_mm_per_s2, 1700.0, 2300.0};
        const double plan = fmax(round(400e-6 * hz[i]), 1.0);
        for (uint32_t axis = 0; axis < 3u; axis++) {
            const double window = 64.0 * (axis == 0u ? 1.0 : plan) / hz[i];
            const double least = ceil(2e-3 * accelerations[axis] / window - 1e-6);
            TEST_ASSERT_EQUAL_INT64((int64_t)least, cam_gains_bound(&p, jerks[axis], hz[i]));
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&p, jerks[axis], (int32_t)least));
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_gains_check(&p, hz[i]).err);
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&p, jerks[axis], (int32_t)least - 1));
            const bool is_zero = least < 2.0;
            const cam_refusal_t refusal = cam_gains_check(&p, hz[i]);
            TEST_ASSERT_EQUAL_INT(is_zero ? cam_ok : cam_err_jerk, refusal.err);
            TEST_ASSERT_EQUAL(!is_zero, refusal.param == jerks[axis]);
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&p, jerks[axis], 0));
        }
    }
}

/// What the bounds of the gains are made of: half of the window and three quarters of the way to
/// U's speed for k1, the speed over the jerk for k2.
static void test_bounds_of_the_gains_are_those_of_the_window(void)
{
    cam_params_t p = usual();
    p.k1_ns = p.k2_us2 = 0;
    p.u_jerk_m_per_s3 = 625000; // 2 * 250 m/s2 in 0.8 ms
    TEST_ASSERT_EQUAL_UINT32(4, cam_gains_log2_window(&p, hal_axis_u, 20000));
    TEST_ASSERT_EQUAL_INT64(400000 + 1200000, cam_gains_bound(&p, cam_param_k1_ns, 20000));
    TEST_ASSERT_EQUAL_INT64(640000, cam_gains_bound(&p, cam_param_k2_us2, 20000));
}
