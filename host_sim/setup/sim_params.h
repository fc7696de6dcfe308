// SPDX-License-Identifier: Apache-2.0
/// sim_params: brings all parameters of a controller into force at once, or says which one is
/// wrong.
#ifndef SIM_PARAMS_H
#define SIM_PARAMS_H

#include "cam_machine.h"  // cam_machine_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool

/// Set all parameters. The interrupt must have taken the last change.
/// @return false and *e, with an acceptable value, when one is refused
bool sim_params_apply(cam_machine_t *machine, const cam_params_t *params, common_error_t *e);

#endif
