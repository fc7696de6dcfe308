// SPDX-License-Identifier: Apache-2.0
#include "sim_lobe_design.h"
#include "sim_json.h"  // sim_json_number
#include "sim_units.h" // SIM_TWO_PI
#include <math.h>      // sqrt
#include <stdio.h>     // snprintf
#include <string.h>    // strcmp

#define REMEDY SIM_JSON_REMEDY

/// @return the point of the profile under a flat face
static sim_lobe_spot_t under_face(const sim_lobe_design_t *d, const sim_lobe_rise_t *rise,
                                  double theta_rad)
{
    const double nx = cos(theta_rad);
    const double ny = sin(theta_rad);
    const double along = d->base_mm + rise->h_mm;
    return (sim_lobe_spot_t){
        .x_mm = along * nx - rise->h1_mm * ny,
        .y_mm = along * ny + rise->h1_mm * nx,
        .nx = nx,
        .ny = ny,
        .ds_mm = along + rise->h2_mm,
        .bend = 1.0,
    };
}

sim_lobe_spot_t sim_lobe_design_at(sim_lobe_design_t *d, uint32_t i_lobe, double theta_rad)
{
    const sim_lobe_rise_t rise = sim_lobe_lift_at(&d->lobe[i_lobe].lift, theta_rad);
    if (d->is_flat) {
        return under_face(d, &rise, theta_rad);
    }
    const double p = d->base_mm + d->roller_mm + rise.h_mm;
    const double square = p * p + rise.h1_mm * rise.h1_mm;
    const double travel = sqrt(square);
    const double cos_gamma = p / travel;
    const double sin_gamma = rise.h1_mm / travel;
    const double c = cos(theta_rad);
    const double s = sin(theta_rad);
    const double nx = c * cos_gamma + s * sin_gamma; // direction theta - gamma
    const double ny = s * cos_gamma - c * sin_gamma;
    const double bend = 1.0 - (rise.h2_mm * p - rise.h1_mm * rise.h1_mm) / square;
    return (sim_lobe_spot_t){
        .x_mm = p * c - d->roller_mm * nx, // the contact is below the roller's centre
        .y_mm = p * s - d->roller_mm * ny,
        .nx = nx,
        .ny = ny,
        .ds_mm = travel - d->roller_mm * bend,
        .bend = bend,
    };
}

uint32_t sim_lobe_design_find(const sim_lobe_design_t *d, double z_mm, double edge_mm)
{
    for (uint32_t i = 0; i < d->n_lobes; i++) {
        if (z_mm >= d->lobe[i].z_first_mm - edge_mm && z_mm <= d->lobe[i].z_last_mm + edge_mm) {
            return i;
        }
    }
    return d->n_lobes;
}

static double largest_mm(sim_lobe_lift_t *lift)
{
    enum { n_samples = 7200 };
    double largest = 0.0;
    for (int i = 0; i < n_samples; i++) {
        const double h_mm = sim_lobe_lift_at(lift, SIM_TWO_PI * i / n_samples).h_mm;
        largest = h_mm > largest ? h_mm : largest;
    }
    return largest;
}

double sim_lobe_design_lift_mm(const sim_lobe_design_t *d)
{
    double largest = 0.0;
    for (uint32_t i = 0; i < d->n_lobes; i++) {
        largest = d->lobe[i].largest_mm > largest ? d->lobe[i].largest_mm : largest;
    }
    return largest;
}

static bool read_radius(double *value, const cJSON *design, const char *name, const char *path,
                        common_error_t *e)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(design, name);
    return (sim_json_number(item, value) && *value >= 1e-3 && *value <= 1e5) ||
           common_error(e, "%s: design.%s: must be a number from 0.001 to 100000; " REMEDY, path,
                        name);
}

static bool read_word(bool *is_second, const cJSON *design, const char *name,
                      const char *const word[2], const char *path, common_error_t *e)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(design, name);
    const char *text = cJSON_IsString(item) ? item->valuestring : "?";
    *is_second = strcmp(text, word[1]) == 0;
    return *is_second || strcmp(text, word[0]) == 0 ||
           common_error(e, "%s: design.%s = \"%.40s\": must be %s or %s; " REMEDY, path, name, text,
                        word[0], word[1]);
}

static bool read_lobe(sim_lobe_design_t *d, const cJSON *item, const char *path, common_error_t *e)
{
    const uint32_t i = d->n_lobes;
    sim_lobe_t *lobe = &d->lobe[i];
    const double above_mm = i > 0u ? d->lobe[i - 1u].z_last_mm : -HUGE_VAL;
    char where[32];
    (void)snprintf(where, sizeof where, "design.lobes.%u", (unsigned)i);
    const cJSON *z = cJSON_GetObjectItemCaseSensitive(item, "z_mm");
    const bool are_numbers = cJSON_IsArray(z) && cJSON_GetArraySize(z) == 2 &&
                             sim_json_number(cJSON_GetArrayItem(z, 0), &lobe->z_first_mm) &&
                             sim_json_number(cJSON_GetArrayItem(z, 1), &lobe->z_last_mm);
    if (!are_numbers || lobe->z_first_mm <= above_mm || lobe->z_last_mm <= lobe->z_first_mm) {
        return common_error(
            e, "%s: %s.z_mm: must be two rising numbers above the lobe before; " REMEDY, path,
            where);
    }
    const cJSON *phase = cJSON_GetObjectItemCaseSensitive(item, "phase_rad");
    if (!sim_json_number(phase, &lobe->phase_rad)) {
        return common_error(e, "%s: %s.phase_rad: must be a finite number; " REMEDY, path, where);
    }
    d->n_lobes++; // from here on sim_lobe_design_free() frees the lobe
    if (!sim_lobe_lift_read(&lobe->lift, item, where, path, e)) {
        return false;
    }
    lobe->largest_mm = largest_mm(&lobe->lift);
    return true;
}

static bool read_lobes(sim_lobe_design_t *d, const cJSON *design, const char *path,
                       common_error_t *e)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(design, "lobes");
    const int n = cJSON_IsArray(list) ? cJSON_GetArraySize(list) : 0;
    if (n < 1 || n > sim_lobe_design_max) {
        return common_error(e, "%s: design.lobes: must be a list of 1 .. %d lobes; " REMEDY, path,
                            sim_lobe_design_max);
    }
    const cJSON *item;
    cJSON_ArrayForEach(item, list)
    {
        if (!read_lobe(d, item, path, e)) {
            return false;
        }
    }
    return true;
}

bool sim_lobe_design_read(sim_lobe_design_t *d, const cJSON *design, const char *path,
                          common_error_t *e)
{
    static const char *const operation[2] = {"grinding", "turning"};
    static const char *const ways[2] = {"feed", "plunge"};
    static const char *const speed[2] = {"uniform", "constant-surface"};
    static const char *const follower[2] = {"roller", "flat"};
    return read_word(&d->is_turned, design, "operation", operation, path, e) &&
           (cJSON_GetObjectItemCaseSensitive(design, "follower") == NULL ||
            read_word(&d->is_flat, design, "follower", follower, path, e)) &&
           (cJSON_GetObjectItemCaseSensitive(design, "path") == NULL ||
            read_word(&d->is_plunged, design, "path", ways, path, e)) &&
           read_word(&d->is_even, design, "speed", speed, path, e) &&
           read_radius(&d->base_mm, design, "base_mm", path, e) &&
           read_radius(&d->roller_mm, design, "roller_mm", path, e) &&
           read_radius(&d->follower_mm, design, "follower_mm", path, e) &&
           read_radius(&d->base_speed, design, "base_speed", path, e) &&
           read_lobes(d, design, path, e);
}

void sim_lobe_design_free(sim_lobe_design_t *d)
{
    for (uint32_t i = 0; i < d->n_lobes; i++) {
        sim_lobe_lift_free(&d->lobe[i].lift);
    }
    d->n_lobes = 0;
}
