// SPDX-License-Identifier: Apache-2.0
#include "sim_units.h" // SIM_PI
#include "sim_work.h"
#include "unity.h"
#include <math.h>   // sin
#include <string.h> // memset

static sim_work_t work;

void setUp(void)
{
    sim_work_init(&work, 46.1, 0.0, 62.0, true);
}

static void touch_at(double turn, double z_mm, double radius_mm, double exact_mm, bool is_counted)
{
    sim_work_remove(&work, z_mm, radius_mm, is_counted);
    sim_work_judge(&work, turn, z_mm, radius_mm, exact_mm, is_counted);
}

static void touch(double turn, double z_mm, double radius_mm)
{
    touch_at(turn, z_mm, radius_mm, 46.0, true);
}

static void test_touch_counts_largest_and_rms_error(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, sim_work_rms_um(&work));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, sim_work_roundness_um(&work));
    touch(0.1, 10.0, 46.003);
    touch(0.2, 20.0, 45.996);
    touch(0.3, 30.0, 46.001);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 4.0, work.max_um);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.2, work.max_turn);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 20.0, work.max_z_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, sqrt((9.0 + 16.0 + 1.0) / 3.0), sim_work_rms_um(&work));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.097, work.depth_min_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.104, work.depth_max_mm);
}

static void test_touch_outside_the_cut_counts_only_as_gouge(void)
{
    touch_at(0.1, 10.0, 45.9, 46.0, false);
    touch_at(0.1, 70.0, 40.0, 46.0, false); // beside the part
    TEST_ASSERT_EQUAL_UINT64(0u, work.n);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, work.max_um);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 100.0, work.gouge_um);
}

static void test_cell_keeps_the_worst_sample(void)
{
    touch(0.50001, 31.0, 46.001);
    touch(0.50002, 31.0, 45.998);
    touch(0.50003, 31.0, 46.0005);
    const sim_cell_t *cell = &work.cell[128][360];
    TEST_ASSERT_EQUAL_UINT32(3u, cell->n);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -2000.0, (double)cell->error_nm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.50002, (double)cell->turn);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 45.998, cell->radius_mm);
}

static void test_without_a_map_the_figures_stay_and_no_cell_is_touched(void)
{
    static const sim_cell_t untouched;
    touch(0.1, 10.0, 46.003);
    const double rms_um = sim_work_rms_um(&work);
    memset(&work, 0, sizeof work);
    sim_work_init(&work, 46.1, 0.0, 62.0, false);
    touch(0.1, 10.0, 46.003);
    TEST_ASSERT_EQUAL_DOUBLE(rms_um, sim_work_rms_um(&work));
    TEST_ASSERT_EQUAL_UINT64(1u, work.row[41].n);
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &work.cell[41][72], sizeof untouched);
}

static void test_places_beyond_the_map_fall_into_its_edge(void)
{
    touch(0.0, -1.0, 46.0);
    touch(1.0, 1000.0, 46.0);
    TEST_ASSERT_EQUAL_UINT32(1u, work.cell[0][0].n);
    TEST_ASSERT_EQUAL_UINT32(1u, work.cell[sim_work_rows - 1][sim_work_columns - 1].n);
}

static void test_roundness_is_the_span_of_errors_of_a_row(void)
{
    for (int i = 0; i < 360; i++) { // 1 um of error three times per turn on an offset of 5 um
        const double error_mm = 5e-3 + 1e-3 * sin(SIM_TWO_PI * 3.0 * i / 360.0);
        touch(i / 360.0, 31.1, 46.0 + error_mm);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, sim_work_roundness_um(&work));
}

/// A ring of 0.1 mm depth and 2 mm height.
static void test_volume_of_a_ring(void)
{
    for (int i = 0; i <= 1000; i++) {
        touch(i % 100 / 100.0, 10.0 + i * 0.002, 46.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, SIM_PI * (46.1 * 46.1 - 46.0 * 46.0) * 2.0, work.removed_mm3);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.1, work.depth_min_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.1, work.depth_max_mm);
}

/// An oval turned by 200 urad with an offset and an error of its own three times per turn.
static void test_turned_part_is_distinguished_from_its_form(void)
{
    const double turned_rad = 200e-6;
    for (int i = 0; i < 7200; i++) {
        const double at = SIM_TWO_PI * i / 3600.0;
        const double exact_mm = 46.0 + 0.5 * cos(2.0 * at);
        const double own_mm = 2e-3 + 1e-3 * sin(3.0 * at);
        const double radius_mm = 46.0 + 0.5 * cos(2.0 * (at + turned_rad)) + own_mm;
        touch_at(i % 3600 / 3600.0, 31.0, radius_mm, exact_mm, true);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, turned_rad, sim_work_turned_rad(&work));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, sqrt(4.0 + 0.5), sim_work_shape_rms_um(&work));
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 3.0, sim_work_shape_max_um(&work));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, sqrt(4.0 + 0.5 + 0.02), sim_work_rms_um(&work));
}

static void test_round_part_is_not_turned(void)
{
    touch(0.1, 31.0, 46.001);
    touch(0.1001, 31.0, 46.001);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, sim_work_turned_rad(&work));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.0, sim_work_shape_rms_um(&work));
}
