// SPDX-License-Identifier: Apache-2.0
/// cam_cut: a cut at a mean speed of the spindle, and the arithmetic that judges it.
///
/// All demands are integers, rounded up, so that none is too small. Context: slow side.
#ifndef CAM_CUT_H
#define CAM_CUT_H

#include "cam_err.h"   // cam_err_t
#include "cam_param.h" // cam_params_t
#include "cam_table.h" // cam_table_t
#include <stdint.h>    // uint32_t, int64_t, uint64_t

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

/// @return a peak of U or of the swing at the amplitude in force, rounded up
static inline uint64_t cam_cut_at_amplitude(const cam_cut_t *c, uint64_t peak)
{
    return cam_cut_scaled_up(peak, (uint32_t)c->p->amplitude_ppm, 1000000);
}

/// @param mrpm  [r/min / 1000]
/// @return      [mrad/s] the same angular speed, 2 pi / 60 of it, rounded up
static inline uint64_t cam_cut_omega_mrad_per_s(uint64_t mrpm)
{
    return cam_cut_divided_up(mrpm * 104719756u, UINT64_C(1000000000));
}

/// @param peak  [nm/rad] first derivative over the angle
/// @return      [um/s] speed at the mean speed of the spindle, rounded up
static inline uint64_t cam_cut_um_per_s(const cam_cut_t *c, uint64_t peak)
{
    return cam_cut_divided_up(peak * cam_cut_omega_mrad_per_s(c->mean_mrpm), 1000000);
}

/// @param peak  [nm/rad2] second derivative over the angle
/// @return      [um/s2] acceleration at the mean speed of the spindle, rounded up, saturated
static inline uint64_t cam_cut_um_per_s2(const cam_cut_t *c, uint64_t peak)
{
    const uint64_t omega = cam_cut_omega_mrad_per_s(c->mean_mrpm);
    const uint64_t omega2 = cam_cut_divided_up(omega * omega, 10000); // [0.01 rad2/s2]
    return cam_cut_scaled_up(peak, omega2, 100000);
}

/// @return [nm] height of the part, over which Z feeds
static inline uint64_t cam_cut_span_nm(const cam_cut_t *c)
{
    return (uint64_t)((int64_t)c->t->z_last_nm - c->t->z_first_nm);
}

#endif
