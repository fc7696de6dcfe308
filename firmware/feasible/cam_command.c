// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible_inner.h"
#include "cam_table.h" // cam_bounds_next, cam_bounds_tenfold
#include "cam_fix.h"   // cam_abs_i64
#include <stdbool.h>   // bool
#include <stddef.h>    // NULL

/// Bernstein coefficients of a quintic. A derivative is raised to the same degree.
enum { n_coefficients = 6 };

/// Beyond these only the peaks bound the command, because products might exceed 64 bits.
enum { most_per_ms = 1 << 10, most_ahead = 1 << 10 };

/// Factors of the feed-forward, for derivatives per knot interval.
typedef struct {
    int64_t first_q16;  ///< [intervals / 2^16] of u'
    int64_t second_q16; ///< [intervals^2 / 2^16] of u''
    int64_t swept_q16;  ///< [intervals / 2^16] of u', of either sign: a spindle that accelerates
} ahead_t;

/// @return [m/s3] peak of u''' omega^3 at uniform speed
static double jerk_m_per_s3(const cam_cut_t *c)
{
    const double by_second = cam_cut_mm_per_s2(c, c->t->u3_peak_nm_per_rad3);
    return c->t->speed.knots != NULL ? 0.0 : by_second * cam_cut_omega(c->mean_mrpm) * 1e-3;
}

/// @return [m/s3] jerk of a motion by time, for which the limits of the command are made
static double jerk_by_time(const cam_cut_t *c)
{
    const uint32_t ticks = UINT32_C(1) << cam_gains_log2_window(c->p, hal_axis_u, c->tick_hz);
    return c->p->u_acceleration_mm_per_s2 * 2e-3 * c->tick_hz / ticks;
}

/// @return a demand of the feed-forward; without gains the command is u, which has its own limits
static cam_demand_t by_gains(const cam_cut_t *c, cam_err_t err, double limit, double needed)
{
    const bool has_gains = c->p->k1_ns > 0 || c->p->k2_us2 > 0;
    const double own = has_gains ? cam_cut_at_amplitude(c, needed) : 0.0;
    return (cam_demand_t){err, (int64_t)limit, cam_cut_up(own)};
}

cam_demand_t cam_command_speed_demand(const cam_cut_t *c)
{
    const double k1_ms = c->p->k1_ns * 1e-6;
    const double k2_ms2 = c->p->k2_us2 * 1e-6;
    const double limit =
        c->p->u_speed_um_per_s + c->p->u_acceleration_mm_per_s2 * k1_ms + jerk_by_time(c) * k2_ms2;
    const double needed = cam_cut_um_per_s(c, c->t->u1_peak_nm_per_rad) +
                          cam_cut_mm_per_s2(c, c->t->u2_peak_nm_per_rad2) * k1_ms +
                          jerk_m_per_s3(c) * k2_ms2;
    return by_gains(c, cam_err_u_command_speed, limit, needed);
}

cam_demand_t cam_command_acceleration_demand(const cam_cut_t *c)
{
    const double k1_ms = c->p->k1_ns * 1e-6;
    const double k2_ms2 = c->p->k2_us2 * 1e-6;
    const double by_time = jerk_by_time(c);
    const double limit =
        c->p->u_acceleration_mm_per_s2 + by_time * k1_ms + by_time * 2e-3 * c->tick_hz * k2_ms2;
    const double needed =
        cam_cut_mm_per_s2(c, c->t->u2_peak_nm_per_rad2) + jerk_m_per_s3(c) * k1_ms;
    return by_gains(c, cam_err_u_command_acceleration, limit, needed);
}

/// @return whether the products fit 64 bits
static bool find_ahead(const cam_cut_t *c, ahead_t *a)
{
    const double per_turn = UINT32_C(1) << (c->t->u.log2_knots + c->t->u.log2_repeat);
    const double per_ms = c->peak_mrpm * per_turn / 6e7;
    const double first = per_ms * c->p->k1_ns * 1e-6;
    const double second = per_ms * per_ms * c->p->k2_us2 * 1e-6;
    const double swept = second * 2.0 * CAM_PI * c->t->spindle_peak_ppm_per_rad * 1e-6 / per_turn;
    if (per_ms >= most_per_ms || cam_cut_most(first, cam_cut_most(second, swept)) >= most_ahead) {
        return false;
    }
    *a = (ahead_t){.first_q16 = (int64_t)cam_cut_up(first * 0x1p16),
                   .second_q16 = (int64_t)cam_cut_up(second * 0x1p16),
                   .swept_q16 = (int64_t)cam_cut_up(swept * 0x1p16)};
    return true;
}

/// Derive a quintic by its coefficients, per knot interval.
static void derive(const int64_t b[n_coefficients], int64_t d[n_coefficients])
{
    const int64_t last = n_coefficients - 1;
    for (int64_t i = 0; i <= last; i++) {
        const int64_t before = i > 0 ? i * (b[i] - b[i - 1]) : 0;
        const int64_t after = i < last ? (last - i) * (b[i + 1] - b[i]) : 0;
        d[i] = before + after;
    }
}

/// @return bound of |b + s d + s^2 e| for all s of 0 .. 1
static int64_t most_of_bend(int64_t b, int64_t d, int64_t e)
{
    int64_t most =
        cam_abs_i64(b) > cam_abs_i64(b + d + e) ? cam_abs_i64(b) : cam_abs_i64(b + d + e);
    const bool is_bent = e != 0 && (d < 0) != (e < 0) && cam_abs_i64(d) < 2 * cam_abs_i64(e);
    if (is_bent) { // it reverses at s = -d / 2 e
        const int64_t turn =
            cam_abs_i64(b + d * (-d * 32768 / e) / 131072) + cam_abs_i64(d) / 65536;
        most = turn > most ? turn : most;
    }
    return most + 1;
}

/// Of s, the share of the speed, the command is b + s d + s^2 e.
/// @return [LSB / 10] largest command of the quintic between two knots at any speed up to this one
static int64_t tenfold(const cam_wide_knot_t *k0, const cam_wide_knot_t *k1, const ahead_t *a)
{
    int64_t b[n_coefficients];
    int64_t d[n_coefficients];
    int64_t e[n_coefficients];
    cam_bounds_tenfold(k0, k1, b);
    derive(b, d);
    derive(d, e);
    int64_t most = 0;
    for (uint32_t i = 0; i < (uint32_t)n_coefficients; i++) {
        const int64_t swept = cam_abs_i64(d[i]) * a->swept_q16 / 65536;
        const int64_t w =
            swept + most_of_bend(b[i], d[i] * a->first_q16 / 65536, e[i] * a->second_q16 / 65536);
        most = w > most ? w : most;
    }
    return most;
}

/// @return [nm] largest command of all slices, and so between them
static uint64_t together_nm(const cam_channel_t *ch, const ahead_t *a)
{
    const int64_t offset = (int64_t)ch->value_offset * (INT64_C(1) << ch->frac_bits);
    int64_t most = 0;
    for (uint32_t i = 0; i < ch->n_slices << ch->log2_knots; i++) {
        const cam_wide_knot_t k0 = cam_bounds_wide(&ch->knots[i], offset);
        const cam_wide_knot_t k1 = cam_bounds_wide(&ch->knots[cam_bounds_next(ch, i)], offset);
        const int64_t w = tenfold(&k0, &k1, a);
        most = w > most ? w : most;
    }
    return ((uint64_t)most / 10u >> ch->frac_bits) + 1u;
}

cam_demand_t cam_command_stroke_demand(const cam_cut_t *c)
{
    const int32_t limit_nm = c->p->u_stroke_nm / 2;
    const double peaks_nm = (double)cam_cut_largest_nm(c->t) +
                            cam_cut_um_per_s(c, c->t->u1_peak_nm_per_rad) * c->p->k1_ns * 1e-6 +
                            cam_cut_mm_per_s2(c, c->t->u2_peak_nm_per_rad2) * c->p->k2_us2 * 1e-6;
    ahead_t ahead;
    const bool is_read = cam_cut_at_amplitude(c, peaks_nm) > limit_nm &&
                         c->peak_mrpm <= (uint32_t)c->p->spindle_limit_mrpm &&
                         c->t->u.knots != NULL && find_ahead(c, &ahead);
    const double read_nm = is_read ? (double)together_nm(&c->t->u, &ahead) : peaks_nm;
    return by_gains(c, cam_err_u_command, limit_nm,
                    (read_nm < peaks_nm ? read_nm : peaks_nm) + c->p->u_friction_nm);
}
