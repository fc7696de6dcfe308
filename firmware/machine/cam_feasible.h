// SPDX-License-Identifier: Apache-2.0
/// cam_feasible: can this machine turn this table at this speed? In integers, with the numbers.
///
/// Speeds are mean speeds: where the table modulates the spindle, its peak speed is larger by the
/// largest ratio, and the guaranteed peaks contain the modulation.
#ifndef CAM_FEASIBLE_H
#define CAM_FEASIBLE_H

#include "cam_err.h"   // cam_err_t
#include "cam_param.h" // cam_params_t
#include "cam_table.h" // cam_table_t
#include <stdint.h>    // uint32_t, int64_t

/// Why a speed is feasible or not.
typedef struct {
    cam_err_t err;            ///< cam_ok or the first limit that is exceeded
    uint32_t speed_mrpm;      ///< the speed asked for
    uint32_t highest_mrpm;    ///< highest speed at which all limits hold; 0 when no speed helps
    uint32_t largest_feed_nm; ///< largest feed with which they hold at the speed asked for; 0 none
    int64_t needed;           ///< what the motion needs, in the unit of the limit
    int64_t limit; ///< [r/min / 1000], [um/s], [mm/s2], [nm], [degrees / 1000], [degrees /
                   ///< 1000 / s], [degrees / s2], [1e-6] or per tick, as err tells
} cam_feasibility_t;

/// Judge a speed.
/// @param speed_mrpm  [r/min / 1000] > 0
/// @param tick_hz     [Hz]
/// @return            what is needed is rounded up, by 0.1 % at most where it is near a limit, the
///                    acceleration of the swing by 1 %; the highest speed and the largest feed are
///                    the largest that pass
/// It is judged some 50 times over.
/// Context: slow side. Source: MATHS.md (61).
cam_feasibility_t cam_feasible(const cam_table_t *table, const cam_params_t *params,
                               uint32_t speed_mrpm, uint32_t tick_hz);

/// @return [r/min / 1000] highest speed within a turn of this mean speed, rounded up, saturated
/// Context: slow side.
uint32_t cam_feasible_peak(const cam_table_t *table, uint32_t mean_mrpm);

#endif
