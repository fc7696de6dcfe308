// SPDX-License-Identifier: Apache-2.0
#include "camsim.h"
#include "sim_cut_pass.h" // sim_cut_left_stock
#include <stdio.h>        // snprintf

/// Explain the first fault; of several at once, the first in the list.
static void explain_fault(const sim_cut_t *cut, const char *table, common_error_t *e)
{
    const cam_status_t status = sim_cut_status(cut);
    const int set = (int)cut->params.counts_per_turn;
    int i = 0;
    while (i + 1 < cam_n_faults && (status.first_fault >> i & 1u) == 0u) {
        i++;
    }
    const unsigned found = cam_status_counts_found(&status, UINT32_C(1) << i, set);
    char counts[120] = "";
    if (found > 0u) {
        (void)snprintf(
            counts, sizeof counts,
            "; the encoder gave %u counts between two index edges, counts_per_turn is %d", found,
            set);
    }
    (void)common_error(
        e,
        "%s: fault %s: %s, %.6f s after the start, %s at %.3f mm%s; see FAULTS.md for the remedy",
        table, cam_fault_name((cam_fault_t)i), cam_fault_text((cam_fault_t)i), cut->fault_s,
        cam_state_name(cut->fault_state), cut->fault_z_mm, counts);
}

/// Name the surface that was not gauged, and the remedy: a feed of half the lobe's height, or half
/// the present feed, gives a whole turn on the lobe.
static void explain_not_gauged(const sim_cut_t *cut, const char *table, common_error_t *e)
{
    if (cut->session.work.n == 0u) {
        const char *remedy = cut->is_stopped ? "leave the stop out, or stop later"
                                             : "check [[piston.window]] of the part file";
        (void)common_error(
            e, "%s: not gauged: nothing was cut to full depth before the cut was %s; %s", table,
            sim_cut_end_name(cut), remedy);
        return;
    }
    if (cut->session.design.shape != sim_shape_lobes) {
        (void)common_error(
            e, "%s: not gauged: no sample in zone %s; feed less, or make the zone larger", table,
            sim_session_zone_without_sample(&cut->session)->name);
        return;
    }
    const uint32_t i = sim_cut_lobe_without_turn(cut);
    const sim_lobe_t *lobe = &cut->session.design.lobes.lobe[i];
    const double high_mm = lobe->z_last_mm - lobe->z_first_mm;
    const double feed_mm = sim_cut_feed_mm(cut);
    (void)common_error(e,
                       "%s: not gauged: lobe %u has %llu samples of the %d of a whole turn; "
                       "give at most --feed %.4g",
                       table, (unsigned)i, (unsigned long long)cut->session.lobes.gauge[i].n,
                       sim_lobe_dexels, 0.5 * (high_mm < feed_mm ? high_mm : feed_mm));
}

/// @return the remedy for a form error: the right tool setting, otherwise better control
static const char *form_remedy(const sim_cut_t *cut)
{
    const sim_session_t *s = &cut->session;
    const double wear_nm = s->options.config.lathe.tool_wear_um * 1e3;
    if (s->nose.nose_mm != s->design.nose_mm && s->design.shape != sim_shape_table) {
        return "the table is made for another nose: set [tool] nose_radius_mm of the part file";
    }
    if (wear_nm > 0.0 && cut->params.x_trim_nm == 0) {
        return "the tool is worn: set x_trim_nm";
    }
    return s->has_target && s->control.max_um <= s->options.tolerance_um
               ? "the table itself is off the drawing: refit or filter less"
               : "match the controller to the machine, or cut slower";
}

void camsim_explain_form(const sim_session_t *s, const char *table, const char *remedy,
                         common_error_t *e)
{
    const sim_areas_t *areas = &s->design.areas;
    for (int i = 0; i < areas->n_zones; i++) {
        const sim_zone_t *zone = &areas->zone[i];
        if (zone->excess_um > 0.0) {
            const double limit_um = sim_zone_tolerance_um(zone, s->options.tolerance_um);
            (void)common_error(e, "%s: zone %s: the form error exceeds its %s by %.3f um; %s",
                               table, zone->name, zone->max_um > limit_um ? "tolerance" : "band",
                               zone->excess_um, remedy);
            return;
        }
    }
    const bool has_zones = areas->n_zones > 0;
    const double most_um = has_zones ? areas->rest_um + s->options.tolerance_um : s->work.max_um;
    (void)common_error(e, "%s: form error %.3f um is beyond --tolerance-um %.6g%s; %s", table,
                       most_um, s->options.tolerance_um, has_zones ? " beside the zones" : "",
                       remedy);
}

int camsim_judge_cut(const sim_cut_t *cut, const char *table, common_error_t *e)
{
    const sim_session_t *s = &cut->session;
    if (sim_cut_is_good(cut)) {
        return camsim_done;
    }
    if (cut->end == sim_cut_fault) {
        explain_fault(cut, table, e);
    } else if (cut->end == sim_cut_refused) {
        (void)common_error(e,
                           "%s: refused: %s; remove the cause (parameters, machine file, --inject)",
                           table, cam_err_text(cut->refusal));
        return camsim_wrong;
    } else if (cut->end == sim_cut_timeout) {
        (void)common_error(e,
                           "%s: not at the end after %.6g s in state %s; give more --max-seconds",
                           table, cut->max_s, cam_state_name(cut->state));
    } else if (cut->end == sim_cut_unsteady) {
        (void)common_error(e,
                           "%s: the controller ended the start after %.6g s: successive turns of "
                           "the spindle do not agree; check [spindle] of the machine file",
                           table, cut->port.time_s);
    } else if (!sim_cut_is_gauged(cut)) {
        explain_not_gauged(cut, table, e);
    } else if (!sim_cut_left_stock(cut)) {
        (void)common_error(e,
                           "%s: a pass before the last one cut below the drawing by more than "
                           "--tolerance-um %.6g; leave more allowance_um, or cut it slower",
                           table, s->options.tolerance_um);
    } else {
        camsim_explain_form(s, table, form_remedy(cut), e);
    }
    return camsim_not_good;
}

bool camsim_check_lobes(const camsim_options_t *o, const sim_cut_t *cut, common_error_t *e)
{
    const cam_table_t *table = &cut->session.table;
    const char *removal_path = o->out_path[sim_table_removal];
    if (table->angle.knots != NULL && o->cut.nose_mm > 0.0) {
        return common_error(
            e, "--nose-mm %.12g: tracks are for skirts only, %s is a cam; leave it out",
            o->cut.nose_mm, table->name);
    }
    return table->angle.knots == NULL || removal_path == NULL ||
           common_error(e, "--removal %s: forces are for skirts only, %s is a cam; leave it out",
                        removal_path, table->name);
}
