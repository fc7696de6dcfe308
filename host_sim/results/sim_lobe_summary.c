// SPDX-License-Identifier: Apache-2.0
#include "sim_summary.h"
#include "sim_lobe_cut.h" // sim_lobe_cut_due_mm_s
#include "sim_units.h"    // sim_abs

double sim_summary_off_plan_percent(const sim_session_t *s)
{
    const double low = sim_abs(s->lobes.off_plan.min);
    const double high = sim_abs(s->lobes.off_plan.max);
    return 100.0 * (low > high ? low : high);
}

static void add_lobe(cJSON *list, const sim_session_t *s, uint32_t i)
{
    const sim_lobe_gauge_t *g = &s->lobes.gauge[i];
    const sim_lobe_t *lobe = &s->design.lobes.lobe[i];
    cJSON *object = cJSON_CreateObject();
    sim_summary_number(object, "z_first_mm", lobe->z_first_mm);
    sim_summary_number(object, "z_last_mm", lobe->z_last_mm);
    sim_summary_number(object, "samples", (double)g->n);
    if (g->n > 0u) {
        sim_summary_number(object, "max_um", g->max_um);
        sim_summary_number(object, "rms_um", sim_lobe_gauge_rms_um(g));
        sim_summary_number(object, "max_at_turn", g->max_turn);
        sim_summary_number(object, "max_at_z_mm", g->max_z_mm);
    }
    (void)cJSON_AddItemToArray(list, object);
}

static void add_speed(cJSON *cam, const sim_session_t *s)
{
    const sim_spread_t *speed = &s->lobes.speed_mm_s;
    if (speed->n == 0u) {
        return;
    }
    cJSON *object = cJSON_AddObjectToObject(cam, "surface_speed_mm_s");
    sim_summary_number(object, "base_circle", sim_lobe_cut_due_mm_s(s));
    sim_summary_number(object, "mean", sim_spread_mean(speed));
    sim_summary_number(object, "min", speed->min);
    sim_summary_number(object, "max", speed->max);
    sim_summary_number(object, "off_plan_percent", sim_summary_off_plan_percent(s));
}

static void add_rake(cJSON *cam, const sim_session_t *s)
{
    const sim_lobe_work_t *w = &s->lobes;
    if (!s->design.lobes.is_turned || w->rake_deg.n == 0u) {
        return;
    }
    cJSON *object = cJSON_AddObjectToObject(cam, "rake_deg");
    sim_summary_number(object, "min", w->rake_deg.min);
    sim_summary_number(object, "max", w->rake_deg.max);
    sim_summary_number(object, "without_swing_min", w->unswung_deg.min);
    sim_summary_number(object, "without_swing_max", w->unswung_deg.max);
}

void sim_summary_lobes(cJSON *root, const sim_session_t *s)
{
    if (s->design.shape != sim_shape_lobes) {
        return;
    }
    const sim_lobe_design_t *d = &s->design.lobes;
    cJSON *cam = cJSON_AddObjectToObject(root, "cam");
    sim_summary_text(cam, "operation", d->is_turned ? "turning" : "grinding");
    sim_summary_number(cam, d->is_turned ? "tip_mm" : "wheel_mm",
                       d->is_turned ? s->lobes.circle_mm : s->lobes.whole_mm);
    cJSON *lobes = cJSON_AddArrayToObject(cam, "lobes");
    for (uint32_t i = 0; i < d->n_lobes; i++) {
        add_lobe(lobes, s, i);
    }
    add_speed(cam, s);
    add_rake(cam, s);
}
