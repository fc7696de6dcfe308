// SPDX-License-Identifier: Apache-2.0
#include "sim_area.h"
#include "unity.h"
#include <math.h>   // asin, sqrt
#include <string.h> // strstr

static sim_areas_t areas;
static common_error_t error;

void setUp(void)
{
    areas = (sim_areas_t){0};
}

void tearDown(void)
{
    sim_areas_free(&areas);
}

static bool read_text(const char *text)
{
    cJSON *design = cJSON_Parse(text);
    const bool is_good = sim_areas_read(&areas, design, "part.json", &error);
    cJSON_Delete(design);
    return is_good;
}

/// A box has a middle and a width of angle, also across 0, and both ends of its heights.
static void test_box_holds_angles_and_heights(void)
{
    const sim_area_t wide = {90.0, 40.0, 10.0, 35.0, 0.0, 0.0, 0.0};
    const sim_area_t about_0 = {350.0, 30.0, 20.0, 20.0, 0.0, 0.0, 0.0};
    static const struct {
        double deg, z_mm;
        bool is_in;
    } cases[] = {{90.0, 20.0, true},  {70.1, 10.0, true},   {69.9, 10.0, false},
                 {109.9, 35.0, true}, {110.1, 35.0, false}, {90.0, 9.9, false},
                 {90.0, 35.1, false}, {4.9, 20.0, true},    {5.1, 20.0, false},
                 {335.1, 20.0, true}, {0.0, 21.0, false},   {0.0, 0.0, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const bool is_in = sim_area_holds(&wide, cases[i].deg / 360.0, cases[i].z_mm, 46.0, 0.0) ||
                           sim_area_holds(&about_0, cases[i].deg / 360.0, cases[i].z_mm, 46.0, 0.0);
        TEST_ASSERT_EQUAL(cases[i].is_in, is_in);
    }
}

/// A bore of 30 mm in a part of 46 mm: it reaches asin(15/46) = 19.03 degrees at its centre, and
/// 15 mm up and down; at 9 mm above the centre asin(12/46). It opens on one side of the part.
static void test_bore_is_a_cylinder(void)
{
    const sim_area_t bore = {90.0, 0.0, 30.0, 30.0, 30.0, 0.0, 0.0};
    const double wide_deg = asin(15.0 / 46.0) * 57.29577951308232;
    const double half_deg = asin(12.0 / 46.0) * 57.29577951308232;
    const struct {
        double deg, z_mm;
        bool is_in;
    } cases[] = {{90.0 + wide_deg - 0.01, 30.0, true},
                 {90.0 + wide_deg + 0.01, 30.0, false},
                 {90.0 - half_deg + 0.01, 39.0, true},
                 {90.0 - half_deg - 0.01, 39.0, false},
                 {90.0, 44.99, true},
                 {90.0, 45.01, false},
                 {90.0, 15.01, true},
                 {270.0, 30.0, false},
                 {-270.0, 30.0, true},
                 {0.0, 30.0, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL(cases[i].is_in,
                          sim_area_holds(&bore, cases[i].deg / 360.0, cases[i].z_mm, 46.0, 0.0));
    }
}

/// A pin 1 mm off the axis, towards rising angles: its edges lie at asin(16/46) and asin(-14/46).
static void test_bore_beside_the_axis(void)
{
    const sim_area_t bore = {90.0, 0.0, 30.0, 30.0, 30.0, 1.0, 0.0};
    const double far_deg = asin(16.0 / 46.0) * 57.29577951308232;
    const double near_deg = asin(14.0 / 46.0) * 57.29577951308232;
    TEST_ASSERT_TRUE(sim_area_holds(&bore, (90.0 + far_deg - 0.01) / 360.0, 30.0, 46.0, 0.0));
    TEST_ASSERT_FALSE(sim_area_holds(&bore, (90.0 + far_deg + 0.01) / 360.0, 30.0, 46.0, 0.0));
    TEST_ASSERT_TRUE(sim_area_holds(&bore, (90.0 - near_deg + 0.01) / 360.0, 30.0, 46.0, 0.0));
    TEST_ASSERT_FALSE(sim_area_holds(&bore, (90.0 - near_deg - 0.01) / 360.0, 30.0, 46.0, 0.0));
}

/// The margin is a length on the surface: 1 mm at a radius of 50 mm is 1.1459 degrees.
static void test_edge_is_metal_without_a_verdict(void)
{
    areas.n_windows = 2;
    areas.window[0] = (sim_area_t){0.0, 20.0, 10.0, 20.0, 0.0, 0.0, 1.0};
    areas.window[1] = (sim_area_t){180.0, 0.0, 15.0, 15.0, 10.0, 0.0, 1.0};
    const struct {
        double deg, z_mm;
        sim_place_kind_t kind;
    } cases[] = {{9.9, 15.0, sim_place_air},    {11.1, 15.0, sim_place_edge},
                 {11.2, 15.0, sim_place_metal}, {0.0, 20.9, sim_place_edge},
                 {0.0, 21.1, sim_place_metal},  {180.0, 19.9, sim_place_air},
                 {180.0, 20.9, sim_place_edge}, {180.0, 21.1, sim_place_metal},
                 {90.0, 15.0, sim_place_metal}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL(cases[i].kind,
                          sim_areas_kind(&areas, cases[i].deg / 360.0, cases[i].z_mm, 50.0));
    }
}

#define PLACE "\"angle_deg\":0,\"width_deg\":360,\"diameter_mm\":0,\"offset_mm\":0,\"margin_mm\":0"

/// The first zone that holds a place decides, by its tolerance and its band; else the part's.
static void test_zone_judges_by_its_own_tolerance(void)
{
    TEST_ASSERT_TRUE(read_text("{\"zones\":[{\"name\":\"belt\"," PLACE
                               ",\"low_mm\":0,\"high_mm\":10,\"tolerance_um\":1}]}"));
    sim_areas_judge(&areas, 0.25, 5.0, 46.0, -0.9, 2.0);
    sim_areas_judge(&areas, 0.5, 15.0, 46.0, 1.9, 2.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.1, areas.excess_um);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.1, areas.rest_um);
    sim_areas_judge(&areas, 0.75, 7.0, 46.0, -1.25, 2.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.25, areas.excess_um);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.25, areas.zone[0].excess_um);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.25, areas.zone[0].max_um);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 7.0, areas.zone[0].max_z_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.75, areas.zone[0].max_turn);
    TEST_ASSERT_EQUAL_UINT64(2u, areas.zone[0].n);
    TEST_ASSERT_EQUAL_STRING("belt", areas.zone[0].name);
    sim_areas_restart(&areas);
    sim_areas_judge(&areas, 0.5, 15.0, 46.0, 2.5, 2.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.5, areas.rest_um);
    TEST_ASSERT_EQUAL_UINT64(0u, areas.zone[0].n);
}

#define LINE(low, high) "{\"breaks_mm\":[0,10],\"coefficients\":[[0,0," high "," low "]]}"

/// The band opens upwards from 0.5 um at height 0 to 2.5 um at height 10; below it is 1 um.
static void test_band_follows_the_height(void)
{
    TEST_ASSERT_TRUE(read_text("{\"zones\":[{" PLACE ",\"low_mm\":0,\"high_mm\":10,"
                               "\"tolerance_um\":9,\"lower_um\":" LINE(
                                   "-1", "0") ",\"upper_um\":" LINE("0.5", "0.2") "}]}"));
    static const struct {
        double z_mm, error_um, excess_um;
    } cases[] = {{0.0, 0.25, -0.25}, {5.0, -0.75, -0.25}, {10.0, 2.75, 0.25}, {1.0, -1.5, 0.5}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        sim_areas_restart(&areas);
        sim_areas_judge(&areas, 0.0, cases[i].z_mm, 46.0, cases[i].error_um, 9.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, cases[i].excess_um, areas.zone[0].excess_um);
    }
}

static void test_what_is_malformed_is_refused(void)
{
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"{\"windows\":7}", "part.json: design.windows: must be a list of at most 80"},
        {"{\"windows\":[{}]}", "design.windows[0].angle_deg: must be a number of -360 .. 360"},
        {"{\"zones\":[{" PLACE ",\"low_mm\":3,\"high_mm\":2}]}", "zones[0].high_mm: must be a"},
        {"{\"zones\":[{" PLACE ",\"low_mm\":1,\"high_mm\":2,\"tolerance_um\":0}]}",
         "design.zones[0].tolerance_um: must be a number of 1e-06 .. 1e+06; make the table again"},
        {"{\"zones\":[{" PLACE ",\"low_mm\":1,\"high_mm\":2,\"tolerance_um\":1,\"upper_um\":1}]}",
         "design.zones[0].lower_um"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_FALSE(read_text(cases[i].text));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, cases[i].message), error.text);
        tearDown();
    }
}
