// SPDX-License-Identifier: Apache-2.0
#include "sim_area.h"
#include "sim_units.h" // SIM_TWO_PI, sim_abs, sim_cosine, sim_sine
#include <math.h>      // remainder, INFINITY
#include <stdio.h>     // snprintf

#define REMEDY SIM_JSON_REMEDY

/// Source of a reading: a window or a zone, its place, and its file for messages.
typedef struct {
    const cJSON *tree;
    char where[32];
    const char *path;
    common_error_t *e;
} source_t;

static bool read_number(const source_t *from, const char *key, double low, double high,
                        double *value)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(from->tree, key);
    return (sim_json_number(item, value) && *value >= low && *value <= high) ||
           common_error(from->e, "%s: %s.%s: must be a number of %g .. %g; " REMEDY, from->path,
                        from->where, key, low, high);
}

static bool read_area(sim_area_t *a, const source_t *from)
{
    return read_number(from, "angle_deg", -360.0, 360.0, &a->middle_deg) &&
           read_number(from, "width_deg", 0.0, 360.0, &a->width_deg) &&
           read_number(from, "low_mm", -1e4, 1e4, &a->low_mm) &&
           read_number(from, "high_mm", a->low_mm, 1e4, &a->high_mm) &&
           read_number(from, "diameter_mm", 0.0, 1e4, &a->diameter_mm) &&
           read_number(from, "offset_mm", -1e4, 1e4, &a->offset_mm) &&
           read_number(from, "margin_mm", 0.0, 1e3, &a->margin_mm);
}

static bool read_zone(sim_zone_t *z, const source_t *from)
{
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(from->tree, "name");
    (void)snprintf(z->name, sizeof z->name, "%s", cJSON_IsString(name) ? name->valuestring : "");
    z->has_band = cJSON_HasObjectItem(from->tree, "upper_um");
    return read_area(&z->area, from) &&
           (!cJSON_HasObjectItem(from->tree, "tolerance_um") ||
            read_number(from, "tolerance_um", 1e-6, 1e6, &z->tolerance_um)) &&
           (!z->has_band || (sim_json_cubics(&z->lower_um, from->tree, from->where, "lower_um",
                                             from->path, from->e) &&
                             sim_json_cubics(&z->upper_um, from->tree, from->where, "upper_um",
                                             from->path, from->e)));
}

static source_t entry(const cJSON *design, const char *key, int i, const char *path,
                      common_error_t *e)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(design, key);
    source_t from = {.tree = cJSON_GetArrayItem(list, i), .path = path, .e = e};
    (void)snprintf(from.where, sizeof from.where, "design.%s[%d]", key, i);
    return from;
}

bool sim_areas_read(sim_areas_t *a, const cJSON *design, const char *path, common_error_t *e)
{
    const int n_windows =
        sim_json_count(design, "design", "windows", sim_areas_most_windows, path, e);
    const int n_zones = sim_json_count(design, "design", "zones", sim_areas_most_zones, path, e);
    for (; a->n_windows < n_windows; a->n_windows++) {
        const source_t from = entry(design, "windows", a->n_windows, path, e);
        if (!read_area(&a->window[a->n_windows], &from)) {
            return false;
        }
    }
    while (a->n_zones < n_zones) {
        const source_t from = entry(design, "zones", a->n_zones, path, e);
        if (!read_zone(&a->zone[a->n_zones++], &from)) {
            return false;
        }
    }
    sim_areas_restart(a);
    return n_windows >= 0 && n_zones >= 0;
}

bool sim_area_holds(const sim_area_t *a, double turn, double z_mm, double radius_mm,
                    double margin_mm)
{
    const double off_turn = remainder(turn - a->middle_deg / 360.0, 1.0);
    if (a->diameter_mm > 0.0) {
        const double across_mm = radius_mm * sim_sine(off_turn) - a->offset_mm;
        const double up_mm = z_mm - a->low_mm;
        const double reach_mm = 0.5 * a->diameter_mm + margin_mm;
        return sim_abs(off_turn) < 0.25 &&
               across_mm * across_mm + up_mm * up_mm < reach_mm * reach_mm;
    }
    const double half_turn = 0.5 * a->width_deg / 360.0 + margin_mm / (SIM_TWO_PI * radius_mm);
    return a->width_deg > 0.0 && z_mm >= a->low_mm - margin_mm && z_mm <= a->high_mm + margin_mm &&
           sim_abs(off_turn) <= half_turn;
}

sim_place_kind_t sim_areas_kind(const sim_areas_t *a, double turn, double z_mm, double radius_mm)
{
    sim_place_kind_t kind = sim_place_metal;
    for (int i = 0; i < a->n_windows && kind != sim_place_air; i++) {
        const sim_area_t *window = &a->window[i];
        if (sim_area_holds(window, turn, z_mm, radius_mm, 0.0)) {
            kind = sim_place_air;
        } else if (sim_area_holds(window, turn, z_mm, radius_mm, window->margin_mm)) {
            kind = sim_place_edge;
        }
    }
    return kind;
}

double sim_zone_tolerance_um(const sim_zone_t *z, double of_part_um)
{
    return z->tolerance_um > 0.0 ? z->tolerance_um : of_part_um;
}

/// @return [um] by how much an error leaves a zone's band or tolerance; below 0: inside
static double excess_um(sim_zone_t *z, double z_mm, double error_um, double tolerance_um)
{
    const double beyond_um = sim_abs(error_um) - sim_zone_tolerance_um(z, tolerance_um);
    if (!z->has_band) {
        return beyond_um;
    }
    const double above_um = error_um - sim_cubics_at(&z->upper_um, z_mm);
    const double below_um = sim_cubics_at(&z->lower_um, z_mm) - error_um;
    return fmax(beyond_um, fmax(above_um, below_um));
}

/// @return [um] the excess of a sample
static double judge_by(sim_zone_t *z, double turn, double z_mm, double error_um,
                       double tolerance_um)
{
    const double most_um = excess_um(z, z_mm, error_um, tolerance_um);
    z->excess_um = most_um > z->excess_um ? most_um : z->excess_um;
    z->sum_um2 += error_um * error_um;
    z->n++;
    if (sim_abs(error_um) > z->max_um) {
        z->max_um = sim_abs(error_um);
        z->max_turn = turn;
        z->max_z_mm = z_mm;
    }
    return most_um;
}

void sim_areas_judge(sim_areas_t *a, double turn, double z_mm, double radius_mm, double error_um,
                     double tolerance_um)
{
    int i = 0;
    while (i < a->n_zones && !sim_area_holds(&a->zone[i].area, turn, z_mm, radius_mm, 0.0)) {
        i++;
    }
    const bool is_beside = i == a->n_zones;
    const double most_um = is_beside ? sim_abs(error_um) - tolerance_um
                                     : judge_by(&a->zone[i], turn, z_mm, error_um, tolerance_um);
    a->excess_um = most_um > a->excess_um ? most_um : a->excess_um;
    a->rest_um = is_beside && most_um > a->rest_um ? most_um : a->rest_um;
}

void sim_areas_restart(sim_areas_t *a)
{
    a->excess_um = a->rest_um = -INFINITY;
    for (int i = 0; i < a->n_zones; i++) {
        sim_zone_t *z = &a->zone[i];
        z->excess_um = -INFINITY;
        z->max_um = z->sum_um2 = 0.0;
        z->n = 0u;
    }
}

void sim_areas_free(sim_areas_t *a)
{
    for (int i = 0; i < a->n_zones; i++) {
        sim_cubics_free(&a->zone[i].lower_um);
        sim_cubics_free(&a->zone[i].upper_um);
    }
    *a = (sim_areas_t){0};
}
