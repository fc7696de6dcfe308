// SPDX-License-Identifier: Apache-2.0
#include "sim_cut_summary.h"
#include "hal/version.h"  // CAMTURN_VERSION
#include "sim_cut_pass.h" // sim_cut_pass_result
#include "sim_summary.h"  // sim_summary_number
#include "sim_units.h"    // SIM_TWO_PI
#include <string.h>       // strrchr

/// @return the file name only, because folders differ between computers and runs
static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

static void add_what(cJSON *root, const sim_cut_t *cut, const char *table_path)
{
    sim_summary_text(root, "camsim", CAMTURN_VERSION);
    sim_summary_text(root, "part", cut->session.table.name);
    sim_summary_text(root, "table", base_name(table_path));
    sim_summary_number(root, "table_crc32", cut->session.table.crc32);
    sim_summary_number(root, "table_bytes", cut->session.table.image_size);
    sim_summary_text(root, "machine", cut->session.options.config.name);
    sim_summary_number(root, "seed", (double)cut->session.options.seed);
    cJSON *gauge = cJSON_AddObjectToObject(root, "gauge");
    const char *design = cut->session.options.design_path;
    sim_summary_text(gauge, "reference", design != NULL ? "design" : "table");
    sim_summary_text(gauge, "file", base_name(design != NULL ? design : table_path));
}

static void add_tool(cJSON *root, const sim_session_t *s)
{
    if (s->design.shape == sim_shape_lobes) {
        return;
    }
    cJSON *tool = cJSON_AddObjectToObject(root, "tool");
    sim_summary_number(tool, "nose_mm", s->nose.nose_mm);
    sim_summary_number(tool, "made_for_mm", s->design.nose_mm);
    sim_summary_number(tool, "wear_um", s->options.config.lathe.tool_wear_um);
}

static void add_faults(cJSON *root, const sim_cut_t *cut)
{
    const cam_status_t status = sim_cut_status(cut);
    sim_summary_faults(root, "faults", status.faults);
    if (cut->fault_s < 0.0) {
        return;
    }
    sim_summary_faults(root, "first_faults", status.first_fault);
    cJSON *fault = cJSON_AddObjectToObject(root, "fault");
    sim_summary_number(fault, "time_s", cut->fault_s);
    sim_summary_sampled(fault, &cut->session, "time_of_cutting_s",
                        cut->fault_s - cut->session.cut_at_s);
    sim_summary_number(fault, "retract_s", cut->session.at.t_s - cut->fault_s);
    sim_summary_number(fault, "turn", cut->fault_turn);
    sim_summary_number(fault, "z_mm", cut->fault_z_mm);
    sim_summary_text(fault, "state", cam_state_name(cut->fault_state));
}

static void add_cut(cJSON *root, const sim_cut_t *cut)
{
    cJSON *object = cJSON_AddObjectToObject(root, "cut");
    sim_summary_number(object, "spindle_rpm", sim_cut_rpm(cut));
    sim_summary_number(object, "feed_mm", sim_cut_feed_mm(cut));
    sim_summary_text(object, "path", cut->session.table.is_ring_helix ? "ring-helix" : "helix");
    sim_summary_number(object, "planned_turns", sim_cut_planned_turns(cut));
    sim_summary_progress(object, &cut->session);
    sim_summary_sampled(object, &cut->session, "depth_min_mm", cut->session.work.depth_min_mm);
    sim_summary_sampled(object, &cut->session, "depth_max_mm", cut->session.work.depth_max_mm);
}

static void add_margin(cJSON *root, const char *key, double needed, double limit)
{
    cJSON *margin = cJSON_AddObjectToObject(root, key);
    sim_summary_number(margin, "needed", needed);
    sim_summary_number(margin, "limit", limit);
    sim_summary_number(margin, "margin", needed > 0.0 ? limit / needed : 1e9);
}

static void add_feasibility(cJSON *root, const sim_cut_t *cut)
{
    const cam_params_t *p = &cut->params;
    const double omega = sim_cut_rpm(cut) * SIM_TWO_PI / 60.0;
    const double amplitude = p->amplitude_ppm * 1e-6;
    const double u_nm = cut->session.table.u_max_nm > -cut->session.table.u_min_nm
                            ? cut->session.table.u_max_nm
                            : -cut->session.table.u_min_nm;
    cJSON *object = cJSON_AddObjectToObject(root, "feasibility");
    sim_summary_number(object, "highest_rpm", cut->feasibility.highest_mrpm * 1e-3);
    add_margin(object, "u_speed_mm_s",
               cut->session.table.u1_peak_nm_per_rad * 1e-6 * omega * amplitude,
               p->u_speed_um_per_s * 1e-3);
    add_margin(object, "u_acceleration_mm_s2",
               cut->session.table.u2_peak_nm_per_rad2 * 1e-6 * omega * omega * amplitude,
               p->u_acceleration_mm_per_s2);
    add_margin(object, "u_stroke_mm", 2e-6 * u_nm * amplitude, p->u_stroke_nm * 1e-6);
    const double peak = (double)cut->session.table.ratio_max_q20 / CAM_TABLE_RATIO_ONE;
    add_margin(object, "spindle_rpm", sim_cut_rpm(cut) * peak, p->spindle_limit_mrpm * 1e-3);
    add_margin(object, "spindle_acceleration_rad_s2",
               cut->session.table.spindle_peak_ppm_per_rad * 1e-6 * omega * omega,
               p->spindle_acceleration_mrad_per_s2 * 1e-3);
}

static void add_spread(cJSON *root, const char *key, const sim_spread_t *s)
{
    cJSON *object = cJSON_AddObjectToObject(root, key);
    sim_summary_number(object, "mean", sim_spread_mean(s));
    sim_summary_number(object, "min", s->min);
    sim_summary_number(object, "max", s->max);
}

static void add_removal(cJSON *root, const sim_cut_t *cut)
{
    const sim_removal_t *r = &cut->removal;
    cJSON *object = cJSON_AddObjectToObject(root, "removal");
    sim_summary_number(object, "slice_s", r->config.slice_s);
    sim_summary_number(object, "kc_n_mm2", r->config.kc_n_mm2);
    if (r->config.size_exponent > 0.0) {
        sim_summary_number(object, "kc_exponent", r->config.size_exponent);
    }
    sim_summary_number(object, "volume_mm3", r->removed_mm3);
    sim_summary_number(object, "turns", (double)r->rate_ripple.n);
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
    const sim_scallop_t *s = &cut->session.scallop;
    if (s->nose_mm <= 0.0) {
        return;
    }
    const sim_scallop_figures_t f = sim_scallop_figures(s, sim_session_played(&cut->session));
    cJSON *object = cJSON_AddObjectToObject(root, "scallop");
    sim_summary_number(object, "nose_mm", s->nose_mm);
    sim_summary_number(object, "z_first_mm", s->z_first_mm);
    sim_summary_number(object, "z_last_mm", s->z_last_mm);
    sim_summary_number(object, "peak_to_valley_max_um", f.highest_um);
    sim_summary_number(object, "peak_to_valley_min_um", f.lowest_um);
    sim_summary_number(object, "mean_um", f.mean_um);
}

static void add_injects(cJSON *root, const sim_cut_t *cut)
{
    cJSON *list = cJSON_AddArrayToObject(root, "injected");
    for (uint32_t i = 0; i < cut->session.options.n_injects; i++) {
        const sim_inject_t *what = &cut->session.options.inject[i];
        cJSON *object = cJSON_CreateObject();
        sim_summary_text(object, "kind", sim_inject_name(what->kind));
        sim_summary_number(object, "at_s", what->at_s);
        sim_summary_number(object, "value", what->value);
        (void)cJSON_AddBoolToObject(object, "happened", what->is_done);
        (void)cJSON_AddItemToArray(list, object);
    }
}

static void add_pass(cJSON *list, const sim_cut_t *cut, uint32_t i)
{
    const sim_pass_result_t r = i < cut->pass ? cut->result[i] : sim_cut_pass_result(cut);
    const double gouge_um = r.gouge_um - r.allowance_mm * 1e3;
    cJSON *object = cJSON_CreateObject();
    sim_summary_number(object, "pass", i + 1.0);
    sim_summary_number(object, "allowance_um", r.allowance_mm * 1e3);
    sim_summary_number(object, "spindle_rpm", r.rpm);
    sim_summary_number(object, "feed_mm", r.feed_mm);
    sim_summary_number(object, "turns", r.turns);
    sim_summary_number(object, "end_s", r.end_s);
    sim_summary_number(object, "samples", (double)r.n);
    cJSON *form = cJSON_AddObjectToObject(object, "form_error_um");
    sim_summary_number(form, "max", r.max_um);
    sim_summary_number(form, "rms", r.rms_um);
    sim_summary_number(object, "below_drawing_um", gouge_um > 0.0 ? gouge_um : 0.0);
    sim_summary_number(object, "depth_min_mm", r.depth_min_mm);
    sim_summary_number(object, "depth_max_mm", r.depth_max_mm);
    sim_summary_number(object, "volume_mm3", r.removed_mm3);
    add_spread(object, "rate_mm3_s", &r.rate);
    add_spread(object, "chip_force_n", &r.chip_force);
    (void)cJSON_AddItemToArray(list, object);
}

/// Form error of a pass, against the drawing plus the stock that it has to leave.
static void add_passes(cJSON *root, const sim_cut_t *cut)
{
    if (cut->session.table.n_passes == 0u) {
        return;
    }
    cJSON *list = cJSON_AddArrayToObject(root, "passes");
    for (uint32_t i = cut->first_pass; i <= cut->pass; i++) {
        add_pass(list, cut, i);
    }
}

/// State what a user may improve: a speed at which the encoder's counts average, a measured loop.
static void add_advice(cJSON *root, const sim_cut_t *cut)
{
    const double better_rpm = sim_cut_averaging_rpm(cut);
    if (better_rpm > 0.0) {
        sim_summary_number(root, "better_rpm", better_rpm);
    }
    if (sim_cut_is_loop_assumed(cut)) {
        (void)cJSON_AddBoolToObject(root, "is_loop_assumed", true);
    }
}

char *sim_cut_summary(sim_cut_t *cut, const char *table_path, double wall_s)
{
    cJSON *root = cJSON_CreateObject();
    add_what(root, cut, table_path);
    sim_summary_text(root, "end", sim_cut_end_name(cut));
    (void)cJSON_AddBoolToObject(root, "is_good", sim_cut_is_good(cut) && sim_cut_is_whole(cut));
    sim_summary_text(root, "state", cam_state_name(cut->firmware.state));
    add_faults(root, cut);
    sim_summary_errors(root, &cut->session);
    sim_summary_learning(root, cut);
    add_cut(root, cut);
    add_passes(root, cut);
    add_advice(root, cut);
    add_feasibility(root, cut);
    add_tool(root, &cut->session);
    sim_summary_lobes(root, &cut->session);
    if (cut->session.table.angle.knots == NULL) { // forces are measured on skirts only
        add_removal(root, cut);
    }
    add_scallop(root, cut);
    sim_summary_number(root, "machine_time_s", cut->port.time_s);
    sim_summary_number(root, "ticks", (double)cut->n_ticks);
    sim_summary_number(root, "tick_hz", 1.0 / cut->port.lathe.step_s);
    sim_summary_number(root, "wall_time_s", wall_s);
    sim_summary_number(root, "ticks_per_s", wall_s > 0.0 ? (double)cut->n_ticks / wall_s : 0.0);
    add_injects(root, cut);
    cJSON *parameters = cJSON_AddObjectToObject(root, "parameters");
    for (int i = 0; i < cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        sim_summary_number(parameters, cam_param_info(id)->name, cam_param_get(&cut->params, id));
    }
    return sim_summary_print(root);
}
