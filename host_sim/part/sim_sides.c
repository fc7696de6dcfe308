// SPDX-License-Identifier: Apache-2.0
#include "sim_surface.h"
#include "sim_design.h" // sim_design_delta_mm
#include "sim_json.h"   // sim_json_cubics
#include "sim_units.h"  // sim_sine, SIM_PI, sim_abs
#include <math.h>       // pow
#include <stdio.h>      // snprintf
#include <string.h>     // strcmp

#define REMEDY SIM_JSON_REMEDY

static double ellipse_mm(double parameter, double a_mm, double g_mm, double s2)
{
    (void)parameter;
    return sim_design_delta_mm(sim_shape_ellipse, 0.0, a_mm, g_mm, s2);
}

static double cosine_mm(double parameter, double a_mm, double g_mm, double s2)
{
    (void)parameter;
    return sim_design_delta_mm(sim_shape_cosine, 0.0, a_mm, g_mm, s2);
}

static double double_ellipse_mm(double parameter, double a_mm, double g_mm, double s2)
{
    return sim_design_delta_mm(sim_shape_double_ellipse, parameter, a_mm, g_mm, s2);
}

static double power_mm(double parameter, double a_mm, double g_mm, double s2)
{
    (void)a_mm;
    return 0.5 * g_mm * pow(s2, 0.5 * parameter);
}

static const struct {
    const char *name; ///< in NAME.json
    sim_law_t law_mm;
} laws[] = {
    {"ellipse", ellipse_mm},
    {"cosine", cosine_mm},
    {"double-ellipse", double_ellipse_mm},
    {"power", power_mm},
};

static double side_mm(sim_side_t *s, double a_mm, double phi_rad, double z_mm)
{
    const double drop_mm = sim_cubics_at(&s->drop_mm, z_mm);
    const double sine = sim_sine((phi_rad - sim_cubics_at(&s->phase_rad, z_mm)) / SIM_TWO_PI);
    return drop_mm + s->law_mm(sim_cubics_at(&s->parameter, z_mm), a_mm - drop_mm,
                               sim_cubics_at(&s->ovality_mm, z_mm), sine * sine);
}

/// @return share of the second side at an angle
static double share(const sim_sides_t *s, double phi_rad)
{
    const double turn = (phi_rad - s->middle_rad) / SIM_TWO_PI;
    const double off_rad = SIM_TWO_PI * sim_abs(sim_fraction(turn + 0.5) - 0.5);
    const double t = sim_clamp((0.5 * SIM_PI - off_rad) / s->blend_rad + 0.5, 0.0, 1.0);
    return t * t * t * t * (35.0 - t * (84.0 - t * (70.0 - 20.0 * t)));
}

double sim_sides_delta_mm(sim_sides_t *s, double a_mm, double phi_rad, double z_mm)
{
    const double w = s->n_sides > 1 ? share(s, phi_rad) : 0.0;
    const double first_mm = w < 1.0 ? side_mm(&s->side[0], a_mm, phi_rad, z_mm) : 0.0;
    const double second_mm = w > 0.0 ? side_mm(&s->side[1], a_mm, phi_rad, z_mm) : 0.0;
    return (1.0 - w) * first_mm + w * second_mm;
}

static bool read_law(sim_law_t *law, const cJSON *side, const char *where, const char *path,
                     common_error_t *e)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(side, "law");
    const char *text = cJSON_IsString(item) ? item->valuestring : "?";
    for (size_t i = 0; i < sizeof laws / sizeof laws[0]; i++) {
        if (strcmp(text, laws[i].name) == 0) {
            *law = laws[i].law_mm;
            return true;
        }
    }
    return common_error(
        e, "%s: %s.law = \"%.40s\": must be ellipse, cosine, double-ellipse or power; " REMEDY,
        path, where, text);
}

static bool read_side(sim_side_t *s, const cJSON *side, const char *where, const char *path,
                      common_error_t *e)
{
    return read_law(&s->law_mm, side, where, path, e) &&
           sim_json_cubics(&s->ovality_mm, side, where, "ovality_mm", path, e) &&
           sim_json_cubics(&s->drop_mm, side, where, "drop_mm", path, e) &&
           sim_json_cubics(&s->parameter, side, where, "parameter", path, e) &&
           sim_json_cubics(&s->phase_rad, side, where, "phase_rad", path, e);
}

bool sim_sides_read(sim_sides_t *s, const cJSON *design, const char *name, const char *path,
                    common_error_t *e)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(design, "sides");
    const int n = cJSON_IsArray(list) ? cJSON_GetArraySize(list) : 0;
    if (n < 1 || n > 2) {
        return common_error(e, "%s: %s.sides: must be a list of one or two sides; " REMEDY, path,
                            name);
    }
    const cJSON *middle = cJSON_GetObjectItemCaseSensitive(design, "middle_rad");
    const cJSON *blend = cJSON_GetObjectItemCaseSensitive(design, "blend_rad");
    if (!sim_json_number(middle, &s->middle_rad) || !sim_json_number(blend, &s->blend_rad) ||
        s->blend_rad <= 0.0) {
        return common_error(
            e, "%s: %s.middle_rad, blend_rad: must be numbers, blend_rad above 0; " REMEDY, path,
            name);
    }
    bool is_good = true;
    for (int i = 0; i < n && is_good; i++) {
        char where[32];
        (void)snprintf(where, sizeof where, "%s.sides.%d", name, i);
        s->n_sides = i + 1;
        is_good = read_side(&s->side[i], cJSON_GetArrayItem(list, i), where, path, e);
    }
    return is_good;
}

void sim_sides_free(sim_sides_t *s)
{
    for (int i = 0; i < s->n_sides; i++) {
        sim_cubics_free(&s->side[i].ovality_mm);
        sim_cubics_free(&s->side[i].drop_mm);
        sim_cubics_free(&s->side[i].parameter);
        sim_cubics_free(&s->side[i].phase_rad);
    }
    s->n_sides = 0;
}
