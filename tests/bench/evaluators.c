// SPDX-License-Identifier: Apache-2.0
// The firmware's evaluation of a surface and three in plain C: the same surface, inputs, compiler
// and emulated core. Prints a table in Markdown. Run by hand:
//
//     cmake --build --preset mcu-qemu --target evaluators
//
// Each clamps the height and blends the knots of two slices linearly before it interpolates over
// the angle. The others find their interval by one 32 x 32 bit multiplication, so that any number
// of knots serves.
#include "budget_count.h"
#include "cam_eval.h"
#include "fixture_image.h"
#include "fixture_random.h"
#include <math.h>   // fabs, sin, cos, sqrt
#include <stdio.h>  // printf
#include <stdlib.h> // EXIT_SUCCESS

#define PI 3.14159265358979323846

enum {
    n_inputs = 16384,
    n_slices = 32,           ///< 2 mm apart: the bend of the ovality is on one
    z_last_nm = 62000000,    ///< heights are 0 .. this
    log2_repeat = 1,         ///< an ellipse is the same after half a turn
    largest_oval_nm = 300000 ///< diametral
};
enum { log2_knots = 3, frac_bits = 8 }; ///< what tools/mktables chooses for 1 nm

/// Knot of a cubic spline.
typedef struct {
    float y; ///< [nm]
    float m; ///< second derivative * h^2 / 6, h = one knot interval
} spline_knot_t;

/// Knot of a quintic: those of cam_knot_t in nm.
typedef struct {
    double p, v, a;
} quintic_knot_t;

/// A surface, and the largest of its tables.
typedef struct {
    const cam_channel_t *ours;
    uint32_t n_knots; ///< of half a turn
    uint32_t n_slices, log2_repeat, span_nm;
    double slices_per_nm;
    float slices_per_nm_float;
    union {
        double linear[1 << 16]; ///< [nm]
        spline_knot_t spline[1 << 12];
        quintic_knot_t quintic[1 << 12];
    };
} table_t;

/// Value and derivatives per knot interval, in the way's own type.
typedef union {
    cam_value_t ours; ///< [LSB]
    float single[3];  ///< [nm]
    double twice[3];  ///< [nm]; linear: value only
} value_t;

typedef void eval_t(const table_t *t, uint32_t theta_q32, int32_t z_nm, value_t *value);

static table_t table = {
    .n_slices = n_slices,
    .log2_repeat = log2_repeat,
    .span_nm = z_last_nm,
    .slices_per_nm = (n_slices - 1) / (double)z_last_nm,
    .slices_per_nm_float = (n_slices - 1) / (float)z_last_nm,
};

/// Link-time optimisation must neither inline these into the harness nor fit them to one table.
#define COMPARED __attribute__((noipa))

#define PER_Q32 (1.0 / 4294967296.0)

/// An angle between two knots.
typedef struct {
    uint32_t k, k_next;
    uint32_t t_q32;
} angle_t;

static inline angle_t find_angle(const table_t *t, uint32_t theta_q32)
{
    const uint64_t knots_q32 = (uint64_t)(theta_q32 << t->log2_repeat) * t->n_knots;
    const uint32_t k = (uint32_t)(knots_q32 >> 32);
    return (angle_t){
        .k = k,
        .k_next = k + 1u == t->n_knots ? 0u : k + 1u,
        .t_q32 = (uint32_t)knots_q32,
    };
}

static inline uint32_t clamp_nm(const table_t *t, int32_t z_nm)
{
    const uint32_t above_nm = z_nm < 0 ? 0u : (uint32_t)z_nm;
    return above_nm > t->span_nm ? t->span_nm : above_nm;
}

static inline uint32_t lower_slice(const table_t *t, uint32_t i)
{
    return i > t->n_slices - 2u ? t->n_slices - 2u : i;
}

static inline double mix(double a, double b, double w)
{
    return a + (b - a) * w;
}

static inline float mix_float(float a, float b, float w)
{
    return a + (b - a) * w;
}

static COMPARED void eval_nothing(const table_t *t, uint32_t theta_q32, int32_t z_nm,
                                  value_t *value)
{
    (void)t;
    (void)theta_q32;
    (void)z_nm;
    (void)value;
}

static COMPARED void eval_ours(const table_t *t, uint32_t theta_q32, int32_t z_nm, value_t *value)
{
    value->ours = cam_eval_surface_at(t->ours, theta_q32, cam_eval_height(t->ours, z_nm));
}

static COMPARED void eval_linear(const table_t *t, uint32_t theta_q32, int32_t z_nm, value_t *value)
{
    const angle_t at = find_angle(t, theta_q32);
    const double slice = clamp_nm(t, z_nm) * t->slices_per_nm;
    const uint32_t i = lower_slice(t, (uint32_t)slice);
    const double w = slice - i;
    const double *low = t->linear + i * t->n_knots;
    const double *high = low + t->n_knots;
    const double u0 = mix(low[at.k], high[at.k], w);
    const double u1 = mix(low[at.k_next], high[at.k_next], w);
    value->twice[0] = mix(u0, u1, at.t_q32 * PER_Q32);
}

static inline spline_knot_t mix_spline(const spline_knot_t *low, const spline_knot_t *high, float w)
{
    return (spline_knot_t){
        .y = mix_float(low->y, high->y, w),
        .m = mix_float(low->m, high->m, w),
    };
}

static COMPARED void eval_spline(const table_t *t, uint32_t theta_q32, int32_t z_nm, value_t *value)
{
    const angle_t at = find_angle(t, theta_q32);
    const float slice = (float)clamp_nm(t, z_nm) * t->slices_per_nm_float;
    const uint32_t i = lower_slice(t, (uint32_t)slice);
    const float w = slice - (float)i;
    const spline_knot_t *low = t->spline + i * t->n_knots;
    const spline_knot_t *high = low + t->n_knots;
    const spline_knot_t k0 = mix_spline(low + at.k, high + at.k, w);
    const spline_knot_t k1 = mix_spline(low + at.k_next, high + at.k_next, w);
    const float x = (float)at.t_q32 * (float)PER_Q32;
    const float c1 = k1.y - k0.y - (2.0f * k0.m + k1.m);
    const float c2 = 3.0f * k0.m;
    const float c3 = k1.m - k0.m;
    value->single[0] = k0.y + x * (c1 + x * (c2 + x * c3));
    value->single[1] = c1 + x * (2.0f * c2 + x * (3.0f * c3));
    value->single[2] = 2.0f * c2 + x * (6.0f * c3);
}

static inline quintic_knot_t mix_quintic(const quintic_knot_t *low, const quintic_knot_t *high,
                                         double w)
{
    return (quintic_knot_t){
        .p = mix(low->p, high->p, w),
        .v = mix(low->v, high->v, w),
        .a = mix(low->a, high->a, w),
    };
}

static COMPARED void eval_quintic(const table_t *t, uint32_t theta_q32, int32_t z_nm,
                                  value_t *value)
{
    const angle_t at = find_angle(t, theta_q32);
    const double slice = clamp_nm(t, z_nm) * t->slices_per_nm;
    const uint32_t i = lower_slice(t, (uint32_t)slice);
    const double w = slice - i;
    const quintic_knot_t *low = t->quintic + i * t->n_knots;
    const quintic_knot_t *high = low + t->n_knots;
    const quintic_knot_t k0 = mix_quintic(low + at.k, high + at.k, w);
    const quintic_knot_t k1 = mix_quintic(low + at.k_next, high + at.k_next, w);
    const double x = at.t_q32 * PER_Q32;
    const double dp = k1.p - k0.p - k0.v - k0.a;
    const double dv = k1.v - k0.v - 2.0 * k0.a;
    const double da = k1.a - k0.a;
    const double c3 = 10.0 * dp - 4.0 * dv + da;
    const double c4 = -15.0 * dp + 7.0 * dv - 2.0 * da;
    const double c5 = 6.0 * dp - 3.0 * dv + da;
    value->twice[0] = k0.p + x * (k0.v + x * (k0.a + x * (c3 + x * (c4 + x * c5))));
    value->twice[1] = k0.v + x * (2.0 * k0.a + x * (3.0 * c3 + x * (4.0 * c4 + x * (5.0 * c5))));
    value->twice[2] = 2.0 * k0.a + x * (6.0 * c3 + x * (12.0 * c4 + x * (20.0 * c5)));
}

/// Long half axis [nm] over height [nm], first and second derivative.
static void profile(double z_nm, double x[3])
{
    const double above_nm = z_nm - 20e6;
    x[0] = 46e6 - 7.5e-11 * above_nm * above_nm;
    x[1] = -1.5e-10 * above_nm;
    x[2] = -1.5e-10;
}

static double oval_nm(double z_nm)
{
    return z_nm < 20e6 ? 150e3 + z_nm * (50e3 / 20e6) : 200e3 + (z_nm - 20e6) * (100e3 / 42e6);
}

/// u [nm] over angle [rad] and height [nm], first and second derivative to the angle, MATHS.md (2).
/// Like tools/parts/perkins240.toml.
static void surface(double theta, double z_nm, double u[3])
{
    double x[3];
    profile(z_nm, x);
    const double a = x[0];
    const double b = a - oval_nm(z_nm) / 2.0;
    const double k = (a - b) * (a + b) / (b * b);
    const double s = sin(theta);
    const double c = cos(theta);
    const double w = 1.0 + k * s * s;
    const double w1 = 2.0 * k * s * c;
    const double w2 = 2.0 * k * (c * c - s * s);
    const double q = sqrt(w);
    u[0] = a * k * s * s / (q * (q + 1.0));
    u[1] = a * w1 / (2.0 * w * q);
    u[2] = a * (w2 / (2.0 * w * q) - 0.75 * w1 * w1 / (w * w * q));
}

static double at_knot(uint32_t i, uint32_t k, double u[3])
{
    surface(PI * k / table.n_knots, i / table.slices_per_nm, u);
    return u[0];
}

static void make_ours(void)
{
    static fixture_image_t image;
    static cam_table_t checked;
    fixture_part_t part = fixture_part_short();
    part.n_slices = n_slices;
    part.log2_knots = log2_knots;
    part.log2_repeat = log2_repeat;
    part.frac_bits = frac_bits;
    part.n_x = 10;
    part.x_frac_bits = 4;
    part.u_offset_nm = largest_oval_nm / 4; // in the middle of the stroke
    part.z_last_nm = z_last_nm;
    part.u = surface;
    part.x = profile;
    fixture_image_make(&image, &part);
    if (cam_table_check(image.bytes, image.size, &checked) == cam_ok) {
        table.ours = &checked.u;
    }
}

static void make_linear(void)
{
    double u[3];
    for (uint32_t j = 0; j < n_slices * table.n_knots; j++) {
        table.linear[j] = at_knot(j / table.n_knots, j % table.n_knots, u);
    }
}

/// The periodic spline through each slice: m[k-1] + 4 m[k] + m[k+1] = y[k-1] - 2 y[k] + y[k+1], by
/// Gauss-Seidel sweeps, each of which divides the error by at least two.
static void make_spline(void)
{
    enum { n_sweeps = 60 };
    static double y[1 << 10], m[1 << 10];
    const uint32_t n = table.n_knots;
    for (uint32_t i = 0; i < n_slices; i++) {
        double u[3];
        for (uint32_t k = 0; k < n; k++) {
            y[k] = at_knot(i, k, u);
            m[k] = 0.0;
        }
        for (uint32_t j = 0; j < n_sweeps * n; j++) {
            const uint32_t k = j % n;
            const uint32_t before = (k + n - 1u) % n;
            const uint32_t after = (k + 1u) % n;
            m[k] = (y[before] - 2.0 * y[k] + y[after] - m[before] - m[after]) / 4.0;
        }
        for (uint32_t k = 0; k < n; k++) {
            table.spline[i * n + k] = (spline_knot_t){.y = (float)y[k], .m = (float)m[k]};
        }
    }
}

static void make_quintic(void)
{
    const double h = PI / table.n_knots;
    for (uint32_t j = 0; j < n_slices * table.n_knots; j++) {
        double u[3];
        (void)at_knot(j / table.n_knots, j % table.n_knots, u);
        table.quintic[j] = (quintic_knot_t){.p = u[0], .v = u[1] * h, .a = u[2] * h * h / 2.0};
    }
}

static void read_ours(const value_t *value, double u[3])
{
    const double lsb_nm = 1.0 / (double)(1u << table.ours->frac_bits);
    u[0] = value->ours.y * lsb_nm + table.ours->value_offset;
    u[2] = value->ours.d2 * lsb_nm;
}

static void read_single(const value_t *value, double u[3])
{
    u[0] = (double)value->single[0];
    u[2] = (double)value->single[2];
}

static void read_twice(const value_t *value, double u[3])
{
    u[0] = value->twice[0];
    u[2] = value->twice[2];
}

typedef struct {
    const char *name;
    eval_t *eval;
    void (*make)(void);
    void (*read)(const value_t *value, double u[3]); ///< value, second derivative
    uint32_t knot_bytes;
} way_t;

/// One code for all, so that its own instructions cancel.
static COMPARED uint32_t count(eval_t *eval, uint32_t theta_q32, int32_t z_nm, value_t *value)
{
    const uint32_t from = budget_count();
    eval(&table, theta_q32, z_nm, value);
    return budget_instructions(from, budget_count());
}

/// Print all inputs by one way; what the call itself costs is taken off. @return [nm] its error
static double row(const way_t *way, uint32_t n_knots)
{
    table.n_knots = n_knots;
    way->make();
    const double per_rad = n_knots / PI;
    value_t value = {.twice = {0}};
    const uint32_t per_call = count(eval_nothing, 0, 0, &value);
    uint32_t least = UINT32_MAX, most = 0;
    double error_nm = 0.0, error2_nm = 0.0;
    fixture_random_t dice = {.state = 5};
    for (uint32_t i = 0; i < n_inputs; i++) {
        const uint32_t theta_q32 = fixture_random_u32(&dice);
        const int32_t z_nm = (int32_t)fixture_random_range(&dice, -1000, z_last_nm + 1000);
        double exact[3], u[3];
        surface(theta_q32 * (PI / 2147483648.0), clamp_nm(&table, z_nm), exact);
        const uint32_t n = count(way->eval, theta_q32, z_nm, &value) - per_call;
        way->read(&value, u);
        least = n < least ? n : least;
        most = n > most ? n : most;
        error_nm = fmax(error_nm, fabs(u[0] - exact[0]));
        error2_nm = fmax(error2_nm, fabs(u[2] * per_rad * per_rad - exact[2]));
    }
    printf("| %s | %lu | %lu | %.3f | %.3f | %lu .. %lu |\n", way->name, (unsigned long)n_knots,
           (unsigned long)(n_slices * n_knots * way->knot_bytes), error_nm,
           100.0 * error2_nm / largest_oval_nm, (unsigned long)least, (unsigned long)most);
    return error_nm;
}

/// The other ways with our bytes, and with the knots that our error takes by the laws of their
/// error: h^2 / 8 times the second and h^4 / 384 times the fourth derivative.
int main(void)
{
    static const way_t ours = {"ours: quintic, int32", eval_ours, make_ours, read_ours, 12};
    static const way_t linear = {"linear, double", eval_linear, make_linear, read_twice, 8};
    static const way_t spline = {"cubic spline, float", eval_spline, make_spline, read_single, 8};
    static const way_t quintic = {"quintic, double", eval_quintic, make_quintic, read_twice, 24};
    budget_count_start();
    printf(
        "| evaluation | knots of a slice | bytes | error of u, nm | error of u'', %% of its peak "
        "| instructions |\n|---|---|---|---|---|---|\n");
    const uint32_t n_knots = 1u << log2_knots;
    const double error_nm = row(&ours, n_knots);
    (void)row(&linear, n_knots * 12u / 8u);
    (void)row(&linear, (uint32_t)ceil(PI / sqrt(8.0 * error_nm / largest_oval_nm)));
    (void)row(&spline, n_knots * 12u / 8u);
    (void)row(&spline, (uint32_t)ceil(PI / sqrt(sqrt(96.0 * error_nm / largest_oval_nm))));
    (void)row(&quintic, n_knots);
    return EXIT_SUCCESS;
}
