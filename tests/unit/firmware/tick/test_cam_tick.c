// SPDX-License-Identifier: Apache-2.0
// A whole cut tick by tick: what is written.
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"
#include <math.h>
#include <stdlib.h>

enum { log_capacity = 60000 };

static fixture_rig_t rig;
static fixture_part_t part;
static cam_tick_record_t *records;

void setUp(void)
{
    records = calloc(log_capacity, sizeof *records);
    TEST_ASSERT_NOT_NULL(records);
    part = fixture_part_short();
    fixture_rig_init(&rig, &part, 20000);
    rig.log = records;
    rig.log_capacity = log_capacity;
}

void tearDown(void)
{
    free(records);
}

static void cut_whole(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_disengaging));
    TEST_ASSERT_LESS_THAN_UINT32(20000, fixture_rig_until(&rig, cam_state_ready, 20000));
    fixture_rig_ticks(&rig, 500);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    TEST_ASSERT_LESS_THAN_UINT32(log_capacity, rig.n_log);
}

/// In off U may stand anywhere, and is told the end of its stroke that is nearer.
static void test_tick_off_tells_u_beyond_its_stroke_the_nearer_end(void)
{
    static const int32_t places_nm[] = {600001, 33554431, 33554432, 40000000, INT32_MAX};
    for (uint32_t i = 0; i < sizeof places_nm / sizeof places_nm[0]; i++) {
        hal_host.in.axis_nm[hal_axis_u] = places_nm[i];
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT32(600000, hal_host.out.axis[hal_axis_u].pos_nm);
        hal_host.in.axis_nm[hal_axis_u] = -places_nm[i];
        fixture_rig_tick(&rig);
        TEST_ASSERT_EQUAL_INT32(-600000, hal_host.out.axis[hal_axis_u].pos_nm);
    }
}

static double step_nm(uint32_t i, hal_axis_t axis)
{
    return (double)records[i].out[axis].pos_nm - records[i - 1u].out[axis].pos_nm;
}

/// Through engage, cut, disengage and retract no set-point moves or accelerates beyond its limits.
static void test_tick_whole_cut_never_steps_a_setpoint(void)
{
    static const double speed[hal_n_axes] = {20000.0, 5000.0, 10000.0};
    static const double acceleration[hal_n_axes] = {625.0, 5.0, 5.0};
    cut_whole();
    for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
        double last_nm = 0.0;
        for (uint32_t i = 2; i < rig.n_log; i++) {
            if (records[i - 2u].want.state == cam_state_off) {
                continue;
            }
            const double nm = step_nm(i, (hal_axis_t)axis);
            TEST_ASSERT_TRUE(fabs(nm) <= speed[axis] + 2.0);
            TEST_ASSERT_TRUE(i == 2u || records[i - 3u].want.state == cam_state_off ||
                             fabs(nm - last_nm) <= acceleration[axis] + 6.0);
            last_nm = nm;
        }
    }
}

static void test_tick_cut_visits_every_height_at_full_amplitude(void)
{
    cut_whole();
    int32_t lowest_nm = INT32_MAX;
    int32_t highest_nm = INT32_MIN;
    uint32_t n_cutting = 0;
    for (uint32_t i = 0; i < rig.n_log; i++) {
        if (records[i].want.state == cam_state_cutting) {
            n_cutting++;
            lowest_nm = records[i].want.z_nm < lowest_nm ? records[i].want.z_nm : lowest_nm;
            highest_nm = records[i].want.z_nm > highest_nm ? records[i].want.z_nm : highest_nm;
        }
    }
    TEST_ASSERT_INT32_WITHIN(200, part.z_first_nm, lowest_nm);
    TEST_ASSERT_INT32_WITHIN(200, part.z_last_nm, highest_nm);
    TEST_ASSERT_UINT32_WITHIN(g_cam.config.offered->play.plan_ticks, 12 * 480,
                              n_cutting); // 10 turns of feed, 2 of ramps
}

static void test_tick_feed_forward_is_the_inverse_of_the_drive(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, cam_param_k1_ns, 742723));
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, cam_param_k2_us2, 281448));
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, cam_param_following_limit_nm, 10000000));
    cut_whole();
    for (uint32_t i = 0; i < rig.n_log; i++) {
        if (records[i].want.state == cam_state_cutting) {
            const hal_setpoint_t *u = &records[i].out[hal_axis_u];
            const double wanted = records[i].want.u_set_q6 / 64.0 +
                                  742723e-9 * 20000.0 * u->vel_q10 / 1024.0 +
                                  (281448e-12 * 4e8 - 1.0 / 48.0) * u->acc_q10 / 1024.0;
            TEST_ASSERT_DOUBLE_WITHIN(0.6, wanted, u->pos_nm);
        }
    }
}
