// SPDX-License-Identifier: Apache-2.0
// The status of the newest tick for the slow side: each field comes from its own source.
#include "cam_tick.h"
#include "unity.h"
#include <string.h>

static cam_t core;
static cam_tick_record_t record;

/// A controller whose newest tick has a different number in each source of the status.
void setUp(void)
{
    memset(&core, 0, sizeof core);
    record = (cam_tick_record_t){
        .tick = 1001,
        .config = 1002,
        .in = {.actual_nm = {[hal_axis_u] = 1003, [hal_axis_x] = 1004, [hal_axis_z] = 1005},
               .inputs = 1006,
               .request = 1007u << 8 | 8u},
        .angle = {.pos_q32 = INT64_C(1009) << 32, .speed_q32 = 1010, .is_synced = true},
        .want = {.state = cam_state_cutting,
                 .z_nm = 1011,
                 .u_set_q6 = 1012,
                 .u_due_q6 = 700 * 64 + 63,
                 .faults = 1013,
                 .outputs = 1014},
    };
    core.guard.first_faults = 1015;
    core.jog.found_nm[hal_axis_z] = 1016;
    core.acknowledge.n_plans = 1017;
    core.spindle.n_late = 1018;
    core.spindle.max_period = 1019;
    atomic_store(&core.trace.newest, &record);
    atomic_store(&core.trace.n_begun, 42);
    atomic_store(&core.trace.n_written, 42);
}

static void test_words_of_the_record_and_of_the_stages_are_reported(void)
{
    const cam_status_t s = cam_status_read(&core);
    TEST_ASSERT_EQUAL_UINT32(1001, s.tick);
    TEST_ASSERT_EQUAL_UINT32(1002, s.config);
    TEST_ASSERT_EQUAL_INT32(1003, s.u_actual_nm);
    TEST_ASSERT_EQUAL_INT32(1004, s.x_actual_nm);
    TEST_ASSERT_EQUAL_INT32(1005, s.z_actual_nm);
    TEST_ASSERT_EQUAL_UINT32(1006, s.inputs);
    TEST_ASSERT_EQUAL_UINT32(1007, s.request);
    TEST_ASSERT_EQUAL_INT64(INT64_C(1009) << 32, s.pos_q32);
    TEST_ASSERT_EQUAL_INT32(1010, s.speed_q32);
    TEST_ASSERT_EQUAL_INT32(1011, s.z_nm);
    TEST_ASSERT_EQUAL_INT32(1012, s.u_set_q6);
    TEST_ASSERT_EQUAL_UINT32(1013, s.faults);
    TEST_ASSERT_EQUAL_UINT32(1014, s.outputs);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, s.state);
    TEST_ASSERT_EQUAL_INT32(1003 - 700, s.following_nm);
    TEST_ASSERT_EQUAL_UINT32(1015, s.first_fault);
    TEST_ASSERT_EQUAL_MEMORY(&core.jog, &s.jog, sizeof s.jog);
    TEST_ASSERT_EQUAL_MEMORY(&core.acknowledge, &s.acknowledge, sizeof s.acknowledge);
    TEST_ASSERT_EQUAL_UINT32(1018, s.n_late);
    TEST_ASSERT_EQUAL_UINT32(1019, s.max_period);
}

static void test_each_condition_is_reported_by_itself(void)
{
    cam_status_t s = cam_status_read(&core);
    TEST_ASSERT_TRUE(s.is_synced && s.is_u_at_rest && !s.is_retracted);
    record.angle.is_synced = false;
    record.want.is_retracted = true;
    record.out[hal_axis_u].vel_q10 = 1;
    s = cam_status_read(&core);
    TEST_ASSERT_TRUE(!s.is_synced && !s.is_u_at_rest && s.is_retracted);
    record.out[hal_axis_u] = (hal_setpoint_t){.acc_q10 = -1};
    TEST_ASSERT_FALSE(cam_status_read(&core).is_u_at_rest);
    record.out[hal_axis_u] = (hal_setpoint_t){.pos_nm = 5};
    TEST_ASSERT_TRUE(cam_status_read(&core).is_u_at_rest);
}

static void test_moment_holds_what_the_stages_left(void)
{
    core.motion.u.home_nm = 2001;
    core.plan.ratio_q28 = 2002;
    cam_moment_t now;
    cam_status_moment(&core, &now);
    TEST_ASSERT_EQUAL_MEMORY(&record, &now.record, sizeof record);
    TEST_ASSERT_EQUAL_MEMORY(&core.spindle, &now.spindle, sizeof now.spindle);
    TEST_ASSERT_EQUAL_MEMORY(&core.motion, &now.motion, sizeof now.motion);
    TEST_ASSERT_EQUAL_UINT32(core.guard.first_faults, now.first_faults);
    TEST_ASSERT_EQUAL_MEMORY(&core.plan, &now.plan, sizeof now.plan);
}

static void test_before_the_first_tick_the_state_is_off_and_nothing_else_is_known(void)
{
    memset(&core, 0, sizeof core);
    cam_moment_t now;
    memset(&now, 0x55, sizeof now);
    cam_status_moment(&core, &now);
    TEST_ASSERT_EQUAL_INT(cam_state_off, now.record.want.state);
    TEST_ASSERT_EQUAL_UINT32(0, now.record.tick);
    TEST_ASSERT_EQUAL_UINT32(0, cam_status_read(&core).n_late);
}
