// SPDX-License-Identifier: Apache-2.0
/// sim_controller: firmware parameters derived from a lathe, with the user's changes.
///
///     k1 = 2 d / w, k2 = 1 / w^2           the inverse of the U drive (sim_drive.h)
///     lead = dead time of U + half a tick  mean age of a held command
///     u_scale, u_scale_latency = quantum and latency of U's scale
///     probe = three quanta, at least its default
///     xz_lag = dead time + half a tick + 2 d / w of X and Z, mean of both
///     swing_lag = dead time + half a tick + 2 d / w of the swing
///     spindle_lag = 1 / bandwidth of the spindle, acceleration = torque / inertia
///
/// A force drive has k1 = k2 = 0, and its lead is a tick, the dead time, half a tick and the lag of
/// the amplifier. The crossover of its position loop is 0.07 / delay, at most damping hz / share of
/// a mode on the scale; the pole of its lead is ten times that, at most a fifth of the tick rate.
///
/// The limits are those of the lathe. The firmware derives the limit of the following error and the
/// window for jumps from machine and part (cam_derived_limits.h). Jitter widens the index window by
/// seven times its rms. The observer bandwidth is 200 Hz, or a twentieth of the tick rate if that
/// is less.
///
/// [controller] of the machine file and --set override derived parameters, for example to study a
/// mismatch of machine and controller.
#ifndef SIM_CONTROLLER_H
#define SIM_CONTROLLER_H

#include "cam_param.h"    // cam_n_params
#include "cam_table.h"    // cam_table_t
#include "common_error.h" // common_error_t
#include "sim_lathe.h"    // sim_lathe_config_t
#include <stdbool.h>      // bool

/// Parameters given by the user; zero-initialised: none.
typedef struct {
    int32_t value[cam_n_params];
    bool is_given[cam_n_params];
    common_error_t retired; ///< names the first retired parameter, which is ignored; "": none
} sim_wishes_t;

/// Store one parameter. A retired one is ignored.
/// @param name    name of a parameter of cam_param.h
/// @param value   whole number within its range
/// @param origin  for the message: file and section, or the option
bool sim_wishes_add(sim_wishes_t *w, const char *name, double value, const char *origin,
                    common_error_t *e);

/// @param params   all are set
/// @param machine  the controller's model of it (sim_config_believed())
/// @param learns   learning is on by default, as in the firmware from 5 kHz on
/// @return        false and *e when a derived value is outside the range of its parameter
bool sim_controller_params(cam_params_t *params, const sim_lathe_config_t *machine, bool learns,
                           const sim_wishes_t *wishes, common_error_t *e);

#endif
