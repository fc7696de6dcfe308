// SPDX-License-Identifier: Apache-2.0
/// sim_params: sets all parameters of a controller, one by one.
///
/// A controller checks each change together with the earlier ones, so a valid set may pass invalid
/// intermediate states: a slow U with small gains passes a slow U with the old gains. Parameters
/// refused for their gains, or for the position loop of U, are therefore retried after the others.
#ifndef SIM_PARAMS_H
#define SIM_PARAMS_H

#include "cam_err.h"      // cam_err_t
#include "cam_param.h"    // cam_params_t, cam_param_id_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int32_t, uint32_t

/// Set one value in the controller; nothing if it has that value already.
typedef cam_err_t (*sim_params_set_t)(void *controller, cam_param_id_t id, int32_t value);

/// Set the parameters that differ.
/// @param tick_hz  [Hz] of the controller
/// @return         false and *e, with an acceptable value, when one is refused
bool sim_params_apply(const cam_params_t *params, uint32_t tick_hz, sim_params_set_t set,
                      void *controller, common_error_t *e);

#endif
