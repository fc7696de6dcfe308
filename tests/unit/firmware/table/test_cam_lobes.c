// SPDX-License-Identifier: Apache-2.0
// The lobes of a shaft: their check, the lobe at a height, and its change.
#include "cam_eval.h"        // cam_lobes_change_q31, cam_lobes_find
#include "cam_table_inner.h" // cam_lobes_check_patterns
#include "fixture_random.h"
#include "fixture_shaft.h"
#include "unity.h"
#include <math.h> // fabs

static fixture_image_t image;
static cam_table_t table;
static fixture_shaft_t shaft;

static cam_err_t check(void)
{
    fixture_image_seal(&image);
    return cam_table_check(image.bytes, image.size, &table);
}

static void make(void)
{
    fixture_shaft_make(&image, &shaft);
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
}

void setUp(void)
{
    shaft = fixture_shaft_three();
    make();
}

static void test_shaft_is_described(void)
{
    TEST_ASSERT_EQUAL_UINT32(3, table.n_lobes);
    TEST_ASSERT_EQUAL_UINT32(80000, table.least_change_nm);
    TEST_ASSERT_EQUAL_UINT32(0xC0000000u, table.lobes[2].phase_q32);
    TEST_ASSERT_EQUAL_UINT32(3, table.u.n_slices);
    TEST_ASSERT_TRUE(table.is_swung);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, table.u_change.most, "patterns have no neighbours");
    TEST_ASSERT_EQUAL_UINT32(0, table.swing_change.kink);
    shaft.has_speed = true;
    make();
    TEST_ASSERT_NOT_NULL(table.speed.knots);
}

static cam_err_t with_word(size_t at, uint32_t value)
{
    fixture_shaft_make(&image, &shaft);
    fixture_image_put(&image, at, value);
    return check();
}

/// Lobes are 0.2 mm apart at least, whatever reciprocal the entry has of a smaller gap.
/// test_cam_entry.c has each field of the entry.
static void test_wrong_lobes_are_refused(void)
{
    enum { entry = 100 }; ///< in place of a lobe: words of the directory's entry
    static const struct {
        uint32_t lobe, word, value;
        cam_err_t err;
    } rows[] = {
        {0, 0, 1u, cam_err_image_height},
        {2, 1, 999999u, cam_err_image_height},
        {1, 1, 400000u, cam_err_image_height},
        {1, 0, 399999u, cam_err_image_height},
        {1, 0, 0x80000000u, cam_err_image_height},
        {0, 4, 1u, cam_err_image_height},
        {2, 4, 1u, cam_err_image_height},
        {0, 3, 3u, cam_err_image_channel},
        {1, 3, 0xFFFFFFFFu, cam_err_image_channel},
        {entry, fixture_in_path, 1u, cam_err_image_channel},
        {entry, fixture_in_n_slices, 0u, cam_err_image_channel},
        {entry, fixture_in_n_slices, 65u, cam_err_image_channel},
        {entry, fixture_in_n_slices, 2u, cam_err_image_layout},
        {entry, fixture_in_offset, 0x7FFFFFE0u, cam_err_image_layout},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const size_t at = rows[i].lobe == entry
                              ? fixture_image_in(fixture_lobes, rows[i].word)
                              : fixture_shaft_word(&image, rows[i].lobe, rows[i].word);
        TEST_ASSERT_EQUAL_INT(rows[i].err, with_word(at, rows[i].value));
    }
    // A second directory, one nanometre too near, and a lobe without height.
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel,
                          with_word(fixture_image_in(fixture_behind_lobes, fixture_in_kind), 6u));
    shaft.lobe[1].z_first_nm--;
    fixture_shaft_make(&image, &shaft);
    TEST_ASSERT_EQUAL_INT(cam_err_image_height, check());
    setUp();
    shaft.lobe[1].z_last_nm = shaft.lobe[1].z_first_nm;
    fixture_shaft_make(&image, &shaft);
    TEST_ASSERT_EQUAL_INT(cam_err_image_height, check());
}

static void test_version_names_lobes(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_word(fixture_at_version, 1u));
    const fixture_part_t part = fixture_part_swung();
    fixture_image_make(&image, &part);
    fixture_image_put(&image, fixture_at_version, 0x00010001u);
    TEST_ASSERT_EQUAL_INT(cam_err_image_version, check());
}

/// Lobes of 1 .. 4 mm with gaps of 0.2 .. 5 mm.
static void scatter(fixture_random_t *random, uint32_t n)
{
    int64_t z_nm = -50000000;
    shaft.n_lobes = n;
    for (uint32_t i = 0; i < n; i++) {
        const int64_t end_nm = z_nm + fixture_random_range(random, 1000000, 4000000);
        shaft.lobe[i] = (cam_lobe_t){(int32_t)z_nm, (int32_t)end_nm, fixture_random_u32(random),
                                     fixture_random_u32(random) % 3u, 0u};
        z_nm = end_nm + fixture_random_range(random, 200000, 5000000);
    }
}

/// @return 1 - share of the lift at a height by the words of the format, and the lobe
static double change_of(int32_t z_nm, uint32_t *found)
{
    uint32_t i = 0;
    while (i + 1u < shaft.n_lobes &&
           z_nm >= shaft.lobe[i].z_last_nm +
                       (shaft.lobe[i + 1u].z_first_nm - shaft.lobe[i].z_last_nm) / 2) {
        i++;
    }
    *found = i;
    const cam_lobe_t *lobe = &shaft.lobe[i];
    const bool is_below = z_nm < lobe->z_first_nm;
    if (is_below ? i == 0u : z_nm <= lobe->z_last_nm || i + 1u == shaft.n_lobes) {
        return 0.0;
    }
    const double beside = fmax((double)lobe->z_first_nm - z_nm, (double)z_nm - lobe->z_last_nm);
    const cam_lobe_t *low = is_below ? lobe - 1 : lobe;
    const double c = floor(((double)low[1].z_first_nm - low->z_last_nm) / 2.0) - 20000.0;
    return fmin(fmax((beside - 20000.0) / c, 0.0), 1.0);
}

static void test_lobe_and_change_are_those_of_the_format(void)
{
    fixture_random_t random = {20241122u};
    for (uint32_t n = 1; n <= 64; n += n < 6u ? 1u : 29u) {
        scatter(&random, n);
        make();
        uint32_t least = n > 1u ? UINT32_MAX : 0;
        for (uint32_t i = 1; i < n; i++) {
            const int32_t gap_nm = shaft.lobe[i].z_first_nm - shaft.lobe[i - 1u].z_last_nm;
            least = (uint32_t)fmin(least, gap_nm / 2 - 20000);
        }
        TEST_ASSERT_EQUAL_UINT32(least, table.least_change_nm);
        for (uint32_t k = 0; k < 4000u / fixture_rarer; k++) {
            const int32_t low = shaft.lobe[0].z_first_nm - 1000000;
            const int32_t high = shaft.lobe[n - 1u].z_last_nm + 1000000;
            const int32_t z_nm = (int32_t)fixture_random_range(&random, low, high);
            uint32_t i = 0;
            const double wanted = change_of(z_nm, &i);
            TEST_ASSERT_EQUAL_UINT32(i, cam_lobes_find(&table, z_nm));
            const double got = cam_lobes_change_q31(&table, i, z_nm) / 2147483647.0;
            TEST_ASSERT_TRUE(fabs(got - wanted) < 2e-6);
        }
    }
}

static void test_middle_of_the_gap_belongs_to_the_upper_lobe_and_has_no_lift(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, cam_lobes_find(&table, 299999));
    TEST_ASSERT_EQUAL_UINT32(1, cam_lobes_find(&table, 300000));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_lobes_change_q31(&table, 1, 300000));
    TEST_ASSERT_EQUAL_INT32(0, cam_lobes_change_q31(&table, 0, 200000)); // within the lobe
    TEST_ASSERT_EQUAL_INT32(0, cam_lobes_change_q31(&table, 0, 220000));
    TEST_ASSERT_EQUAL_INT32(0, cam_lobes_change_q31(&table, 1, 380000));
    TEST_ASSERT_GREATER_THAN_INT32(0, cam_lobes_change_q31(&table, 0, 220001));
    TEST_ASSERT_EQUAL_UINT32(0, cam_lobes_find(&table, INT32_MIN));
    TEST_ASSERT_EQUAL_UINT32(2, cam_lobes_find(&table, INT32_MAX));
    TEST_ASSERT_EQUAL_INT32(0, cam_lobes_change_q31(&table, 2, INT32_MAX));
}

/// Each pattern alone, from its first slice to its last.
static void test_slice_is_the_pattern_alone(void)
{
    for (uint32_t pattern = 0; pattern < 3u; pattern++) {
        const cam_height_t at = cam_lobes_slice(3, pattern);
        const cam_value_t u = cam_eval_surface_at(&table.u, 0x40000000u, at);
        double wanted[3];
        fixture_shaft_lift(1.5707963267948966, 500000.0 * pattern, wanted);
        TEST_ASSERT_INT32_WITHIN(2, (int32_t)wanted[0] * 128, u.y);
    }
}

/// All channels over the angle have a slice for each pattern, and each lobe has one of them.
static void test_channels_of_a_shaft_have_the_same_patterns(void)
{
    static const struct {
        const char *name;
        int32_t u, speed, angle; ///< more slices
        bool no_speed, no_angle, has_rings;
        cam_err_t err;
    } rows[] = {
        {"alike", 0, 0, 0, false, false, false, cam_ok},
        {"speed has fewer", 0, -1, 0, false, false, false, cam_err_image_channel},
        {"speed has more", 0, 1, 0, false, false, false, cam_err_image_channel},
        {"no speed", 0, 1, 0, true, false, false, cam_ok},
        {"angle has fewer", 0, 0, -1, true, false, false, cam_err_image_channel},
        {"angle has more", 0, 0, 1, true, false, false, cam_err_image_channel},
        {"no angle", 0, 0, 0, false, true, false, cam_err_image_channel},
        {"a ring-helix", 0, 0, 0, false, false, true, cam_err_image_channel},
        {"two patterns, a third wanted", -1, -1, -1, false, false, false, cam_err_image_channel},
    };
    shaft.has_speed = true;
    make();
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        cam_table_t t = table;
        t.u.n_slices += (uint32_t)rows[i].u;
        t.speed.n_slices += (uint32_t)rows[i].speed;
        t.angle.n_slices += (uint32_t)rows[i].angle;
        t.speed.knots = rows[i].no_speed ? NULL : t.speed.knots;
        t.angle.knots = rows[i].no_angle ? NULL : t.angle.knots;
        t.is_ring_helix = rows[i].has_rings;
        TEST_ASSERT_EQUAL_INT_MESSAGE(rows[i].err, cam_lobes_check_patterns(&t), rows[i].name);
    }
}
