// SPDX-License-Identifier: Apache-2.0
#include "sim_lobe_cut.h"
#include "sim_design_table.h" // sim_design_table_ratio
#include "sim_units.h"        // SIM_TWO_PI, sim_fraction

bool sim_lobe_cut_check(const sim_cut_t *cut, const char *name, common_error_t *e)
{
    const bool has_lobes = cut->design.shape == sim_shape_lobes;
    const bool is_turned = has_lobes && cut->design.lobes.is_turned;
    const double tip_mm = cut->options.tip_mm;
    if (has_lobes && is_turned != cut->table.is_swung) {
        return common_error(e, "%s: turned or ground, table and design disagree; " SIM_LOBE_REMEDY,
                            name);
    }
    if (tip_mm > 0.0 && cut->table.is_swung && !has_lobes) {
        return common_error(e, "--tool-tip-mm %.12g: wants the design of %s; " SIM_LOBE_REMEDY,
                            tip_mm, name);
    }
    if (tip_mm > 0.0 && !is_turned) {
        return common_error(
            e, "--tool-tip-mm %.12g: %s is not turned by a swinging tool; leave it out", tip_mm,
            name);
    }
    return tip_mm <= cut->design.lobes.roller_mm || !is_turned ||
           common_error(e, "--tool-tip-mm %.12g: larger than the roller; give at most %.12g",
                        tip_mm, cut->design.lobes.roller_mm);
}

void sim_lobe_cut_begin(sim_cut_t *cut)
{
    const double tip_mm = cut->options.tip_mm > 0.0 ? cut->options.tip_mm : SIM_LOBE_TIP_MM;
    const double roller_mm = cut->design.lobes.roller_mm;
    sim_lobe_work_init(&cut->lobes, &cut->design.lobes, &cut->work,
                       tip_mm < roller_mm ? tip_mm : roller_mm);
}

double sim_lobe_cut_mean_rad_s(const sim_cut_t *cut)
{
    return cut->feasibility.speed_mrpm * (SIM_TWO_PI / 60e3);
}

double sim_lobe_cut_due_mm_s(const sim_cut_t *cut)
{
    const sim_lobe_design_t *d = &cut->design.lobes;
    return sim_lobe_cut_mean_rad_s(cut) * d->base_speed * d->base_mm;
}

void sim_lobe_cut_gauge(sim_cut_t *cut, double turn)
{
    const double ratio = sim_design_table_ratio(&cut->table, sim_fraction(turn), cut->z_mm);
    const sim_lobe_tool_t tool = {
        .t_s = cut->sample_s,
        .turn = turn,
        .centre_mm = sim_machine_radius_mm(&cut->machine),
        .swing_deg = cut->swing_deg,
        .z_mm = cut->z_mm,
        .due_rad_s = ratio * sim_lobe_cut_mean_rad_s(cut),
        .is_counted = cut->state == cam_state_cutting,
    };
    sim_lobe_work_cut(&cut->lobes, &tool);
    cut->part_turn = cut->lobes.contact_turn;
    cut->exact_mm = cut->lobes.contact_mm;
    cut->radius_mm = cut->lobes.contact_mm + cut->lobes.gap_mm;
}
