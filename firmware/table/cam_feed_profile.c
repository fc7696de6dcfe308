// SPDX-License-Identifier: Apache-2.0
#include "cam_table_inner.h"
#include <stdbool.h> // bool

enum {
    least_feed_ppm = 20000, // [1e-6] smallest feed over its mean
    standing_ppm = -1000,   // [1e-6] with stations: 0, less the rounding of a knot
    max_height_nm = 1000000000,
};

static bool is_zero(const cam_channel_t *way, const cam_knot_t *knot)
{
    return knot->p == -way->value_offset * (INT64_C(1) << way->frac_bits);
}

/// @return [LSB per slice] lower bound of the slope of way between two knots: the smallest
///         Bernstein coefficient of its derivative
static int64_t least_slope(const cam_knot_t *k0, const cam_knot_t *k1)
{
    const int64_t rise = (int64_t)k1->p - k0->p;
    const int64_t v0 = k0->v;
    const int64_t v1 = k1->v;
    // Degree 4: the third coefficient makes their mean the rise; a = h^2 f'' / 2.
    const int64_t b1 = v0 + k0->a / 2;
    const int64_t b3 = v1 - k1->a / 2;
    const int64_t coefficient[] = {v0, b1, 5 * rise - v0 - b1 - b3 - v1, b3, v1};
    int64_t least = coefficient[0];
    for (uint32_t i = 1; i < sizeof coefficient / sizeof coefficient[0]; i++) {
        least = coefficient[i] < least ? coefficient[i] : least;
    }
    return least;
}

/// @return whether Z rises by at least a share of the mean feed between any two knots
static bool is_rising(const cam_channel_t *way, int64_t least_ppm)
{
    // [LSB per slice] rise of a plain helix, rounded down
    const int64_t plain = ((int64_t)way->span_nm << way->frac_bits) / (way->n_slices - 1u);
    const int64_t least = plain * least_ppm / 1000000;
    for (uint32_t i = 0; i + 1u < way->n_slices; i++) {
        if (plain + least_slope(&way->knots[i], &way->knots[i + 1u]) < least) {
            return false;
        }
    }
    return true;
}

/// Z ends at the table's end, or with stations anywhere between its start and max_height_nm.
static bool is_sound(const cam_table_t *t)
{
    const cam_channel_t *way = &t->way;
    const cam_knot_t *last = &way->knots[way->n_slices - 1u];
    const int64_t ahead_nm = way->value_offset + (last->p >> way->frac_bits);
    const int64_t risen_nm = (int64_t)way->span_nm + ahead_nm;
    const bool is_ended = t->has_stations
                              ? risen_nm >= 0 && way->z_first_nm + risen_nm <= max_height_nm
                              : is_zero(way, last);
    return is_zero(way, &way->knots[0]) && is_ended &&
           is_rising(way, t->has_stations ? standing_ppm : least_feed_ppm);
}

cam_err_t cam_feed_profile_check(cam_table_t *table)
{
    const cam_channel_t *way = &table->way;
    table->way_slope_ppm = 1000000;
    table->way_bend_ppm_per_m = 0;
    if (way->knots == NULL) {
        return cam_ok;
    }
    const cam_x_slope_t most = cam_x_slope_of(way);
    const uint32_t most_rise_ppm = UINT32_MAX - 1000000u;
    table->way_slope_ppm =
        1000000u + (most.rise_ppm < most_rise_ppm ? most.rise_ppm : most_rise_ppm);
    table->way_bend_ppm_per_m = most.bend_ppm_per_m;
    return is_sound(table) ? cam_ok : cam_err_image_channel;
}
