// SPDX-License-Identifier: Apache-2.0
#include "compare_eval.h"

/// Link-time optimisation must neither inline these into the harness nor fit them to one table.
#define COMPARED __attribute__((noipa))

#define PER_Q32 (1.0 / 4294967296.0)

/// An angle between two knots.
typedef struct {
    uint32_t k, k_next;
    uint32_t t_q32;
} angle_t;

static inline angle_t find_angle(const compare_table_t *t, uint32_t theta_q32)
{
    const uint64_t knots_q32 = (uint64_t)(theta_q32 << t->log2_repeat) * t->n_knots;
    const uint32_t k = (uint32_t)(knots_q32 >> 32);
    return (angle_t){
        .k = k,
        .k_next = k + 1u == t->n_knots ? 0u : k + 1u,
        .t_q32 = (uint32_t)knots_q32,
    };
}

static inline uint32_t clamp_nm(const compare_table_t *t, int32_t z_nm)
{
    const uint32_t above_nm = z_nm < 0 ? 0u : (uint32_t)z_nm;
    return above_nm > t->span_nm ? t->span_nm : above_nm;
}

static inline uint32_t lower_slice(const compare_table_t *t, uint32_t i)
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

COMPARED void compare_nothing(const compare_table_t *t, uint32_t theta_q32, int32_t z_nm,
                              compare_value_t *value)
{
    (void)t;
    (void)theta_q32;
    (void)z_nm;
    (void)value;
}

COMPARED void compare_ours(const compare_table_t *t, uint32_t theta_q32, int32_t z_nm,
                           compare_value_t *value)
{
    value->ours = cam_eval_surface_at(t->ours, theta_q32, cam_eval_height(t->ours, z_nm));
}

COMPARED void compare_linear(const compare_table_t *t, uint32_t theta_q32, int32_t z_nm,
                             compare_value_t *value)
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

static inline compare_spline_knot_t mix_spline(const compare_spline_knot_t *low,
                                               const compare_spline_knot_t *high, float w)
{
    return (compare_spline_knot_t){
        .y = mix_float(low->y, high->y, w),
        .m = mix_float(low->m, high->m, w),
    };
}

COMPARED void compare_spline(const compare_table_t *t, uint32_t theta_q32, int32_t z_nm,
                             compare_value_t *value)
{
    const angle_t at = find_angle(t, theta_q32);
    const float slice = (float)clamp_nm(t, z_nm) * t->slices_per_nm_float;
    const uint32_t i = lower_slice(t, (uint32_t)slice);
    const float w = slice - (float)i;
    const compare_spline_knot_t *low = t->spline + i * t->n_knots;
    const compare_spline_knot_t *high = low + t->n_knots;
    const compare_spline_knot_t k0 = mix_spline(low + at.k, high + at.k, w);
    const compare_spline_knot_t k1 = mix_spline(low + at.k_next, high + at.k_next, w);
    const float x = (float)at.t_q32 * (float)PER_Q32;
    const float c1 = k1.y - k0.y - (2.0f * k0.m + k1.m);
    const float c2 = 3.0f * k0.m;
    const float c3 = k1.m - k0.m;
    value->single[0] = k0.y + x * (c1 + x * (c2 + x * c3));
    value->single[1] = c1 + x * (2.0f * c2 + x * (3.0f * c3));
    value->single[2] = 2.0f * c2 + x * (6.0f * c3);
}

static inline compare_quintic_knot_t mix_quintic(const compare_quintic_knot_t *low,
                                                 const compare_quintic_knot_t *high, double w)
{
    return (compare_quintic_knot_t){
        .p = mix(low->p, high->p, w),
        .v = mix(low->v, high->v, w),
        .a = mix(low->a, high->a, w),
    };
}

COMPARED void compare_quintic(const compare_table_t *t, uint32_t theta_q32, int32_t z_nm,
                              compare_value_t *value)
{
    const angle_t at = find_angle(t, theta_q32);
    const double slice = clamp_nm(t, z_nm) * t->slices_per_nm;
    const uint32_t i = lower_slice(t, (uint32_t)slice);
    const double w = slice - i;
    const compare_quintic_knot_t *low = t->quintic + i * t->n_knots;
    const compare_quintic_knot_t *high = low + t->n_knots;
    const compare_quintic_knot_t k0 = mix_quintic(low + at.k, high + at.k, w);
    const compare_quintic_knot_t k1 = mix_quintic(low + at.k_next, high + at.k_next, w);
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
