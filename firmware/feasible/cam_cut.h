// SPDX-License-Identifier: Apache-2.0
/// cam_cut: a cut at a mean speed of the spindle, and the arithmetic that judges it.
///
/// Demands are calculated in doubles and rounded up, so that none is too small.
/// Context: slow side.
#ifndef CAM_CUT_H
#define CAM_CUT_H

#include "cam_doubles.h" // CAM_PI
#include "cam_err.h"     // cam_err_t
#include "cam_fix.h"     // cam_abs_i64
#include "cam_param.h"   // cam_params_t
#include "cam_table.h"   // cam_table_t
#include <stdint.h>      // uint32_t, int64_t, uint64_t

typedef struct {
    const cam_table_t *t;
    const cam_params_t *p;
    uint32_t tick_hz;   ///< [Hz] rate of the tick
    uint32_t mean_mrpm; ///< [r/min / 1000] mean speed, below 2^26
    uint32_t peak_mrpm; ///< [r/min / 1000] highest speed within a turn, up to four times the mean
    uint64_t feed_nm;   ///< [nm] feed per turn, override included, below 2^25
    uint64_t programmed_nm; ///< [nm] without the override: the ramps of the feed are made for it
} cam_cut_t;

/// One limit and what the cut needs of it.
typedef struct {
    cam_err_t err;   ///< error that reports an excess
    int64_t limit;   ///< in the unit of CAM_ERR_LIMITS for err
    uint64_t needed; ///< in the same unit, rounded up; it never decreases as speed or feed rises
} cam_demand_t;

static inline int64_t cam_cut_smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static inline uint64_t cam_cut_greater(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/// @return a / b, rounded up
static inline uint64_t cam_cut_divided_up(uint64_t a, uint64_t b)
{
    return (a + b - 1u) / b;
}

/// @return a * b / c, rounded up, saturated
static inline uint64_t cam_cut_scaled_up(uint64_t a, uint64_t b, uint64_t c)
{
    return a == 0u || b < (uint64_t)INT64_MAX / a ? cam_cut_divided_up(a * b, c)
                                                  : (uint64_t)INT64_MAX;
}

/// @return v rounded up, saturated to 0 .. INT64_MAX, INT64_MAX for NaN; what exceeds an integer by
///         less than 2^-40 of itself is rounding
static inline uint64_t cam_cut_up(double v)
{
    if (!(v < 0x1p62)) {
        return (uint64_t)INT64_MAX;
    }
    if (v <= 0.0) {
        return 0;
    }
    const uint64_t whole = (uint64_t)v;
    return v - (double)whole > v * 0x1p-40 ? whole + 1u : whole;
}

static inline double cam_cut_most(double a, double b)
{
    return a > b ? a : b;
}

/// @return a peak of U or of the swing at the amplitude in force
static inline double cam_cut_at_amplitude(const cam_cut_t *c, double peak)
{
    return peak * c->p->amplitude_ppm * 1e-6;
}

/// @param mrpm  [r/min / 1000]
/// @return      [rad/s] the same angular speed
static inline double cam_cut_omega(uint32_t mrpm)
{
    return mrpm * (CAM_PI / 30000.0);
}

/// @param peak  [nm/rad] first derivative over the angle
/// @return      [um/s] speed at the mean speed of the spindle
static inline double cam_cut_um_per_s(const cam_cut_t *c, double peak)
{
    return peak * cam_cut_omega(c->mean_mrpm) * 1e-3;
}

/// @param peak  [nm/rad2] second derivative over the angle
/// @return      [mm/s2] acceleration at the mean speed of the spindle
static inline double cam_cut_mm_per_s2(const cam_cut_t *c, double peak)
{
    const double omega = cam_cut_omega(c->mean_mrpm);
    return peak * omega * omega * 1e-6;
}

/// The smooth step of the envelope and of lobes, and the magnitudes of its derivatives.
typedef struct {
    double e, e1, e2;
} cam_cut_step_t;

/// @param s  0 .. 1
static inline cam_cut_step_t cam_cut_step(double s)
{
    const double left = 1.0 - s;
    return (cam_cut_step_t){
        .e = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
        .e1 = 30.0 * s * s * left * left,
        .e2 = 60.0 * s * left * (left > s ? left - s : s - left),
    };
}

/// @return [nm] how far U travels from the middle of its stroke, without feed-forward
static inline uint64_t cam_cut_largest_nm(const cam_table_t *t)
{
    return cam_cut_greater((uint64_t)cam_abs_i64(t->u_min_nm), (uint64_t)cam_abs_i64(t->u_max_nm));
}

/// @return [nm] height of the part, over which Z feeds
static inline uint64_t cam_cut_span_nm(const cam_cut_t *c)
{
    return (uint64_t)((int64_t)c->t->z_last_nm - c->t->z_first_nm);
}

#endif
