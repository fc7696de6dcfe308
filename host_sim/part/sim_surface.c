// SPDX-License-Identifier: Apache-2.0
#include "sim_surface.h"
#include "sim_json.h"  // sim_json_breaks
#include "sim_units.h" // sim_clamp, sim_fraction
#include <stdlib.h>    // calloc, free
#include <string.h>    // strcmp

enum { n_in_piece = sim_surface_n_angle * sim_surface_n_height };

/// Angle coordinate of a section with a joint; the quadrants mirror each other.
static double from_joint(sim_surface_t *s, double turn, double z_mm)
{
    const double half = 0.5 * sim_fraction(2.0 * turn);
    const double q = half > 0.25 ? 0.5 - half : half;
    const double joint = sim_cubics_at(&s->joint_turn, z_mm);
    return q < joint ? q / joint : 1.0 + (q - joint) / (0.25 - joint);
}

/// @return position within piece i, 0 .. 1
static double share(const double *breaks, size_t i, double v)
{
    return (v - breaks[i]) / (breaks[i + 1u] - breaks[i]);
}

double sim_surface_delta_mm(sim_surface_t *s, double turn, double z_mm)
{
    const double at = s->has_joint ? from_joint(s, turn, z_mm) : sim_fraction(turn);
    const double z = sim_clamp(z_mm, s->break_mm[0], s->break_mm[s->m]);
    s->i_last = sim_piece_of(s->breaks, s->n, s->i_last, at);
    s->j_last = sim_piece_of(s->break_mm, s->m, s->j_last, z);
    const double t = share(s->breaks, s->i_last, at);
    const double w = share(s->break_mm, s->j_last, z);
    const double(*c)[sim_surface_n_height] =
        (const double(*)[sim_surface_n_height])s->c[s->j_last * s->n + s->i_last];
    double sum = 0.0;
    for (int k = sim_surface_n_angle - 1; k >= 0; k--) {
        double row = 0.0;
        for (int l = sim_surface_n_height - 1; l >= 0; l--) {
            row = row * w + c[k][l];
        }
        sum = sum * t + row;
    }
    return sum;
}

/// Position in a report, for messages.
typedef struct {
    const char *path, *where;
    common_error_t *e;
} place_t;

static bool read_angle(sim_surface_t *s, const cJSON *surface, const place_t *at)
{
    const cJSON *angle = cJSON_GetObjectItemCaseSensitive(surface, "angle");
    const char *text = cJSON_IsString(angle) ? angle->valuestring : "?";
    s->has_joint = strcmp(text, "joint") == 0;
    if (!s->has_joint && strcmp(text, "turn") != 0) {
        return common_error(at->e,
                            "%s: %s.angle = \"%.40s\": must be turn or joint; " SIM_JSON_REMEDY,
                            at->path, at->where, text);
    }
    return !s->has_joint ||
           sim_json_cubics(&s->joint_turn, surface, at->where, "joint_turn", at->path, at->e);
}

/// The joint must be between the axes at all heights.
static bool check_joint(sim_surface_t *s, const place_t *at)
{
    enum { per_piece = 16 };
    for (size_t i = 0; s->has_joint && i < s->joint_turn.n * per_piece; i++) {
        const double *z_mm = &s->joint_turn.break_mm[i / per_piece];
        const double part = (double)(i % per_piece) / (per_piece - 1);
        const double joint = sim_cubics_at(&s->joint_turn, z_mm[0] + part * (z_mm[1] - z_mm[0]));
        if (!(joint > 0.0 && joint < 0.25)) {
            return common_error(at->e,
                                "%s: %s.joint_turn: %.12g is outside 0 .. 0.25 "
                                "turn; " SIM_JSON_REMEDY,
                                at->path, at->where, joint);
        }
    }
    return true;
}

static bool read_breaks(sim_surface_t *s, const cJSON *surface, const place_t *at)
{
    const double last = s->has_joint ? 2.0 : 1.0;
    if (!sim_json_breaks(cJSON_GetObjectItemCaseSensitive(surface, "breaks"), &s->breaks, &s->n) ||
        s->breaks[0] != 0.0 || s->breaks[s->n] != last) {
        return common_error(at->e,
                            "%s: %s.breaks: must be rising numbers from 0 to %g; " SIM_JSON_REMEDY,
                            at->path, at->where, last);
    }
    return sim_json_breaks(cJSON_GetObjectItemCaseSensitive(surface, "breaks_mm"), &s->break_mm,
                           &s->m) ||
           common_error(at->e,
                        "%s: %s.breaks_mm: must be rising finite numbers, 2 or "
                        "more; " SIM_JSON_REMEDY,
                        at->path, at->where);
}

static bool read_coefficients(sim_surface_t *s, const cJSON *surface, const place_t *at)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(surface, "coefficients");
    double *values = NULL;
    size_t n = 0;
    const bool is_list = sim_json_numbers(list, &values, &n);
    s->c = (double(*)[sim_surface_n_angle][sim_surface_n_height])(void *)values;
    return (is_list && n == s->m * s->n * n_in_piece) ||
           common_error(at->e, "%s: %s.coefficients: must be %zu finite numbers; " SIM_JSON_REMEDY,
                        at->path, at->where, s->m * s->n * n_in_piece);
}

/// The quintic between two knots, each a value and two derivatives per turn. @param h  [turn] width
static void quintic_of(const double *low, const double *high, double h, double c[])
{
    const double v0 = h * low[1];
    const double v1 = h * high[1];
    const double a0 = 0.5 * h * h * low[2];
    const double a1 = 0.5 * h * h * high[2];
    const double rise = high[0] - low[0];
    c[0] = low[0];
    c[1] = v0;
    c[2] = a0;
    c[3] = 10.0 * rise - 6.0 * v0 - 4.0 * v1 - 3.0 * a0 + a1;
    c[4] = -15.0 * rise + 8.0 * v0 + 7.0 * v1 + 3.0 * a0 - 2.0 * a1;
    c[5] = 6.0 * rise - 3.0 * v0 - 3.0 * v1 - a0 + a1;
}

/// Fill the piece above height j and break i from the knots at its four corners: over height a
/// cubic, or linear without slopes.
static void piece_of(sim_surface_t *s, const double *knots, const double *slopes, size_t j,
                     size_t i)
{
    enum { n_angle = sim_surface_n_angle };
    const size_t next = (i + 1u) % s->n;
    const double h = s->breaks[i + 1u] - s->breaks[i];
    const double dz_mm = s->break_mm[j + 1u] - s->break_mm[j];
    double at[2][n_angle];
    double rising[2][n_angle] = {{0.0}, {0.0}};
    for (size_t k = 0; k < 2u; k++) {
        const size_t row = (j + k) * s->n;
        quintic_of(knots + 3u * (row + i), knots + 3u * (row + next), h, at[k]);
        if (slopes != NULL) {
            quintic_of(slopes + 3u * (row + i), slopes + 3u * (row + next), h, rising[k]);
        }
    }
    for (int k = 0; k < n_angle; k++) {
        double *c = s->c[j * s->n + i][k];
        const double rise = at[1][k] - at[0][k];
        const double s0 = slopes != NULL ? dz_mm * rising[0][k] : rise;
        const double s1 = slopes != NULL ? dz_mm * rising[1][k] : rise;
        c[0] = at[0][k];
        c[1] = s0;
        c[2] = 3.0 * rise - 2.0 * s0 - s1;
        c[3] = s0 + s1 - 2.0 * rise;
    }
}

/// Read a list of three numbers for each height and break. @param is_needed  missing is an error
static bool read_knots(double **values, const sim_surface_t *s, const cJSON *surface,
                       const char *name, bool is_needed, const place_t *at)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(surface, name);
    const size_t wanted = 3u * (s->m + 1u) * s->n;
    size_t n = 0;
    if (list == NULL && !is_needed) {
        return true;
    }
    return (sim_json_numbers(list, values, &n) && n == wanted) ||
           common_error(at->e, "%s: %s.%s: must be %zu finite numbers; " SIM_JSON_REMEDY, at->path,
                        at->where, name, wanted);
}

/// Read sections given by knots, and convert them to pieces.
static bool read_sections(sim_surface_t *s, const cJSON *surface, const place_t *at)
{
    double *knots = NULL;
    double *slopes = NULL;
    bool is_good = read_knots(&knots, s, surface, "knots", true, at) &&
                   read_knots(&slopes, s, surface, "slopes", false, at);
    s->c = is_good ? calloc(s->m * s->n, sizeof *s->c) : NULL;
    if (is_good && s->c == NULL) {
        is_good = common_error(at->e, "%s: %s: not enough memory; measure fewer points", at->path,
                               at->where);
    }
    for (size_t i = 0; s->c != NULL && i < s->m * s->n; i++) {
        piece_of(s, knots, slopes, i / s->n, i % s->n);
    }
    free(knots);
    free(slopes);
    return is_good;
}

bool sim_surface_read(sim_surface_t *s, const cJSON *surface, const char *where, const char *path,
                      common_error_t *e)
{
    const place_t at = {.path = path, .where = where, .e = e};
    if (!cJSON_IsObject(surface)) {
        return common_error(e, "%s: %s: is missing; " SIM_JSON_REMEDY, path, where);
    }
    return read_angle(s, surface, &at) && check_joint(s, &at) && read_breaks(s, surface, &at) &&
           (cJSON_HasObjectItem(surface, "knots") ? read_sections(s, surface, &at)
                                                  : read_coefficients(s, surface, &at));
}

void sim_surface_free(sim_surface_t *s)
{
    sim_cubics_free(&s->joint_turn);
    free(s->breaks);
    free(s->break_mm);
    free(s->c);
    *s = (sim_surface_t){0};
}
