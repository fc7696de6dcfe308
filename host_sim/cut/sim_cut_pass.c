// SPDX-License-Identifier: Apache-2.0
#include "sim_cut_pass.h"
#include "cam_build.h"   // cam_build_settle_turns
#include "cam_machine.h" // cam_pass_params
#include "sim_units.h"   // SIM_NM_PER_MM, SIM_TWO_PI
#include <math.h>        // ceil, floor

/// The papers measure 30 slices in a quarter turn.
enum { slices_per_turn = 120 };

/// @return [mm] stock left by a pass
static double allowance_mm(const sim_cut_t *cut, uint32_t pass)
{
    const cam_table_t *table = &cut->session.table;
    return table->passes != NULL ? table->passes[pass].allowance_nm / SIM_NM_PER_MM : 0.0;
}

/// @return [r/min / 1000] mean speed of a pass
static double mrpm_of(const cam_table_t *table, const cam_params_t *here)
{
    return here->spindle_mrpm > 0 ? (double)here->spindle_mrpm : (double)table->spindle_mrpm;
}

/// @return [nm] feed per turn of a pass
static double feed_nm_of(const cam_table_t *table, const cam_params_t *here)
{
    return here->feed_nm > 0 ? here->feed_nm : (double)table->feed_nm;
}

double sim_cut_feed_mm(const sim_cut_t *cut)
{
    const double of_bands_mm = sim_bands_feed_mm(&cut->session.design.bands);
    return of_bands_mm > 0.0 ? of_bands_mm
                             : feed_nm_of(&cut->session.table, &cut->here) / SIM_NM_PER_MM;
}

bool sim_cut_has_rings(const sim_cut_t *cut)
{
    return cut->session.table.is_ring_helix && cut->params.z_is_measured == 0;
}

static double turns_of(const cam_table_t *table, const cam_params_t *here)
{
    const double span_nm = (double)table->z_last_nm - table->z_first_nm;
    const double fed = span_nm / feed_nm_of(table, here);
    if (table->is_ring_helix && here->z_is_measured == 0) {
        return 2.0 * ceil(fed) + 1.0;
    }
    const double ramp = here->z_is_measured != 0 ? 0.0 : here->feed_ramp_turns;
    return fed + (ramp < fed ? ramp : fed); // the rising and the falling half
}

double sim_cut_planned_turns(const sim_cut_t *cut)
{
    return turns_of(&cut->session.table, &cut->here);
}

/// Prepare the gauges for a pass.
static void take_pass(sim_cut_t *cut, uint32_t pass)
{
    sim_session_t *s = &cut->session;
    cut->pass = pass;
    cut->here = cam_pass_params(&cut->params, &s->table, pass);
    s->allowance_mm = allowance_mm(cut, pass);
    s->has_stock = pass > 0u;
    s->stock_mm = pass > 0u ? allowance_mm(cut, pass - 1u) : 0.0;
}

void sim_cut_first_pass(sim_cut_t *cut)
{
    take_pass(cut, cam_pass_first(&cut->params, &cut->session.table));
    cut->first_pass = cut->pass;
}

void sim_cut_plan_pass(sim_cut_t *cut)
{
    const sim_cut_options_t *o = &cut->options;
    const sim_removal_config_t removal = {
        .blank_mm = cut->session.work.blank_mm,
        .feed_mm = sim_cut_feed_mm(cut),
        .slice_s = o->slice_s > 0.0
                       ? o->slice_s
                       : 60e3 / mrpm_of(&cut->session.table, &cut->here) / slices_per_turn,
        .kc_n_mm2 = o->kc_n_mm2,
        .size_exponent = o->kc_exponent,
        .nose_mm = o->nose_mm,
    };
    sim_removal_init(&cut->removal, &removal);
    const double ramp_turns = cut->params.feed_ramp_turns;
    cut->full_first_turn = ramp_turns + 1.0; // the rising feed left the chips of one more turn
    cut->full_last_turn = sim_cut_planned_turns(cut) - ramp_turns;
    cut->session.mean_rad_s = mrpm_of(&cut->session.table, &cut->here) * (SIM_TWO_PI / 60e3);
}

double sim_cut_planned_s(const sim_cut_t *cut)
{
    const cam_table_t *table = &cut->session.table;
    double planned_s = 0.0;
    for (uint32_t i = cut->first_pass; i < cam_pass_count(table); i++) {
        const cam_params_t here = cam_pass_params(&cut->params, table, i);
        const double cut_turns = here.engage_turns + cam_build_settle_turns(&here) +
                                 turns_of(table, &here) + here.disengage_turns;
        const double rehearsal_turns =
            here.rehearse_turns > 0 ? here.engage_turns + here.rehearse_turns + here.disengage_turns
                                    : 0.0;
        const double turns = cut_turns + rehearsal_turns;
        planned_s += turns * 60e3 / mrpm_of(table, &here);
    }
    return planned_s;
}

double sim_cut_planned_in_all(const sim_cut_t *cut)
{
    const cam_table_t *table = &cut->session.table;
    double turns = 0.0;
    for (uint32_t i = cut->first_pass; i < cam_pass_count(table); i++) {
        const cam_params_t here = cam_pass_params(&cut->params, table, i);
        turns += turns_of(table, &here);
    }
    return turns;
}

/// Feeds in the default window of the map.
enum { scallop_feeds = 4 };

/// The default window starts at a whole number of feeds, that is with a ring of a ring-helix.
bool sim_cut_place_scallop(sim_cut_t *cut, common_error_t *e)
{
    const sim_cut_options_t *o = &cut->options;
    const double low_mm = cut->session.design.z_first_mm;
    const double high_mm = cut->session.design.z_last_mm;
    const double feed_mm = sim_cut_feed_mm(cut);
    const double feeds = (high_mm - low_mm) / feed_mm;
    const double first = floor(0.5 * (feeds - scallop_feeds) + 0.5);
    double from_mm = low_mm + feed_mm * (first > 0.0 ? first : 0.0);
    double to_mm = from_mm + scallop_feeds * feed_mm;
    if (o->has_window) {
        from_mm = o->window_first_mm;
        to_mm = o->window_last_mm;
    }
    if (from_mm < low_mm || from_mm > high_mm || (o->has_window && to_mm > high_mm)) {
        return common_error(
            e, "--scallop-mm %.12g:%.12g: beyond the part; give heights %.12g .. %.12g", from_mm,
            to_mm, low_mm, high_mm);
    }
    sim_scallop_init(&cut->session.scallop, o->nose_mm, from_mm, to_mm < high_mm ? to_mm : high_mm,
                     cut->session.work.blank_mm);
    return true;
}

bool sim_cut_has_next_pass(const sim_cut_t *cut)
{
    const bool is_whole = !cut->is_stopped || cut->params.z_is_measured != 0;
    return is_whole && cut->params.pass == 0 && cut->session.cut_at_s >= 0.0 &&
           cut->pass + 1u < cam_pass_count(&cut->session.table);
}

sim_pass_result_t sim_cut_pass_result(const sim_cut_t *cut)
{
    const sim_session_t *s = &cut->session;
    return (sim_pass_result_t){
        .n = s->work.n,
        .allowance_mm = s->allowance_mm,
        .rpm = mrpm_of(&cut->session.table, &cut->here) * 1e-3,
        .feed_mm = sim_cut_feed_mm(cut),
        .turns = s->cut_turns,
        .end_s = cut->port.time_s,
        .max_um = s->work.max_um,
        .rms_um = sim_work_rms_um(&s->work),
        .gouge_um = s->work.gouge_um,
        .depth_min_mm = s->work.depth_min_mm,
        .depth_max_mm = s->work.depth_max_mm,
        .removed_mm3 = cut->removal.removed_mm3,
        .rate = cut->removal.rate,
        .chip_force = cut->removal.chip_force,
    };
}

void sim_cut_next_pass(sim_cut_t *cut)
{
    sim_session_t *s = &cut->session;
    cam_machine_poll(&cut->firmware.machine);
    const cam_refusal_t found = cam_machine_feasibility(&cut->firmware.machine);
    if (found.pass != cut->pass + 2u) {
        return;
    }
    cut->result[cut->pass] = sim_cut_pass_result(cut);
    cut->feasibility = found;
    take_pass(cut, cut->pass + 1u);
    sim_session_begin_pass(s);
    common_error_t ignored; // the window was inside the part before
    (void)sim_cut_place_scallop(cut, &ignored);
    sim_cut_plan_pass(cut);
    cut->is_started = false;
    cut->is_stopped = false;
}

bool sim_cut_left_stock(const sim_cut_t *cut)
{
    bool is_left = true;
    for (uint32_t i = cut->first_pass; i < cut->pass; i++) {
        const sim_pass_result_t *r = &cut->result[i];
        const double below_um = r->gouge_um - r->allowance_mm * 1e3;
        is_left = is_left && below_um <= cut->session.options.tolerance_um;
    }
    return is_left;
}
