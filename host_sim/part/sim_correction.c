// SPDX-License-Identifier: Apache-2.0
#include "sim_surface.h"
#include "sim_json.h"  // sim_json_cubics
#include "sim_units.h" // sim_cosine, sim_sine
#include <math.h>      // floor
#include <stdio.h>     // snprintf
#include <stdlib.h>    // calloc, free

#define REMEDY SIM_JSON_REMEDY

static bool read_wave(sim_wave_t *w, const cJSON *wave, const char *where, const char *path,
                      common_error_t *e)
{
    const cJSON *order = cJSON_GetObjectItemCaseSensitive(wave, "order");
    if (!sim_json_number(order, &w->order) || w->order < 1.0 ||
        w->order > sim_correction_max_order || w->order != floor(w->order)) {
        return common_error(e, "%s: %s.order: must be a whole number of 1 .. %d; " REMEDY, path,
                            where, (int)sim_correction_max_order);
    }
    return sim_json_cubics(&w->cos_mm, wave, where, "cos_mm", path, e) &&
           sim_json_cubics(&w->sin_mm, wave, where, "sin_mm", path, e);
}

bool sim_correction_read(sim_correction_t *c, const cJSON *design, const char *name,
                         const char *path, common_error_t *e)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(design, "correction");
    const int n = sim_json_count(design, name, "correction", sim_correction_max_order, path, e);
    if (n <= 0) {
        return n == 0;
    }
    c->wave = calloc((size_t)n + 1u, sizeof *c->wave);
    if (c->wave == NULL) {
        return common_error(e, "%s: no memory for %s.correction; free some", path, name);
    }
    for (c->n = 0; c->n < (size_t)n;) {
        char where[64];
        (void)snprintf(where, sizeof where, "%s.correction[%zu]", name, c->n);
        const cJSON *wave = cJSON_GetArrayItem(list, (int)c->n);
        if (!read_wave(&c->wave[c->n++], wave, where, path, e)) {
            return false;
        }
    }
    return true;
}

double sim_correction_delta_mm(sim_correction_t *c, double turn, double z_mm)
{
    double delta_mm = 0.0;
    for (size_t i = 0; i < c->n; i++) {
        sim_wave_t *w = &c->wave[i];
        const double waves = w->order * turn;
        delta_mm += sim_cubics_at(&w->cos_mm, z_mm) * sim_cosine(waves) +
                    sim_cubics_at(&w->sin_mm, z_mm) * sim_sine(waves);
    }
    return delta_mm;
}

void sim_correction_free(sim_correction_t *c)
{
    for (size_t i = 0; i < c->n; i++) {
        sim_cubics_free(&c->wave[i].cos_mm);
        sim_cubics_free(&c->wave[i].sin_mm);
    }
    free(c->wave);
    *c = (sim_correction_t){0};
}
