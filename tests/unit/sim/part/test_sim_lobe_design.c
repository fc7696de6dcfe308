// SPDX-License-Identifier: Apache-2.0
#include "sim_lobe_design.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h>   // atan2, hypot
#include <string.h> // strstr

static sim_lobe_design_t design;
static common_error_t error;

#define HEAD                                                                                       \
    "\"operation\": \"turning\", \"speed\": \"uniform\", \"base_mm\": 20, \"roller_mm\": 10, "     \
    "\"follower_mm\": 10, \"base_speed\": 1"
#define LOBE(law) "{\"z_mm\": [0, 12], \"phase_rad\": 0, " law "}"
#define POLY345 LOBE("\"law\": \"poly345\", \"lift_mm\": 8, \"half_angle_rad\": 1.2217304763960306")
#define DISC LOBE("\"law\": \"disc\", \"reach_mm\": 35, \"offset_mm\": 5")

void setUp(void)
{
    memset(&design, 0, sizeof design);
}

void tearDown(void)
{
    sim_lobe_design_free(&design);
}

static bool read(const char *text)
{
    cJSON *root = cJSON_Parse(text);
    TEST_ASSERT_NOT_NULL(root);
    const bool is_good = sim_lobe_design_read(&design, root, "a.json", &error);
    cJSON_Delete(root);
    return is_good;
}

/// theta, OC and alpha_C of MATHS.md (30), to the digits of its worked table.
static void check_golden(const double golden[][3], int n)
{
    for (int i = 0; i < n; i++) {
        const double theta = golden[i][0] / 360.0 * SIM_TWO_PI;
        const sim_lobe_spot_t s = sim_lobe_design_at(&design, 0, theta);
        TEST_ASSERT_DOUBLE_WITHIN(0.6e-7, golden[i][1], hypot(s.x_mm, s.y_mm));
        TEST_ASSERT_DOUBLE_WITHIN(0.6e-6, golden[i][2], atan2(s.y_mm, s.x_mm) * 360.0 / SIM_TWO_PI);
    }
}

static void test_disc_has_the_published_contacts(void)
{
    static const double golden[][3] = {
        {0, 30.0, 0.0},
        {15, 29.81482741, 14.2894418},
        {60, 27.33594637, 57.4060029},
        {90, 24.78478796, 86.6956948},
        {135, 21.36048680, 132.2894311},
        {165, 20.15666787, 163.9489426},
    };
    TEST_ASSERT_TRUE(read("{" HEAD ", \"lobes\": [" DISC "]}"));
    check_golden(golden, 6);
}

static void test_poly345_has_the_published_contacts(void)
{
    static const double golden[][3] = {
        {-80, 20.0, -80.0},
        {-60, 20.2566726, -57.252091},
        {-40, 23.7668907, -31.854451},
        {-10, 27.8549130, -8.402435},
        {0, 28.0, 0.0},
        {30, 25.7755395, 22.900591},
        {50, 21.6351132, 43.258352},
    };
    TEST_ASSERT_TRUE(read("{" HEAD ", \"lobes\": [" POLY345 "]}"));
    check_golden(golden, 7);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 8.0, sim_lobe_design_lift_mm(&design));
}

/// Two quintics that happen to be lines up and down: (1 + s) and (1 + pi - s).
static void test_pieces_are_evaluated_from_the_highest_power(void)
{
    TEST_ASSERT_TRUE(read("{" HEAD ", \"lobes\": [" LOBE(
        "\"law\": \"pieces\", \"breaks_rad\": [0, 3.141592653589793, 6.283185307179586], "
        "\"coefficients\": [0, 0, 0, 0, 1, 1, 0, 0, 0, 0.5, -1, 4.141592653589793]") "]}"));
    sim_lobe_lift_t *lift = &design.lobe[0].lift;
    const sim_lobe_rise_t up = sim_lobe_lift_at(lift, 1.0 - 2.0 * SIM_TWO_PI);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2.0, up.h_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0, up.h1_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, up.h2_mm);
    const sim_lobe_rise_t down = sim_lobe_lift_at(lift, SIM_PI + 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, SIM_PI + 0.5, down.h_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, down.h1_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0, down.h2_mm);
}

/// Tangent, arc length and turning of the normal agree with the differences of neighbours.
static void test_derivatives_agree_with_differences(void)
{
    const double step = 1e-5;
    TEST_ASSERT_TRUE(read("{" HEAD ", \"lobes\": [" POLY345 "]}"));
    for (double theta = -1.15; theta < 1.2; theta += 0.07) {
        const sim_lobe_spot_t a = sim_lobe_design_at(&design, 0, theta - step);
        const sim_lobe_spot_t s = sim_lobe_design_at(&design, 0, theta);
        const sim_lobe_spot_t b = sim_lobe_design_at(&design, 0, theta + step);
        const double x = (b.x_mm - a.x_mm) / (2.0 * step);
        const double y = (b.y_mm - a.y_mm) / (2.0 * step);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, x * s.nx + y * s.ny);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, s.ds_mm, y * s.nx - x * s.ny);
        const double turned = asin(a.nx * b.ny - a.ny * b.nx) / (2.0 * step);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, s.bend, turned);
    }
}

static void test_lobes_are_found_by_height(void)
{
    TEST_ASSERT_TRUE(read("{" HEAD ", \"lobes\": [" DISC ", {\"z_mm\": [20, 30], \"phase_rad\": 1, "
                          "\"law\": \"disc\", \"reach_mm\": 35, \"offset_mm\": 5}]}"));
    TEST_ASSERT_EQUAL_UINT32(0, sim_lobe_design_find(&design, 12.0, 0.0));
    TEST_ASSERT_EQUAL_UINT32(2, sim_lobe_design_find(&design, 12.01, 0.001));
    TEST_ASSERT_EQUAL_UINT32(1, sim_lobe_design_find(&design, 19.9995, 0.001));
    TEST_ASSERT_EQUAL_UINT32(2, sim_lobe_design_find(&design, -1.0, 0.001));
}

static void test_bad_designs_are_refused_by_field(void)
{
    static const char *const bad[][2] = {
        {"{\"operation\": \"milling\"}", "design.operation = \"milling\""},
        {"{\"operation\": \"turning\"}", "design.speed"},
        {"{\"operation\": \"turning\", \"speed\": \"uniform\", \"base_mm\": -1}", "base_mm"},
        {"{" HEAD "}", "design.lobes"},
        {"{" HEAD ", \"lobes\": [{\"z_mm\": [3, 1]}]}", "design.lobes.0.z_mm"},
        {"{" HEAD ", \"lobes\": [" DISC ", " DISC "]}", "design.lobes.1.z_mm"},
        {"{" HEAD ", \"lobes\": [{\"z_mm\": [1, 3]}]}", "design.lobes.0.phase_rad"},
        {"{" HEAD ", \"lobes\": [" LOBE("\"law\": \"sine\"") "]}", "law = \"sine\""},
        {"{" HEAD ", \"lobes\": [" LOBE("\"law\": \"poly345\", \"lift_mm\": 1") "]}",
         "half_angle_rad"},
        {"{" HEAD
         ", \"lobes\": [" LOBE("\"law\": \"disc\", \"reach_mm\": 1, \"offset_mm\": 2") "]}",
         "offset_mm = 2"},
        {"{" HEAD ", \"lobes\": [" LOBE("\"law\": \"pieces\", \"breaks_rad\": [0, 1]") "]}",
         "breaks_rad"},
        {"{" HEAD
         ", \"lobes\": [" LOBE("\"law\": \"pieces\", \"breaks_rad\": [0, 6.283185307179586], "
                               "\"coefficients\": [1]") "]}",
         "coefficients: must be 6"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        setUp();
        TEST_ASSERT_FALSE(read(bad[i][0]));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, bad[i][1]), error.text);
        TEST_ASSERT_NOT_NULL(strstr(error.text, "a.json: "));
        sim_lobe_design_free(&design);
    }
}
