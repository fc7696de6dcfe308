// SPDX-License-Identifier: Apache-2.0
/// sim_params: hand all parameters to a controller that takes them one by one.
///
/// Each change has to be right together with those made before it, which a set that is right as a
/// whole need not be on the way: a slow U with small gains passes a slow U with the gains of
/// before. What is refused for its gains is therefore tried again behind the others.
#ifndef SIM_PARAMS_H
#define SIM_PARAMS_H

#include "cam_err.h"      // cam_err_t
#include "cam_param.h"    // cam_params_t, cam_param_id_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int32_t, uint32_t

/// Give one value to the controller, and let it take it; nothing where it has that value.
typedef cam_err_t (*sim_params_set_t)(void *controller, cam_param_id_t id, int32_t value);

/// Set the parameters that differ.
/// @param tick_hz  [Hz] of the controller
/// @return         false and *e, with the value that it would take, where it refuses one
bool sim_params_apply(const cam_params_t *params, uint32_t tick_hz, sim_params_set_t set,
                      void *controller, common_error_t *e);

#endif
