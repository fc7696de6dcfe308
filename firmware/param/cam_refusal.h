// SPDX-License-Identifier: Apache-2.0
/// cam_refusal: why a check refuses parameters or a speed, with the numbers. Context: slow side.
#ifndef CAM_REFUSAL_H
#define CAM_REFUSAL_H

#include "cam_err.h"   // cam_err_t
#include "cam_param.h" // cam_param_id_t
#include <stdint.h>    // int64_t, uint32_t

typedef struct {
    cam_err_t err;        ///< cam_ok: nothing is refused
    cam_param_id_t param; ///< the refused parameter; cam_n_params: none
    int64_t needed;       ///< its value, or what the motion needs; in the unit of the limit
    int64_t limit; ///< in the unit of the parameter or of CAM_ERR_LIMITS; 0 where none is known
    uint32_t speed_mrpm;      ///< [r/min / 1000] the speed that was judged; 0: none
    uint32_t highest_mrpm;    ///< [r/min / 1000] cam_feasible_highest_mrpm()
    uint32_t largest_feed_nm; ///< [nm] cam_feasible_largest_feed_nm()
    uint32_t pass;            ///< number of the pass that was judged; 0: the table has none
} cam_refusal_t;

/// @return no refusal
static inline cam_refusal_t cam_refusal_none(void)
{
    return (cam_refusal_t){.err = cam_ok, .param = cam_n_params};
}

/// @return the refusal of a parameter
static inline cam_refusal_t cam_refusal_of(cam_err_t err, cam_param_id_t param, int64_t needed,
                                           int64_t limit)
{
    return (cam_refusal_t){.err = err, .param = param, .needed = needed, .limit = limit};
}

#endif
