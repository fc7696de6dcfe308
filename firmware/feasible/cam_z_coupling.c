// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible_inner.h"
#include "cam_motion.h" // cam_feed_ramp_q32
#include <stdbool.h>    // bool
#include <stddef.h>     // NULL

static bool has_rings(const cam_cut_t *c)
{
    return c->t->is_ring_helix && c->p->z_is_measured == 0;
}

/// @return [um/s] speed of Z along a helix with the mean feed
static double plain_um_per_s(const cam_cut_t *c)
{
    return (double)c->feed_nm * c->peak_mrpm / 6e7;
}

/// @return [1] largest feed over its mean
static double way_slope(const cam_cut_t *c)
{
    const bool has_way = c->p->z_is_measured == 0 && c->t->way.knots != NULL;
    return has_way ? c->t->way_slope_ppm * 1e-6 : 1.0;
}

/// Where the feed changes with the height, Z accelerates by that change times the square of its
/// mean speed. @return [mm/s2]
static double way_mm_per_s2(const cam_cut_t *c)
{
    const double v_um_per_s = plain_um_per_s(c);
    return c->t->way.knots != NULL ? v_um_per_s * v_um_per_s * c->t->way_bend_ppm_per_mm * 1e-12
                                   : 0.0;
}

double cam_z_coupling_z_um_per_s(const cam_cut_t *c)
{
    if (!has_rings(c)) {
        return plain_um_per_s(c) * way_slope(c);
    }
    const uint32_t feed_nm = (uint32_t)c->feed_nm;
    const uint32_t ramp_q32 =
        cam_feed_ramp_q32(feed_nm, c->peak_mrpm, (uint32_t)c->p->z_acceleration_mm_per_s2);
    return (double)cam_feed_speed_um_per_s(feed_nm, c->peak_mrpm, ramp_q32);
}

/// @return [mm/s2] acceleration along a plain helix
static double ramp_mm_per_s2(const cam_cut_t *c)
{
    const double rpm = c->peak_mrpm * 1e-3;
    const double feed_nm = (double)c->programmed_nm;
    const double span_turns = (double)cam_cut_span_nm(c) / feed_nm;
    const double ramp_turns = c->p->feed_ramp_turns;
    return feed_nm * rpm * rpm / (3.6e9 * (ramp_turns < span_turns ? ramp_turns : span_turns));
}

double cam_z_coupling_z_mm_per_s2(const cam_cut_t *c)
{
    return has_rings(c) ? (double)cam_feed_least_acceleration((uint32_t)c->feed_nm, c->peak_mrpm)
                        : ramp_mm_per_s2(c) * way_slope(c) + way_mm_per_s2(c);
}

double cam_z_coupling_z_feeding_mm_per_s2(const cam_cut_t *c)
{
    return has_rings(c)               ? c->p->z_acceleration_mm_per_s2
           : c->p->z_is_measured != 0 ? 0.0
                                      : cam_z_coupling_z_mm_per_s2(c);
}

double cam_z_coupling_along_um_per_s(const cam_cut_t *c)
{
    return c->t->has_stations ? plain_um_per_s(c) : cam_z_coupling_z_um_per_s(c);
}

double cam_z_coupling_along_mm_per_s2(const cam_cut_t *c)
{
    return c->t->has_stations ? ramp_mm_per_s2(c) : cam_z_coupling_z_feeding_mm_per_s2(c);
}

cam_z_coupling_t cam_z_coupling_of(const cam_cut_t *c, const cam_channel_t *ch,
                                   const cam_change_t *change, uint32_t set_point_hz)
{
    if (c->t->n_lobes > 0u) {
        return (cam_z_coupling_t){0};
    }
    const double spacing_um = ch->span_nm * 1e-3 / (ch->n_slices - 1u);
    const double per_s = cam_z_coupling_along_um_per_s(c) / spacing_um;
    const double per_s2 = cam_z_coupling_along_mm_per_s2(c) * 1e3 / spacing_um;
    return (cam_z_coupling_t){
        .speed = change->most * per_s * 1e-3,
        .speed_per_rad = change->per_rad * per_s * 1e-3,
        .acceleration = (change->kink * per_s * set_point_hz + change->most * per_s2) * 1e-3,
    };
}

double cam_z_coupling_acceleration(const cam_cut_t *c, const cam_z_coupling_t *d)
{
    return 2.0 * d->speed_per_rad * cam_cut_omega(c->peak_mrpm) + d->acceleration;
}

/// The smooth step is evaluated at this many points; between them it is at most 1 % larger.
enum { n_places = 20 };
#define BETWEEN 1.01

/// @return x = R / (2 pi N); with a speed channel the lift has half the height
static double x_of(const cam_table_t *t, uint64_t feed_nm)
{
    const double change_nm = t->least_change_nm * (t->speed.knots != NULL ? 0.5 : 1.0);
    return (double)feed_nm * t->ratio_max_q20 * 0x1p-20 / (2.0 * CAM_PI * change_nm);
}

/// @param f       [unit/rad^n] the magnitude that the smooth step scales
/// @param g1, g2  [unit/rad^n] the factors of the magnitudes of E' x and E'' x^2
/// @return        bound of f E + g1 E' x + g2 E'' x^2 over the step; f of a single lobe, or of none
static double bound(const cam_table_t *t, uint64_t feed_nm, double f, double g1, double g2)
{
    if (t->least_change_nm == 0u) {
        return f;
    }
    const double x = x_of(t, feed_nm);
    double most = f;
    double before = 0.0;
    for (uint32_t i = 1; i <= (uint32_t)n_places; i++) {
        const cam_cut_step_t at = cam_cut_step((double)i / n_places);
        const double more = g1 * x * at.e1 + g2 * x * x * at.e2;
        most = cam_cut_most(most, f * at.e + BETWEEN * cam_cut_most(before, more));
        before = more;
    }
    return most;
}

double cam_z_coupling_lobes_first(const cam_table_t *t, uint64_t feed_nm,
                                  const cam_z_coupling_peaks_t *peaks)
{
    return bound(t, feed_nm, peaks->f1, peaks->f, 0.0);
}

double cam_z_coupling_lobes_second(const cam_table_t *t, uint64_t feed_nm,
                                   const cam_z_coupling_peaks_t *peaks, uint32_t n_set_points)
{
    const double by_spindle = peaks->f * t->spindle_peak_ppm_per_rad * 1e-6 * n_set_points;
    return bound(t, feed_nm, peaks->f2, 2.0 * peaks->f1 + by_spindle, peaks->f * n_set_points);
}
