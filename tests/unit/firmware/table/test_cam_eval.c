// SPDX-License-Identifier: Apache-2.0
// The evaluation against exact arithmetic on the same knots.
#include "cam_eval.h"
#include "fixture_random.h"
#include "fixture_reference.h"
#include "image_bench.h"
#include <math.h>

static fixture_random_t dice = {.state = 99};

static void expect_near(const cam_value_t *got, const fixture_value_t *exact)
{
    TEST_ASSERT_TRUE(fabsl(got->y - exact->y) <= 1.0L);
    TEST_ASSERT_TRUE(fabsl(got->d1 - exact->d1) <= 2.0L);
    TEST_ASSERT_TRUE(fabsl(got->d2 - exact->d2) <= 8.0L);
}

static cam_value_t u_at(uint32_t theta_q32, int32_t z_nm)
{
    return cam_eval_surface_at(&table.u, theta_q32, cam_eval_height(&table.u, z_nm));
}

static void expect_surface_at(uint32_t theta_q32, int32_t z_nm)
{
    const cam_value_t got = u_at(theta_q32, z_nm);
    const fixture_value_t exact = fixture_reference_surface_at(&table.u, theta_q32, z_nm);
    expect_near(&got, &exact);
}

/// Expect the reference at a random place.
static void expect_surface(void)
{
    const uint32_t theta_q32 = fixture_random_u32(&dice);
    expect_surface_at(theta_q32, (int32_t)fixture_random_range(&dice, -5, 1000005));
}

static void test_surface_every_pattern_and_size_is_within_the_error(void)
{
    for (uint32_t repeat = 0; repeat <= 1u; repeat++) {
        for (uint32_t knots = 4; knots <= 8u; knots++) {
            part.log2_repeat = repeat;
            part.log2_knots = knots;
            make();
            for (int i = 0; i < 5000 / fixture_rarer; i++) {
                expect_surface();
            }
        }
    }
}

/// On each slice and each third between two of them: the quintics continue in one another.
static void test_surface_on_both_sides_of_every_knot_is_within_the_error(void)
{
    make();
    for (uint32_t knot = 0; knot < 32u; knot++) {
        for (int32_t i = 0; i <= 30; i++) {
            const int32_t z_nm = i * 100000 / 3;
            expect_surface_at(knot << 27, z_nm);
            expect_surface_at((knot << 27) - 1u, z_nm);
        }
    }
}

static void test_height_outside_is_clamped(void)
{
    make();
    static const int32_t cases[][2] = {{-1, 0},
                                       {-1000, 0},
                                       {INT32_MIN, 0},
                                       {1000001, 1000000},
                                       {2000000, 1000000},
                                       {INT32_MAX, 1000000}};
    for (int i = 0; i < 6; i++) {
        TEST_ASSERT_EQUAL_INT32(u_at(0x20000000u, cases[i][1]).y, u_at(0x20000000u, cases[i][0]).y);
        TEST_ASSERT_EQUAL_INT32(cam_eval_profile(&table.x, cases[i][1]).y,
                                cam_eval_profile(&table.x, cases[i][0]).y);
    }
}

static void test_height_weight_is_exact_for_every_nanometre_spacing(void)
{
    make();
    for (int i = 0; i < 30000 / fixture_rarer; i++) {
        const int32_t z_nm = (int32_t)fixture_random_range(&dice, 0, 1000000);
        const cam_height_t h = cam_eval_height(&table.u, z_nm);
        const double slice = z_nm / 100000.0;
        TEST_ASSERT_DOUBLE_WITHIN(2e-8, slice, h.i + h.w_q31 / 2147483648.0);
        TEST_ASSERT_LESS_THAN_UINT32(part.n_slices - 1u, h.i);
    }
}

static void test_profile_random_heights_are_within_the_documented_error(void)
{
    make();
    for (int i = 0; i < 50000 / fixture_rarer; i++) {
        const int32_t z_nm = (int32_t)fixture_random_range(&dice, 0, 999999);
        const cam_value_t got = cam_eval_profile(&table.x, z_nm);
        const uint32_t interval = (uint32_t)z_nm / 250000u;
        const long double t = (z_nm - 250000.0L * interval) / 250000.0L;
        const fixture_value_t exact = fixture_reference_profile(&table.x, interval, t);
        expect_near(&got, &exact);
    }
}

/// Knots that alternate at random between the extremes of a scale; of scale 0 neighbouring slices
/// are constants that differ by the full scale.
static cam_err_t with_wild_knots(int32_t scale)
{
    fixture_image_make(&image, &part);
    cam_knot_t *knots = fixture_image_knots(&image, fixture_u);
    for (uint32_t i = 0; i < fixture_image_n_knots(&image, fixture_u); i++) {
        const int32_t sign = (fixture_random_u32(&dice) & 1u) != 0u ? 1 : -1;
        knots[i] = (cam_knot_t){sign * scale, -sign * scale / 3, sign * scale / 5};
        if (scale == 0) {
            knots[i].p = i / 32u % 2u != 0u ? CAM_TABLE_SUM_MAX : -CAM_TABLE_SUM_MAX;
        }
    }
    fixture_image_remeasure(&image, fixture_u);
    fixture_image_put(&image, fixture_at_u1_peak, INT32_MAX);
    fixture_image_put(&image, fixture_at_u2_peak, INT32_MAX);
    return check();
}

static void test_surface_wildest_accepted_tables_do_not_overflow(void)
{
    int32_t scale = 400000; // the largest accepted one is within 2 % of the bound
    while (with_wild_knots(scale) != cam_ok) {
        scale -= scale / 50;
    }
    TEST_ASSERT_GREATER_THAN_INT32(30000, scale);
    TEST_ASSERT_EQUAL_INT(cam_err_image_knots, with_wild_knots(scale + scale / 10));
    for (int is_constant = 0; is_constant < 2; is_constant++) {
        const int32_t wild = is_constant != 0 ? 0 : scale - scale / 50;
        TEST_ASSERT_EQUAL_INT(cam_ok, with_wild_knots(wild));
        for (int i = 0; i < 50000 / fixture_rarer; i++) {
            expect_surface();
        }
    }
}
