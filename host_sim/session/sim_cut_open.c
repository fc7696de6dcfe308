// SPDX-License-Identifier: Apache-2.0
#include "cam_feed.h"    // cam_feed_least_nm
#include "sim_cam_cut.h" // sim_cam_cut_begin
#include "sim_cut.h"
#include "sim_slow.h"  // sim_slow_check
#include "sim_units.h" // SIM_NM_PER_MM
#include <math.h>      // floor
#include <stdio.h>     // snprintf
#include <stdlib.h>    // aligned_alloc
#include <string.h>    // memcpy

/// What a user can do about an image that is refused.
#define REMEDY "make it again with tools/mktables"

static bool take_image(sim_cut_t *cut, const void *image, size_t size, const char *name,
                       sim_error_t *e)
{
    cut->image = aligned_alloc(32, (size + 31u) / 32u * 32u + 32u);
    if (cut->image == NULL) {
        return sim_error(e, "%s: not enough memory for %zu bytes; use a smaller table", name, size);
    }
    memcpy(cut->image, image, size);
    const cam_err_t err = cam_table_check(cut->image, size, &cut->table);
    if (err != cam_ok) {
        return sim_error(e, "%s: table refused: %s; " REMEDY, name, cam_err_text(err));
    }
    return true;
}

static void wish(sim_wishes_t *w, cam_param_id_t id, double value)
{
    w->value[id] = (int32_t)(value + 0.5);
    w->is_given[id] = true;
}

/// The machine file's wishes, overruled by the command line's.
static sim_wishes_t all_wishes(const sim_cut_options_t *o)
{
    sim_wishes_t w = o->config.controller;
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
    wish(&w, cam_param_trace_on, o->is_traced ? 1.0 : 0.0);
    return w;
}

static bool load_design(sim_cut_t *cut, const char *name, sim_error_t *e)
{
    if (cut->options.design_path != NULL) {
        return sim_design_load(&cut->design, cut->options.design_path, &cut->table, e) &&
               sim_cam_cut_check(cut, name, e);
    }
    sim_design_from_table(&cut->design, &cut->table);
    return sim_cam_cut_check(cut, name, e);
}

/// The firmware takes rings that are nearer as so far apart: it would cut other turns than planned.
static bool check_rings(const sim_cut_t *cut, sim_error_t *e)
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
    return sim_error(e,
                     "%s: rings of a ring-helix are at least %.6f mm apart; give at least "
                     "--feed %.6f, or a table with path = \"helix\"",
                     field, least_mm, least_mm);
}

static void place_machine(sim_cut_t *cut)
{
    const sim_machine_config_t *config = &cut->options.config.machine;
    const double blank_mm = cut->design.largest_mm + cut->table.depth_nm / SIM_NM_PER_MM;
    const double tool_mm = cut->design.cam.follower_mm; // X carries the centre of a cam's follower
    const double x_nm = (blank_mm + tool_mm + config->x_start_mm) * SIM_NM_PER_MM;
    const double z_nm = cut->table.z_first_nm - config->z_start_mm * SIM_NM_PER_MM;
    sim_work_init(&cut->work, blank_mm, cut->design.z_first_mm, cut->design.z_last_mm);
    sim_machine_init(&cut->machine, config, x_nm, z_nm, cut->options.seed);
    if (cut->design.shape == sim_shape_cam) {
        sim_cam_cut_begin(cut);
    }
}

/// Set what differs; each change is taken by the next tick, so the next finds a free half.
static bool apply_params(sim_cut_t *cut, sim_error_t *e)
{
    for (uint32_t i = 0; i < cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        const int32_t value = cam_param_get(&cut->params, id);
        if (sim_firmware_param(&cut->firmware, id) == value) {
            continue;
        }
        const cam_err_t err = sim_firmware_set_param(&cut->firmware, id, value);
        sim_cut_idle(cut);
        if (err != cam_ok) {
            return sim_error(e, "parameter %s = %d: refused: %s; change the machine file or --set",
                             cam_param_info(id)->name, (int)value, cam_err_text(err));
        }
    }
    return true;
}

static const char *unit_of(cam_err_t err, double *per_unit)
{
    *per_unit = 1.0;
    switch (err) {
    case cam_err_spindle_speed:
        *per_unit = 1e-3;
        return "r/min";
    case cam_err_u_speed:
    case cam_err_z_speed:
    case cam_err_x_speed:
        *per_unit = 1e-3;
        return "mm/s";
    case cam_err_spindle_acceleration:
        *per_unit = 1e-3;
        return "rad/s2";
    case cam_err_u_stroke:
        *per_unit = 1e-6;
        return "mm";
    case cam_err_u_acceleration:
    case cam_err_z_acceleration:
    case cam_err_x_acceleration:
        return "mm/s2";
    case cam_err_swing_axis:
        return "swing axis";
    case cam_err_swing_range:
        *per_unit = 1e-3;
        return "degrees";
    case cam_err_swing_speed:
        *per_unit = 1e-3;
        return "degrees/s";
    case cam_err_swing_acceleration:
        return "degrees/s2";
    default:
        return "";
    }
}

/// A speed that the machine can, and that does not count as stopped.
static bool is_speed(const sim_cut_t *cut, uint32_t mrpm)
{
    return mrpm > 0u && sim_slow_is_turning(&cut->table, &cut->params, mrpm * 1e-3);
}

/// What would do: a lower speed, a smaller feed.
static void put_remedy(const sim_cut_t *cut, char *to, size_t size)
{
    const cam_feasibility_t *f = &cut->feasibility;
    char feed[40] = "";
    if (f->largest_feed_nm > 0u) {
        (void)snprintf(feed, sizeof feed, "--feed %.12g", f->largest_feed_nm * 1e-6);
    }
    if (is_speed(cut, f->highest_mrpm)) {
        (void)snprintf(to, size, "give at most --rpm %.3f%s%s", f->highest_mrpm * 1e-3,
                       feed[0] != '\0' ? " or " : "", feed);
    } else if (feed[0] != '\0') {
        (void)snprintf(to, size, "give at most %s", feed);
    } else {
        (void)snprintf(to, size, "no speed helps: use another machine or part");
    }
}

/// Asked, needed, limit, and what would do.
static bool infeasible(const sim_cut_t *cut, sim_error_t *e)
{
    const cam_feasibility_t *f = &cut->feasibility;
    double scale;
    const char *unit = unit_of(f->err, &scale);
    char remedy[80];
    put_remedy(cut, remedy, sizeof remedy);
    if (f->err == cam_err_feed) {
        return sim_error(e, "--feed %.12g: infeasible: %s; give at most --feed %.12g",
                         (double)f->needed * 1e-6, cam_err_text(f->err), (double)f->limit * 1e-6);
    }
    if (f->err == cam_err_cam_amplitude) {
        return sim_error(e, "--set amplitude_ppm=%lld: infeasible: %s; give at least %lld",
                         (long long)f->limit, cam_err_text(f->err), (long long)f->needed);
    }
    return sim_error(e, "--rpm %.12g: infeasible: %s: needs %.12g %s, limit %.12g %s; %s",
                     f->speed_mrpm * 1e-3, cam_err_text(f->err), (double)f->needed * scale, unit,
                     (double)f->limit * scale, unit, remedy);
}

static bool select_table(sim_cut_t *cut, const char *name, size_t size, sim_error_t *e)
{
    const cam_err_t err = sim_firmware_select_table(&cut->firmware, cut->image, size);
    sim_cut_idle(cut);
    return err == cam_ok || sim_error(e, "%s: refused: %s; " REMEDY, name, cam_err_text(err));
}

static bool check_feasible(sim_cut_t *cut, sim_error_t *e)
{
    cut->feasibility = sim_firmware_feasibility(&cut->firmware);
    if (cut->feasibility.err != cam_ok) {
        return infeasible(cut, e);
    }
    return sim_slow_check(&cut->table, &cut->params, &cut->feasibility, e);
}

static bool check_injects(const sim_cut_t *cut, size_t size, sim_error_t *e)
{
    for (uint32_t i = 0; i < cut->options.n_injects; i++) {
        const sim_inject_t *what = &cut->options.inject[i];
        if (what->kind == sim_inject_table_flip && what->value >= (double)size) {
            return sim_error(e,
                             "--inject table-flip: byte %.0f lies outside the table; give 0 .. %zu",
                             what->value, size - 1u);
        }
    }
    return true;
}

/// 30 slices in a quarter turn, as the papers.
enum { slices_per_turn = 120 };

/// Sections of the map where no window is given.
enum { scallop_feeds = 4 };

/// The window of the surface between tracks: given, or from a whole number of feeds on, so that a
/// ring-helix begins in it with a ring.
static bool place_scallop(sim_cut_t *cut, sim_error_t *e)
{
    const sim_cut_options_t *o = &cut->options;
    const double low_mm = cut->design.z_first_mm;
    const double high_mm = cut->design.z_last_mm;
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
        return sim_error(e,
                         "--scallop-mm %.12g:%.12g: beyond the part; give heights %.12g .. %.12g",
                         from_mm, to_mm, low_mm, high_mm);
    }
    sim_scallop_init(&cut->scallop, o->nose_mm, from_mm, to_mm < high_mm ? to_mm : high_mm,
                     cut->work.blank_mm);
    return true;
}

/// Twice the turns from engaging to the end, and a minute, for spin-up and homing.
static double longest_s(const sim_cut_t *cut, double turn_s)
{
    const double turns =
        cut->params.engage_turns + sim_cut_planned_turns(cut) + cut->params.disengage_turns;
    return 2.0 * turns * turn_s + 60.0;
}

static void plan(sim_cut_t *cut)
{
    const double turn_s = 60e3 / cut->feasibility.speed_mrpm;
    const sim_removal_config_t removal = {
        .blank_mm = cut->work.blank_mm,
        .feed_mm = sim_cut_feed_mm(cut),
        .slice_s = cut->options.slice_s > 0.0 ? cut->options.slice_s : turn_s / slices_per_turn,
        .kc_n_mm2 = cut->options.kc_n_mm2,
    };
    sim_removal_init(&cut->removal, &removal);
    cut->max_s = cut->options.max_s > 0.0 ? cut->options.max_s : longest_s(cut, turn_s);
    cut->phase_turn = cut->params.phase_udeg / SIM_UDEG_PER_TURN;
    cut->until_poll = sim_cut_poll_ticks;
    cut->n_waiting = cut->options.n_injects;
    cut->state = cam_state_off;
}

static bool prepare(sim_cut_t *cut, const void *image, size_t size, const char *name,
                    sim_error_t *e)
{
    const sim_wishes_t wishes = all_wishes(&cut->options);
    if (!take_image(cut, image, size, name, e) || !check_injects(cut, size, e) ||
        !load_design(cut, name, e) ||
        !sim_controller_params(&cut->params, &cut->options.config.machine, &cut->table, &wishes,
                               e) ||
        !check_rings(cut, e)) {
        return false;
    }
    place_machine(cut);
    if (!place_scallop(cut, e)) {
        return false;
    }
    if (!sim_firmware_open(&cut->firmware, cut->options.target, cut->options.target_image, e)) {
        return false;
    }
    return apply_params(cut, e) && select_table(cut, name, size, e) && check_feasible(cut, e);
}

bool sim_cut_open(sim_cut_t *cut, const sim_cut_options_t *options, const void *image, size_t size,
                  const char *name, sim_error_t *e)
{
    memset(cut, 0, sizeof *cut);
    cut->options = *options;
    cut->cut_at_s = -1.0;
    cut->fault_s = -1.0;
    if (!prepare(cut, image, size, name, e)) {
        (void)sim_firmware_is_lost(&cut->firmware, e); // then that is the reason
        sim_cut_close(cut);
        return false;
    }
    plan(cut);
    return true;
}
