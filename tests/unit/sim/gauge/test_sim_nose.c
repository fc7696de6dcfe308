// SPDX-License-Identifier: Apache-2.0
#include "sim_work.h"
#include "unity.h"
#include <math.h>   // NAN, hypot, sqrt
#include <stdlib.h> // calloc
#include <string.h> // memcpy, memset

static sim_design_t design;
static sim_nose_t nose;
static bool is_beside;

/// @return piecewise cubics over the height
static sim_cubics_t cubics(size_t n, const double *breaks_mm, const double *coefficients)
{
    sim_cubics_t p = {.n = n};
    p.break_mm = calloc(n + 1u, sizeof *p.break_mm);
    p.c = calloc(n, sizeof *p.c);
    memcpy(p.break_mm, breaks_mm, (n + 1u) * sizeof *breaks_mm);
    memcpy(p.c, coefficients, n * sizeof *p.c);
    return p;
}

/// Give a round part of 20 mm, of one cubic or of two, its half axis over the height.
static void profile(size_t n, const double *coefficients)
{
    static const double ends_mm[] = {0.0, 20.0};
    static const double halves_mm[] = {0.0, 10.0, 20.0};
    sim_design_free(&design);
    design = (sim_design_t){.shape = sim_shape_cosine, .at_z_mm = NAN, .z_last_mm = 20.0};
    design.ovality_mm = cubics(1, ends_mm, (double[4]){0.0});
    design.radius_mm = cubics(n, n == 1u ? ends_mm : halves_mm, coefficients);
}

void tearDown(void)
{
    sim_design_free(&design);
}

/// Let a nose touch at a height of the part.
static double tip_mm(double nose_mm, double z_mm)
{
    sim_nose_init(&nose, nose_mm, &design);
    return sim_nose_radius_mm(&nose, &design, 0.1, z_mm, &is_beside);
}

static void test_a_point_stands_on_the_surface(void)
{
    profile(1, (double[]){0.0, 0.0, -0.2, 40.0});
    TEST_ASSERT_EQUAL_DOUBLE(sim_design_radius_mm(&design, 0.1, 7.0), tip_mm(0.0, 7.0));
}

/// On a cone the tip stands r (1 / cos - 1) further out, whatever the sense of the slope.
static void test_on_a_cone_the_tip_stands_out_by_the_closed_form(void)
{
    static const double slope[] = {-1.0, -0.2, -0.0063, 0.0, 0.0063, 0.3};
    for (size_t i = 0; i < sizeof slope / sizeof slope[0]; i++) {
        profile(1, (double[]){0.0, 0.0, slope[i], 40.0});
        const double out_mm = 0.8 * (hypot(1.0, slope[i]) - 1.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 40.0 + 10.0 * slope[i] + out_mm, tip_mm(0.8, 10.0));
    }
}

/// Every contact of a parabola belongs to one place of the tip, in closed form.
static void test_on_a_parabola_the_contact_lies_where_the_slopes_are_equal(void)
{
    profile(1, (double[]){0.0, -0.02, 0.4, 40.0});
    for (int i = 0; i < 24; i++) {
        const double at_mm = 2.0 + 0.7 * i;
        const double s = 0.4 - 0.04 * at_mm;
        const double z_mm = at_mm - 1.5 * s / hypot(1.0, s);
        const double surface_mm = 40.0 + at_mm * (0.4 - 0.02 * at_mm);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, surface_mm - 1.5 * (1.0 - 1.0 / hypot(1.0, s)),
                                  tip_mm(1.5, z_mm));
    }
}

/// Over a kink that juts out the tip runs on a circle about the kink.
static void test_over_a_kink_the_tip_runs_on_a_circle(void)
{
    profile(2, (double[]){0.0, 0.0, 0.3, 37.0, 0.0, 0.0, -0.3, 40.0});
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 40.0, tip_mm(0.8, 10.0));
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 40.0 + sqrt(0.64 - 0.04) - 0.8, tip_mm(0.8, 10.2));
}

/// Beyond the end there is no surface: at an end that rises the nose comes from beside it.
static void test_an_end_that_rises_is_touched_from_beside(void)
{
    profile(1, (double[]){0.0, 0.0, 0.5, 40.0});
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 50.0, tip_mm(0.8, 20.0));
    TEST_ASSERT_TRUE(is_beside);
    (void)tip_mm(0.8, 19.6); // the contact is 0.8 sin 26.6 degrees = 0.36 mm above
    TEST_ASSERT_FALSE(is_beside);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 40.0 + 0.8 * (hypot(1.0, 0.5) - 1.0), tip_mm(0.8, 0.0));
    TEST_ASSERT_FALSE(is_beside);
    design.shape = sim_shape_table; // without report: the table holds the path of the tip
    sim_nose_init(&nose, 0.8, &design);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, nose.nose_mm);
}
