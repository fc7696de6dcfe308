// SPDX-License-Identifier: Apache-2.0
#include "sim_lobe_design.h"
#include "sim_json.h"  // sim_piece_of, sim_json_number
#include "sim_units.h" // SIM_TWO_PI, sim_abs, sim_fraction
#include <math.h>      // cos, sin, sqrt
#include <stdlib.h>    // free
#include <string.h>    // strcmp

#define REMEDY SIM_JSON_REMEDY

static sim_lobe_rise_t poly345(const sim_lobe_lift_t *lift, double theta_rad)
{
    const double theta = // the same angle, -pi .. pi
        (sim_fraction(theta_rad / SIM_TWO_PI + 0.5) - 0.5) * SIM_TWO_PI;
    const double u = 1.0 - sim_abs(theta) / lift->half_angle_rad;
    if (u <= 0.0) {
        return (sim_lobe_rise_t){0};
    }
    const double slope = (theta > 0.0 ? -1.0 : 1.0) / lift->half_angle_rad;
    const double v = 1.0 - u;
    return (sim_lobe_rise_t){
        .h_mm = lift->lift_mm * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
        .h1_mm = lift->lift_mm * slope * 30.0 * u * u * v * v,
        .h2_mm = lift->lift_mm * slope * slope * 60.0 * u * v * (1.0 - 2.0 * u),
    };
}

/// Eccentric disc: the roller's centre moves on a circle about the disc's centre.
static sim_lobe_rise_t disc(const sim_lobe_lift_t *lift, double theta_rad)
{
    const double e = lift->offset_mm;
    const double s = sin(theta_rad);
    const double c = cos(theta_rad);
    const double root = sqrt(lift->reach_mm * lift->reach_mm - e * e * s * s);
    const double root1 = -e * e * s * c / root;
    const double root2 = -(e * e * (c * c - s * s) + root1 * root1) / root;
    return (sim_lobe_rise_t){
        .h_mm = root + e * c - (lift->reach_mm - e),
        .h1_mm = root1 - e * s,
        .h2_mm = root2 - e * c,
    };
}

static sim_lobe_rise_t pieces(sim_lobe_lift_t *lift, double theta_rad)
{
    const double first = lift->break_rad[0];
    const double at = first + SIM_TWO_PI * sim_fraction((theta_rad - first) / SIM_TWO_PI);
    lift->i_last = sim_piece_of(lift->break_rad, lift->n, lift->i_last, at);
    const double s = at - lift->break_rad[lift->i_last];
    const double *c = lift->c[lift->i_last];
    sim_lobe_rise_t r = {0};
    for (int k = 0; k < sim_lobe_lift_terms; k++) { // Horner's scheme with derivatives
        r.h2_mm = r.h2_mm * s + 2.0 * r.h1_mm;
        r.h1_mm = r.h1_mm * s + r.h_mm;
        r.h_mm = r.h_mm * s + c[k];
    }
    return r;
}

sim_lobe_rise_t sim_lobe_lift_at(sim_lobe_lift_t *lift, double theta_rad)
{
    switch (lift->law) {
    case sim_lobe_lift_poly345:
        return poly345(lift, theta_rad);
    case sim_lobe_lift_disc:
        return disc(lift, theta_rad);
    case sim_lobe_lift_flanks:
        return sim_lobe_flanks_at(&lift->flanks, theta_rad);
    case sim_lobe_lift_pieces:
    default:
        return pieces(lift, theta_rad);
    }
}

/// Read a number above 0.
static bool read_number(double *value, const cJSON *lobe, const char *where, const char *name,
                        const char *path, common_error_t *e)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(lobe, name);
    return (sim_json_number(item, value) && *value > 0.0) ||
           common_error(e, "%s: %s.%s: must be a number above 0; " REMEDY, path, where, name);
}

static bool read_pieces(sim_lobe_lift_t *lift, const cJSON *lobe, const char *where,
                        const char *path, common_error_t *e)
{
    const cJSON *breaks = cJSON_GetObjectItemCaseSensitive(lobe, "breaks_rad");
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(lobe, "coefficients");
    size_t n_values = 0;
    double *values = NULL;
    if (!sim_json_breaks(breaks, &lift->break_rad, &lift->n) ||
        sim_abs(lift->break_rad[lift->n] - lift->break_rad[0] - SIM_TWO_PI) > 1e-9) {
        return common_error(e, "%s: %s.breaks_rad: must be rising numbers over one turn; " REMEDY,
                            path, where);
    }
    const bool is_list = sim_json_numbers(list, &values, &n_values);
    lift->c = (double(*)[sim_lobe_lift_terms])(void *)values;
    return (is_list && n_values == lift->n * sim_lobe_lift_terms) ||
           common_error(e, "%s: %s.coefficients: must be %zu finite numbers; " REMEDY, path, where,
                        lift->n * sim_lobe_lift_terms);
}

bool sim_lobe_lift_read(sim_lobe_lift_t *lift, const cJSON *lobe, const char *where,
                        const char *path, common_error_t *e)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(lobe, "law");
    const char *law = cJSON_IsString(item) ? item->valuestring : "?";
    if (strcmp(law, "poly345") == 0) {
        lift->law = sim_lobe_lift_poly345;
        return read_number(&lift->lift_mm, lobe, where, "lift_mm", path, e) &&
               read_number(&lift->half_angle_rad, lobe, where, "half_angle_rad", path, e);
    }
    if (strcmp(law, "disc") == 0) {
        lift->law = sim_lobe_lift_disc;
        if (!read_number(&lift->reach_mm, lobe, where, "reach_mm", path, e) ||
            !read_number(&lift->offset_mm, lobe, where, "offset_mm", path, e)) {
            return false;
        }
        return lift->offset_mm < lift->reach_mm ||
               common_error(e, "%s: %s.offset_mm = %.12g: must be below reach_mm; " REMEDY, path,
                            where, lift->offset_mm);
    }
    if (strcmp(law, "flanks") == 0) {
        lift->law = sim_lobe_lift_flanks;
        return sim_lobe_flanks_read(&lift->flanks, lobe, where, path, e);
    }
    if (strcmp(law, "pieces") == 0) {
        lift->law = sim_lobe_lift_pieces;
        return read_pieces(lift, lobe, where, path, e);
    }
    return common_error(e,
                        "%s: %s.law = \"%.40s\": must be poly345, disc, flanks or pieces; " REMEDY,
                        path, where, law);
}

void sim_lobe_lift_free(sim_lobe_lift_t *lift)
{
    free(lift->break_rad);
    free(lift->c);
    *lift = (sim_lobe_lift_t){0};
}
