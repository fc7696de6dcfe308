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
static void test_disc_has_the_published_contacts(void)
{
    static const double golden[][3] = {{0, 30.0, 0.0},
                                       {15, 29.81482741, 14.2894418},
                                       {60, 27.33594637, 57.4060029},
                                       {90, 24.78478796, 86.6956948},
                                       {135, 21.36048680, 132.2894311},
                                       {165, 20.15666787, 163.9489426}};
    TEST_ASSERT_TRUE(read("{" HEAD ", \"lobes\": [" DISC "]}"));
    for (int i = 0; i < 6; i++) {
        const double theta = golden[i][0] / 360.0 * SIM_TWO_PI;
        const sim_lobe_spot_t s = sim_lobe_design_at(&design, 0, theta);
        TEST_ASSERT_DOUBLE_WITHIN(0.6e-7, golden[i][1], hypot(s.x_mm, s.y_mm));
        TEST_ASSERT_DOUBLE_WITHIN(0.6e-6, golden[i][2], atan2(s.y_mm, s.x_mm) * 360.0 / SIM_TWO_PI);
    }
}

/// Every law is its lift at the angle 0 and 0 on the base circle, and it has its derivatives.
static void test_laws_have_their_lift_and_derivatives(void)
{
    const double step_rad = 1e-5;
    for (int law = 0; law <= sim_lobe_n_flanks; law++) {
        sim_lobe_lift_t lift = {.law = law < sim_lobe_n_flanks ? sim_lobe_lift_flanks
                                                               : sim_lobe_lift_poly345,
                                .lift_mm = 8.0,
                                .half_angle_rad = 1.1,
                                .flanks = {(sim_lobe_flank_t)law, 8.0, 1.1, 0.2, 0.9, 0.02, 0.03}};
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 8.0, sim_lobe_lift_at(&lift, SIM_TWO_PI).h_mm);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, sim_lobe_lift_at(&lift, 3.0).h_mm);
        double last_mm = sim_lobe_lift_at(&lift, -1.0).h_mm;
        for (int i = 0; i < 1000; i++) {
            const double at_rad = SIM_TWO_PI * (i + 0.5) / 1000.0 - 1.0;
            const sim_lobe_rise_t low = sim_lobe_lift_at(&lift, at_rad - step_rad);
            const sim_lobe_rise_t here = sim_lobe_lift_at(&lift, at_rad);
            const sim_lobe_rise_t high = sim_lobe_lift_at(&lift, at_rad + step_rad);
            const double h1_mm = 0.5 * (high.h_mm - low.h_mm) / step_rad;
            const double h2_mm = 0.5 * (high.h1_mm - low.h1_mm) / step_rad;
            TEST_ASSERT_DOUBLE_WITHIN(0.12, last_mm, here.h_mm); // no jumps
            last_mm = here.h_mm;
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, h1_mm, here.h1_mm);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, h2_mm, here.h2_mm);
        }
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
