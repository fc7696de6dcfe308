// SPDX-License-Identifier: Apache-2.0
#include "sim_surface.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h>   // cos, fmod, pow, sin
#include <stdio.h>  // snprintf
#include <string.h> // strstr

static sim_surface_t surface;
static common_error_t error;
static char text[65536];

void setUp(void)
{
    memset(&surface, 0, sizeof surface);
}

void tearDown(void)
{
    sim_surface_free(&surface);
}

static bool read(const char *json)
{
    cJSON *root = cJSON_Parse(json);
    TEST_ASSERT_NOT_NULL(root);
    const bool is_good = sim_surface_read(&surface, root, "design.surface", "part.json", &error);
    cJSON_Delete(root);
    return is_good;
}

/// @return a coefficient that differs for every place
static double coefficient(int j, int i, int k, int l)
{
    return 0.001 * (1 + j) + 0.01 * (1 + i) / (1 + k) - 0.02 / (1 + l + k);
}

/// A surface of m x n pieces with the coefficients above.
static const char *make(const char *angle, const char *breaks, int n, const char *breaks_mm, int m)
{
    int at =
        snprintf(text, sizeof text, "{%s, \"breaks\": %s, \"breaks_mm\": %s, \"coefficients\": [",
                 angle, breaks, breaks_mm);
    for (int q = 0; q < m * n * 48; q++) {
        const double c = coefficient(q / 48 / n, q / 48 % n, q / 8 % 6, q % 8);
        at += snprintf(text + at, sizeof text - (size_t)at, "%s%.17g", q > 0 ? "," : "", c);
    }
    (void)snprintf(text + at, sizeof text - (size_t)at, "]}");
    return text;
}

static double expected(int j, int i, double t, double w)
{
    double sum = 0.0;
    for (int k = 0; k < 6; k++) {
        for (int l = 0; l < 8; l++) {
            sum += coefficient(j, i, k, l) * pow(t, k) * pow(w, l);
        }
    }
    return sum;
}

static const char by_turn[] = "\"angle\": \"turn\"";
static const char by_joint[] = "\"angle\": \"joint\", \"joint_turn\": {\"breaks_mm\": [0, 20],"
                               "\"coefficients\": [[0, 0, 0.001, 0.12]]}";

static void test_pieces_of_a_whole_turn(void)
{
    TEST_ASSERT_TRUE(read(make(by_turn, "[0, 0.25, 1]", 2, "[0, 5, 20]", 2)));
    const double turn[] = {0.0, 0.1, 0.2499, 0.25, 0.7, 0.999};
    const double z_mm[] = {0.0, 2.5, 5.0, 19.0, 20.0, 3.0};
    for (int q = 0; q < 36; q++) {
        const double at = turn[q % 6];
        const double z = z_mm[q / 6];
        const int i = at < 0.25 ? 0 : 1;
        const int j = z < 5.0 ? 0 : 1;
        const double t = i == 0 ? at / 0.25 : (at - 0.25) / 0.75;
        const double w = j == 0 ? z / 5.0 : (z - 5.0) / 15.0;
        const double found = sim_surface_delta_mm(&surface, at, z);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, expected(j, i, t, w), found);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, found, sim_surface_delta_mm(&surface, at - 3.0, z));
    }
    const double low = sim_surface_delta_mm(&surface, 0.3, 0.0); // heights outside are clamped
    const double high = sim_surface_delta_mm(&surface, 0.3, 20.0);
    TEST_ASSERT_EQUAL_DOUBLE(low, sim_surface_delta_mm(&surface, 0.3, -7.0));
    TEST_ASSERT_EQUAL_DOUBLE(high, sim_surface_delta_mm(&surface, 0.3, 99.0));
}

static void test_joint_moves_with_the_height_and_quadrants_are_mirrored(void)
{
    TEST_ASSERT_TRUE(read(make(by_joint, "[0, 1, 2]", 2, "[0, 20]", 1)));
    for (int q = 0; q < 200; q++) {
        const double z = 20.0 * q / 199.0;
        const double at = fmod(q * 0.0391, 0.25);
        const double joint = 0.12 + 0.001 * z;
        const int i = at < joint ? 0 : 1;
        const double t = i == 0 ? at / joint : (at - joint) / (0.25 - joint);
        const double wanted = expected(0, i, t, z / 20.0);
        const double turned[] = {at, 0.5 - at, 0.5 + at, 1.0 - at};
        for (int k = 0; k < 4; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, wanted, sim_surface_delta_mm(&surface, turned[k], z));
        }
    }
}

enum { n_breaks = 96 };

/// Sections of f = (1 + 0.1 z + 0.02 z^2) cos(2 phi) at three heights, given by knots.
static const char *make_sections(const char *slopes)
{
    static const double z_mm[] = {0.0, 5.0, 20.0};
    int at = snprintf(text, sizeof text,
                      "{\"angle\": \"turn\", \"breaks_mm\": [0, 5, 20], \"breaks\": [");
    for (int i = 0; i <= n_breaks; i++) {
        at += snprintf(text + at, sizeof text - (size_t)at, "%s%.17g", i > 0 ? "," : "",
                       (double)i / n_breaks);
    }
    for (int part = 0; part < (slopes != NULL ? 2 : 1); part++) {
        at += snprintf(text + at, sizeof text - (size_t)at, "], \"%s\": [",
                       part == 0 ? "knots" : slopes);
        for (int q = 0; q < 3 * n_breaks; q++) {
            const double z = z_mm[q / n_breaks];
            const double a = part == 0 ? 1.0 + 0.1 * z + 0.02 * z * z : 0.1 + 0.04 * z;
            const double w = 2.0 * SIM_TWO_PI;
            const double phi = w * (q % n_breaks) / n_breaks;
            at +=
                snprintf(text + at, sizeof text - (size_t)at, "%s%.17g,%.17g,%.17g",
                         q > 0 ? "," : "", a * cos(phi), -a * w * sin(phi), -a * w * w * cos(phi));
        }
    }
    (void)snprintf(text + at, sizeof text - (size_t)at, "]}");
    return text;
}

/// The quintic errs by (4 pi / 96)^6 / 46080 = 1e-10 of the amplitude, the cubic is exact. Without
/// slopes straight lines join the sections.
static void test_sections_are_given_by_knots(void)
{
    TEST_ASSERT_TRUE_MESSAGE(read(make_sections("slopes")), error.text);
    for (int q = 0; q < 400; q++) {
        const double turn = fmod(q * 0.617, 1.0);
        const double z = 20.0 * q / 399.0;
        const double a = 1.0 + 0.1 * z + 0.02 * z * z;
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, a * cos(2.0 * SIM_TWO_PI * turn),
                                  sim_surface_delta_mm(&surface, turn, z));
    }
    sim_surface_free(&surface);
    TEST_ASSERT_TRUE_MESSAGE(read(make_sections(NULL)), error.text);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0 + 0.5 * 1.0, sim_surface_delta_mm(&surface, 0.0, 2.5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -(2.0 + 9.0 / 3.0),
                              sim_surface_delta_mm(&surface, 0.25, 10.0));
}

static void refused(const char *json, const char *field)
{
    TEST_ASSERT_FALSE(read(json));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, "part.json: design.surface"), error.text);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, field), error.text);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, "; make the table again"), error.text);
    sim_surface_free(&surface);
}

static void test_malformed_surfaces_are_refused_by_field(void)
{
    refused("5", "is missing");
    refused("{}", "angle = \"?\"");
    refused(make("\"angle\": \"polar\"", "[0, 1]", 1, "[0, 1]", 1), "angle = \"polar\"");
    refused(make("\"angle\": \"joint\"", "[0, 1, 2]", 2, "[0, 1]", 1), "joint_turn.breaks_mm");
    refused(make("\"angle\": \"joint\", \"joint_turn\": {\"breaks_mm\": [0, 1],"
                 "\"coefficients\": [[0, 0, 0, 0.25]]}",
                 "[0, 1, 2]", 2, "[0, 1]", 1),
            "0.25 is outside");
    refused(make(by_turn, "[0, 2]", 1, "[0, 1]", 1), "breaks: must be rising numbers from 0 to 1");
    refused(make(by_turn, "[0, 0.5, 0.5, 1]", 3, "[0, 1]", 1), "breaks: must be");
    refused(make(by_turn, "[0, 1]", 1, "[1]", 1), "breaks_mm");
    refused(make(by_turn, "[0, 1]", 1, "[0, \"a\"]", 1), "breaks_mm");
    refused(make(by_turn, "[0, 1]", 1, "[0, 1, 2]", 1), "coefficients: must be 96 finite numbers");
    refused("{\"angle\": \"turn\", \"breaks\": [0, 1], \"breaks_mm\": [0, 1],"
            "\"coefficients\": [1, null]}",
            "coefficients: must be 48");
    refused("{\"angle\": \"turn\", \"breaks\": [0, 1], \"breaks_mm\": [0, 1], \"knots\": [1, 2]}",
            "design.surface.knots: must be 6");
    refused("{\"angle\": \"turn\", \"breaks\": [0, 1], \"breaks_mm\": [0, 1], "
            "\"knots\": [1, 0, 0, 1, 0, 0], \"slopes\": [0]}",
            "design.surface.slopes: must be 6");
}
