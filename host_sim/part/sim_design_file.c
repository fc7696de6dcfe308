// SPDX-License-Identifier: Apache-2.0
#include "sim_design.h"
#include "cam_eval.h"  // cam_feed_profile_z_last_nm
#include "sim_file.h"  // sim_file_read
#include "sim_json.h"  // sim_json_cubics
#include "sim_units.h" // SIM_NM_PER_MM
#include <cjson/cJSON.h>
#include <math.h>   // NAN
#include <stdio.h>  // snprintf
#include <stdlib.h> // strtoul
#include <string.h> // strcmp

enum { max_report_bytes = 64 * 1024 * 1024 };

#define REMEDY SIM_JSON_REMEDY

/// [mm] tolerance for heights, which are whole nanometres in a table.
#define ROUNDING_MM 2e-6

/// Source of a reading: the drawing or the target, and its name for messages.
typedef struct {
    const cJSON *tree;
    const char *name, *path;
    common_error_t *e;
} source_t;

/// Read a shape. @param n  number of allowed names
static bool read_name(sim_shape_t *shape, const source_t *from, const char *key, int n)
{
    static const char *const name[] = {"ellipse", "cosine",      "double-ellipse",
                                       "surface", "ellipse-arc", "sides"};
    static const sim_shape_t known[] = {
        sim_shape_ellipse, sim_shape_cosine, sim_shape_double_ellipse,
        sim_shape_surface, sim_shape_arc,    sim_shape_sides};
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(from->tree, key);
    const char *text = cJSON_IsString(item) ? item->valuestring : "?";
    for (int i = 0; i < n; i++) {
        if (strcmp(text, name[i]) == 0) {
            *shape = known[i];
            return true;
        }
    }
    return common_error(
        from->e, "%s: %s.%s = \"%.40s\": must be ellipse, cosine, double-ellipse%s; " REMEDY,
        from->path, from->name, key, text, n > 3 ? ", surface, ellipse-arc or sides" : "");
}

static bool read_beta(sim_design_t *d, const source_t *from)
{
    const cJSON *beta = cJSON_GetObjectItemCaseSensitive(from->tree, "beta");
    return sim_json_number(beta, &d->beta) ||
           common_error(from->e, "%s: %s.beta: must be a finite number; " REMEDY, from->path,
                        from->name);
}

static bool read_cubics(sim_cubics_t *p, const source_t *from, const char *name)
{
    return sim_json_cubics(p, from->tree, from->name, name, from->path, from->e);
}

static bool read_arc(sim_design_t *d, const source_t *from)
{
    return read_name(&d->oval, from, "base", 3) &&
           (d->oval != sim_shape_double_ellipse || read_beta(d, from)) &&
           read_cubics(&d->trim_mm, from, "trim_mm") &&
           read_cubics(&d->joint_turn, from, "joint_turn");
}

static bool read_outline(sim_design_t *d, const source_t *from)
{
    d->is_turned = cJSON_HasObjectItem(from->tree, "phase_rad");
    if (!read_name(&d->shape, from, "shape", 6) || !read_cubics(&d->radius_mm, from, "radius_mm") ||
        (d->is_turned && !read_cubics(&d->phase_rad, from, "phase_rad"))) {
        return false;
    }
    if (d->shape == sim_shape_sides) {
        return sim_sides_read(&d->sides, from->tree, from->name, from->path, from->e);
    }
    if (d->shape == sim_shape_surface) {
        char where[32];
        (void)snprintf(where, sizeof where, "%s.surface", from->name);
        const cJSON *surface = cJSON_GetObjectItemCaseSensitive(from->tree, "surface");
        return sim_surface_read(&d->surface, surface, where, from->path, from->e);
    }
    return read_cubics(&d->ovality_mm, from, "ovality_mm") &&
           (d->shape != sim_shape_double_ellipse || read_beta(d, from)) &&
           (d->shape != sim_shape_arc || read_arc(d, from));
}

static bool read_skirt(sim_design_t *d, const source_t *from)
{
    return read_outline(d, from) &&
           sim_correction_read(&d->correction, from->tree, from->name, from->path, from->e);
}

/// Check that the report's CRC-32, a number or hexadecimal text, is the table's.
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

/// Read the ends of the part, if the table extends beyond them; otherwise they are the table's.
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
                        "%s: design.gauge_mm: must be two rising heights inside the table's, "
                        "%.12g .. %.12g mm; " REMEDY,
                        path, first_mm, last_mm);
}

/// Read the nose of the tool for which the table is made; without a tool it is a point.
static bool read_tool(sim_design_t *d, const cJSON *root, const char *path, common_error_t *e)
{
    const cJSON *tool = cJSON_GetObjectItemCaseSensitive(root, "tool");
    const cJSON *nose = cJSON_GetObjectItemCaseSensitive(tool, "nose_radius_mm");
    return nose == NULL || (sim_json_number(nose, &d->nose_mm) && d->nose_mm >= 0.0) ||
           common_error(e, "%s: tool.nose_radius_mm: must be a number of at least 0; " REMEDY,
                        path);
}

static bool read_design(sim_design_t *d, const cJSON *root, const char *path, common_error_t *e)
{
    const source_t from = {cJSON_GetObjectItemCaseSensitive(root, "design"), "design", path, e};
    if (!cJSON_IsObject(from.tree)) {
        return common_error(e, "%s: design: missing, so there is nothing to gauge against; " REMEDY,
                            path);
    }
    if (!check_crc(root, d->table, path, e)) {
        return false;
    }
    if (d->table->angle.knots != NULL) {
        d->shape = sim_shape_lobes;
        return sim_lobe_design_read(&d->lobes, from.tree, path, e);
    }
    return read_tool(d, root, path, e) && read_gauge(d, from.tree, path, e) &&
           sim_areas_read(&d->areas, from.tree, path, e) &&
           sim_bands_read(&d->bands, from.tree, path, e) && read_skirt(d, &from);
}

static void begin(sim_design_t *d, const cam_table_t *table)
{
    *d = (sim_design_t){.at_z_mm = NAN, .table = table};
    d->z_first_mm = table->z_first_nm / SIM_NM_PER_MM;
    d->z_last_mm = cam_feed_profile_z_last_nm(table) / SIM_NM_PER_MM;
}

/// @return the report as a tree, which the caller deletes; NULL and *e on failure
static cJSON *parse(const char *path, common_error_t *e)
{
    sim_file_t file;
    if (!sim_file_read(&file, path, max_report_bytes, e)) {
        return NULL;
    }
    cJSON *root = cJSON_ParseWithLength((const char *)file.bytes, file.size);
    sim_file_free(&file);
    if (root == NULL) {
        (void)common_error(e, "%s: is not JSON; " REMEDY, path);
    }
    return root;
}

bool sim_design_load(sim_design_t *d, const char *path, const cam_table_t *table, common_error_t *e)
{
    begin(d, table);
    cJSON *root = parse(path, e);
    const bool is_good = root != NULL && read_design(d, root, path, e);
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

bool sim_design_load_target(sim_design_t *d, bool *is_there, const char *path,
                            const cam_table_t *table, common_error_t *e)
{
    begin(d, table);
    cJSON *root = parse(path, e);
    const source_t from = {cJSON_GetObjectItemCaseSensitive(root, "target"), "target", path, e};
    *is_there = from.tree != NULL;
    const bool is_good = root != NULL && (!*is_there || read_skirt(d, &from));
    cJSON_Delete(root);
    if (!is_good) {
        sim_design_free(d);
    }
    return is_good;
}

void sim_design_from_table(sim_design_t *d, const cam_table_t *table)
{
    begin(d, table);
    d->shape = sim_shape_table;
    // X is the largest radius; if u oscillates about a mean, X is smaller by the least u.
    const double above_nm = table->u_min_nm < -1 ? -(double)table->u_min_nm : 0.0;
    d->largest_mm = sim_design_find_largest_mm(d) + above_nm / SIM_NM_PER_MM;
}
