// SPDX-License-Identifier: Apache-2.0
#include "camsim_summary.h"
#include "camsim_cam.h" // camsim_cam_json
#include "sim_units.h"  // SIM_TWO_PI
#include <cjson/cJSON.h>
#include <stdio.h>  // printf
#include <string.h> // strrchr

const char *camsim_summary_end(const sim_cut_t *cut)
{
    static const char *const name[] = {"running", "done", "fault", "timeout", "refused", "lost"};
    return cut->end == sim_cut_done && cut->is_stopped ? "stopped" : name[cut->end];
}

bool camsim_summary_is_good(const camsim_options_t *options, const sim_cut_t *cut)
{
    return cut->end == sim_cut_done && sim_cut_is_gauged(cut) &&
           cut->work.max_um <= options->tolerance_um;
}

/// Folders differ between machines and runs, names do not.
static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

static void number(cJSON *object, const char *key, double value)
{
    (void)cJSON_AddNumberToObject(object, key, value);
}

/// A number that exists only when there were samples.
static void sampled(cJSON *object, const sim_cut_t *cut, const char *key, double value)
{
    if (cut->work.n > 0u) {
        number(object, key, value);
    } else {
        (void)cJSON_AddNullToObject(object, key);
    }
}

static double rpm_of(const sim_cut_t *cut)
{
    return cut->feasibility.speed_mrpm * 1e-3;
}

static void add_what(cJSON *root, const camsim_options_t *options, const sim_cut_t *cut)
{
    (void)cJSON_AddStringToObject(root, "camsim", CAMSIM_VERSION);
    (void)cJSON_AddStringToObject(root, "part", cut->table.name);
    (void)cJSON_AddStringToObject(root, "table", base_name(options->table_path));
    number(root, "table_crc32", cut->table.crc32);
    number(root, "table_bytes", cut->table.image_size);
    (void)cJSON_AddStringToObject(root, "machine", cut->options.config.name);
    number(root, "seed", (double)cut->options.seed);
    cJSON *gauge = cJSON_AddObjectToObject(root, "gauge");
    const char *design = cut->options.design_path;
    (void)cJSON_AddStringToObject(gauge, "reference", design != NULL ? "design" : "table");
    (void)cJSON_AddStringToObject(gauge, "file",
                                  base_name(design != NULL ? design : options->table_path));
}

static void add_faults(cJSON *root, const sim_cut_t *cut)
{
    const cam_status_t *status = sim_cut_status(cut);
    cJSON *list = cJSON_AddArrayToObject(root, "faults");
    for (int i = 0; i < cam_n_faults; i++) {
        if ((status->faults >> i & 1u) != 0u) {
            (void)cJSON_AddItemToArray(list, cJSON_CreateString(cam_fault_name((cam_fault_t)i)));
        }
    }
    if (cut->fault_s < 0.0) {
        return;
    }
    cJSON *first = cJSON_AddArrayToObject(root, "first_faults");
    for (int i = 0; i < cam_n_faults; i++) {
        if ((status->first_fault >> i & 1u) != 0u) {
            (void)cJSON_AddItemToArray(first, cJSON_CreateString(cam_fault_name((cam_fault_t)i)));
        }
    }
    cJSON *fault = cJSON_AddObjectToObject(root, "fault");
    number(fault, "time_s", cut->fault_s);
    sampled(fault, cut, "time_of_cutting_s", cut->fault_s - cut->cut_at_s);
    number(fault, "retract_s", cut->sample_s - cut->fault_s);
    number(fault, "turn", cut->fault_turn);
    number(fault, "z_mm", cut->fault_z_mm);
    (void)cJSON_AddStringToObject(fault, "state", cam_state_name(cut->fault_state));
}

static void add_errors(cJSON *root, const camsim_options_t *options, const sim_cut_t *cut)
{
    cJSON *form = cJSON_AddObjectToObject(root, "form_error_um");
    sampled(form, cut, "max", cut->work.max_um);
    sampled(form, cut, "rms", sim_work_rms_um(&cut->work));
    sampled(form, cut, "roundness", sim_work_roundness_um(&cut->work));
    sampled(form, cut, "max_at_turn", cut->work.max_turn);
    sampled(form, cut, "max_at_z_mm", cut->work.max_z_mm);
    number(form, "tolerance", options->tolerance_um);
    cJSON *following = cJSON_AddObjectToObject(root, "following_error_um");
    sampled(following, cut, "max", cut->following_max_um);
    sampled(following, cut, "rms", sim_cut_following_rms_um(cut));
}

static void add_cut(cJSON *root, const sim_cut_t *cut)
{
    cJSON *object = cJSON_AddObjectToObject(root, "cut");
    number(object, "spindle_rpm", rpm_of(cut));
    number(object, "feed_mm", sim_cut_feed_mm(cut));
    (void)cJSON_AddStringToObject(object, "path",
                                  cut->table.is_ring_helix ? "ring-helix" : "helix");
    number(object, "planned_turns", sim_cut_planned_turns(cut));
    number(object, "turns", cut->cut_turns);
    number(object, "seconds", cut->cut_s);
    number(object, "samples", (double)cut->work.n);
    number(object, "blank_radius_mm", cut->work.blank_mm);
    sampled(object, cut, "depth_min_mm", cut->work.depth_min_mm);
    sampled(object, cut, "depth_max_mm", cut->work.depth_max_mm);
    number(object, "removed_mm3", cut->work.removed_mm3);
    number(object, "gouge_um", cut->work.gouge_um);
}

static void add_margin(cJSON *root, const char *key, double needed, double limit)
{
    cJSON *margin = cJSON_AddObjectToObject(root, key);
    number(margin, "needed", needed);
    number(margin, "limit", limit);
    number(margin, "margin", needed > 0.0 ? limit / needed : 1e9);
}

static void add_feasibility(cJSON *root, const sim_cut_t *cut)
{
    const cam_params_t *p = &cut->params;
    const double omega = rpm_of(cut) * SIM_TWO_PI / 60.0;
    const double amplitude = p->amplitude_ppm * 1e-6;
    const double u_nm =
        cut->table.u_max_nm > -cut->table.u_min_nm ? cut->table.u_max_nm : -cut->table.u_min_nm;
    cJSON *object = cJSON_AddObjectToObject(root, "feasibility");
    number(object, "highest_rpm", cut->feasibility.highest_mrpm * 1e-3);
    add_margin(object, "u_speed_mm_s", cut->table.u1_peak_nm_per_rad * 1e-6 * omega * amplitude,
               p->u_speed_um_per_s * 1e-3);
    add_margin(object, "u_acceleration_mm_s2",
               cut->table.u2_peak_nm_per_rad2 * 1e-6 * omega * omega * amplitude,
               p->u_acceleration_mm_per_s2);
    add_margin(object, "u_stroke_mm", 2e-6 * u_nm * amplitude, p->u_stroke_nm * 1e-6);
    const double peak = (double)cut->table.ratio_max_q20 / CAM_TABLE_RATIO_ONE;
    add_margin(object, "spindle_rpm", rpm_of(cut) * peak, p->spindle_limit_mrpm * 1e-3);
    add_margin(object, "spindle_acceleration_rad_s2",
               cut->table.spindle_peak_ppm * 1e-6 * omega * omega,
               p->spindle_acceleration_mrad_per_s2 * 1e-3);
}

static void add_spread(cJSON *root, const char *key, const sim_spread_t *s)
{
    cJSON *object = cJSON_AddObjectToObject(root, key);
    number(object, "mean", sim_spread_mean(s));
    number(object, "min", s->min);
    number(object, "max", s->max);
}

static void add_removal(cJSON *root, const sim_cut_t *cut)
{
    const sim_removal_t *r = &cut->removal;
    cJSON *object = cJSON_AddObjectToObject(root, "removal");
    number(object, "slice_s", r->config.slice_s);
    number(object, "kc_n_mm2", r->config.kc_n_mm2);
    number(object, "volume_mm3", r->removed_mm3);
    number(object, "turns", (double)r->rate_ripple.n);
    if (r->rate_ripple.n == 0u) {
        return;
    }
    add_spread(object, "rate_mm3_s", &r->rate);
    add_spread(object, "power_w", &r->power);
    add_spread(object, "rate_force_n", &r->rate_force);
    add_spread(object, "chip_force_n", &r->chip_force);
    add_spread(object, "rate_ripple", &r->rate_ripple);
    add_spread(object, "chip_force_ripple", &r->force_ripple);
}

static void add_scallop(cJSON *root, sim_cut_t *cut)
{
    const sim_scallop_t *s = &cut->scallop;
    if (s->nose_mm <= 0.0) {
        return;
    }
    const sim_scallop_figures_t f = sim_scallop_figures(s, &cut->design);
    cJSON *object = cJSON_AddObjectToObject(root, "scallop");
    number(object, "nose_mm", s->nose_mm);
    number(object, "z_first_mm", s->z_first_mm);
    number(object, "z_last_mm", s->z_last_mm);
    number(object, "peak_to_valley_max_um", f.highest_um);
    number(object, "peak_to_valley_min_um", f.lowest_um);
    number(object, "mean_um", f.mean_um);
}

static void add_parameters(cJSON *root, const sim_cut_t *cut)
{
    cJSON *object = cJSON_AddObjectToObject(root, "parameters");
    for (int i = 0; i < cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        number(object, cam_param_info(id)->name, cam_param_get(&cut->params, id));
    }
}

static void add_injects(cJSON *root, const sim_cut_t *cut)
{
    cJSON *list = cJSON_AddArrayToObject(root, "injected");
    for (uint32_t i = 0; i < cut->options.n_injects; i++) {
        const sim_inject_t *what = &cut->options.inject[i];
        cJSON *object = cJSON_CreateObject();
        (void)cJSON_AddStringToObject(object, "kind", sim_inject_name(what->kind));
        number(object, "at_s", what->at_s);
        number(object, "value", what->value);
        (void)cJSON_AddBoolToObject(object, "happened", what->is_done);
        (void)cJSON_AddItemToArray(list, object);
    }
}

static void add_time(cJSON *root, const sim_cut_t *cut, double wall_s)
{
    number(root, "machine_time_s", cut->machine.time_s);
    number(root, "ticks", (double)cut->n_ticks);
    number(root, "tick_hz", 1.0 / cut->machine.period_s);
    number(root, "wall_time_s", wall_s);
    number(root, "ticks_per_s", wall_s > 0.0 ? (double)cut->n_ticks / wall_s : 0.0);
}

bool camsim_summary_json(camsim_out_t *o, const camsim_options_t *options, sim_cut_t *cut,
                         double wall_s)
{
    cJSON *root = cJSON_CreateObject();
    add_what(root, options, cut);
    (void)cJSON_AddStringToObject(root, "end", camsim_summary_end(cut));
    (void)cJSON_AddBoolToObject(root, "is_good", camsim_summary_is_good(options, cut));
    (void)cJSON_AddStringToObject(root, "state", cam_state_name(sim_cut_status(cut)->state));
    add_faults(root, cut);
    add_errors(root, options, cut);
    add_cut(root, cut);
    add_feasibility(root, cut);
    camsim_cam_json(root, cut);
    if (!camsim_cam_is(cut)) {
        add_removal(root, cut);
    }
    add_scallop(root, cut);
    add_time(root, cut, wall_s);
    add_injects(root, cut);
    add_parameters(root, cut);
    char *text = cJSON_Print(root);
    cJSON_Delete(root);
    if (text == NULL) {
        return false;
    }
    camsim_out_text(o, text);
    camsim_out_char(o, '\n');
    cJSON_free(text);
    return true;
}

void camsim_summary_text(const camsim_options_t *options, const sim_cut_t *cut, double wall_s)
{
    const char *reference = cut->options.design_path != NULL ? "exact design" : "table";
    (void)printf("%s on machine %s: %.6g r/min, feed %.6g mm, %.1f of %.1f turns, %s\n",
                 cut->table.name, cut->options.config.name, rpm_of(cut), sim_cut_feed_mm(cut),
                 cut->cut_turns, sim_cut_planned_turns(cut), camsim_summary_end(cut));
    if (cut->work.n > 0u) {
        (void)printf(
            "form error      max %.4f um, rms %.4f um against the %s (tolerance %.6g um)\n",
            cut->work.max_um, sim_work_rms_um(&cut->work), reference, options->tolerance_um);
        (void)printf("following error max %.4f um, rms %.4f um\n", cut->following_max_um,
                     sim_cut_following_rms_um(cut));
    } else {
        (void)printf("form error      not gauged: nothing was cut to full depth\n");
    }
    camsim_cam_text(cut);
    (void)printf("machine time    %.3f s in %.3f s, %.2f million ticks/s\n", cut->machine.time_s,
                 wall_s, wall_s > 0.0 ? (double)cut->n_ticks / wall_s * 1e-6 : 0.0);
}
