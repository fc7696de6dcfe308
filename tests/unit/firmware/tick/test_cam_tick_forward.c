// SPDX-License-Identifier: Apache-2.0
// Commands of U against the control law in doubles: u + k1 u' w + k2 u'' w^2, read at lead.
#include "fixture_reference.h"
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"
#include <math.h>
#include <stdlib.h>

enum { log_capacity = 60000, tick_hz = 20000 };
#define K1_S 742723e-9
#define K2_S2 281448e-12
#define LEAD_TICKS 2.5

static fixture_rig_t rig;
static fixture_part_t part;
static cam_tick_record_t *records;

void setUp(void)
{
    records = calloc(log_capacity, sizeof *records);
    TEST_ASSERT_NOT_NULL(records);
    part = fixture_part_short();
    fixture_rig_init(&rig, &part, tick_hz);
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, cam_param_k1_ns, 742723));
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, cam_param_k2_us2, 281448));
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, cam_param_lead_ns, 125000));
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, cam_param_following_limit_nm, 10000000));
    rig.log = records;
    rig.log_capacity = log_capacity;
}

void tearDown(void)
{
    free(records);
}

/// Value and derivatives by time [nm, nm/s, nm/s2] at the angle of a record, read ahead.
static void expected(const cam_tick_record_t *r, double u[3])
{
    const cam_channel_t *ch = &rig.machine.table.u;
    const double ahead = (double)r->angle.pos_q32 + LEAD_TICKS * r->angle.speed_q32;
    const uint32_t theta_q32 = (uint32_t)(uint64_t)(int64_t)floor(ahead);
    const fixture_value_t v = fixture_reference_surface_at(ch, theta_q32, r->want.z_nm);
    const double knots_per_s = ldexp(r->angle.speed_q32, (int)ch->log2_knots - 32) * tick_hz;
    const double nm = ldexp(1.0, -(int)ch->frac_bits);
    u[0] = (double)v.y * nm + ch->value_offset;
    u[1] = (double)v.d1 * nm * knots_per_s;
    u[2] = (double)v.d2 * nm * knots_per_s * knots_per_s;
}

static void test_command_in_the_cut_is_the_control_law(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    rig.n_log = 0;
    fixture_rig_ticks(&rig, 5000);
    TEST_ASSERT_EQUAL_UINT32(5000, rig.n_log);
    const double um_per_s = tick_hz / 1024e3;
    const double mm_per_s2 = (double)tick_hz * tick_hz / 1024e6;
    double largest_nm = 0.0;
    for (uint32_t i = 10; i < rig.n_log; i++) {
        double u[3];
        expected(&records[i], u);
        const hal_setpoint_t *out = &records[i].out[hal_axis_u];
        TEST_ASSERT_EQUAL_INT(cam_state_cutting, records[i].want.state);
        // U's height is linear between two plans, the expected one is not where the feed rises.
        TEST_ASSERT_DOUBLE_WITHIN(2.5, u[0], records[i].want.u_set_q6 / 64.0);
        TEST_ASSERT_DOUBLE_WITHIN(4.0, u[1] * 1e-3, out->vel_q10 * um_per_s);  // of 40 000 um/s
        TEST_ASSERT_DOUBLE_WITHIN(6.0, u[2] * 1e-6, out->acc_q10 * mm_per_s2); // of 20 000 mm/s2
        const double forward_nm = K1_S * u[1] + K2_S2 * u[2];
        TEST_ASSERT_DOUBLE_WITHIN(8.0, u[0] + forward_nm, out->pos_nm);
        largest_nm = fabs(forward_nm) > largest_nm ? fabs(forward_nm) : largest_nm;
    }
    TEST_ASSERT_TRUE(largest_nm > 20000.0); // the feed-forward is large enough to be judged
}
