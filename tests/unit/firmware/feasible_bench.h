// SPDX-License-Identifier: Apache-2.0
/// feasible_bench: a table by its numbers alone, parameters that allow everything, and the
/// judgement of both. Each program that includes it has one of each.
#ifndef FEASIBLE_BENCH_H
#define FEASIBLE_BENCH_H

#include "cam_feasible.h" // cam_feasible
#include "unity.h"        // TEST_ASSERT_*

static cam_table_t table;
static cam_params_t params;
static const double pi = 3.14159265358979323846;

/// Called by Unity before each test: a skirt of 0.3 mm ovality, u' 150 000 nm/rad, u'' 300 000
/// nm/rad2, on a machine without limits.
void setUp(void)
{
    params = cam_param_defaults();
    table = (cam_table_t){
        .u = {.log2_knots = 3, .log2_repeat = 1, .n_slices = 32, .span_nm = 62000000},
        .z_last_nm = 62000000,
        .direction = 1,
        .spindle_mrpm = 2500000,
        .feed_nm = 100000,
        .limit_u_stroke_nm = 2000000,
        .limit_u_speed_um_per_s = 10000000,
        .limit_u_acceleration_mm_per_s2 = 10000000,
        .limit_spindle_mrpm = 60000000,
        .u_max_nm = 150000,
        .ratio_max_q20 = CAM_TABLE_RATIO_ONE,
        .u1_peak_nm_per_rad = 150000,
        .u2_peak_nm_per_rad2 = 300000,
    };
    params.spindle_limit_mrpm = 60000000;
    params.z_speed_um_per_s = 10000000;
    params.z_acceleration_mm_per_s2 = 1000000;
    params.feed_ramp_turns = 100;
    params.u_speed_um_per_s = 10000000;
    params.u_acceleration_mm_per_s2 = 10000000;
}

/// Called by Unity after each test.
void tearDown(void) {}

static inline cam_feasibility_t judge(uint32_t mrpm)
{
    return cam_feasible(&table, &params, mrpm, 20000);
}

/// A speed is refused with these numbers, and the reported highest speed is right to 0.3 %.
static inline void expect_refused(cam_err_t err, uint32_t mrpm, double needed, double limit,
                                  double highest_mrpm)
{
    const cam_feasibility_t why = judge(mrpm);
    TEST_ASSERT_EQUAL_INT(err, why.err);
    TEST_ASSERT_EQUAL_UINT32(mrpm, why.speed_mrpm);
    TEST_ASSERT_DOUBLE_WITHIN(0.002 * needed + 1.0, needed, (double)why.needed);
    TEST_ASSERT_DOUBLE_WITHIN(0.6, limit, (double)why.limit);
    TEST_ASSERT_DOUBLE_WITHIN(0.003 * highest_mrpm, highest_mrpm, why.highest_mrpm);
    if (highest_mrpm > 0.0) {
        TEST_ASSERT_EQUAL_INT(cam_ok, judge(why.highest_mrpm).err);
        TEST_ASSERT_EQUAL_INT(err, judge((uint32_t)(highest_mrpm * 1.003)).err);
    }
}

static inline double omega(double mrpm)
{
    return mrpm * 2.0 * pi / 60000.0;
}

#endif
