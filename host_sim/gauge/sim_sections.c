// SPDX-License-Identifier: Apache-2.0
#include "sim_work.h"
#include "sim_units.h" // sim_abs, sim_floor
#include <math.h>      // NAN, fmax, fmin, isnan

/// [mm] tolerance for a height that is on a track.
#define SAME_MM 1e-9

enum { places_per_line = sim_sections_places / sim_sections_lines };

void sim_sections_init(sim_sections_t *s, const double *z_mm, int n, double z_first_mm,
                       double z_last_mm)
{
    s->n = n;
    s->first_mm = z_first_mm;
    s->step_mm = (z_last_mm - z_first_mm) / (sim_sections_heights - 1);
    s->has_passes = n > 0;
    sim_sections_break(s);
    for (int i = 0; i < n; i++) {
        s->z_mm[i] = z_mm[i];
        for (int k = 0; k < sim_sections_places; k++) {
            s->section[i][k] = (sim_place_t){.e_mm = NAN};
        }
    }
    for (int i = 0; i < sim_sections_lines && n > 0; i++) {
        for (int k = 0; k < sim_sections_heights; k++) {
            s->line_e_mm[i][k] = NAN;
        }
    }
}

void sim_sections_break(sim_sections_t *s)
{
    s->n_tips = 0;
    for (int k = 0; s->has_passes && k < sim_sections_places; k++) {
        s->before_z_mm[k] = NAN;
        s->before_e_mm[k] = NAN;
    }
    s->has_passes = false;
}

double sim_sections_height_mm(const sim_sections_t *s, int i)
{
    return s->first_mm + i * s->step_mm;
}

/// Two tracks at one angle, the lower first; a single track counts as two at the same height.
typedef struct {
    double low_mm, low_e_mm, high_mm, high_e_mm;
} tracks_t;

static double between(const tracks_t *t, double z_mm)
{
    const double span_mm = t->high_mm - t->low_mm;
    const double share = span_mm > SAME_MM ? (z_mm - t->low_mm) / span_mm : 0.0;
    return t->low_e_mm + share * (t->high_e_mm - t->low_e_mm);
}

static void take_line(sim_sections_t *s, double e_mm[sim_sections_heights], const tracks_t *t)
{
    const int64_t first = -sim_floor((SAME_MM - t->low_mm + s->first_mm) / s->step_mm);
    const int64_t last = sim_floor((t->high_mm + SAME_MM - s->first_mm) / s->step_mm);
    for (int64_t i = first > 0 ? first : 0; i <= last && i < sim_sections_heights; i++) {
        e_mm[i] = between(t, sim_sections_height_mm(s, (int)i));
    }
}

static tracks_t tracks_of(double z_mm, double e_mm, double last_z_mm, double last_e_mm)
{
    if (isnan(last_z_mm)) {
        return (tracks_t){z_mm, e_mm, z_mm, e_mm};
    }
    return z_mm < last_z_mm ? (tracks_t){z_mm, e_mm, last_z_mm, last_e_mm}
                            : (tracks_t){last_z_mm, last_e_mm, z_mm, e_mm};
}

/// @return the index of any whole number of places
static int wrapped(int64_t place)
{
    const int64_t n = sim_sections_places;
    return (int)(((place % n) + n) % n);
}

void sim_sections_pass(sim_sections_t *s, int64_t place, double z_mm, const sim_place_t *at)
{
    if (s->n == 0) {
        return;
    }
    const int k = wrapped(place);
    const tracks_t t = tracks_of(z_mm, at->e_mm, s->before_z_mm[k], s->before_e_mm[k]);
    s->before_z_mm[k] = z_mm;
    s->before_e_mm[k] = at->e_mm;
    s->has_passes = true;
    for (int i = 0; i < s->n; i++) {
        if (s->z_mm[i] >= t.low_mm - SAME_MM && s->z_mm[i] <= t.high_mm + SAME_MM) {
            s->section[i][k] = *at;
            s->section[i][k].e_mm = between(&t, s->z_mm[i]);
        }
    }
    if (k % places_per_line == 0) {
        take_line(s, s->line_e_mm[k / places_per_line], &t);
    }
}

/// Interpolate the deviation between the two middle samples of four: by the Lagrange cubic, whose
/// angles need not be evenly spaced; linearly after a reversal.
static double cubic(const sim_section_tip_t tip[4], double turn)
{
    const double step = tip[2].turn - tip[1].turn;
    const bool is_one_way =
        (tip[1].turn - tip[0].turn) * step > 0.0 && (tip[3].turn - tip[2].turn) * step > 0.0;
    const int first = is_one_way ? 0 : 1;
    const int last = is_one_way ? 3 : 2;
    double sum = 0.0;
    for (int i = first; i <= last; i++) {
        double weight = 1.0;
        for (int k = first; k <= last; k++) {
            weight *= k == i ? 1.0 : (turn - tip[k].turn) / (tip[i].turn - tip[k].turn);
        }
        sum += weight * tip[i].e_mm;
    }
    return sum;
}

/// The places between two angles, none where they are far apart.
typedef struct {
    int64_t first, last;
} places_t;

static places_t places_between(double from_turn, double to_turn)
{
    if (sim_abs(to_turn - from_turn) > 0.5) {
        return (places_t){.first = 0, .last = -1};
    }
    return (places_t){sim_floor(fmin(from_turn, to_turn) * sim_sections_places) + 1,
                      sim_floor(fmax(from_turn, to_turn) * sim_sections_places)};
}

/// Forget the passes before this one at all places between two angles.
static void forget(sim_sections_t *s, double from_turn, double to_turn)
{
    const places_t found = places_between(from_turn, to_turn);
    for (int64_t place = found.first; place <= found.last; place++) {
        s->before_z_mm[wrapped(place)] = NAN;
    }
}

/// Record all points between the two middle samples.
static void pass_between(sim_sections_t *s)
{
    const sim_section_tip_t *from = &s->tip[1];
    const sim_section_tip_t *to = &s->tip[2];
    const double turned = to->turn - from->turn;
    const places_t found = places_between(from->turn, to->turn);
    for (int64_t place = found.first; place <= found.last; place++) {
        const double turn = (double)place / sim_sections_places;
        const double share = (turn - from->turn) / turned;
        const sim_place_t at = {.e_mm = cubic(s->tip, turn)};
        sim_sections_pass(s, place, from->z_mm + share * (to->z_mm - from->z_mm), &at);
    }
}

void sim_sections_touch(sim_sections_t *s, double turn, double z_mm, double e_mm, bool is_counted)
{
    if (s->n == 0 || !is_counted) {
        sim_sections_break(s);
        return;
    }
    if (s->n_tips == 4) {
        for (int i = 0; i < 3; i++) {
            s->tip[i] = s->tip[i + 1];
        }
        s->n_tips = 3;
    }
    s->tip[s->n_tips++] = (sim_section_tip_t){.turn = turn, .z_mm = z_mm, .e_mm = e_mm};
    if (s->n_tips == 4) {
        pass_between(s);
    } else if (s->n_tips < 3) { // points up to the second sample after a window are not recorded
        forget(s, s->n_tips == 1 ? s->skipped_turn : s->tip[0].turn, turn);
    }
}

void sim_sections_skip(sim_sections_t *s, double turn)
{
    if (s->n > 0) {
        const int before = s->n_tips - 2; // points after the third sample were not recorded
        forget(s, before >= 0 ? s->tip[before].turn : s->skipped_turn, turn);
        s->skipped_turn = turn;
        s->n_tips = 0;
    }
}
