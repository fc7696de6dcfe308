// SPDX-License-Identifier: Apache-2.0
// One channel of an image: every limit of its entry at its last good value and at the one beyond.
#include "cam_table_inner.h"
#include "fixture_random.h"
#include "unity.h"
#include <stdlib.h>
#include <string.h>

enum { begin = 64, n_knots = 8, n_words = 16 };
enum { least_ratio = CAM_TABLE_RATIO_ONE / 16, most_ratio = CAM_TABLE_RATIO_ONE * 4 };

static uint32_t image[(begin + n_knots * sizeof(cam_knot_t)) / sizeof(uint32_t)];
static cam_entry_t entry;
static cam_table_t in;
static const cam_lobe_t lobe;
static uint64_t used;

static cam_knot_t *knots(void)
{
    return (cam_knot_t *)(void *)&image[begin / sizeof(uint32_t)];
}

/// The heights and the reciprocal of their spacing.
static void set_heights(int32_t first_nm, int32_t last_nm)
{
    const uint64_t span_nm = (uint64_t)((int64_t)last_nm - first_nm);
    entry.z_first_nm = first_nm;
    entry.z_last_nm = last_nm;
    entry.slices_per_nm_q48 =
        (uint32_t)((((uint64_t)(entry.n_slices - 1u) << 48) + span_nm / 2u) / span_nm);
}

/// A channel of two slices whose knots are all 0 and may be anything.
static void make(uint32_t kind)
{
    memset(image, 0, sizeof image);
    const bool is_around = kind != cam_kind_x && kind != cam_kind_way;
    const uint32_t n = is_around ? n_knots : 2u;
    entry = (cam_entry_t){.kind = kind,
                          .offset = begin,
                          .size = n * (uint32_t)sizeof(cam_knot_t),
                          .n_slices = 2,
                          .log2_knots = is_around ? 2u : 0u,
                          .frac_bits = 4};
    set_heights(0, 1000000);
    in = (cam_table_t){.image = image, .image_size = begin + entry.size, .z_last_nm = 1000000};
    used = begin;
}

static cam_err_t check(void)
{
    return cam_entry_check(&entry, &in, &used);
}

void setUp(void)
{
    make(cam_kind_u);
}

/// Only x and the way are over the height alone.
static void test_plain_channel_of_each_kind_is_good(void)
{
    for (uint32_t kind = 0; kind < 12u; kind++) {
        make(kind);
        entry.value_offset = kind == cam_kind_speed ? CAM_TABLE_RATIO_ONE : 0;
        const bool is_known = (kind >= 1u && kind <= 5u) || kind == 7u;
        TEST_ASSERT_EQUAL_INT(is_known ? cam_ok : cam_err_image_channel, check());
        TEST_ASSERT_EQUAL(kind != cam_kind_x && kind != cam_kind_way,
                          cam_entry_is_over_angle(&entry));
    }
}

/// A field of a kind, its last good value and the first bad one.
typedef struct {
    uint32_t kind;
    size_t at;
    int64_t good, bad;
} limit_t;

#define AT(member) offsetof(cam_entry_t, member)

static cam_err_t with(const limit_t *limit, int64_t value)
{
    make(limit->kind);
    entry.p_min = -1;
    entry.p_max = 1;
    const uint32_t word = (uint32_t)value;
    memcpy((uint8_t *)&entry + limit->at, &word, sizeof word);
    return check();
}

/// A good value that changes how many knots there are is found out by the layout, behind the shape.
static void test_each_field_is_limited(void)
{
    static const limit_t limits[] = {
        {cam_kind_u, AT(n_slices), 2, 1},
        {cam_kind_u, AT(n_slices), cam_table_max_slices, cam_table_max_slices + 1},
        {cam_kind_u, AT(log2_knots), 2, 1},
        {cam_kind_u, AT(log2_knots), 12, 13},
        {cam_kind_u, AT(log2_repeat), 4, 5},
        {cam_kind_u, AT(frac_bits), 8, 9},
        {cam_kind_u, AT(path), 0, 1},
        {cam_kind_u, AT(p_min), -CAM_TABLE_SUM_MAX, -CAM_TABLE_SUM_MAX - 1},
        {cam_kind_u, AT(p_min), 1, 2},
        {cam_kind_u, AT(p_max), CAM_TABLE_SUM_MAX, CAM_TABLE_SUM_MAX + 1},
        {cam_kind_u, AT(p_max), -1, -2},
        {cam_kind_u, AT(v_max), CAM_TABLE_SUM_MAX, CAM_TABLE_SUM_MAX + 1},
        {cam_kind_u, AT(a_max), CAM_TABLE_SUM_MAX, CAM_TABLE_SUM_MAX + 1},
        {cam_kind_u, AT(value_offset), (1 << 23) - 1, 1 << 23},
        {cam_kind_u, AT(value_offset), 1 - (1 << 23), -(1 << 23)},
        {cam_kind_x, AT(log2_knots), 0, 1},
        {cam_kind_x, AT(log2_repeat), 0, 1},
        {cam_kind_x, AT(path), 1, 2},
        {cam_kind_way, AT(path), 1, 2},
        {cam_kind_x, AT(value_offset), 2000000000, 2000000001},
        {cam_kind_x, AT(value_offset), -2000000000, -2000000001},
        {cam_kind_speed, AT(value_offset), least_ratio + 1, least_ratio},
        {cam_kind_speed, AT(value_offset), most_ratio - 1, most_ratio},
        {cam_kind_swing, AT(value_offset), CAM_TABLE_ANGLE_MAX - 1, CAM_TABLE_ANGLE_MAX},
        {cam_kind_swing, AT(value_offset), 1 - CAM_TABLE_ANGLE_MAX, -CAM_TABLE_ANGLE_MAX},
        {cam_kind_contact, AT(value_offset), CAM_TABLE_ANGLE_MAX - 1, CAM_TABLE_ANGLE_MAX},
        {cam_kind_contact, AT(value_offset), 1 - CAM_TABLE_ANGLE_MAX, -CAM_TABLE_ANGLE_MAX},
    };
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        TEST_ASSERT_NOT_EQUAL_INT(cam_err_image_channel, with(&limits[i], limits[i].good));
        TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with(&limits[i], limits[i].bad));
    }
}

/// An LSB beyond a whole unit is beyond it.
static void test_range_of_the_knots_is_rounded_outwards(void)
{
    make(cam_kind_speed);
    entry.value_offset = CAM_TABLE_RATIO_ONE;
    entry.p_min = (least_ratio - CAM_TABLE_RATIO_ONE) * 16;
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    entry.p_min--;
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check());
    make(cam_kind_speed);
    entry.value_offset = most_ratio - CAM_TABLE_RATIO_ONE;
    entry.p_max = CAM_TABLE_RATIO_ONE * 16;
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    entry.p_max++;
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check());
}

static void test_numbers_lie_aligned_behind_what_was_used_and_in_the_image(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    TEST_ASSERT_EQUAL_UINT64(begin + entry.size, used);
    used = begin + 1;
    TEST_ASSERT_EQUAL_INT(cam_err_image_layout, check());
    used = 0;
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    in.image_size--;
    TEST_ASSERT_EQUAL_INT(cam_err_image_layout, (used = 0, check()));
    make(cam_kind_u);
    for (uint32_t off = 1; off < 32u; off++) {
        used = 0;
        entry.offset = begin - off;
        TEST_ASSERT_EQUAL_INT(cam_err_image_layout, check());
    }
    make(cam_kind_u);
    entry.size++;
    TEST_ASSERT_EQUAL_INT(cam_err_image_layout, check());
    entry.size -= 2u;
    TEST_ASSERT_EQUAL_INT(cam_err_image_layout, (used = 0, check()));
}

static cam_err_t with_heights(int32_t first_nm, int32_t last_nm)
{
    set_heights(first_nm, last_nm);
    used = 0;
    return check();
}

static void test_heights_serve_the_whole_table(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, with_heights(-1, 1000001));
    TEST_ASSERT_EQUAL_INT(cam_err_image_height, with_heights(1, 1000000));
    TEST_ASSERT_EQUAL_INT(cam_err_image_height, with_heights(0, 999999));
    in.z_first_nm = in.z_last_nm = 1000000000;
    TEST_ASSERT_EQUAL_INT(cam_ok, with_heights(999000000, 1000000000));
    TEST_ASSERT_EQUAL_INT(cam_err_image_height, with_heights(999000000, 1000000001));
    in.z_first_nm = in.z_last_nm = -1000000000;
    TEST_ASSERT_EQUAL_INT(cam_ok, with_heights(-1000000000, -999000000));
    TEST_ASSERT_EQUAL_INT(cam_err_image_height, with_heights(-1000000001, -999000000));
}

static void test_spacing_of_slices_and_its_reciprocal_are_limited(void)
{
    make(cam_kind_x);
    entry.n_slices = 3;
    entry.size += (uint32_t)sizeof(cam_knot_t);
    in.image_size = begin + entry.size;
    in.z_last_nm = 1;
    TEST_ASSERT_EQUAL_INT(cam_ok, with_heights(0, 2 * 65537));
    TEST_ASSERT_EQUAL_INT(cam_err_image_height, with_heights(0, 2 * 65537 - 1));
    TEST_ASSERT_EQUAL_INT(cam_ok, with_heights(0, 2 * 16777216));
    TEST_ASSERT_EQUAL_INT(cam_err_image_height, with_heights(0, 2 * 16777216 + 1));
    for (int32_t off = -1; off <= 1; off++) {
        set_heights(0, 300000);
        entry.slices_per_nm_q48 += (uint32_t)off;
        used = 0;
        TEST_ASSERT_EQUAL_INT(off == 0 ? cam_ok : cam_err_image_height, check());
    }
}

/// Patterns are of the whole table and have no spacing; x has one there as elsewhere.
static void test_patterns_have_no_heights_of_their_own(void)
{
    in.lobes = &lobe;
    TEST_ASSERT_EQUAL_INT(cam_err_image_height, check());
    for (uint32_t wrong = 0; wrong < 3u; wrong++) {
        make(cam_kind_u);
        in.lobes = &lobe;
        entry.slices_per_nm_q48 = 0;
        TEST_ASSERT_EQUAL_INT(cam_ok, check());
        entry.z_first_nm -= wrong == 0u ? 1 : 0;
        entry.z_last_nm += wrong == 1u ? 1 : 0;
        entry.slices_per_nm_q48 += wrong == 2u ? 1u : 0u;
        used = 0;
        TEST_ASSERT_EQUAL_INT(cam_err_image_height, check());
    }
    make(cam_kind_x);
    in.lobes = &lobe;
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
}

static cam_err_t check_records(void)
{
    return cam_entry_check_records(&entry, 2, sizeof(cam_knot_t), &in, &used);
}

static void test_records_have_no_field_of_knots(void)
{
    static const size_t unused[] = {
        AT(log2_knots),   AT(log2_repeat), AT(frac_bits),  AT(slices_per_nm_q48),
        AT(value_offset), AT(p_min),       AT(p_max),      AT(v_max),
        AT(a_max),        AT(path),        AT(z_first_nm), AT(z_last_nm)};
    for (size_t i = 0; i < sizeof unused / sizeof unused[0]; i++) {
        make(cam_kind_x);
        entry.frac_bits = entry.slices_per_nm_q48 = 0;
        TEST_ASSERT_EQUAL_INT(cam_ok, check_records());
        used = begin;
        ((uint8_t *)&entry)[unused[i]] ^= 1u;
        TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check_records());
    }
}

/// @return whether the three sums of the format hold, with coefficients straight from the knots
static bool is_within(const cam_knot_t *k, const cam_knot_t *l)
{
    const int64_t d = (int64_t)l->p - k->p;
    const int64_t c3 = llabs(10 * d - 6LL * k->v - 4LL * l->v - 3LL * k->a + l->a);
    const int64_t c4 = llabs(-15 * d + 8LL * k->v + 7LL * l->v + 3LL * k->a - 2LL * l->a);
    const int64_t c5 = llabs(6 * d - 3LL * k->v - 3LL * l->v - k->a + l->a);
    const int64_t v = llabs(k->v), a = llabs(k->a);
    return llabs(k->p) + v + a + c3 + c4 + c5 <= CAM_TABLE_SUM_MAX &&
           v + 2 * a + 3 * c3 + 4 * c4 + 5 * c5 <= CAM_TABLE_SUM_MAX &&
           2 * a + 6 * c3 + 12 * c4 + 20 * c5 <= CAM_TABLE_SUM_MAX;
}

static void allow_all(void)
{
    entry.p_min = -CAM_TABLE_SUM_MAX;
    entry.p_max = CAM_TABLE_SUM_MAX;
    entry.v_max = entry.a_max = CAM_TABLE_SUM_MAX;
}

static int32_t member(fixture_random_t *random, uint32_t most_bits)
{
    const int64_t size = INT64_C(1) << (most_bits - fixture_random_u32(random) % 5u);
    return (int32_t)fixture_random_range(random, -size, size);
}

/// One segment at a time, of members of all sizes: some break one of the sums alone.
static void test_segments_are_refused_where_a_sum_of_the_format_is_too_large(void)
{
    fixture_random_t random = {.state = 41};
    int n_good = 0;
    for (int i = 0; i < 4000; i++) {
        make(cam_kind_x);
        allow_all();
        const int32_t v = member(&random, 25);
        cam_knot_t *k = knots();
        k[0] = (cam_knot_t){.p = member(&random, 25), .v = v, .a = member(&random, 19)};
        k[1] = (cam_knot_t){.v = v + member(&random, 19), .a = member(&random, 19)};
        const int64_t p = (int64_t)k[0].p + v + member(&random, 18);
        k[1].p = p < -CAM_TABLE_SUM_MAX || p > CAM_TABLE_SUM_MAX ? 0 : (int32_t)p;
        const bool is_good = is_within(&k[0], &k[1]);
        n_good += is_good;
        TEST_ASSERT_EQUAL_INT(is_good ? cam_ok : cam_err_image_knots, check());
    }
    TEST_ASSERT_INT_WITHIN(1000, 2000, n_good);
}

/// Along a straight line all is in the value and its slope.
static void test_sums_may_be_just_as_large_as_allowed(void)
{
    make(cam_kind_x);
    allow_all();
    knots()[0] = (cam_knot_t){.v = CAM_TABLE_SUM_MAX};
    knots()[1] = (cam_knot_t){.p = CAM_TABLE_SUM_MAX, .v = CAM_TABLE_SUM_MAX};
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    knots()[0].p = 1;
    knots()[1].p = CAM_TABLE_SUM_MAX;
    TEST_ASSERT_EQUAL_INT(cam_err_image_knots, (used = 0, check()));
}

/// The last knot over height begins no segment; around a turn each knot does.
static void test_each_knot_is_checked_with_its_segment(void)
{
    static const uint32_t promises[][3] = {{1, 1, 1}, {0, 1, 1}, {1, 0, 1}, {1, 1, 0}};
    for (uint32_t i = 0; i < n_knots; i++) {
        make(cam_kind_u);
        allow_all();
        knots()[i].a = CAM_TABLE_SUM_MAX;
        TEST_ASSERT_EQUAL_INT(cam_err_image_knots, check());
        knots()[i] = (cam_knot_t){.p = 1, .v = 1, .a = 1};
        entry.p_min = 0;
        for (uint32_t k = 0; k < 4u; k++) {
            entry.p_max = (int32_t)promises[k][0];
            entry.v_max = promises[k][1];
            entry.a_max = promises[k][2];
            used = 0;
            TEST_ASSERT_EQUAL_INT(k == 0u ? cam_ok : cam_err_image_limits, check());
        }
    }
}

static void test_channel_is_as_its_entry_has_it(void)
{
    entry.log2_repeat = 3;
    entry.value_offset = -5;
    set_heights(-7, 1000000);
    const cam_channel_t ch = cam_entry_channel(&entry, &in);
    TEST_ASSERT_EQUAL_PTR(knots(), ch.knots);
    TEST_ASSERT_TRUE(ch.n_slices == 2u && ch.log2_knots == 2u);
    TEST_ASSERT_EQUAL_UINT32(3, ch.log2_repeat);
    TEST_ASSERT_EQUAL_UINT32(4, ch.frac_bits);
    TEST_ASSERT_EQUAL_INT32(-7, ch.z_first_nm);
    TEST_ASSERT_EQUAL_UINT32(1000007, ch.span_nm);
    TEST_ASSERT_EQUAL_UINT32(entry.slices_per_nm_q48, ch.slices_per_nm_q48);
    TEST_ASSERT_EQUAL_INT32(-5, ch.value_offset);
}
