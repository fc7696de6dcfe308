// SPDX-License-Identifier: Apache-2.0
#include "sim_band.h"
#include "sim_json.h" // sim_json_count, sim_json_number
#include <stddef.h>   // NULL

/// Read as many numbers as the band has passes.
static bool read_passes(const sim_band_t *band, const cJSON *list, double *values)
{
    bool is_good = cJSON_GetArraySize(list) == band->n_passes;
    for (int i = 0; is_good && i < band->n_passes; i++) {
        is_good = sim_json_number(cJSON_GetArrayItem(list, i), &values[i]);
    }
    return is_good;
}

static bool read_band(sim_band_t *band, const cJSON *from)
{
    const cJSON *passes = cJSON_GetObjectItemCaseSensitive(from, "allowance_mm");
    band->n_passes = cJSON_GetArraySize(passes);
    return band->n_passes >= 1 && band->n_passes <= sim_band_most_passes &&
           sim_json_number(cJSON_GetObjectItem(from, "low_mm"), &band->low_mm) &&
           sim_json_number(cJSON_GetObjectItem(from, "high_mm"), &band->high_mm) &&
           sim_json_number(cJSON_GetObjectItem(from, "run_mm"), &band->run_mm) &&
           band->low_mm < band->high_mm && band->run_mm > 0.0 &&
           read_passes(band, passes, band->allowance_mm) &&
           read_passes(band, cJSON_GetObjectItem(from, "feed_mm"), band->feed_mm);
}

bool sim_bands_read(sim_bands_t *b, const cJSON *design, const char *path, common_error_t *e)
{
    const int n = sim_json_count(design, "design", "bands", sim_bands_most, path, e);
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(design, "bands");
    for (; b->n < n; b->n++) {
        if (!read_band(&b->band[b->n], cJSON_GetArrayItem(list, b->n))) {
            return common_error(
                e,
                "%s: design.bands[%d]: must have low_mm below high_mm, run_mm "
                "above 0, and 1 to %d numbers allowance_mm and feed_mm; " SIM_JSON_REMEDY,
                path, b->n, sim_band_most_passes);
        }
    }
    return n >= 0;
}

/// @return whether the tool is at a height of the band
static bool follow(sim_band_t *band, double z_mm)
{
    const bool is_there = z_mm >= band->low_mm && z_mm <= band->high_mm;
    if (z_mm < band->low_mm - 0.5 * band->run_mm) {
        band->is_below = true;
    } else if (band->is_below && is_there) {
        band->is_below = false;
        band->is_inside = true;
        band->n_begun += band->n_begun < band->n_passes ? 1 : 0;
    } else {
        band->is_inside = band->is_inside && z_mm <= band->high_mm;
    }
    return is_there;
}

const sim_band_t *sim_bands_follow(sim_bands_t *b, double z_mm)
{
    const sim_band_t *found = NULL;
    for (int i = 0; i < b->n; i++) {
        found = follow(&b->band[i], z_mm) ? &b->band[i] : found;
    }
    return found;
}

bool sim_band_is_last(const sim_band_t *band)
{
    return band->is_inside && band->n_begun == band->n_passes;
}

double sim_band_stock_mm(const sim_band_t *band)
{
    const int n_done = band->n_begun - (band->is_inside ? 1 : 0);
    return n_done > 0 ? band->allowance_mm[n_done - 1] : -1.0;
}

bool sim_bands_are_done(const sim_bands_t *b)
{
    int n = 0;
    while (n < b->n && b->band[n].n_begun == b->band[n].n_passes) {
        n++;
    }
    return n == b->n;
}

double sim_bands_feed_mm(const sim_bands_t *b)
{
    double most_mm = 0.0;
    for (int i = 0; i < b->n; i++) {
        const double feed_mm = b->band[i].feed_mm[b->band[i].n_passes - 1];
        most_mm = feed_mm > most_mm ? feed_mm : most_mm;
    }
    return most_mm;
}

void sim_bands_restart(sim_bands_t *b)
{
    for (int i = 0; i < b->n; i++) {
        b->band[i].n_begun = 0;
        b->band[i].is_below = b->band[i].is_inside = false;
    }
}
