// SPDX-License-Identifier: Apache-2.0
#include "camsim_cam.h"
#include "sim_cam_cut.h" // sim_cam_cut_due_mm_s
#include "sim_units.h"   // sim_abs
#include <stdio.h>       // printf

bool camsim_cam_is(const sim_cut_t *cut)
{
    return cut->table.angle.knots != NULL;
}

bool camsim_cam_check(const camsim_options_t *options, const sim_cut_t *cut, sim_error_t *e)
{
    if (!camsim_cam_is(cut)) {
        return true;
    }
    if (cut->options.nose_mm > 0.0) {
        return sim_error(
            e, "--nose-mm %.12g: tracks are told of skirts only, %s is a cam; leave it out",
            cut->options.nose_mm, cut->table.name);
    }
    return options->removal_path == NULL ||
           sim_error(e, "--removal %s: forces are told of skirts only, %s is a cam; leave it out",
                     options->removal_path, cut->table.name);
}

static double largest(const sim_spread_t *s)
{
    const double low = sim_abs(s->min);
    const double high = sim_abs(s->max);
    return low > high ? low : high;
}

static void add_lobe(cJSON *list, const sim_cut_t *cut, uint32_t i)
{
    const sim_cam_gauge_t *g = &cut->cam.gauge[i];
    const sim_cam_lobe_t *lobe = &cut->design.cam.lobe[i];
    cJSON *object = cJSON_CreateObject();
    (void)cJSON_AddNumberToObject(object, "z_first_mm", lobe->z_first_mm);
    (void)cJSON_AddNumberToObject(object, "z_last_mm", lobe->z_last_mm);
    (void)cJSON_AddNumberToObject(object, "samples", (double)g->n);
    if (g->n > 0u) {
        (void)cJSON_AddNumberToObject(object, "max_um", g->max_um);
        (void)cJSON_AddNumberToObject(object, "rms_um", sim_cam_gauge_rms_um(g));
        (void)cJSON_AddNumberToObject(object, "max_at_turn", g->max_turn);
        (void)cJSON_AddNumberToObject(object, "max_at_z_mm", g->max_z_mm);
    }
    (void)cJSON_AddItemToArray(list, object);
}

static void add_speed(cJSON *cam, const sim_cut_t *cut)
{
    const sim_spread_t *s = &cut->cam.speed_mm_s;
    if (s->n == 0u) {
        return;
    }
    cJSON *object = cJSON_AddObjectToObject(cam, "surface_speed_mm_s");
    (void)cJSON_AddNumberToObject(object, "base_circle", sim_cam_cut_due_mm_s(cut));
    (void)cJSON_AddNumberToObject(object, "mean", sim_spread_mean(s));
    (void)cJSON_AddNumberToObject(object, "min", s->min);
    (void)cJSON_AddNumberToObject(object, "max", s->max);
    (void)cJSON_AddNumberToObject(object, "off_plan_percent", 100.0 * largest(&cut->cam.off_plan));
}

static void add_rake(cJSON *cam, const sim_cut_t *cut)
{
    const sim_cam_work_t *w = &cut->cam;
    if (!cut->design.cam.is_turned || w->rake_deg.n == 0u) {
        return;
    }
    cJSON *object = cJSON_AddObjectToObject(cam, "rake_deg");
    (void)cJSON_AddNumberToObject(object, "min", w->rake_deg.min);
    (void)cJSON_AddNumberToObject(object, "max", w->rake_deg.max);
    (void)cJSON_AddNumberToObject(object, "without_swing_min", w->unswung_deg.min);
    (void)cJSON_AddNumberToObject(object, "without_swing_max", w->unswung_deg.max);
}

void camsim_cam_json(cJSON *root, const sim_cut_t *cut)
{
    if (cut->design.shape != sim_shape_cam) {
        return;
    }
    const sim_cam_design_t *d = &cut->design.cam;
    cJSON *cam = cJSON_AddObjectToObject(root, "cam");
    (void)cJSON_AddStringToObject(cam, "operation", d->is_turned ? "turning" : "grinding");
    (void)cJSON_AddNumberToObject(cam, d->is_turned ? "tip_mm" : "wheel_mm", cut->cam.circle_mm);
    cJSON *lobes = cJSON_AddArrayToObject(cam, "lobes");
    for (uint32_t i = 0; i < d->n_lobes; i++) {
        add_lobe(lobes, cut, i);
    }
    add_speed(cam, cut);
    add_rake(cam, cut);
}

static void print_lobe(const sim_cut_t *cut, uint32_t i)
{
    const sim_cam_gauge_t *g = &cut->cam.gauge[i];
    const sim_cam_lobe_t *lobe = &cut->design.cam.lobe[i];
    if (g->n == 0u) {
        (void)printf("lobe %u          %.6g .. %.6g mm: not cut\n", (unsigned)i, lobe->z_first_mm,
                     lobe->z_last_mm);
        return;
    }
    (void)printf("lobe %u          %.6g .. %.6g mm: max %.4f um at %.1f degrees, rms %.4f um\n",
                 (unsigned)i, lobe->z_first_mm, lobe->z_last_mm, g->max_um, 360.0 * g->max_turn,
                 sim_cam_gauge_rms_um(g));
}

void camsim_cam_text(const sim_cut_t *cut)
{
    if (cut->design.shape != sim_shape_cam || cut->work.n == 0u) {
        return;
    }
    const sim_cam_work_t *w = &cut->cam;
    for (uint32_t i = 0; cut->design.cam.n_lobes > 1u && i < cut->design.cam.n_lobes; i++) {
        print_lobe(cut, i);
    }
    (void)printf(
        "surface speed   %.3f .. %.3f mm/s, base circle %.3f; off the table's by %.2f %%\n",
        w->speed_mm_s.min, w->speed_mm_s.max, sim_cam_cut_due_mm_s(cut),
        100.0 * largest(&w->off_plan));
    if (cut->design.cam.is_turned) {
        (void)printf("effective rake  varies by %.4f .. %.4f degrees; without the swing by "
                     "%.2f .. %.2f\n",
                     w->rake_deg.min, w->rake_deg.max, w->unswung_deg.min, w->unswung_deg.max);
    }
}
