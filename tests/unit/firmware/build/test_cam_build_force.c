// SPDX-License-Identifier: Apache-2.0
// The configuration of a U that takes forces, number by number.
#include "cam_build.h"
#include "hal_host.h"
#include "unity.h"
#include <math.h>
#include <stddef.h> // NULL

enum { hz = 20000, clock_hz = 200000000 };

static cam_params_t params;
static cam_config_t config;

void setUp(void)
{
    hal_host_reset(hz);
    hal_host.slow.force.quantum_un = 20000;
    params = cam_param_defaults();
}

static void build(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_build_config(&config, &params, NULL, 3000000, hz, clock_hz).err);
}

static void expect_near(double wanted, double got)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(wanted) + 1.0, wanted, got);
}

/// 1.5 kg, 200 N and an observer of 300 Hz; the force of a tick acts four ticks later, for which
/// the reading may stand three ticks longer. Friction counts 2.2 times, at least
/// 5 m/s2, and 12 m/s2 where none is stated. A push outwards takes 5 ms at most.
static void test_force(void)
{
    params.servo_crossover_hz = 400;
    params.servo_friction_mn = 1000;
    params.servo_force_delay_ns = 130000;
    params.u_scale_latency_ns = 70000;
    params.servo_limited_ms = 30;
    build();
    const cam_force_config_t *c = &config.force;
    const double wt = 2.0 * acos(-1.0) * 300.0 / hz;
    const double motion = 1e9 / 1500.0 / hz / hz; // [nm / mN]
    TEST_ASSERT_TRUE(c->is_used);
    expect_near(ldexp(motion, 24), c->motion_q24);
    expect_near(ldexp(2.0 * wt, 18), c->pos_q18);
    expect_near(ldexp(wt * wt, 24), c->vel_q24);
    TEST_ASSERT_EQUAL_UINT32(3 + 4, c->still_ticks);
    TEST_ASSERT_EQUAL_INT32(10 * 1024, c->quantum_q10);
    TEST_ASSERT_EQUAL_INT32(140, c->unseen_nm);
    TEST_ASSERT_EQUAL_UINT32(600, c->limited_ticks);
    TEST_ASSERT_EQUAL_UINT32(100, c->blind_ticks);
    expect_near(100e6 / hz * 1024.0, c->push_speed_q10);
    expect_near(500e6 / hz * 1024.0, c->most_excess_q10);
    TEST_ASSERT_EQUAL_INT32(1000, c->braking_nm);
    TEST_ASSERT_EQUAL_INT32(params.u_stroke_nm / 2 + config.guard.approach_nm, c->travel_nm);
    TEST_ASSERT_EQUAL_INT32(50000 * 64, c->runaway_q6);
    expect_near(5.0e9 / hz / hz * 1024.0, c->held_q10);
    params.servo_friction_mn = 6000;
    params.u_scale_nm = 10000;
    params.servo_runaway_nm = 777;
    build();
    TEST_ASSERT_EQUAL_INT32(777 * 64, c->runaway_q6);
    expect_near(2.2 * 4.0e9 / hz / hz * 1024.0, c->held_q10);
    TEST_ASSERT_EQUAL_INT32(40100, c->unseen_nm);
    params.servo_friction_mn = 0;
    build();
    expect_near(12.0e9 / hz / hz * 1024.0, c->held_q10);
}
