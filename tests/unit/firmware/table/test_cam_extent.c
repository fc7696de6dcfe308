// SPDX-License-Identifier: Apache-2.0
// The range of values of a channel, against a dense evaluation in long double, and what the check
// of a table makes of it. The evaluation of the firmware is within an LSB of that
// (test_cam_eval.c).
#include "cam_table_inner.h"
#include "fixture_random.h"
#include "fixture_reference.h"
#include "fixture_shaft.h"
#include "image_bench.h"
#include <math.h>

enum { n_places = 256 };

/// A dense range, in the unit of a channel.
typedef struct {
    long double low, high;
} dense_t;

static dense_t dense_of(const cam_channel_t *ch, bool is_around)
{
    dense_t all = {1e30L, -1e30L};
    const uint32_t n = 1u << ch->log2_knots;
    for (uint32_t i = 0; i < ch->n_slices * n; i++) {
        const uint32_t next = is_around ? i - i % n + (i + 1u) % n : i + 1u;
        for (int k = 0; k <= n_places && next < ch->n_slices * n; k++) {
            const cam_knot_t ends[2] = {ch->knots[i], ch->knots[next]};
            const cam_channel_t segment = {.knots = ends};
            const long double t = (long double)k / n_places;
            const long double y = fixture_reference_profile(&segment, 0, t).y;
            all.low = fminl(all.low, y);
            all.high = fmaxl(all.high, y);
        }
    }
    all.low = ch->value_offset + ldexpl(all.low, -(int)ch->frac_bits);
    all.high = ch->value_offset + ldexpl(all.high, -(int)ch->frac_bits);
    return all;
}

/// A range holds a dense one and an LSB more, and is wider by at most `slack` and the rounding.
static void expect_around(const cam_channel_t *ch, cam_extent_t found, dense_t dense,
                          long double slack)
{
    const long double lsb = ldexpl(1.0L, -(int)ch->frac_bits);
    TEST_ASSERT_TRUE((long double)found.low <= dense.low - lsb);
    TEST_ASSERT_TRUE((long double)found.high >= dense.high + lsb);
    TEST_ASSERT_TRUE((long double)found.low >= dense.low - lsb - 1.001L - slack);
    TEST_ASSERT_TRUE((long double)found.high <= dense.high + lsb + 1.001L + slack);
}

static cam_extent_t extent_of(const cam_channel_t *ch, bool is_around)
{
    int32_t low = ch->knots[0].p;
    int32_t high = low;
    for (uint32_t i = 0; i < ch->n_slices << ch->log2_knots; i++) {
        low = ch->knots[i].p < low ? ch->knots[i].p : low;
        high = ch->knots[i].p > high ? ch->knots[i].p : high;
    }
    return cam_extent_widened(ch, is_around, cam_extent_of_knots(ch, low, high));
}

/// Knots at random, of all sizes and over angle or height, of all fractions.
static void test_range_is_that_of_a_dense_evaluation(void)
{
    fixture_random_t random = {2718281828u};
    for (int i = 0; i < 400; i++) {
        cam_knot_t knots[8];
        const int64_t size = INT64_C(1) << (i % 19);
        const cam_channel_t ch = {.knots = knots,
                                  .n_slices = 2u,
                                  .log2_knots = i % 2 == 0 ? 2u : 0u,
                                  .frac_bits = (uint32_t)i % 9u,
                                  .value_offset = -46000000 * (i % 3)};
        for (int k = 0; k < 8; k++) {
            knots[k] = (cam_knot_t){.p = (int32_t)fixture_random_range(&random, -size, size),
                                    .v = (int32_t)fixture_random_range(&random, -size, size),
                                    .a = (int32_t)fixture_random_range(&random, -size, size)};
        }
        const dense_t dense = dense_of(&ch, i % 2 == 0);
        const long double slack = 0.03L * ldexpl((long double)size, -(int)ch.frac_bits);
        expect_around(&ch, extent_of(&ch, i % 2 == 0), dense, slack);
    }
}

/// What holds a channel already is given back as it is, and a narrower range is widened.
static void test_promise_is_kept_or_widened(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    const cam_extent_t promised = {table.u_min_nm, table.u_max_nm};
    cam_extent_t found = cam_extent_widened(&table.u, true, promised);
    TEST_ASSERT_TRUE(found.low == promised.low && found.high == promised.high);
    const cam_extent_t narrow = {promised.low + 1, promised.high - 1};
    found = cam_extent_widened(&table.u, true, narrow);
    TEST_ASSERT_TRUE(found.low == promised.low && found.high == promised.high);
    expect_around(&table.u, promised, dense_of(&table.u, true), 1.0L);
}

/// Waves whose slopes, not values, stand at the knots: they rise and fall by 5/16 of the slope.
static void put_waves(uint32_t channel, int32_t p, int32_t v)
{
    cam_knot_t *k = fixture_image_knots(&image, channel);
    for (uint32_t i = 0; i < fixture_image_n_knots(&image, channel); i++) {
        k[i] = (cam_knot_t){.p = p, .v = i % 2u == 0u ? v : -v};
    }
    fixture_image_remeasure(&image, channel);
}

/// Promise the most of the peaks.
static void promise_all(void)
{
    fixture_image_put(&image, fixture_at_u1_peak, INT32_MAX);
    fixture_image_put(&image, fixture_at_u2_peak, INT32_MAX);
    fixture_image_put(&image, fixture_at_spindle_peak, 10000000u);
}

/// The header may promise no less than what lies 295 nm beyond the knots, not by a nanometre.
static void test_range_of_u_holds_between_the_knots(void)
{
    put_waves(fixture_u, 0, 295 * 128 * 16 / 5);
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    const dense_t dense = dense_of(&table.u, true);
    TEST_ASSERT_INT_WITHIN(1, 295, (int)dense.high);
    expect_around(&table.u, (cam_extent_t){table.u_min_nm, table.u_max_nm}, dense, 5.0L);
    const uint32_t most = (uint32_t)table.u_max_nm;
    const uint32_t least = (uint32_t)table.u_min_nm;
    const uint32_t wrong[][2] = {{least, 1}, {least, most - 1u}, {0, most}, {least + 1u, most}};
    for (int i = 0; i < 4; i++) {
        fixture_image_put(&image, fixture_at_u_min, wrong[i][0]);
        fixture_image_put(&image, fixture_at_u_max, wrong[i][1]);
        TEST_ASSERT_EQUAL_INT(cam_err_image_limits, check());
    }
}

static void test_range_of_x_and_of_the_ratio_hold_between_the_knots(void)
{
    part = fixture_part_modulated();
    fixture_image_make(&image, &part);
    put_waves(fixture_x, 0, 300000);
    put_waves(fixture_speed, 1 << 20, 200000);
    promise_all();
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    const cam_extent_t x = {table.x_min_nm, table.x_max_nm};
    expect_around(&table.x, x, dense_of(&table.x, false), 5.0L);
    const dense_t ratio = dense_of(&table.speed, true);
    TEST_ASSERT_TRUE((long double)table.ratio_max_q20 >= ratio.high + 1.0L);
    TEST_ASSERT_TRUE((long double)table.ratio_max_q20 <= ratio.high + 120.0L);
    TEST_ASSERT_TRUE(ratio.high > table.speed.value_offset + (1 << 17) + 7800);
}

/// What the entry of x allows its knots counts, and an LSB more, even where no curve goes so far.
static void test_range_of_x_is_that_of_its_promise(void)
{
    const size_t low = fixture_image_in(fixture_x, fixture_in_p_min);
    const size_t high = fixture_image_in(fixture_x, fixture_in_p_max);
    for (int32_t more = 40000; more < 44000; more += 333) {
        fixture_image_make(&image, &part);
        const int32_t p_min = (int32_t)fixture_image_get(&image, low) - more;
        const int32_t p_max = (int32_t)fixture_image_get(&image, high) + 2 * more;
        fixture_image_put(&image, low, (uint32_t)p_min);
        fixture_image_put(&image, high, (uint32_t)p_max);
        TEST_ASSERT_EQUAL_INT(cam_ok, check());
        const int frac = (int)table.x.frac_bits;
        const double x_nm = table.x.value_offset;
        TEST_ASSERT_EQUAL_DOUBLE(x_nm + floor(ldexp(p_min - 1.0, -frac)), table.x_min_nm);
        TEST_ASSERT_EQUAL_DOUBLE(x_nm + ceil(ldexp(p_max + 1.0, -frac)), table.x_max_nm);
    }
}

/// A ratio of 4 and an angle of a quarter turn are the most between the knots, too.
static void test_values_beyond_their_unit_between_the_knots_are_refused(void)
{
    part = fixture_part_modulated();
    fixture_image_make(&image, &part);
    put_waves(fixture_speed, (CAM_TABLE_RATIO_ONE * 3 - 1000) * 8, 1000 * 16);
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, check()); // the spindle's acceleration
    promise_all();
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    put_waves(fixture_speed, (CAM_TABLE_RATIO_ONE * 3 - 100) * 8, 1000 * 16);
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, check());
    part = fixture_part_swung();
    fixture_image_make(&image, &part);
    const size_t at = fixture_image_in(fixture_swing, fixture_in_value_offset);
    put_waves(fixture_swing, 0, 4000 * 16 / 5); // a thousand units
    fixture_image_put(&image, at, CAM_TABLE_ANGLE_MAX - 1100);
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    fixture_image_put(&image, at, CAM_TABLE_ANGLE_MAX - 900);
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, check());
}

/// Between two lobes u is 0, so that the range of a shaft holds 0.
static void test_range_of_a_shaft_holds_the_base_circle(void)
{
    const fixture_shaft_t shaft = fixture_shaft_three();
    fixture_shaft_make(&image, &shaft);
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    TEST_ASSERT_TRUE(table.u_min_nm < 0 && table.u_max_nm >= 0);
    const size_t at = fixture_image_in(fixture_behind_lobes + fixture_u, fixture_in_value_offset);
    fixture_image_put(&image, at, (uint32_t)-1000000);
    fixture_image_remeasure(&image, fixture_behind_lobes + fixture_u);
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, check());
}
