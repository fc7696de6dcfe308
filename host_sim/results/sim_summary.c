// SPDX-License-Identifier: Apache-2.0
#include "sim_summary.h"
#include "cam_state.h" // cam_fault_name
#include <math.h>      // sqrt

void sim_summary_number(cJSON *object, const char *key, double value)
{
    (void)cJSON_AddNumberToObject(object, key, value);
}

void sim_summary_text(cJSON *object, const char *key, const char *text)
{
    (void)cJSON_AddStringToObject(object, key, text);
}

void sim_summary_sampled(cJSON *object, const sim_session_t *s, const char *key, double value)
{
    if (s->work.n > 0u) {
        sim_summary_number(object, key, value);
    } else {
        (void)cJSON_AddNullToObject(object, key);
    }
}

void sim_summary_faults(cJSON *root, const char *key, uint32_t faults)
{
    cJSON *list = cJSON_AddArrayToObject(root, key);
    for (int i = 0; i < cam_n_faults; i++) {
        if ((faults >> i & 1u) != 0u) {
            (void)cJSON_AddItemToArray(list, cJSON_CreateString(cam_fault_name((cam_fault_t)i)));
        }
    }
}

/// @return the errors of a gauge, as an object of the summary
static cJSON *add_errors(cJSON *root, const char *key, const sim_session_t *s, const sim_work_t *w)
{
    cJSON *errors = cJSON_AddObjectToObject(root, key);
    sim_summary_sampled(errors, s, "max", w->max_um);
    sim_summary_sampled(errors, s, "rms", sim_work_rms_um(w));
    sim_summary_sampled(errors, s, "roundness", sim_work_roundness_um(w));
    sim_summary_sampled(errors, s, "max_at_turn", w->max_turn);
    sim_summary_sampled(errors, s, "max_at_z_mm", w->max_z_mm);
    return errors;
}

/// Add what was found in each zone; nothing of a zone in which nothing was gauged.
static void add_zones(cJSON *root, const sim_session_t *s)
{
    const sim_areas_t *areas = &s->design.areas;
    cJSON *list = areas->n_zones > 0 ? cJSON_AddArrayToObject(root, "zones") : NULL;
    for (int i = 0; i < areas->n_zones; i++) {
        const sim_zone_t *z = &areas->zone[i];
        cJSON *object = cJSON_CreateObject();
        sim_summary_text(object, "name", z->name);
        sim_summary_number(object, "samples", (double)z->n);
        const double tolerance_um = sim_zone_tolerance_um(z, s->options.tolerance_um);
        sim_summary_number(object, "tolerance_um", tolerance_um);
        if (z->n > 0u) {
            sim_summary_number(object, "max_um", z->max_um);
            sim_summary_number(object, "rms_um", sqrt(z->sum_um2 / (double)z->n));
            sim_summary_number(object, "max_at_turn", z->max_turn);
            sim_summary_number(object, "max_at_z_mm", z->max_z_mm);
            sim_summary_number(object, "excess_um", z->excess_um);
            (void)cJSON_AddBoolToObject(object, "is_good", z->excess_um <= 0.0);
        }
        (void)cJSON_AddItemToArray(list, object);
    }
}

void sim_summary_errors(cJSON *root, const sim_session_t *s)
{
    cJSON *form = add_errors(root, "form_error_um", s, &s->work);
    sim_summary_number(form, "tolerance", s->options.tolerance_um);
    if (s->design.areas.n_zones > 0) {
        const double rest_um = s->design.areas.rest_um;
        sim_summary_sampled(form, s, "excess", s->design.areas.excess_um);
        (void)cJSON_AddBoolToObject(form, "is_good_beside_zones", rest_um <= 0.0);
    }
    if (s->design.shape != sim_shape_lobes) {
        sim_summary_sampled(form, s, "turned_urad", sim_work_turned_rad(&s->work) * 1e6);
        sim_summary_sampled(form, s, "rms_not_turned", sim_work_shape_rms_um(&s->work));
        if (s->work.has_map) {
            sim_summary_sampled(form, s, "max_not_turned", sim_work_shape_max_um(&s->work));
        }
    }
    add_zones(root, s);
    (void)add_errors(root, "control_error_um", s, sim_session_control(s));
    cJSON *following = cJSON_AddObjectToObject(root, "following_error_um");
    sim_summary_sampled(following, s, "max", s->following_max_um);
    sim_summary_sampled(following, s, "rms", sim_session_following_rms_um(s));
}

void sim_summary_progress(cJSON *cut, const sim_session_t *s)
{
    sim_summary_number(cut, "turns", s->cut_turns);
    sim_summary_number(cut, "seconds", s->cut_s);
    sim_summary_number(cut, "samples", (double)s->work.n);
    sim_summary_number(cut, "blank_radius_mm", s->work.blank_mm);
    sim_summary_number(cut, "removed_mm3", s->work.removed_mm3);
    sim_summary_number(cut, "gouge_um", s->work.gouge_um);
}

char *sim_summary_print(cJSON *root)
{
    char *text = cJSON_Print(root);
    cJSON_Delete(root);
    return text;
}
