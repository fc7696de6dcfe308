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
        .angle = {.pos_q32 = INT64_C(1008) << 32, .speed_q32 = 1009, .is_synced = true},
        .want = {.state = cam_state_cutting,
                 .z_nm = 1010,
                 .u_set_q6 = 1011,
                 .u_due_q6 = 700 * 64 + 63,
                 .faults = 1012,
                 .outputs = 1013},
    };
    core.spindle.n_late = 1014;
    core.guard.first_faults = 1015;
    core.jog.found_nm[hal_axis_z] = 1016;
    core.spindle.max_period = 1017;
    core.acknowledge.n_plans = 1018;
    atomic_store(&core.trace.newest, &record);
    atomic_store(&core.trace.n_begun, 42);
    atomic_store(&core.trace.n_written, 42);
}

static void test_words_of_the_record_and_of_the_stages_are_reported(void)
{
    const cam_status_t s = cam_status_read(&core);
    const int64_t words[] = {s.tick,        s.config,
                             s.u_actual_nm, s.x_actual_nm,
                             s.z_actual_nm, s.inputs,
                             s.request,     s.pos_q32 >> 32,
                             s.speed_q32,   s.z_nm,
                             s.u_set_q6,    s.faults,
                             s.outputs,     s.n_late,
                             s.first_fault, s.jog.found_nm[hal_axis_z],
                             s.max_period,  s.acknowledge.n_plans};
    for (uint32_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        TEST_ASSERT_EQUAL_INT64(1001 + i, words[i]);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, s.state);
    TEST_ASSERT_EQUAL_INT32(1003 - 700, s.following_nm);
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
