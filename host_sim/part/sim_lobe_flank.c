// SPDX-License-Identifier: Apache-2.0
#include "sim_lobe_design.h"
#include "sim_json.h"  // sim_json_number
#include "sim_units.h" // SIM_PI, SIM_TWO_PI, sim_fraction
#include <math.h>      // cos, sin
#include <stddef.h>    // NULL
#include <string.h>    // strcmp

#define REMEDY SIM_JSON_REMEDY

/// A rise and its derivatives over x.
typedef struct {
    double y, d1, d2;
} flank_t;

static flank_t poly345(double x)
{
    const double v = 1.0 - x;
    return (flank_t){x * x * x * (10.0 - 15.0 * x + 6.0 * x * x), 30.0 * x * x * v * v,
                     60.0 * x * v * (1.0 - 2.0 * x)};
}

static flank_t cycloidal(double x)
{
    const double t = SIM_TWO_PI * x;
    return (flank_t){x - sin(t) / SIM_TWO_PI, 1.0 - cos(t), SIM_TWO_PI * sin(t)};
}

static flank_t harmonic(double x)
{
    const double t = SIM_PI * x;
    return (flank_t){0.5 * (1.0 - cos(t)), 0.5 * SIM_PI * sin(t), 0.5 * SIM_PI * SIM_PI * cos(t)};
}

static flank_t modified_sine(double x)
{
    const double a = 1.0 / (4.0 + SIM_PI);
    const bool is_middle = x > 0.125 && x < 0.875;
    const double fast = 4.0 * SIM_PI * x;
    const double slow = (SIM_PI + fast) / 3.0;
    if (is_middle) {
        return (flank_t){a * (2.0 + SIM_PI * x - 2.25 * sin(slow)),
                         a * SIM_PI * (1.0 - 3.0 * cos(slow)),
                         4.0 * SIM_PI * SIM_PI * a * sin(slow)};
    }
    return (flank_t){a * ((x > 0.5 ? 4.0 : 0.0) + SIM_PI * x - 0.25 * sin(fast)),
                     a * SIM_PI * (1.0 - cos(fast)), 4.0 * SIM_PI * SIM_PI * a * sin(fast)};
}

/// The first half; the second is its reflection.
static flank_t half_trapezoid(double x)
{
    const double b = 1.0 / (2.0 + SIM_PI);
    if (x <= 0.125) {
        const double t = 4.0 * SIM_PI * x;
        return (flank_t){b * (2.0 * x - sin(t) / SIM_TWO_PI), 2.0 * b * (1.0 - cos(t)),
                         8.0 * SIM_PI * b * sin(t)};
    }
    const double y1 = b * (0.25 - 1.0 / SIM_TWO_PI);
    if (x <= 0.375) {
        const double s = x - 0.125;
        return (flank_t){y1 + b * (2.0 * s + 4.0 * SIM_PI * s * s), b * (2.0 + 8.0 * SIM_PI * s),
                         8.0 * SIM_PI * b};
    }
    const double y2 = y1 + b * (0.5 + 0.25 * SIM_PI);
    const double s = x - 0.375;
    const double t = 4.0 * SIM_PI * s;
    return (flank_t){y2 + b * ((2.0 + SIM_TWO_PI) * s + (1.0 - cos(t)) / SIM_TWO_PI),
                     b * (2.0 + SIM_TWO_PI + 2.0 * sin(t)), 8.0 * SIM_PI * b * cos(t)};
}

static flank_t modified_trapezoid(double x)
{
    if (x <= 0.5) {
        return half_trapezoid(x);
    }
    const flank_t f = half_trapezoid(1.0 - x);
    return (flank_t){1.0 - f.y, f.d1, -f.d2};
}

/// The driven mass follows 126 x^5 - 420 x^6 + 540 x^7 - 315 x^8 + 70 x^9, whose slope is 630 q^4,
/// q = x (1 - x); the lift is larger by the deflection times its acceleration.
static flank_t polydyne(double x, double deflection)
{
    const double q = x * (1.0 - x);
    const double q1 = 1.0 - 2.0 * x;
    const double place =
        x * x * x * x * x * (126.0 + x * (-420.0 + x * (540.0 + x * (-315.0 + 70.0 * x))));
    const double a2 = 2520.0 * q * q * q * q1;
    const double a3 = 2520.0 * q * q * (3.0 * q1 * q1 - 2.0 * q);
    const double a4 = 2520.0 * q * q1 * (6.0 * q1 * q1 - 18.0 * q);
    return (flank_t){place + deflection * a2, 630.0 * q * q * q * q + deflection * a3,
                     a2 + deflection * a4};
}

static flank_t shape_at(sim_lobe_flank_t shape, double x, double deflection)
{
    switch (shape) {
    case sim_lobe_flank_cycloidal:
        return cycloidal(x);
    case sim_lobe_flank_modified_sine:
        return modified_sine(x);
    case sim_lobe_flank_modified_trapezoid:
        return modified_trapezoid(x);
    case sim_lobe_flank_harmonic:
        return harmonic(x);
    case sim_lobe_flank_polydyne:
        return polydyne(x, deflection);
    case sim_lobe_flank_poly345:
    case sim_lobe_n_flanks:
    default:
        return poly345(x);
    }
}

/// @param angle_rad  angle of the flank; below 0 for a fall
static sim_lobe_rise_t scaled(const sim_lobe_flanks_t *f, flank_t y, double angle_rad)
{
    return (sim_lobe_rise_t){f->lift_mm * y.y, f->lift_mm * y.d1 / angle_rad,
                             f->lift_mm * y.d2 / (angle_rad * angle_rad)};
}

sim_lobe_rise_t sim_lobe_flanks_at(const sim_lobe_flanks_t *f, double theta_rad)
{
    const double first = -0.5 * f->dwell_rad - f->rise_rad;
    const double at = SIM_TWO_PI * sim_fraction((theta_rad - first) / SIM_TWO_PI);
    const double top = f->rise_rad + f->dwell_rad;
    if (at < f->rise_rad) {
        return scaled(f, shape_at(f->shape, at / f->rise_rad, f->rise_deflection), f->rise_rad);
    }
    if (at <= top) {
        return (sim_lobe_rise_t){.h_mm = f->lift_mm};
    }
    const double x = 1.0 - (at - top) / f->fall_rad;
    return x <= 0.0 ? (sim_lobe_rise_t){0}
                    : scaled(f, shape_at(f->shape, x, f->fall_deflection), -f->fall_rad);
}

static bool read_number(double *value, const cJSON *lobe, const char *where, const char *name,
                        double least, const char *path, common_error_t *e)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(lobe, name);
    return (sim_json_number(item, value) && *value >= least && *value <= 1e6) ||
           common_error(e, "%s: %s.%s: must be a number from %g to 1e6; " REMEDY, path, where, name,
                        least);
}

static bool read_shape(sim_lobe_flank_t *shape, const cJSON *lobe, const char *where,
                       const char *path, common_error_t *e)
{
    static const char *const name[sim_lobe_n_flanks] = {
        "poly345", "cycloidal", "modified-sine", "modified-trapezoid", "harmonic", "polydyne"};
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(lobe, "shape");
    const char *text = cJSON_IsString(item) ? item->valuestring : "?";
    for (int i = 0; i < sim_lobe_n_flanks; i++) {
        if (strcmp(text, name[i]) == 0) {
            *shape = (sim_lobe_flank_t)i;
            return true;
        }
    }
    return common_error(e, "%s: %s.shape = \"%.40s\": is no law of a flank; " REMEDY, path, where,
                        text);
}

bool sim_lobe_flanks_read(sim_lobe_flanks_t *f, const cJSON *lobe, const char *where,
                          const char *path, common_error_t *e)
{
    const double least_rad = 1e-3;
    *f = (sim_lobe_flanks_t){0};
    if (!read_shape(&f->shape, lobe, where, path, e) ||
        !read_number(&f->lift_mm, lobe, where, "lift_mm", 1e-9, path, e) ||
        !read_number(&f->rise_rad, lobe, where, "rise_rad", least_rad, path, e) ||
        !read_number(&f->dwell_rad, lobe, where, "dwell_rad", 0.0, path, e) ||
        !read_number(&f->fall_rad, lobe, where, "fall_rad", least_rad, path, e)) {
        return false;
    }
    if (f->rise_rad + f->dwell_rad + f->fall_rad > SIM_TWO_PI + 1e-9) {
        return common_error(e, "%s: %s: rise, dwell and fall exceed a turn; " REMEDY, path, where);
    }
    return f->shape != sim_lobe_flank_polydyne ||
           (read_number(&f->rise_deflection, lobe, where, "rise_deflection", 0.0, path, e) &&
            read_number(&f->fall_deflection, lobe, where, "fall_deflection", 0.0, path, e));
}
