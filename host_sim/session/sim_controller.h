// SPDX-License-Identifier: Apache-2.0
/// sim_controller: the parameters of the firmware that fit a lathe, and the changes of the user.
///
///     k1 = 2 d / w, k2 = 1 / w^2           the inverse of the U drive (sim_drive.h)
///     lead = dead time of U + half a tick  the mean age of a held command
///     k1, k2, lead of a drive of kind force: what its loop is worth (sim_servo.h)
///     u_scale, u_scale_latency = quantum and latency of U's scale
///     probe = three quanta, at least its default
///     xz_lag = dead time + half a tick + 2 d / w of X and Z, mean of both
///     swing_lag = dead time + half a tick + 2 d / w of the swing
///     spindle_lag = 1 / bandwidth of the spindle, acceleration = torque / inertia
///
/// The limits are those of the lathe; the following error and the window for jumps are left to the
/// firmware, which derives them from machine and part (cam_derived_limits.h); jitter widens the
/// window for the index by seven times its rms. The observer has 200 Hz, or a twentieth of a slower
/// tick.
///
/// A parameter that is given in [controller] of the machine file or by --set overrules the derived
/// one, so that a mismatch between machine and controller can be studied.
#ifndef SIM_CONTROLLER_H
#define SIM_CONTROLLER_H

#include "cam_param.h"    // cam_n_params
#include "cam_table.h"    // cam_table_t
#include "common_error.h" // common_error_t
#include "sim_lathe.h"    // sim_lathe_config_t
#include <stdbool.h>      // bool

/// Parameters that the user gave; zero-initialised there are none.
typedef struct {
    int32_t value[cam_n_params];
    bool is_given[cam_n_params];
} sim_wishes_t;

/// Remember one parameter.
/// @param name    of a parameter of cam_param.h
/// @param value   whole number within its range
/// @param origin  for the message: file and section, or the option
bool sim_wishes_add(sim_wishes_t *w, const char *name, double value, const char *origin,
                    common_error_t *e);

/// @param params   filled completely
/// @param machine  as the controller believes it to be (sim_config_believed())
/// @param measures_u  U's port is a measurement to learn from: learning is on by default
/// @return        false and *e when a derived value is outside the range of its parameter
bool sim_controller_params(cam_params_t *params, const sim_lathe_config_t *machine, bool measures_u,
                           const sim_wishes_t *wishes, common_error_t *e);

#endif
