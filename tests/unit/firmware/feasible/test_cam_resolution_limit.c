// SPDX-License-Identifier: Apache-2.0
// The form error that the steps of the outputs leave.
#include "cam_derived_limits.h"
#include "hal_host.h"
#include "unity.h"
#include <stddef.h> // NULL

static cam_table_t table;

void setUp(void)
{
    hal_host_reset(20000);
    table = (cam_table_t){.x_slope_ppm = 20000, // 0.02, and U adds 10 um in 5 mm of height
                          .u_change.most = 1000,
                          .u = {.n_slices = 11, .span_nm = 5000000}};
}

static void set_steps(uint32_t u_pm, uint32_t x_pm, uint32_t z_pm)
{
    hal_host.slow.scale[hal_axis_u].command_pm = u_pm;
    hal_host.slow.scale[hal_axis_x].command_pm = x_pm;
    hal_host.slow.scale[hal_axis_z].command_pm = z_pm;
}

static void test_form_of_a_skirt_is_half_of_each_step_and_of_z_by_the_slope(void)
{
    set_steps(30517, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(15258, cam_derived_limits_form_pm(&table));
    set_steps(30517, 6103515, 0);
    TEST_ASSERT_EQUAL_UINT32(3067016, cam_derived_limits_form_pm(&table));
    set_steps(0, 0, 15258789);
    TEST_ASSERT_EQUAL_UINT32(167846, cam_derived_limits_form_pm(&table)); // 0.022
}

static void test_form_without_a_table_or_of_a_lobe_takes_no_z(void)
{
    set_steps(1000, 2000, 500000000);
    TEST_ASSERT_EQUAL_UINT32(1500, cam_derived_limits_form_pm(NULL));
    static const cam_lobe_t lobe;
    table.lobes = &lobe;
    TEST_ASSERT_EQUAL_UINT32(1500, cam_derived_limits_form_pm(&table));
}

static void test_form_without_a_word_of_the_port_is_nothing(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, cam_derived_limits_form_pm(&table));
}

/// u = 0.075 mm (1 - cos 2 a) has the slope 150 um; a count of 10 000 is 0.628 mrad.
static void test_count_is_the_way_of_u_in_it(void)
{
    table.u1_peak_nm_per_rad = 150000;
    TEST_ASSERT_EQUAL_UINT32(94247, cam_derived_limits_count_pm(&table, 10000));
    TEST_ASSERT_EQUAL_UINT32(14726214, cam_derived_limits_count_pm(&table, 64));
    table.u1_peak_nm_per_rad = UINT32_MAX;
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, cam_derived_limits_count_pm(&table, 64));
    TEST_ASSERT_EQUAL_UINT32(1608495, cam_derived_limits_count_pm(&table, 16777216));
}

static void test_form_of_extremes_is_saturated(void)
{
    set_steps(UINT32_MAX, UINT32_MAX, UINT32_MAX);
    table.x_slope_ppm = UINT32_MAX;
    table.u_change.most = UINT32_MAX;
    table.u.n_slices = cam_table_max_slices;
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, cam_derived_limits_form_pm(&table));
}
