// SPDX-License-Identifier: Apache-2.0
#include "sim_session.h"
#include "sim_lobe_cut.h" // sim_lobe_cut_gauge
#include "sim_units.h"    // sim_abs, sim_fraction
#include <math.h>         // sqrt
#include <stdlib.h>       // aligned_alloc, free
#include <string.h>       // memcpy

bool sim_session_open(sim_session_t *s, const sim_session_options_t *options, const void *image,
                      size_t size, const char *name, common_error_t *e)
{
    s->options = *options;
    s->n_waiting = options->n_injects;
    s->cut_at_s = -1.0;
    s->began_at_s = -1.0;
    // The firmware demands an aligned image, and aligned_alloc() a multiple of the alignment.
    s->image = aligned_alloc(32, (size + 31u) / 32u * 32u + 32u);
    if (s->image == NULL) {
        return common_error(e, "%s: not enough memory for %zu bytes; use a smaller table", name,
                            size);
    }
    memcpy(s->image, image, size);
    const cam_err_t err = cam_table_check(s->image, size, &s->table);
    return err == cam_ok ||
           common_error(e, "%s: table refused: %s; make it again with tools/mktables", name,
                        cam_err_text(err));
}

bool sim_session_load_design(sim_session_t *s, common_error_t *e)
{
    if (s->options.design_path != NULL) {
        const char *path = s->options.design_path;
        return sim_design_load(&s->design, path, &s->table, e) &&
               sim_design_load_target(&s->target, &s->has_target, path, &s->table, e);
    }
    sim_design_from_table(&s->design, &s->table);
    return s->table.lobes != NULL || !s->table.has_stations ||
           common_error(e, "a table with bands is gauged by its report; give NAME.json beside it");
}

sim_design_t *sim_session_played(sim_session_t *s)
{
    return s->has_target ? &s->target : &s->design;
}

const sim_work_t *sim_session_control(const sim_session_t *s)
{
    return s->has_target ? &s->control : &s->work;
}

/// @return [mm] radius of the tool's nose: requested, of the machine, or of the table
static double nose_mm(const sim_session_t *s)
{
    const double of_machine_mm = s->options.config.lathe.tool_nose_mm;
    if (s->options.nose_mm > 0.0) {
        return s->options.nose_mm;
    }
    return of_machine_mm >= 0.0 ? of_machine_mm : s->design.nose_mm;
}

/// Start the gauges against the drawing, and against the target if there is one.
static void init_work(sim_session_t *s, double blank_mm)
{
    const bool has_map = s->options.has_map;
    sim_work_init(&s->work, blank_mm, s->design.z_first_mm, s->design.z_last_mm, has_map);
    if (s->has_target) {
        sim_work_init(&s->control, blank_mm, s->design.z_first_mm, s->design.z_last_mm, has_map);
    }
}

void sim_session_place(sim_session_t *s, double *x_nm, double *z_nm)
{
    const sim_lathe_config_t *lathe = &s->options.config.lathe;
    // The blank is a cylinder: largest radius of the part plus depth of cut.
    const double blank_mm = s->design.largest_mm + s->table.depth_nm / SIM_NM_PER_MM;
    s->blank_mm = blank_mm;
    const double tool_mm = s->design.lobes.follower_mm; // X holds the centre of a lobe's follower
    *x_nm = (blank_mm + tool_mm + lathe->x_start_mm) * SIM_NM_PER_MM;
    *z_nm = s->table.z_first_nm - lathe->z_start_mm * SIM_NM_PER_MM;
    sim_nose_init(&s->nose, nose_mm(s), &s->design);
    init_work(s, blank_mm);
}

/// Gauge what the tip of a skirt's tool leaves on the part released from its chuck, against the
/// drawing and the played surface, each plus the stock that the pass has to leave.
static void gauge_skirt(sim_session_t *s)
{
    bool is_beside;
    const sim_lathe_config_t *lathe = &s->options.config.lathe;
    const double sprung_mm = sim_chuck_sprung_mm(&lathe->chuck, s->at.turn, s->z_mm);
    s->radius_mm = (s->at.x_nm - s->at.u_nm) * 1e-6 + lathe->tool_wear_um * 1e-3 + sprung_mm;
    const double drawn_mm =
        sim_nose_radius_mm(&s->nose, &s->design, s->part_turn, s->z_mm, &is_beside);
    s->exact_mm = drawn_mm + s->allowance_mm;
    s->work.blank_mm = s->has_stock ? drawn_mm + s->stock_mm + sprung_mm : s->work.blank_mm;
    const bool is_made = !is_beside || s->radius_mm < s->exact_mm;
    const bool is_too_deep = s->is_rough && s->radius_mm < s->exact_mm;
    const bool is_counted = (s->is_cutting || is_too_deep) && is_made;
    s->place = sim_areas_kind(&s->design.areas, s->part_turn, s->z_mm, s->exact_mm);
    sim_work_remove(&s->work, s->z_mm, s->place == sim_place_air ? s->work.blank_mm : s->radius_mm,
                    is_counted);
    if (s->place != sim_place_metal) {
        sim_sections_skip(&s->sections, sim_session_turn(s));
        return;
    }
    sim_work_judge(&s->work, s->part_turn, s->z_mm, s->radius_mm, s->exact_mm, is_counted);
    if (is_counted) {
        sim_areas_judge(&s->design.areas, s->part_turn, s->z_mm, s->exact_mm,
                        (s->radius_mm - s->exact_mm) * 1e3, s->options.tolerance_um);
    }
    if (s->has_target && is_counted) {
        const double played_mm =
            sim_nose_radius_mm(&s->nose, &s->target, s->part_turn, s->z_mm, &is_beside);
        sim_work_judge(&s->control, s->part_turn, s->z_mm, s->radius_mm,
                       played_mm + s->allowance_mm, true);
    }
    sim_sections_touch(&s->sections, sim_session_turn(s), s->z_mm, s->radius_mm - s->exact_mm,
                       is_counted);
    sim_scallop_touch(&s->scallop, sim_session_played(s), s->part_turn, s->z_mm, s->radius_mm);
}

void sim_session_begin_pass(sim_session_t *s)
{
    init_work(s, s->work.blank_mm);
    sim_areas_restart(&s->design.areas);
    sim_bands_restart(&s->design.bands);
    const sim_sections_t *sections = &s->sections;
    sim_sections_init(&s->sections, sections->z_mm, sections->n, s->design.z_first_mm,
                      s->design.z_last_mm);
    s->cut_at_s = -1.0;
    s->cut_turns = 0.0;
    s->cut_s = 0.0;
    s->has_touched = false;
    s->following_max_um = 0.0;
    s->following_sum_um2 = 0.0;
    s->n_following = 0;
}

double sim_session_depth_mm(const sim_session_t *s)
{
    const double depth_mm = s->work.blank_mm - s->radius_mm;
    const bool is_in = s->is_on_part && s->place != sim_place_air &&
                       s->design.shape != sim_shape_lobes && depth_mm > 0.0;
    return is_in ? depth_mm : 0.0;
}

double sim_session_turn(const sim_session_t *s)
{
    return s->at.turn - s->phase_turn;
}

/// Follow the cutting tool through the bands of the part: of each the last pass is judged, and
/// whatever else cuts below the drawing.
static void follow_band(sim_session_t *s)
{
    const sim_band_t *band = sim_bands_follow(&s->design.bands, s->z_mm);
    s->is_on_part = band != NULL;
    s->is_cutting = band != NULL && sim_band_is_last(band);
    s->is_rough = band != NULL && !s->is_cutting;
    s->stock_mm = band != NULL ? sim_band_stock_mm(band) : -1.0;
    s->has_stock = s->stock_mm >= 0.0;
    s->work.blank_mm = s->blank_mm;
    s->band_feed_mm = band != NULL && band->n_begun > 0 ? band->feed_mm[band->n_begun - 1] : 0.0;
}

void sim_session_touch(sim_session_t *s, const sim_sample_t *at, bool is_cutting,
                       double following_nm)
{
    s->at = *at;
    s->z_mm = at->z_nm * 1e-6;
    s->is_on_part = sim_design_is_on_part(&s->design, s->z_mm);
    s->is_cutting = is_cutting && s->is_on_part;
    s->is_rough = false;
    if (s->design.bands.n > 0 && is_cutting) {
        follow_band(s);
    }
    const double turn = sim_session_turn(s);
    s->part_turn = sim_fraction(turn);
    if (s->is_cutting && !s->has_touched) {
        s->has_touched = true;
        s->touched_at_turn = turn;
    }
    if (s->design.shape == sim_shape_lobes) {
        sim_lobe_cut_gauge(s, turn);
    } else {
        gauge_skirt(s);
    }
    if (!is_cutting) {
        return;
    }
    if (s->cut_at_s < 0.0) {
        s->cut_at_s = at->t_s;
        s->began_at_s = s->began_at_s < 0.0 ? at->t_s : s->began_at_s;
        s->cut_at_turn = at->turn;
    }
    s->cut_s = at->t_s - s->cut_at_s;
    s->cut_turns = sim_abs(at->turn - s->cut_at_turn);
    const double off_um = sim_abs(following_nm * 1e-3);
    s->following_max_um = off_um > s->following_max_um ? off_um : s->following_max_um;
    s->following_sum_um2 += off_um * off_um;
    s->n_following++;
}

sim_inject_t *sim_session_next_inject(sim_session_t *s, double now_s)
{
    for (uint32_t i = 0; s->n_waiting > 0u && i < s->options.n_injects; i++) {
        sim_inject_t *what = &s->options.inject[i];
        // Times count from the first sample of cutting.
        const double zero_s = what->is_absolute ? 0.0 : s->began_at_s;
        if (!what->is_done && zero_s >= 0.0 && now_s >= zero_s + what->at_s) {
            what->is_done = true;
            s->n_waiting--;
            return what;
        }
    }
    return NULL;
}

bool sim_session_is_within(const sim_session_t *s)
{
    const bool has_zones = s->design.areas.n_zones > 0;
    return has_zones ? s->design.areas.excess_um <= 0.0 : s->work.max_um <= s->options.tolerance_um;
}

const sim_zone_t *sim_session_zone_without_sample(const sim_session_t *s)
{
    for (int i = 0; i < s->design.areas.n_zones; i++) {
        if (s->design.areas.zone[i].n == 0u) {
            return &s->design.areas.zone[i];
        }
    }
    return NULL;
}

double sim_session_following_rms_um(const sim_session_t *s)
{
    return s->n_following > 0u ? sqrt(s->following_sum_um2 / (double)s->n_following) : 0.0;
}

void sim_session_close(sim_session_t *s)
{
    sim_design_free(&s->design);
    sim_design_free(&s->target);
    free(s->image);
    s->image = NULL;
}
