// SPDX-License-Identifier: Apache-2.0
#include "camsim.h"
#include "sim_cut_pass.h" // sim_cut_pass_result
#include "sim_lobe_cut.h" // sim_lobe_cut_due_mm_s
#include "sim_summary.h"  // sim_summary_off_plan_percent
#include <stdio.h>        // printf

static void print_lobes(const sim_session_t *s)
{
    if (s->design.shape != sim_shape_lobes || s->work.n == 0u) {
        return;
    }
    const sim_lobe_work_t *w = &s->lobes;
    for (uint32_t i = 0; s->design.lobes.n_lobes > 1u && i < s->design.lobes.n_lobes; i++) {
        const sim_lobe_gauge_t *g = &w->gauge[i];
        const sim_lobe_t *lobe = &s->design.lobes.lobe[i];
        (void)printf("lobe %u          %.6g .. %.6g mm: ", (unsigned)i, lobe->z_first_mm,
                     lobe->z_last_mm);
        if (g->n > 0u) {
            (void)printf("max %.4f um at %.1f degrees, rms %.4f um\n", g->max_um,
                         360.0 * g->max_turn, sim_lobe_gauge_rms_um(g));
        } else {
            (void)printf("not cut\n");
        }
    }
    (void)printf(
        "surface speed   %.3f .. %.3f mm/s, base circle %.3f; off the table's by %.2f %%\n",
        w->speed_mm_s.min, w->speed_mm_s.max, sim_lobe_cut_due_mm_s(s),
        sim_summary_off_plan_percent(s));
    if (s->design.lobes.is_turned) {
        (void)printf("effective rake  varies by %.4f .. %.4f degrees; without the swing by "
                     "%.2f .. %.2f\n",
                     w->rake_deg.min, w->rake_deg.max, w->unswung_deg.min, w->unswung_deg.max);
    }
}

static void print_passes(const sim_cut_t *cut)
{
    const uint32_t n = cut->session.table.n_passes;
    for (uint32_t i = cut->first_pass; n > 0u && i <= cut->pass; i++) {
        const sim_pass_result_t r = i < cut->pass ? cut->result[i] : sim_cut_pass_result(cut);
        (void)printf("pass %u of %u     %.6g r/min, feed %.6g mm, depth %.4f .. %.4f mm, leaves "
                     "%.6g um: max %.4f um\n",
                     (unsigned)i + 1u, (unsigned)n, r.rpm, r.feed_mm, r.depth_min_mm,
                     r.depth_max_mm, r.allowance_mm * 1e3, r.max_um);
    }
}

void camsim_print_zones(const sim_session_t *s)
{
    for (int i = 0; i < s->design.areas.n_zones; i++) {
        const sim_zone_t *zone = &s->design.areas.zone[i];
        (void)printf("zone %-10s max %.4f um (tolerance %.6g um%s), %s\n", zone->name, zone->max_um,
                     sim_zone_tolerance_um(zone, s->options.tolerance_um),
                     zone->has_band ? " and a band" : "",
                     zone->n == 0u            ? "not gauged"
                     : zone->excess_um <= 0.0 ? "good"
                                              : "out of tolerance");
    }
}

void camsim_print_cut(const sim_cut_t *cut, double wall_s)
{
    const sim_session_t *s = &cut->session;
    const char *reference = s->options.design_path != NULL ? "drawing" : "table";
    (void)printf("%s on machine %s: %.6g r/min, feed %.6g mm, %.1f of %.1f turns, %s\n",
                 s->table.name, s->options.config.name, sim_cut_rpm(cut), sim_cut_feed_mm(cut),
                 s->cut_turns, sim_cut_planned_turns(cut), sim_cut_end_name(cut));
    if (s->work.n > 0u) {
        (void)printf(
            "form error      max %.4f um, rms %.4f um against the %s (tolerance %.6g um)\n",
            s->work.max_um, sim_work_rms_um(&s->work), reference, s->options.tolerance_um);
        camsim_print_zones(s);
        if (s->has_target) {
            (void)printf("control error   max %.4f um, rms %.4f um against what the table plays\n",
                         s->control.max_um, sim_work_rms_um(&s->control));
        }
        (void)printf("following error max %.4f um, rms %.4f um\n", s->following_max_um,
                     sim_session_following_rms_um(s));
    } else {
        (void)printf("form error      not gauged: nothing was cut to full depth\n");
    }
    const double better_rpm = sim_cut_averaging_rpm(cut);
    if (better_rpm > 0.0) {
        (void)printf("counts          whole ones per tick at this speed do not average: %.6g r/min "
                     "is better\n",
                     better_rpm);
    }
    if (sim_cut_is_loop_assumed(cut)) {
        (void)printf(
            "loop of U       not measured; run tools/tune --machine FILE -o DIR --apply\n");
    }
    print_passes(cut);
    print_lobes(s);
    (void)printf("machine time    %.3f s in %.3f s, %.2f million ticks/s\n", cut->port.time_s,
                 wall_s, wall_s > 0.0 ? (double)cut->n_ticks / wall_s * 1e-6 : 0.0);
}
