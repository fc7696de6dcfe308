// SPDX-License-Identifier: Apache-2.0
#include "sim_lobe_work.h"
#include "sim_units.h" // SIM_TWO_PI, sim_abs, sim_clamp, sim_floor, sim_fraction
#include <math.h>      // atan2, cos, hypot, sin, sqrt

#define DEXELS_PER_RAD (sim_lobe_dexels / SIM_TWO_PI)
#define FAR_MM 1e9     // marks an uncut line
#define REACH_MM 0.005 // the error of one pass changes by less
#define EDGE_MM 0.001  // tolerance of Z at the ends of a lobe
#define RAD_PER_DEG (SIM_TWO_PI / 360.0)

enum { most_beside = 400, most_pieces = 64, most_steps = 20 };

/// Centre of the circle in the lobe's frame.
typedef struct {
    double x_mm, y_mm;
} point_t;

void sim_lobe_work_init(sim_lobe_work_t *w, sim_lobe_design_t *design, sim_work_t *work,
                        int direction, double tip_mm, double wear_mm)
{
    *w = (sim_lobe_work_t){.design = design, .work = work, .i_lobe = design->n_lobes};
    w->sense = direction;
    w->whole_mm = design->is_turned ? tip_mm : design->follower_mm;
    w->wear_mm = design->is_turned ? 0.0 : wear_mm;
    w->circle_mm = w->whole_mm;
}

static double phase_of(const sim_lobe_work_t *w)
{
    return w->design->lobe[w->i_lobe].phase_rad;
}

/// The gauge's frame is the lobe's, with angles rising in the sense of cutting: for M4 it is the
/// mirror image of the drawing's.
/// @return [rad] drawing's angle of the tool in this frame
static double in_frame(const sim_lobe_work_t *w, double turn)
{
    return w->sense * (SIM_TWO_PI * sim_fraction(turn) - phase_of(w));
}

/// @return the point of the exact profile at an angle in this frame
static sim_lobe_spot_t spot_at(const sim_lobe_work_t *w, double theta_rad)
{
    sim_lobe_spot_t s = sim_lobe_design_at(w->design, w->i_lobe, w->sense * theta_rad);
    s.y_mm *= w->sense;
    s.ny *= w->sense;
    return s;
}

/// @return [turn] drawing's angle of a point of this frame on the shaft, 0 .. 1
static double turn_of(const sim_lobe_work_t *w, const sim_lobe_spot_t *s)
{
    return sim_fraction((w->sense * atan2(s->y_mm, s->x_mm) + phase_of(w)) / SIM_TWO_PI);
}

/// @return [deg] swing of the tool in this frame; the swing axis does not depend on the sense of
///         cutting
static double swing_deg(const sim_lobe_work_t *w, const sim_lobe_tool_t *tool)
{
    return w->sense * tool->swing_deg;
}

static point_t centre_of(const sim_lobe_work_t *w, const sim_lobe_tool_t *tool)
{
    const double phi = in_frame(w, tool->turn);
    point_t c = {tool->centre_mm * cos(phi), tool->centre_mm * sin(phi)};
    if (w->design->is_turned) {
        const double line = phi - swing_deg(w, tool) * RAD_PER_DEG;
        const double back_mm = w->design->roller_mm - w->circle_mm;
        c.x_mm -= back_mm * cos(line);
        c.y_mm -= back_mm * sin(line);
    }
    return c;
}

static sim_lobe_dexel_t *dexel_at(sim_lobe_work_t *w, int64_t i)
{
    const int64_t n = sim_lobe_dexels;
    return &w->dexel[(i % n + n) % n];
}

/// @return [mm] height at which the circle cuts a line; FAR_MM: it does not
static double cut_at(const sim_lobe_dexel_t *d, point_t c, double circle_mm)
{
    const double x = c.x_mm - d->x_mm;
    const double y = c.y_mm - d->y_mm;
    const double across = x * d->ny - y * d->nx;
    const double square = circle_mm * circle_mm - across * across;
    return square > 0.0 ? x * d->nx + y * d->ny - sqrt(square) : FAR_MM;
}

static void load_lobe(sim_lobe_work_t *w, uint32_t i_lobe)
{
    w->i_lobe = i_lobe;
    w->n_before = 0;
    w->first = w->end = 0;
    if (w->sections != NULL) {
        sim_sections_break(w->sections);
    }
    w->circle_mm = w->whole_mm - w->wear_mm * (i_lobe < w->design->n_lobes ? i_lobe : 0u);
    for (int i = 0; i_lobe < w->design->n_lobes && i < sim_lobe_dexels; i++) {
        const sim_lobe_spot_t s = spot_at(w, i / DEXELS_PER_RAD);
        w->dexel[i] = (sim_lobe_dexel_t){
            .x_mm = s.x_mm,
            .y_mm = s.y_mm,
            .nx = s.nx,
            .ny = s.ny,
            .turn = turn_of(w, &s),
            .radius_mm = hypot(s.x_mm, s.y_mm),
            .left_mm = FAR_MM,
            .is_clean = true,
        };
    }
}

/// Search all lines for the one nearest to the circle. @return [rad] its angle
static double search(sim_lobe_work_t *w, point_t c)
{
    int best = 0;
    double least_mm = HUGE_VAL;
    for (int i = 0; i < sim_lobe_dexels; i++) {
        const double distance_mm = hypot(c.x_mm - w->dexel[i].x_mm, c.y_mm - w->dexel[i].y_mm);
        if (distance_mm < least_mm) {
            least_mm = distance_mm;
            best = i;
        }
    }
    return best / DEXELS_PER_RAD;
}

/// Find the point whose normal passes through the centre, by Newton's method.
/// @return false when there is none near `theta`
static bool refine(sim_lobe_work_t *w, point_t c, double *theta)
{
    for (int i = 0; i < most_steps; i++) {
        const sim_lobe_spot_t s = spot_at(w, *theta);
        const double x = c.x_mm - s.x_mm;
        const double y = c.y_mm - s.y_mm;
        const double along = x * s.nx + y * s.ny;
        const double step = (y * s.nx - x * s.ny) / (s.ds_mm + along * s.bend);
        w->spot = s;
        w->gap_mm = along - w->circle_mm;
        if (sim_abs(step) < 1e-10) {
            return true;
        }
        *theta += sim_clamp(step, -0.05, 0.05);
    }
    return false;
}

static void find_contact(sim_lobe_work_t *w, point_t c)
{
    double theta = w->theta_rad;
    if (w->n_before == 0u || !refine(w, c, &theta)) {
        theta = search(w, c);
        w->n_before = 0;
        w->first = w->end = 0;
        (void)refine(w, c, &theta); // on failure the searched angle is near enough
    }
    w->theta_rad = theta;
    w->contact_mm = hypot(w->spot.x_mm, w->spot.y_mm);
    w->contact_turn = turn_of(w, &w->spot);
}

/// Grinding to size starts from an even stock on the profile, otherwise from a bar.
/// @return [mm] the blank's surface on a line
static double blank_at(const sim_lobe_work_t *w, const sim_lobe_dexel_t *d)
{
    const double bar_mm = w->work->blank_mm;
    const double nose_mm = w->design->base_mm + sim_lobe_design_lift_mm(w->design);
    return w->design->is_plunged ? d->radius_mm + bar_mm - nose_mm : bar_mm;
}

/// Gauge a line that is finished.
/// @param fed_mm  feed of the turn: height of the ring
static void finish(sim_lobe_work_t *w, int64_t i, const sim_lobe_tool_t *tool, double fed_mm)
{
    const sim_lobe_dexel_t *d = dexel_at(w, i);
    const bool is_counted = d->is_clean && tool->is_counted;
    if (d->left_mm >= FAR_MM) {
        return;
    }
    sim_work_judge(w->work, d->turn, tool->z_mm, d->radius_mm + d->left_mm, d->radius_mm,
                   is_counted);
    if (!is_counted) {
        return;
    }
    if (w->sections != NULL) {
        const sim_place_t at = {.e_mm = d->left_mm, .turn = d->turn, .drawn_mm = d->radius_mm};
        sim_sections_pass(w->sections, w->sense > 0.0 ? i : -i, tool->z_mm, &at);
    }
    const double wide = sim_fraction(w->sense * (dexel_at(w, i + 1)->turn - d->turn)) * SIM_TWO_PI;
    const double blank_mm = blank_at(w, d);
    w->work->removed_mm3 +=
        0.5 * (blank_mm * blank_mm - d->radius_mm * d->radius_mm) * wide * fed_mm;
    sim_lobe_gauge_t *g = &w->gauge[w->i_lobe];
    const double error_um = d->left_mm * 1e3;
    if (sim_abs(error_um) > g->max_um) {
        g->max_um = sim_abs(error_um);
        g->max_turn = d->turn;
        g->max_z_mm = tool->z_mm;
    }
    g->sum_um2 += error_um * error_um;
    g->n++;
}

/// Start the lines that the circle reaches and finish those that it leaves, in rising order. After
/// a reversal of the spindle the window restarts.
static void move_window(sim_lobe_work_t *w, const sim_lobe_tool_t *tool, point_t before,
                        point_t now)
{
    const int64_t at = sim_floor(w->theta_rad * DEXELS_PER_RAD);
    const double limit_mm = w->gap_mm + REACH_MM;
    const bool is_anew = w->first == w->end || at < w->first || at > w->end + most_beside;
    const int64_t old_first = is_anew ? at : w->first;
    const int64_t old_end = is_anew ? at : w->end;
    int64_t first = at;
    int64_t end = at + 1;
    while (first > old_first && first > at - most_beside &&
           (cut_at(dexel_at(w, first), before, w->circle_mm) < limit_mm ||
            cut_at(dexel_at(w, first), now, w->circle_mm) < limit_mm)) {
        first--;
    }
    while (end < old_end ||
           (end < at + most_beside && cut_at(dexel_at(w, end), now, w->circle_mm) < limit_mm)) {
        end++;
    }
    for (int64_t i = old_end; i < end; i++) {
        if (w->design->is_plunged) {
            continue; // still being cut
        }
        dexel_at(w, i)->left_mm = FAR_MM;
        dexel_at(w, i)->is_clean =
            tool->is_counted && !is_anew; // otherwise half of its cut is unknown
    }
    const double turned = w->sense * (tool->turn - w->before[0].turn);
    const double per_turn = turned > 0.0 ? 1.0 / turned : 0.0;
    const double fed_mm = sim_abs(tool->z_mm - w->before[0].z_mm) * per_turn;
    for (int64_t i = old_first; i < first && !w->design->is_plunged; i++) {
        finish(w, i, tool, fed_mm);
    }
    w->first = first;
    w->end = end;
}

/// @return the lowest point, within 0 .. 1, of the parabola through three cuts at 0, 1/2 and 1
static double lowest(double s0, double s1, double s2)
{
    const double rise = s2 - s0;
    const double bend = s0 + s2 - 2.0 * s1;
    const double ends = s0 < s2 ? s0 : s2;
    if (bend <= 0.0 || sim_abs(rise) >= 2.0 * bend) {
        return ends;
    }
    return s1 - rise * rise / (8.0 * bend);
}

static void cut_piece(sim_lobe_work_t *w, int64_t first, int64_t end, const point_t c[3])
{
    for (int64_t i = first; i < end; i++) {
        sim_lobe_dexel_t *d = dexel_at(w, i);
        const double s0 = cut_at(d, c[0], w->circle_mm);
        const double s1 = cut_at(d, c[1], w->circle_mm);
        const double s2 = cut_at(d, c[2], w->circle_mm);
        const bool is_smooth = s0 < FAR_MM && s1 < FAR_MM && s2 < FAR_MM;
        const double s = is_smooth ? lowest(s0, s1, s2) : s0 < s2 ? s0 : s2;
        d->left_mm = s < d->left_mm ? s : d->left_mm;
    }
}

/// Interpolate on the parabola through three instants.
/// @param f  0 .. 1 from the last instant to this one
static double between(double f, double y_before, double y_last, double y_now)
{
    return y_last + f * (0.5 * (y_now - y_before) + f * (0.5 * (y_now + y_before) - y_last));
}

static point_t centre_between(const sim_lobe_work_t *w, const sim_lobe_tool_t *now, double f)
{
    const sim_lobe_tool_t *b = w->before;
    sim_lobe_tool_t at = *now;
    at.turn = between(f, b[1].turn, b[0].turn, now->turn);
    at.centre_mm = between(f, b[1].centre_mm, b[0].centre_mm, now->centre_mm);
    at.swing_deg = between(f, b[1].swing_deg, b[0].swing_deg, now->swing_deg);
    return centre_of(w, &at);
}

static void sweep(sim_lobe_work_t *w, const sim_lobe_tool_t *now, double travel_mm, point_t last,
                  point_t here)
{
    const double wanted = ceil(4.0 * travel_mm / w->circle_mm);
    const int n = (int)sim_clamp(wanted, 1.0, most_pieces);
    point_t begin = last;
    for (int k = 0; k < n; k++) {
        const double f = (double)(k + 1) / n;
        const point_t middle = centre_between(w, now, f - 0.5 / n);
        const point_t stop = k + 1 < n ? centre_between(w, now, f) : here;
        cut_piece(w, w->first, w->end, (const point_t[3]){begin, middle, stop});
        begin = stop;
    }
}

/// @return [deg] angle from the normal at the contact to a direction
static double off_normal_deg(const sim_lobe_spot_t *s, double direction_rad)
{
    const double x = cos(direction_rad);
    const double y = sin(direction_rad);
    return atan2(s->nx * y - s->ny * x, s->nx * x + s->ny * y) / RAD_PER_DEG;
}

static void measure(sim_lobe_work_t *w, const sim_lobe_tool_t *tool, double travel_mm)
{
    const double phi = in_frame(w, tool->turn);
    const double slant = cos(phi) * w->spot.nx + sin(phi) * w->spot.ny;
    const double follower_mm = w->design->follower_mm;
    // Travel of the contact per radian of the spindle: ds/dphi = ds (centre) / (cos (ds + R bend)).
    const double mm_per_rad =
        w->spot.ds_mm * tool->centre_mm / (slant * (w->spot.ds_mm + follower_mm * w->spot.bend));
    const double speed_mm_s = travel_mm / (tool->t_s - w->before[0].t_s);
    sim_spread_add(&w->speed_mm_s, speed_mm_s);
    sim_spread_add(&w->off_plan, speed_mm_s / (mm_per_rad * tool->due_rad_s) - 1.0);
    if (w->design->is_turned) {
        const double line = phi - swing_deg(w, tool) * RAD_PER_DEG;
        sim_spread_add(&w->rake_deg, w->sense * off_normal_deg(&w->spot, line));
        sim_spread_add(&w->unswung_deg, w->sense * off_normal_deg(&w->spot, phi));
    }
}

/// A plunged wheel leaves its lobe: gauge all lines; their ring is the whole lobe.
static void leave_lobe(sim_lobe_work_t *w)
{
    const sim_lobe_t *lobe = &w->design->lobe[w->i_lobe];
    sim_lobe_tool_t at = w->before[0];
    at.z_mm = 0.5 * (lobe->z_first_mm + lobe->z_last_mm);
    for (int64_t i = 0; i < sim_lobe_dexels; i++) {
        finish(w, i, &at, lobe->z_last_mm - lobe->z_first_mm);
        dexel_at(w, i)->left_mm = FAR_MM;
    }
}

/// @return whether a plunged wheel leaves its lobe now, or disengages
static bool is_leaving(const sim_lobe_work_t *w, const sim_lobe_tool_t *now, uint32_t i_lobe)
{
    return w->design->is_plunged && w->n_before > 0u && w->i_lobe < w->design->n_lobes &&
           w->before[0].is_counted && (i_lobe != w->i_lobe || !now->is_counted);
}

/// Between two lobes any cut below the base circle is a gouge.
static void touch_shaft(sim_lobe_work_t *w, const sim_lobe_tool_t *tool)
{
    const double base_mm = w->design->base_mm;
    const double back_mm = w->design->is_turned ? w->design->roller_mm - w->circle_mm : 0.0;
    const double swing_rad = tool->swing_deg * RAD_PER_DEG;
    const double centre_mm =
        hypot(tool->centre_mm - back_mm * cos(swing_rad), back_mm * sin(swing_rad));
    sim_work_judge(w->work, sim_fraction(tool->turn), tool->z_mm, centre_mm - w->circle_mm, base_mm,
                   false);
}

void sim_lobe_work_cut(sim_lobe_work_t *w, const sim_lobe_tool_t *tool)
{
    sim_lobe_tool_t now = *tool;
    const uint32_t i_lobe = sim_lobe_design_find(w->design, now.z_mm, EDGE_MM);
    if (is_leaving(w, &now, i_lobe)) {
        leave_lobe(w);
    }
    if (i_lobe != w->i_lobe ||
        (w->design->is_plunged && w->n_before > 0u && w->before[0].is_counted != now.is_counted)) {
        load_lobe(w, i_lobe);
    }
    if (i_lobe == w->design->n_lobes) {
        touch_shaft(w, &now);
        return;
    }
    const sim_lobe_t *lobe = &w->design->lobe[i_lobe];
    now.z_mm = sim_clamp(now.z_mm, lobe->z_first_mm, lobe->z_last_mm);
    const double theta_before = w->theta_rad;
    const double ds_before = w->spot.ds_mm;
    const point_t here = centre_of(w, &now);
    find_contact(w, here);
    if (w->n_before == 2u) {
        const double travel_mm = 0.5 * (w->spot.ds_mm + ds_before) * (w->theta_rad - theta_before);
        const point_t last = centre_of(w, &w->before[0]);
        move_window(w, &now, last, here);
        sweep(w, &now, sim_abs(travel_mm), last, here);
        if (now.is_counted && w->before[0].is_counted) {
            measure(w, &now, travel_mm);
        }
    }
    w->n_before = w->n_before < 2u ? w->n_before + 1u : 2u;
    w->before[1] = w->before[0];
    w->before[0] = now;
}

double sim_lobe_gauge_rms_um(const sim_lobe_gauge_t *g)
{
    return g->n > 0u ? sqrt(g->sum_um2 / (double)g->n) : 0.0;
}
