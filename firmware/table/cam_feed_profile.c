// SPDX-License-Identifier: Apache-2.0
#include "cam_table_inner.h"
#include "cam_fix.h" // cam_greater_u64, cam_is_between
#include <stdbool.h> // bool

enum {
    least_feed_ppm = 20000, // [1e-6] smallest feed over its mean
    beyond_nm = 1000,       // [nm] rounding of knots of a Z that stands
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

/// @return whether Z rises by at least the least feed between any two knots
static bool is_rising(const cam_channel_t *way)
{
    // [LSB per slice] rise of a plain helix, rounded down
    const int64_t plain = ((int64_t)way->span_nm << way->frac_bits) / (way->n_slices - 1u);
    const int64_t least = plain * least_feed_ppm / 1000000;
    for (uint32_t i = 0; i + 1u < way->n_slices; i++) {
        if (plain + least_slope(&way->knots[i], &way->knots[i + 1u]) < least) {
            return false;
        }
    }
    return true;
}

/// @return whether Z stays between its first height and another one, by its Bernstein coefficients
static bool is_within(const cam_channel_t *way, int64_t risen_nm)
{
    const int64_t n_fifths = INT64_C(5) * (way->n_slices - 1u);
    const int64_t offset = way->value_offset * (INT64_C(1) << way->frac_bits);
    for (uint32_t i = 0; i + 1u < way->n_slices; i++) {
        const cam_wide_knot_t k0 = cam_bounds_wide(&way->knots[i], offset);
        const cam_wide_knot_t k1 = cam_bounds_wide(&way->knots[i + 1u], offset);
        int64_t tenfold[6];
        cam_bounds_tenfold(&k0, &k1, tenfold);
        for (int64_t j = 0; j < 6; j++) {
            const int64_t helix = 10 * (INT64_C(5) * i + j) * way->span_nm / n_fifths;
            const int64_t z = helix + (tenfold[j] >> way->frac_bits); // [nm / 10]
            if (!cam_is_between(z, INT64_C(-10) * beyond_nm, 10 * (risen_nm + beyond_nm))) {
                return false;
            }
        }
    }
    return true;
}

/// Z rises to the table's end. With stations it ends anywhere between its start and max_height_nm,
/// and never leaves what lies between the two, in which it may stand and go back.
static bool is_sound(const cam_table_t *t)
{
    const cam_channel_t *way = &t->way;
    const cam_knot_t *last = &way->knots[way->n_slices - 1u];
    const int64_t ahead_nm = way->value_offset + (last->p >> way->frac_bits);
    const int64_t risen_nm = (int64_t)way->span_nm + ahead_nm;
    if (!is_zero(way, &way->knots[0])) {
        return false;
    }
    return t->has_stations ? risen_nm >= 0 && way->z_first_nm + risen_nm <= max_height_nm &&
                                 is_within(way, risen_nm)
                           : is_zero(way, last) && is_rising(way);
}

cam_err_t cam_feed_profile_check(cam_table_t *table)
{
    const cam_channel_t *way = &table->way;
    table->way_slope_ppm = 1000000;
    table->way_bend_ppm_per_mm = 0;
    if (way->knots == NULL) {
        return cam_ok;
    }
    const cam_x_slope_t most = cam_x_slope_of(way);
    const uint64_t rise_ppm = UINT64_C(1000000) + most.rise_ppm;
    const uint64_t fall_ppm = cam_greater_u64(most.slope_ppm, 1000000u) - 1000000u; // Z goes back
    table->way_slope_ppm =
        (uint32_t)cam_smaller_i64((int64_t)cam_greater_u64(rise_ppm, fall_ppm), UINT32_MAX);
    table->way_bend_ppm_per_mm = most.bend_ppm_per_mm;
    return is_sound(table) ? cam_ok : cam_err_image_channel;
}
