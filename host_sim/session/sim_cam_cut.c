// SPDX-License-Identifier: Apache-2.0
#include "sim_cam_cut.h"
#include "sim_design_table.h" // sim_design_table_ratio
#include "sim_units.h"        // SIM_TWO_PI, sim_fraction

bool sim_cam_cut_check(const sim_cut_t *cut, const char *name, sim_error_t *e)
{
    const bool is_cam = cut->design.shape == sim_shape_cam;
    const bool is_turned = is_cam && cut->design.cam.is_turned;
    const double tip_mm = cut->options.tip_mm;
    if (is_cam && is_turned != cut->table.is_swung) {
        return sim_error(e, "%s: turned or ground, table and design disagree; " SIM_CAM_REMEDY,
                         name);
    }
    if (tip_mm > 0.0 && cut->table.is_swung && !is_cam) {
        return sim_error(e, "--tool-tip-mm %.12g: wants the design of %s; " SIM_CAM_REMEDY, tip_mm,
                         name);
    }
    if (tip_mm > 0.0 && !is_turned) {
        return sim_error(e,
                         "--tool-tip-mm %.12g: %s is not turned by a swinging tool; leave it out",
                         tip_mm, name);
    }
    return tip_mm <= cut->design.cam.roller_mm || !is_turned ||
           sim_error(e, "--tool-tip-mm %.12g: larger than the roller; give at most %.12g", tip_mm,
                     cut->design.cam.roller_mm);
}

void sim_cam_cut_begin(sim_cut_t *cut)
{
    const double tip_mm = cut->options.tip_mm > 0.0 ? cut->options.tip_mm : SIM_CAM_TIP_MM;
    const double roller_mm = cut->design.cam.roller_mm;
    sim_cam_work_init(&cut->cam, &cut->design.cam, &cut->work,
                      tip_mm < roller_mm ? tip_mm : roller_mm);
}

double sim_cam_cut_mean_rad_s(const sim_cut_t *cut)
{
    return cut->feasibility.speed_mrpm * (SIM_TWO_PI / 60e3);
}

double sim_cam_cut_due_mm_s(const sim_cut_t *cut)
{
    const sim_cam_design_t *d = &cut->design.cam;
    return sim_cam_cut_mean_rad_s(cut) * d->base_speed * d->base_mm;
}

void sim_cam_cut_gauge(sim_cut_t *cut, double turn)
{
    const double ratio = sim_design_table_ratio(&cut->table, sim_fraction(turn), cut->z_mm);
    const sim_cam_tool_t tool = {
        .t_s = cut->sample_s,
        .turn = turn,
        .centre_mm = sim_machine_radius_mm(&cut->machine),
        .swing_deg = cut->swing_deg,
        .z_mm = cut->z_mm,
        .due_rad_s = ratio * sim_cam_cut_mean_rad_s(cut),
        .is_counted = cut->state == cam_state_cutting,
    };
    sim_cam_work_cut(&cut->cam, &tool);
    cut->part_turn = cut->cam.contact_turn;
    cut->exact_mm = cut->cam.contact_mm;
    cut->radius_mm = cut->cam.contact_mm + cut->cam.gap_mm;
}
