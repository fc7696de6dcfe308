// SPDX-License-Identifier: Apache-2.0
#include "sim_cut.h"
#include "sim_cut_pass.h" // sim_cut_plan_pass
#include "cam_motion.h"   // cam_feed_least_nm
#include "sim_lobe_cut.h" // sim_lobe_cut_begin
#include "sim_config.h"   // sim_params_apply, sim_slow_check
#include "sim_units.h"    // SIM_NM_PER_MM
#include <stdio.h>        // snprintf

static void wish(sim_wishes_t *w, cam_param_id_t id, double value)
{
    w->value[id] = (int32_t)(value + 0.5);
    w->is_given[id] = true;
}

sim_wishes_t sim_cut_wishes(const sim_cut_options_t *o)
{
    sim_wishes_t w = o->session.config.controller;
    for (int id = 0; id < cam_n_params; id++) {
        if (o->wishes.is_given[id]) {
            wish(&w, (cam_param_id_t)id, 0.0);
            w.value[id] = o->wishes.value[id];
        }
    }
    if (o->rpm > 0.0) {
        wish(&w, cam_param_spindle_mrpm, o->rpm * 1e3);
    }
    if (o->feed_mm > 0.0) {
        wish(&w, cam_param_feed_nm, o->feed_mm * SIM_NM_PER_MM);
    }
    if (o->is_without_feed_forward) {
        wish(&w, cam_param_k1_ns, 0.0);
        wish(&w, cam_param_k2_us2, 0.0);
    }
    if (o->is_without_lead) {
        wish(&w, cam_param_lead_ns, 0.0);
    }
    return w;
}

/// Refuse rings closer than cam_feed_least_nm: the firmware would cut them at that distance, and
/// the number of turns would differ from the plan.
static bool check_rings(const sim_cut_t *cut, common_error_t *e)
{
    const double feed_nm = sim_cut_feed_mm(cut) * SIM_NM_PER_MM;
    if (!sim_cut_has_rings(cut) || feed_nm > cam_feed_least_nm - 0.5) {
        return true;
    }
    const bool is_given = cut->options.feed_mm > 0.0;
    char field[40];
    (void)snprintf(field, sizeof field, is_given ? "--feed %.12g" : "feed_nm = %.0f",
                   is_given ? cut->options.feed_mm : feed_nm);
    const double least_mm = cam_feed_least_nm / SIM_NM_PER_MM;
    return common_error(e,
                        "%s: rings of a ring-helix are at least %.6f mm apart; give at least "
                        "--feed %.6f, or a table with path = \"helix\"",
                        field, least_mm, least_mm);
}

/// Refuse one feed for all bands: it would scale those of the table.
static bool check_feed(const sim_cut_t *cut, common_error_t *e)
{
    return cut->session.design.bands.n == 0 || cut->options.feed_mm == 0.0 ||
           common_error(e, "--feed %.12g: each band has a feed of its own; leave it out",
                        cut->options.feed_mm);
}

#define UNIT(error, unit, units_per, parameter) {cam_err_##error, unit, units_per},

static const char *unit_of(cam_err_t err, double *per_unit)
{
    static const struct {
        cam_err_t err;
        const char *unit;
        double per_unit;
    } units[] = {CAM_ERR_LIMITS(UNIT)};
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++) {
        if (units[i].err == err) {
            *per_unit = units[i].per_unit;
            return units[i].unit;
        }
    }
    *per_unit = 1.0;
    return "";
}

/// Format the remedy: a lower speed or a smaller feed.
static void put_remedy(const sim_cut_t *cut, char *to, size_t size)
{
    const cam_refusal_t *f = &cut->feasibility;
    char feed[40] = "";
    if (f->largest_feed_nm > 0u) {
        (void)snprintf(feed, sizeof feed, "--feed %.12g", f->largest_feed_nm * 1e-6);
    }
    const bool is_speed = // reached by the lathe, and not counted as stopped
        f->highest_mrpm > 0u &&
        sim_slow_is_turning(&cut->session.table, &cut->params, f->highest_mrpm * 1e-3);
    if (is_speed) {
        (void)snprintf(to, size, "give at most --rpm %.3f%s%s", f->highest_mrpm * 1e-3,
                       feed[0] != '\0' ? " or " : "", feed);
    } else if (feed[0] != '\0') {
        (void)snprintf(to, size, "give at most %s", feed);
    } else {
        (void)snprintf(to, size, "no speed helps: use another machine or part");
    }
}

/// Refuse an infeasible speed, with demand, limit and remedy. @return false
static bool infeasible(const sim_cut_t *cut, common_error_t *e)
{
    const cam_refusal_t *f = &cut->feasibility;
    double per_unit;
    const char *unit = unit_of(f->err, &per_unit);
    const double u_retract_nm = cut->params.u_retract_nm;
    char remedy[80];
    put_remedy(cut, remedy, sizeof remedy);
    if (f->err == cam_err_feed) {
        return common_error(e, "--feed %.12g: infeasible: %s; give at most --feed %.12g",
                            (double)f->needed * 1e-6, cam_err_text(f->err),
                            (double)f->limit * 1e-6);
    }
    if (f->err == cam_err_turns) {
        return common_error(e, "--feed %.12g: infeasible: %s: %lld, limit %lld; give a larger feed",
                            sim_cut_feed_mm(cut), cam_err_text(f->err), (long long)f->needed,
                            (long long)f->limit);
    }
    if (f->err == cam_err_u_retract) { // only if set: the default fits every stroke
        const double most_nm = (double)f->limit - ((double)f->needed + u_retract_nm);
        return common_error(e,
                            "--set u_retract_nm=%.0f: infeasible: %s: needs %.12g mm, limit %.12g "
                            "mm; give at least %.0f, or leave it out: the default goes as far as "
                            "the stroke allows",
                            u_retract_nm, cam_err_text(f->err), (double)f->needed / per_unit,
                            (double)f->limit / per_unit, most_nm > 0.0 ? -most_nm : 0.0);
    }
    if (f->err == cam_err_cam_amplitude) {
        return common_error(e, "--set amplitude_ppm=%lld: infeasible: %s; give at least %lld",
                            (long long)f->limit, cam_err_text(f->err), (long long)f->needed);
    }
    char pass[24] = "";
    if (f->pass > 0u) {
        (void)snprintf(pass, sizeof pass, "pass %u: ", (unsigned)f->pass);
    }
    return common_error(e, "%s--rpm %.12g: infeasible: %s: needs %.12g %s, limit %.12g %s; %s",
                        pass, f->speed_mrpm * 1e-3, cam_err_text(f->err),
                        (double)f->needed / per_unit, unit, (double)f->limit / per_unit, unit,
                        remedy);
}

static bool check_injects(const sim_session_t *s, size_t size, common_error_t *e)
{
    for (uint32_t i = 0; i < s->options.n_injects; i++) {
        const sim_inject_t *what = &s->options.inject[i];
        if (what->kind == sim_inject_table_flip && what->value >= (double)size) {
            return common_error(
                e, "--inject table-flip: byte %.0f is outside the table; give 0 .. %zu",
                what->value, size - 1u);
        }
    }
    return true;
}

/// Place the sections. Default heights are one, three, five, seven and nine tenths of the part, or
/// the middle of each of the first lobes.
static bool place_sections(sim_cut_t *cut, common_error_t *e)
{
    enum { usual = 5 };
    const sim_cut_options_t *o = &cut->options;
    const sim_design_t *d = &cut->session.design;
    const int n_lobes =
        d->lobes.n_lobes < sim_sections_most ? (int)d->lobes.n_lobes : (int)sim_sections_most;
    const bool has_lobes = d->shape == sim_shape_lobes;
    const int n = o->n_sections > 0 ? o->n_sections : has_lobes ? n_lobes : usual;
    double z_mm[sim_sections_most];
    for (int i = 0; i < n; i++) {
        const sim_lobe_t *lobe = &d->lobes.lobe[i];
        z_mm[i] = o->n_sections > 0 ? o->section_mm[i]
                  : has_lobes       ? 0.5 * (lobe->z_first_mm + lobe->z_last_mm)
                              : d->z_first_mm + (i + 0.5) / n * (d->z_last_mm - d->z_first_mm);
        if (z_mm[i] < d->z_first_mm || z_mm[i] > d->z_last_mm) {
            return common_error(e,
                                "--sections-mm %.12g: beyond the part; give heights %.12g .. %.12g",
                                z_mm[i], d->z_first_mm, d->z_last_mm);
        }
    }
    sim_sections_init(&cut->session.sections, z_mm, o->has_sections ? n : 0, d->z_first_mm,
                      d->z_last_mm);
    return true;
}

/// Mount the blank, connect the lathe to the port, and prepare the gauges.
static bool place(sim_cut_t *cut, common_error_t *e)
{
    sim_session_t *s = &cut->session;
    double x_nm;
    double z_nm;
    sim_session_place(s, &x_nm, &z_nm);
    sim_port_init(&cut->port, &s->options.config.lathe, x_nm, z_nm, s->options.seed);
    if (s->design.shape == sim_shape_lobes) {
        sim_lobe_cut_begin(s, cut->options.tip_mm);
    }
    return sim_cut_place_scallop(cut, e) && place_sections(cut, e);
}

/// Start the firmware and set parameters and table; each change takes effect in the next tick.
static bool set_up_firmware(sim_cut_t *cut, size_t size, const char *name, common_error_t *e)
{
    cam_machine_t *machine = &cut->firmware.machine;
    sim_firmware_init(&cut->firmware);
    sim_cut_idle(cut); // takes the parameters of before
    if (!sim_params_apply(machine, &cut->params, e)) {
        return false;
    }
    sim_cut_idle(cut);
    cam_err_t err = cam_err_busy;
    for (int i = 0; i < 2 && err == cam_err_busy; i++) { // learning may offer a configuration first
        err = cam_machine_select_table(machine, cut->session.image, size);
        sim_cut_idle(cut);
    }
    if (err != cam_ok) {
        return common_error(e, "%s: refused: %s; make it again with tools/mktables", name,
                            cam_err_text(err));
    }
    cut->feasibility = cam_machine_feasibility(machine);
    if (cut->feasibility.err != cam_ok) {
        return infeasible(cut, e);
    }
    return sim_slow_check(&cut->session.table, &cut->params, &cut->feasibility, e);
}

/// Derive times and slices from the firmware's speed.
static void plan(sim_cut_t *cut)
{
    sim_session_t *s = &cut->session;
    sim_cut_plan_pass(cut);
    // Twice the planned time, and a minute for spin-up and homing.
    cut->max_s = s->options.max_s > 0.0 ? s->options.max_s : 2.0 * sim_cut_planned_s(cut) + 60.0;
    sim_turns_init(&cut->turns, cut->params.engage_turns, cut->params.rehearse_turns,
                   cut->params.disengage_turns);
    s->phase_turn = cut->params.phase_udeg / SIM_UDEG_PER_TURN;
    cut->until_poll = sim_cut_poll_ticks;
    cut->state = cam_state_off;
}

/// Prepare the first pass: rings and window of the tracks depend on its feed.
static bool prepare_pass(sim_cut_t *cut, common_error_t *e)
{
    sim_cut_first_pass(cut);
    return check_rings(cut, e) && check_feed(cut, e) && place(cut, e);
}

static bool prepare(sim_cut_t *cut, const void *image, size_t size, const char *name,
                    common_error_t *e)
{
    sim_session_t *s = &cut->session;
    const sim_wishes_t wishes = sim_cut_wishes(&cut->options);
    return sim_session_open(s, &cut->options.session, image, size, name, e) &&
           check_injects(s, size, e) && sim_session_load_design(s, e) &&
           sim_lobe_cut_check(s, cut->options.tip_mm, name, e) &&
           sim_controller_params(&cut->params, sim_config_believed(&s->options.config),
                                 !cut->options.is_without_learning, &wishes, e) &&
           prepare_pass(cut, e) && set_up_firmware(cut, size, name, e);
}

bool sim_cut_open(sim_cut_t *cut, const sim_cut_options_t *options, const void *image, size_t size,
                  const char *name, common_error_t *e)
{
    cut->options = *options;
    cut->fault_s = -1.0;
    if (!prepare(cut, image, size, name, e)) {
        sim_cut_close(cut);
        return false;
    }
    plan(cut);
    return true;
}
