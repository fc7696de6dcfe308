// SPDX-License-Identifier: Apache-2.0
#include "sim_json.h"
#include <math.h>   // isfinite
#include <stdlib.h> // calloc, free

bool sim_json_number(const cJSON *item, double *value)
{
    if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble)) {
        return false;
    }
    *value = item->valuedouble;
    return true;
}

static bool copy_numbers(const cJSON *list, double *values)
{
    size_t i = 0;
    const cJSON *item;
    cJSON_ArrayForEach(item, list)
    {
        if (!sim_json_number(item, &values[i++])) {
            return false;
        }
    }
    return true;
}

bool sim_json_numbers(const cJSON *list, double **values, size_t *n)
{
    *n = cJSON_IsArray(list) ? (size_t)cJSON_GetArraySize(list) : 0u;
    *values = *n > 0u ? calloc(*n, sizeof **values) : NULL;
    if (*values != NULL && copy_numbers(list, *values)) {
        return true;
    }
    free(*values);
    *values = NULL;
    return false;
}

int sim_json_count(const cJSON *parent, const char *where, const char *name, int most,
                   const char *path, common_error_t *e)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(parent, name);
    const int n = list == NULL ? 0 : cJSON_IsArray(list) ? cJSON_GetArraySize(list) : -1;
    if (n < 0 || n > most) {
        (void)common_error(e, "%s: %s.%s: must be a list of at most %d; " SIM_JSON_REMEDY, path,
                           where, name, most);
        return -1;
    }
    return n;
}

bool sim_json_breaks(const cJSON *list, double **breaks, size_t *n_pieces)
{
    size_t n;
    if (!sim_json_numbers(list, breaks, &n)) {
        return false;
    }
    *n_pieces = n - 1u;
    bool is_good = n >= 2u && n <= sim_json_max_pieces;
    for (size_t i = 1; i < n && is_good; i++) {
        is_good = (*breaks)[i] > (*breaks)[i - 1u];
    }
    if (is_good) {
        return true;
    }
    free(*breaks);
    *breaks = NULL;
    return false;
}

static bool read_pieces(sim_cubics_t *p, const cJSON *list)
{
    if (!cJSON_IsArray(list) || (size_t)cJSON_GetArraySize(list) != p->n) {
        return false;
    }
    p->c = calloc(p->n, sizeof *p->c);
    size_t i = 0;
    const cJSON *item;
    cJSON_ArrayForEach(item, list)
    {
        if (p->c == NULL || !cJSON_IsArray(item) || cJSON_GetArraySize(item) != 4 ||
            !copy_numbers(item, p->c[i++])) {
            return false;
        }
    }
    return true;
}

bool sim_json_cubics(sim_cubics_t *p, const cJSON *parent, const char *where, const char *name,
                     const char *path, common_error_t *e)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(parent, name);
    if (!sim_json_breaks(cJSON_GetObjectItemCaseSensitive(item, "breaks_mm"), &p->break_mm,
                         &p->n)) {
        return common_error(
            e, "%s: %s.%s.breaks_mm: must be rising finite numbers, 2 or more; " SIM_JSON_REMEDY,
            path, where, name);
    }
    if (!read_pieces(p, cJSON_GetObjectItemCaseSensitive(item, "coefficients"))) {
        return common_error(
            e, "%s: %s.%s.coefficients: must be %zu lists of 4 finite numbers; " SIM_JSON_REMEDY,
            path, where, name, p->n);
    }
    return true;
}
