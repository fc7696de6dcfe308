// SPDX-License-Identifier: Apache-2.0
#include "cam_eval.h" // cam_eval_surface_at
#include "fixture_image.h"
#include "sim_design.h"
#include "sim_units.h" // SIM_PI
#include "unity.h"
#include <math.h>   // cos, fabs, sin
#include <stdio.h>  // fopen
#include <string.h> // strstr

static fixture_image_t image;
static cam_table_t table;
static sim_design_t design;
static common_error_t error;
static const char path[] = "test_sim_design.json";

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
}

void tearDown(void)
{
    (void)remove(path);
}

static const char radius[] =
    "{\"breaks_mm\": [0, 10, 20], \"coefficients\": [[0, 0, 0.1, 45], [0, -0.01, 0.1, 46]]}";
static const char ovality[] = "{\"breaks_mm\": [0, 20], \"coefficients\": [[0, 0, 0, 0.2]]}";

/// Write a report of this table. @param more  what follows the design
static void write_report(const char *shape, const char *a, const char *g, const char *more)
{
    FILE *f = fopen(path, "w");
    TEST_ASSERT_NOT_NULL(f);
    (void)fprintf(f,
                  "{\"table_crc32\": %u, \"design\": {\"shape\": \"%s\", \"beta\": 0.5,"
                  "\"radius_mm\": %s, \"ovality_mm\": %s}%s}",
                  (unsigned)table.crc32, shape, a, g, more);
    TEST_ASSERT_EQUAL_INT(0, fclose(f));
}

/// Write a report of an ellipse-arc section: half axis 45.4645484572, G 0.38 at all heights.
static void write_arc(const char *base, const char *joint_turn, const char *more)
{
    char g[600];
    (void)snprintf(
        g, sizeof g,
        "{\"breaks_mm\": [0, 20], \"coefficients\": [[0, 0, 0, 0.38]]}, \"base\": \"%s\", "
        "\"trim_mm\": {\"breaks_mm\": [0, 20], \"coefficients\": [[0, 0, 0, 0.4]]}, "
        "\"joint_turn\": {\"breaks_mm\": [0, 20], \"coefficients\": [[0, 0, 0, %s]]}",
        base, joint_turn);
    write_report("ellipse-arc",
                 "{\"breaks_mm\": [0, 20], \"coefficients\": [[0, 0, 0, 45.4645484572]]}", g, more);
}

static bool load(void)
{
    return sim_design_load(&design, path, &table, &error);
}

/// Worked values of MATHS.md (2): a = 46, G = 0.2.
static void test_delta_has_the_published_values(void)
{
    static const sim_shape_t shapes[] = {sim_shape_ellipse, sim_shape_cosine,
                                         sim_shape_double_ellipse, sim_shape_double_ellipse};
    static const double betas[] = {0, 0, 1, -1};
    static const double golden[][5] = {
        {0, 0, 0, 0, 0},
        {10, 0.003024932, 0.003015369, 0.003483280, 0.002547458},
        {15, 0.006719165, 0.006698730, 0.007698730, 0.005698730},
        {30, 0.025061263, 0.025000000, 0.028000000, 0.022000000},
        {45, 0.050081610, 0.050000000, 0.054000000, 0.046000000},
        {60, 0.075061152, 0.075000000, 0.078000000, 0.072000000},
        {75, 0.093321641, 0.093301270, 0.094301270, 0.092301270},
        {90, 0.1, 0.1, 0.1, 0.1},
    };
    for (size_t i = 0; i < sizeof golden / sizeof golden[0]; i++) {
        const double s = sin(golden[i][0] * SIM_PI / 180.0);
        for (int k = 0; k < 4; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(6e-10, golden[i][1 + k],
                                      sim_design_delta_mm(shapes[k], betas[k], 46, 0.2, s * s));
        }
    }
}

/// A tiny ovality: the cosine form is then exact to 3 G^2 / 32 a, and the plain formula would lose
/// digits.
static void test_delta_of_a_tiny_ovality_keeps_its_digits(void)
{
    const double g = 1e-9;
    const double delta = sim_design_delta_mm(sim_shape_ellipse, 0, 46, g, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-20, g / 4, delta);
}

static void test_load_evaluates_piecewise_cubics_and_clamps(void)
{
    static const double long_mm[][2] = {{5, 45.5}, {15, 46.25}, {10, 46.0}, {-1, 45.0}, {21, 46.0}};
    write_report("cosine", radius, ovality, "");
    TEST_ASSERT_TRUE_MESSAGE(load(), error.text);
    for (int i = 0; i < 5; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, long_mm[i][1], sim_design_long_mm(&design, long_mm[i][0]));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 45.4, sim_design_radius_mm(&design, 0.25, 5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 45.4, sim_design_radius_mm(&design, 0.75, 5));
    sim_design_free(&design);
}

static void expect_refusal(const char *why)
{
    TEST_ASSERT_FALSE(load());
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, why), error.text);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, path), error.text);
}

static void test_load_refuses_what_is_wrong(void)
{
    static const struct {
        const char *shape, *a, *g, *why;
    } rows[] = {
        {"square", radius, ovality, "design.shape"},
        {"ellipse-arc", radius, ovality, "design.base"},
        {"cosine", "{}", ovality, "design.radius_mm.breaks_mm"},
        {"cosine", radius, "{\"breaks_mm\": [0, 0], \"coefficients\": [[0,0,0,0]]}",
         "design.ovality_mm.breaks_mm"},
        {"cosine", radius, "{\"breaks_mm\": [0, 1], \"coefficients\": [[0,0,0]]}",
         "design.ovality_mm.coefficients"},
        {"cosine", radius, "{\"breaks_mm\": [0, 1], \"coefficients\": [[0,0,0,1e999]]}",
         "design.ovality_mm.coefficients"},
        {"cosine", radius, "", "not JSON"},
    };
    expect_refusal("cannot be opened");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        write_report(rows[i].shape, rows[i].a, rows[i].g, "");
        expect_refusal(rows[i].why);
    }
    write_arc("square", "0.13", "");
    expect_refusal("design.base = \"square\"");
    write_report("cosine", radius, ovality, "");
    table.crc32++;
    expect_refusal("table_crc32");
}

/// Table in double against the firmware's fixed point: within an LSB of each channel.
static void test_table_design_is_what_the_firmware_plays(void)
{
    sim_design_from_table(&design, &table);
    for (int i = 0; i < 5000; i++) {
        const double turn = i * 0.000199;
        const int32_t z_nm = (int32_t)(i * 200);
        const uint32_t theta = (uint32_t)(turn * 4294967296.0);
        const cam_value_t u = cam_eval_surface_at(&table.u, theta, cam_eval_height(&table.u, z_nm));
        const cam_value_t x = cam_eval_profile(&table.x, z_nm);
        const double u_nm = table.u.value_offset + ldexp(u.y, -(int)table.u.frac_bits);
        const double x_nm = table.x.value_offset + ldexp(x.y, -(int)table.x.frac_bits);
        const double lsb =
            ldexp(1.0, -(int)table.u.frac_bits) + ldexp(1.0, -(int)table.x.frac_bits);
        TEST_ASSERT_DOUBLE_WITHIN(lsb + 1e-3, x_nm - u_nm,
                                  1e6 * sim_design_radius_mm(&design, turn, z_nm * 1e-6));
    }
}

/// Reductions printed in the refit paper's section: 0.104930204 at the joint of 48 degrees, 0.59 at
/// the short axis; the circle has the radius 46.834548457 about (0, -1.96).
static void test_arc_has_the_published_values(void)
{
    write_arc("cosine", "0.133333333333333", "");
    TEST_ASSERT_TRUE_MESSAGE(load(), error.text);
    const double a = 45.4645484572;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, a, sim_design_radius_mm(&design, 0.0, 5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, a - 0.59, sim_design_radius_mm(&design, 0.25, 5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, a - 0.104930204,
                              sim_design_radius_mm(&design, 48.0 / 360.0, 5));
    for (int deg = 0; deg < 360; deg++) { // on the oval or on the circle, in all quadrants
        const double phi = deg * SIM_PI / 180.0;
        const double r = sim_design_radius_mm(&design, deg / 360.0, 5);
        const double x = fabs(r * cos(phi));
        const double y = fabs(r * sin(phi));
        const double circle = sqrt(x * x + (y + 1.96) * (y + 1.96)) - 46.834548457;
        const double oval = r - (a - 0.095 * (1.0 - cos(2.0 * phi)));
        const bool is_oval = fabs(sin(phi)) < sin(47.9 * SIM_PI / 180.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.0, is_oval ? oval : circle);
    }
    sim_design_free(&design);
}

static void test_target_is_read_beside_the_drawing(void)
{
    static sim_design_t target;
    bool is_there = true;
    write_arc("cosine", "0.13", "");
    TEST_ASSERT_TRUE(sim_design_load_target(&target, &is_there, path, &table, &error));
    TEST_ASSERT_FALSE(is_there);
    char played[400];
    (void)snprintf(played, sizeof played,
                   ", \"target\": {\"shape\": \"cosine\", \"radius_mm\": %s, \"ovality_mm\": %s}",
                   radius, ovality);
    write_arc("cosine", "0.13", played);
    TEST_ASSERT_TRUE(sim_design_load_target(&target, &is_there, path, &table, &error));
    TEST_ASSERT_TRUE(is_there);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 45.4, sim_design_radius_mm(&target, 0.25, 5));
    sim_design_free(&target);
    write_arc("cosine", "0.13", ", \"target\": {\"shape\": \"surface\"}");
    TEST_ASSERT_FALSE(sim_design_load_target(&target, &is_there, path, &table, &error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, "target.radius_mm"), error.text);
}
