// SPDX-License-Identifier: Apache-2.0
#include "sim_lobe_cut.h"
#include "sim_design.h" // sim_design_table_ratio
#include "sim_units.h"  // sim_fraction

/// Remedy for a table without its report.
#define REMEDY "make the table again with tools/mktables, or give --design"

/// [mm] default radius of the tool's tip.
#define DEFAULT_TIP_MM 0.4

bool sim_lobe_cut_check(const sim_session_t *s, double tip_mm, const char *name, common_error_t *e)
{
    const bool has_lobes = s->design.shape == sim_shape_lobes;
    const bool is_turned = has_lobes && s->design.lobes.is_turned;
    if (has_lobes && is_turned != s->table.is_swung) {
        return common_error(e, "%s: turned or ground, table and design disagree; " REMEDY, name);
    }
    if (tip_mm > 0.0 && s->table.is_swung && !has_lobes) {
        return common_error(e, "--tool-tip-mm %.12g: needs the design of %s; " REMEDY, tip_mm,
                            name);
    }
    if (tip_mm > 0.0 && !is_turned) {
        return common_error(
            e, "--tool-tip-mm %.12g: %s is not turned by a swinging tool; leave it out", tip_mm,
            name);
    }
    return tip_mm <= s->design.lobes.roller_mm || !is_turned ||
           common_error(e, "--tool-tip-mm %.12g: larger than the roller; give at most %.12g",
                        tip_mm, s->design.lobes.roller_mm);
}

void sim_lobe_cut_begin(sim_session_t *s, double tip_mm)
{
    const double wanted_mm = tip_mm > 0.0 ? tip_mm : DEFAULT_TIP_MM;
    const double roller_mm = s->design.lobes.roller_mm;
    sim_lobe_work_init(&s->lobes, &s->design.lobes, &s->work, s->table.direction,
                       wanted_mm < roller_mm ? wanted_mm : roller_mm,
                       s->options.config.lathe.wheel_wear_um * 1e-3);
    s->lobes.sections = &s->sections;
}

double sim_lobe_cut_due_mm_s(const sim_session_t *s)
{
    return s->mean_rad_s * s->design.lobes.base_speed * s->design.lobes.base_mm;
}

void sim_lobe_cut_gauge(sim_session_t *s, double turn)
{
    const sim_lobe_tool_t tool = {
        .t_s = s->at.t_s,
        .turn = turn,
        .centre_mm = (s->at.x_nm - s->at.u_nm) * 1e-6,
        .swing_deg = s->at.swing_deg,
        .z_mm = s->z_mm,
        .due_rad_s = sim_design_table_ratio(&s->table, sim_fraction(turn), s->z_mm) * s->mean_rad_s,
        .is_counted = s->is_cutting,
    };
    sim_lobe_work_cut(&s->lobes, &tool);
    s->part_turn = s->lobes.contact_turn;
    s->exact_mm = s->lobes.contact_mm;
    s->radius_mm = s->lobes.contact_mm + s->lobes.gap_mm;
}
