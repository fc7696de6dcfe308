// SPDX-License-Identifier: Apache-2.0
#include "compare_table.h"
#include "compare_surface.h"
#include "fixture_image.h"
#include "unity.h"
#include <stdlib.h> // malloc

#define PI 3.14159265358979323846

static void *memory;

static void *take(uint32_t bytes)
{
    compare_table_release();
    memory = malloc(bytes);
    TEST_ASSERT_NOT_NULL(memory);
    return memory;
}

void compare_table_release(void)
{
    free(memory);
    memory = NULL;
}

static compare_table_t grid(uint32_t n_knots)
{
    const double slices_per_nm = (compare_n_slices - 1) / (double)compare_z_last_nm;
    return (compare_table_t){
        .n_knots = n_knots,
        .n_slices = compare_n_slices,
        .log2_repeat = compare_log2_repeat,
        .span_nm = compare_z_last_nm,
        .slices_per_nm = slices_per_nm,
        .slices_per_nm_float = (float)slices_per_nm,
    };
}

uint32_t compare_table_bytes(const compare_table_t *t)
{
    const size_t knot = t->ours != NULL     ? sizeof *t->ours->knots
                        : t->linear != NULL ? sizeof *t->linear
                        : t->spline != NULL ? sizeof *t->spline
                                            : sizeof *t->quintic;
    return t->n_slices * t->n_knots * (uint32_t)knot;
}

compare_table_t compare_table_ours(void)
{
    static fixture_image_t image;
    static cam_table_t table;
    fixture_part_t part = fixture_part_short();
    part.n_slices = compare_n_slices;
    part.log2_knots = compare_log2_knots;
    part.log2_repeat = compare_log2_repeat;
    part.frac_bits = compare_frac_bits;
    part.n_x = 10;
    part.x_frac_bits = 4;
    part.u_offset_nm = compare_largest_oval_nm / 4; // in the middle of the stroke
    part.z_last_nm = compare_z_last_nm;
    part.u = compare_surface;
    part.x = compare_profile;
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    compare_table_t t = grid(1u << compare_log2_knots);
    t.ours = &table.u;
    return t;
}

/// u and its derivatives at a knot.
static void at_knot(const compare_table_t *t, uint32_t i, uint32_t k, double u[3])
{
    compare_surface(PI * k / t->n_knots, i / t->slices_per_nm, u);
}

compare_table_t compare_table_linear(uint32_t n_knots)
{
    compare_table_t t = grid(n_knots);
    double *y = take(compare_n_slices * n_knots * (uint32_t)sizeof *y);
    for (uint32_t j = 0; j < t.n_slices * n_knots; j++) {
        double u[3];
        at_knot(&t, j / n_knots, j % n_knots, u);
        y[j] = u[0];
    }
    t.linear = y;
    return t;
}

/// The periodic spline through one slice: m[k-1] + 4 m[k] + m[k+1] = y[k-1] - 2 y[k] + y[k+1],
/// by Gauss-Seidel sweeps, each of which divides the error by at least two.
static void fit_spline(compare_spline_knot_t *knots, const double *y, double *m, uint32_t n)
{
    enum { n_sweeps = 60 };
    for (uint32_t k = 0; k < n; k++) {
        m[k] = 0.0;
    }
    for (uint32_t j = 0; j < n_sweeps * n; j++) {
        const uint32_t k = j % n;
        const uint32_t before = (k + n - 1u) % n;
        const uint32_t after = (k + 1u) % n;
        m[k] = (y[before] - 2.0 * y[k] + y[after] - m[before] - m[after]) / 4.0;
    }
    for (uint32_t k = 0; k < n; k++) {
        knots[k] = (compare_spline_knot_t){.y = (float)y[k], .m = (float)m[k]};
    }
}

compare_table_t compare_table_spline(uint32_t n_knots)
{
    compare_table_t t = grid(n_knots);
    compare_spline_knot_t *knots = take(compare_n_slices * n_knots * (uint32_t)sizeof *knots);
    double *y = malloc(2u * n_knots * sizeof *y);
    TEST_ASSERT_NOT_NULL(y);
    for (uint32_t i = 0; i < t.n_slices; i++) {
        for (uint32_t k = 0; k < n_knots; k++) {
            double u[3];
            at_knot(&t, i, k, u);
            y[k] = u[0];
        }
        fit_spline(knots + i * n_knots, y, y + n_knots, n_knots);
    }
    free(y);
    t.spline = knots;
    return t;
}

compare_table_t compare_table_quintic(uint32_t n_knots)
{
    compare_table_t t = grid(n_knots);
    compare_quintic_knot_t *knots = take(compare_n_slices * n_knots * (uint32_t)sizeof *knots);
    const double h = PI / n_knots;
    for (uint32_t j = 0; j < t.n_slices * n_knots; j++) {
        double u[3];
        at_knot(&t, j / n_knots, j % n_knots, u);
        knots[j] = (compare_quintic_knot_t){.p = u[0], .v = u[1] * h, .a = u[2] * h * h / 2.0};
    }
    t.quintic = knots;
    return t;
}
