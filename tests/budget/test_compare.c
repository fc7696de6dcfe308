// SPDX-License-Identifier: Apache-2.0
// Our evaluation beside plain C of others: the same surface, inputs, compiler and core. Prints a
// table in Markdown; only ours is held to limits.
#include "budget_count.h"
#include "compare_surface.h"
#include "compare_table.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h>  // fabs, sqrt
#include <stdio.h> // printf

#define TWO_PI 6.28318530717958647693

#ifdef __ARM_ARCH_7EM__
#if __ARM_FP & 8
#define CORE "Cortex-M7"
#else
#define CORE "Cortex-M4"
#endif
#endif

enum {
    n_random = 16384,
    n_edge_angles = 56, ///< around 32 angles of a turn, and the ends
    n_edge_heights = 40,
    n_samples = n_random + n_edge_angles * n_edge_heights,
};

/// Our error: 1 LSB of cam_eval.h, half an LSB of stored knots, 0.36 nm of eight knots to an oval
/// (h^6 / 46080 times the sixth derivative), 0.01 nm of the ovality between two slices.
#define OUR_ERROR_NM (1.5 / (1 << compare_frac_bits) + 0.37)

/// Instructions between the shortest and the longest of our evaluations: branches of clamping.
enum { our_spread = 12 };

typedef struct {
    uint32_t theta_q32;
    int32_t z_nm;
    double u[3]; ///< exact, per rad
} sample_t;

typedef struct {
    const char *name;
    compare_fn *eval;
    /// What it returned, in nm and rad; n_values of it are meant.
    void (*read)(const compare_table_t *t, const compare_value_t *value, double u[3]);
    int n_values;
} way_t;

typedef struct {
    uint32_t min, max, sum; ///< [instructions]
    double error_nm;
    double error2_nm; ///< [nm/rad2] of the second derivative
} figures_t;

static sample_t samples[n_samples];
static figures_t ours;

static double rad_per_interval(const compare_table_t *t)
{
    return TWO_PI / (double)(t->n_knots << t->log2_repeat);
}

static void read_ours(const compare_table_t *t, const compare_value_t *value, double u[3])
{
    const double lsb_nm = 1.0 / (double)(1u << t->ours->frac_bits);
    const double per_rad = 1.0 / rad_per_interval(t);
    u[0] = value->ours.y * lsb_nm + t->ours->value_offset;
    u[1] = value->ours.d1 * lsb_nm * per_rad;
    u[2] = value->ours.d2 * lsb_nm * per_rad * per_rad;
}

static void read_single(const compare_table_t *t, const compare_value_t *value, double u[3])
{
    const double per_rad = 1.0 / rad_per_interval(t);
    u[0] = (double)value->single[0];
    u[1] = (double)value->single[1] * per_rad;
    u[2] = (double)value->single[2] * per_rad * per_rad;
}

static void read_twice(const compare_table_t *t, const compare_value_t *value, double u[3])
{
    const double per_rad = 1.0 / rad_per_interval(t);
    u[0] = value->twice[0];
    u[1] = value->twice[1] * per_rad;
    u[2] = value->twice[2] * per_rad * per_rad;
}

static const way_t way_ours = {"ours: quintic, int32", compare_ours, read_ours, 3};
static const way_t way_linear = {"linear, double", compare_linear, read_twice, 1};
static const way_t way_spline = {"cubic spline, float", compare_spline, read_single, 3};
static const way_t way_quintic = {"quintic, double", compare_quintic, read_twice, 3};

static uint32_t edge_angle_q32(uint32_t i)
{
    static const uint32_t ends[] = {1u, UINT32_MAX,  UINT32_MAX - 1u, 0x7FFFFFFFu,
                                    2u, 0x80000001u, 0x0FFFFFFFu,     0x10000001u};
    const uint32_t at_q32 = (i % 32u) << 27; // knots of ours and the middles between them
    return i < 32u ? at_q32 : i < 48u ? (i % 16u << 28) - 1u : ends[i % 8u];
}

static int32_t edge_height_nm(uint32_t i)
{
    static const int32_t ends[] = {
        INT32_MIN, -1, 0, 1, compare_z_last_nm - 1, compare_z_last_nm, compare_z_last_nm + 1,
        INT32_MAX};
    return i < 8u ? ends[i] : (int32_t)((i - 7u) * 1000000u - (i % 3u == 0u));
}

static void fill_samples(void)
{
    fixture_random_t dice = {.state = 5};
    for (uint32_t i = 0; i < n_samples; i++) {
        sample_t *s = &samples[i];
        const uint32_t edge = i - n_random;
        if (i < n_random) {
            s->theta_q32 = fixture_random_u32(&dice);
            s->z_nm = (int32_t)fixture_random_range(&dice, -1000, compare_z_last_nm + 1000);
        } else {
            s->theta_q32 = edge_angle_q32(edge / n_edge_heights);
            s->z_nm = edge_height_nm(edge % n_edge_heights);
        }
        compare_reference(s->theta_q32, s->z_nm, s->u);
    }
}

/// One code for all, so that its own instructions cancel.
static __attribute__((noipa)) uint32_t count(compare_fn *eval, const compare_table_t *t,
                                             const sample_t *s, compare_value_t *value)
{
    const uint32_t from = budget_count();
    eval(t, s->theta_q32, s->z_nm, value);
    return budget_instructions(from, budget_count());
}

/// All samples by one way; what the call itself costs is taken off.
static figures_t measure(const way_t *way, const compare_table_t *t)
{
    compare_value_t value;
    const uint32_t per_call = count(compare_nothing, t, &samples[0], &value);
    figures_t f = {.min = UINT32_MAX};
    for (uint32_t i = 0; i < n_samples; i++) {
        const uint32_t n = count(way->eval, t, &samples[i], &value) - per_call;
        double u[3];
        way->read(t, &value, u);
        f.min = n < f.min ? n : f.min;
        f.max = n > f.max ? n : f.max;
        f.sum += n;
        f.error_nm = fmax(f.error_nm, fabs(u[0] - samples[i].u[0]));
        if (way->n_values > 2) {
            f.error2_nm = fmax(f.error2_nm, fabs(u[2] - samples[i].u[2]));
        }
    }
    return f;
}

static figures_t row(const way_t *way, const compare_table_t *t, const char *why)
{
    const figures_t f = measure(way, t);
    const double peak2_nm = compare_largest_oval_nm; // of u''
    printf("| %s | %s | %s | %lu x %lu | %lu | %.3f | ", way->name,
           way->n_values > 1 ? "u, u', u''" : "u", why, (unsigned long)t->n_slices,
           (unsigned long)t->n_knots, (unsigned long)compare_table_bytes(t), f.error_nm);
    if (way->n_values > 1) {
        printf("%.3f", 100.0 * f.error2_nm / peak2_nm);
    } else {
        printf("-");
    }
    printf(" | %lu .. %lu |\n", (unsigned long)f.min, (unsigned long)f.max);
    return f;
}

void setUp(void) {}

void tearDown(void)
{
    compare_table_release();
}

static void test_ours_is_exact_and_its_counts_repeat(void)
{
    const compare_table_t t = compare_table_ours();
    ours = row(&way_ours, &t, "as mktables makes it");
    const figures_t again = measure(&way_ours, &t);
    TEST_ASSERT_DOUBLE_WITHIN(OUR_ERROR_NM, 0.0, ours.error_nm);
    TEST_ASSERT_EQUAL_UINT32(ours.min, again.min);
    TEST_ASSERT_EQUAL_UINT32(ours.max, again.max);
    TEST_ASSERT_EQUAL_UINT32(ours.sum, again.sum);
    TEST_ASSERT_GREATER_THAN_UINT32(0, ours.min);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(our_spread, ours.max - ours.min);
}

static uint32_t our_bytes(void)
{
    const compare_table_t t = compare_table_ours();
    return compare_table_bytes(&t);
}

/// The other sides: with the bytes of ours, and with what our error needs by the laws of their
/// error, h^2 / 8 times the second and h^4 / 384 times the fourth derivative.
static void test_linear(void)
{
    compare_table_t t =
        compare_table_linear(our_bytes() / compare_n_slices / (uint32_t)sizeof(double));
    (void)row(&way_linear, &t, "our bytes");
    const double h = sqrt(8.0 * ours.error_nm / compare_largest_oval_nm);
    t = compare_table_linear((uint32_t)ceil(TWO_PI / 2.0 / h));
    (void)row(&way_linear, &t, "our error");
}

static void test_spline(void)
{
    compare_table_t t = compare_table_spline(our_bytes() / compare_n_slices /
                                             (uint32_t)sizeof(compare_spline_knot_t));
    (void)row(&way_spline, &t, "our bytes");
    const double h = sqrt(sqrt(384.0 * ours.error_nm / (4.0 * compare_largest_oval_nm)));
    t = compare_table_spline((uint32_t)ceil(TWO_PI / 2.0 / h));
    (void)row(&way_spline, &t, "our error");
}

static void test_quintic(void)
{
    const compare_table_t t = compare_table_quintic(1u << compare_log2_knots);
    (void)row(&way_quintic, &t, "our knots");
}

int main(void)
{
    budget_count_start();
    fill_samples();
    printf("\n%s, %d inputs\n\n", CORE, n_samples);
    printf("| evaluation | gives | size | slices x knots | bytes | error of u, nm | error of u'', "
           "%% of its peak | instructions |\n|---|---|---|---|---|---|---|---|\n");
    UNITY_BEGIN();
    RUN_TEST(test_ours_is_exact_and_its_counts_repeat);
    RUN_TEST(test_linear);
    RUN_TEST(test_spline);
    RUN_TEST(test_quintic);
    return UNITY_END();
}
