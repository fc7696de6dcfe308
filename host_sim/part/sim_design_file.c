// SPDX-License-Identifier: Apache-2.0
#include "sim_design.h"
#include "sim_file.h"  // sim_file_read
#include "sim_json.h"  // sim_json_cubics
#include "sim_units.h" // SIM_NM_PER_MM
#include <cjson/cJSON.h>
#include <math.h>   // NAN
#include <stdlib.h> // strtoul
#include <string.h> // strcmp

enum { max_report_bytes = 64 * 1024 * 1024 };

#define REMEDY SIM_JSON_REMEDY

/// [mm] heights of a table are whole nanometres.
#define ROUNDING_MM 2e-6

static bool read_shape(sim_design_t *d, const cJSON *design, const char *path, common_error_t *e)
{
    static const char *const name[] = {"ellipse", "cosine", "double-ellipse", "surface"};
    const cJSON *shape = cJSON_GetObjectItemCaseSensitive(design, "shape");
    const char *text = cJSON_IsString(shape) ? shape->valuestring : "?";
    for (int i = 0; i < 4; i++) {
        if (strcmp(text, name[i]) == 0) {
            d->shape = (sim_shape_t)i;
            const cJSON *beta = cJSON_GetObjectItemCaseSensitive(design, "beta");
            if (d->shape == sim_shape_double_ellipse && !sim_json_number(beta, &d->beta)) {
                return common_error(e, "%s: design.beta: wants a finite number; " REMEDY, path);
            }
            return true;
        }
    }
    return common_error(
        e,
        "%s: design.shape = \"%.40s\": wants ellipse, cosine, double-ellipse or surface; " REMEDY,
        path, text);
}

/// The CRC-32 in the report, a number or a string in hexadecimal, must be the table's.
static bool check_crc(const cJSON *root, const cam_table_t *table, const char *path,
                      common_error_t *e)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(root, "table_crc32");
    bool is_same = cJSON_IsNumber(item) && item->valuedouble == (double)table->crc32;
    if (cJSON_IsString(item)) {
        char *end = NULL;
        const unsigned long value = strtoul(item->valuestring, &end, 16);
        is_same = end != item->valuestring && *end == '\0' && value == table->crc32;
    }
    return is_same ||
           common_error(e,
                        "%s: table_crc32: belongs to another table than this one (0x%08x); " REMEDY,
                        path, (unsigned)table->crc32);
}

/// Read the ends of the part where the table reaches beyond them; without them it ends with the
/// table.
static bool read_gauge(sim_design_t *d, const cJSON *design, const char *path, common_error_t *e)
{
    const cJSON *gauge = cJSON_GetObjectItemCaseSensitive(design, "gauge_mm");
    if (gauge == NULL) {
        return true;
    }
    const double first_mm = d->z_first_mm;
    const double last_mm = d->z_last_mm;
    const bool is_good = cJSON_GetArraySize(gauge) == 2 &&
                         sim_json_number(cJSON_GetArrayItem(gauge, 0), &d->z_first_mm) &&
                         sim_json_number(cJSON_GetArrayItem(gauge, 1), &d->z_last_mm) &&
                         d->z_first_mm >= first_mm - ROUNDING_MM &&
                         d->z_last_mm <= last_mm + ROUNDING_MM && d->z_first_mm < d->z_last_mm;
    d->is_run_into = d->z_first_mm > first_mm + ROUNDING_MM;
    d->is_run_out_of = d->z_last_mm < last_mm - ROUNDING_MM;
    return is_good ||
           common_error(e,
                        "%s: design.gauge_mm: wants two rising heights inside the table's, "
                        "%.12g .. %.12g mm; " REMEDY,
                        path, first_mm, last_mm);
}

static bool read_root(sim_design_t *d, const cJSON *root, const cam_table_t *table,
                      const char *path, common_error_t *e)
{
    const cJSON *design = cJSON_GetObjectItemCaseSensitive(root, "design");
    if (!cJSON_IsObject(design)) {
        return common_error(e, "%s: design: missing, so there is nothing to gauge against; " REMEDY,
                            path);
    }
    if (!check_crc(root, table, path, e)) {
        return false;
    }
    if (table->angle.knots != NULL) {
        d->shape = sim_shape_lobes;
        return sim_lobe_design_read(&d->lobes, design, path, e);
    }
    if (!read_gauge(d, design, path, e) || !read_shape(d, design, path, e) ||
        !sim_json_cubics(&d->radius_mm, design, "design", "radius_mm", path, e)) {
        return false;
    }
    const cJSON *surface = cJSON_GetObjectItemCaseSensitive(design, "surface");
    return d->shape == sim_shape_surface
               ? sim_surface_read(&d->surface, surface, path, e)
               : sim_json_cubics(&d->ovality_mm, design, "design", "ovality_mm", path, e);
}

static void begin(sim_design_t *d, const cam_table_t *table)
{
    *d = (sim_design_t){.at_z_mm = NAN, .table = table};
    d->z_first_mm = table->z_first_nm / SIM_NM_PER_MM;
    d->z_last_mm = table->z_last_nm / SIM_NM_PER_MM;
}

bool sim_design_load(sim_design_t *d, const char *path, const cam_table_t *table, common_error_t *e)
{
    begin(d, table);
    sim_file_t file;
    if (!sim_file_read(&file, path, max_report_bytes, e)) {
        return false;
    }
    cJSON *root = cJSON_ParseWithLength((const char *)file.bytes, file.size);
    sim_file_free(&file);
    const bool is_good = root != NULL ? read_root(d, root, table, path, e)
                                      : common_error(e, "%s: is no JSON; " REMEDY, path);
    cJSON_Delete(root);
    if (!is_good) {
        sim_design_free(d);
        return false;
    }
    d->largest_mm = d->shape == sim_shape_lobes
                        ? d->lobes.base_mm + sim_lobe_design_lift_mm(&d->lobes)
                        : sim_design_find_largest_mm(d);
    return true;
}

void sim_design_from_table(sim_design_t *d, const cam_table_t *table)
{
    begin(d, table);
    d->shape = sim_shape_table;
    // X is the largest radius, or where u swings about a mean, less than that by the least u.
    const double above_nm = table->u_min_nm < -1 ? -(double)table->u_min_nm : 0.0;
    d->largest_mm = sim_design_find_largest_mm(d) + above_nm / SIM_NM_PER_MM;
}
