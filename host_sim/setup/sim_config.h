// SPDX-License-Identifier: Apache-2.0
/// sim_config: reads machine files, derives the controller's parameters from them and sets these.
///
/// A machine file is a subset of TOML:
///
///     # comment
///     [section]
///     key = 1.5          # number, true, false or "string"
///
/// Every key has a default; machines/default.toml lists and explains them all. Unknown and repeated
/// keys and invalid or out-of-range values are refused; the message names file, line, key, value
/// and remedy. [controller] takes any parameter of cam_param.h.
///
/// [believed.SECTION] takes the keys of every other section except [machine] and [controller]:
/// values for which the controller is configured instead of the true ones. Keys not given there
/// keep their true values.
#ifndef SIM_CONFIG_H
#define SIM_CONFIG_H

#include "cam_machine.h"  // cam_machine_t
#include "cam_param.h"    // cam_n_params, cam_params_t, cam_refusal_t
#include "cam_table.h"    // cam_table_t
#include "common_error.h" // common_error_t
#include "sim_lathe.h"    // sim_lathe_config_t
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t
#include <stdint.h>       // int32_t, uint32_t

// Firmware parameters derived from a lathe, with the user's changes.
//
//     k1 = 2 d / w, k2 = 1 / w^2           the inverse of the U drive (sim_drive.h)
//     lead = dead time of U + half a tick  mean age of a held command
//     u_scale, u_scale_latency = quantum and latency of U's scale
//     probe = three quanta, at least its default
//     xz_lag = dead time + half a tick + 2 d / w of X and Z, mean of both
//     swing_lag = dead time + half a tick + 2 d / w of the swing
//     spindle_lag = 1 / bandwidth of the spindle, acceleration = torque / inertia
//
// A force drive has k1 = k2 = 0, and its lead is a tick, the dead time, half a tick and the lag of
// the amplifier. The crossover of its position loop is 0.07 / delay, at most damping hz / share of
// a mode on the scale; the pole of its lead is ten times that, at most a fifth of the tick rate.
//
// The limits are those of the lathe. The firmware derives the limit of the following error and the
// window for jumps from machine and part (cam_feasible.h). Jitter widens the index window by
// seven times its rms. The observer bandwidth is 200 Hz, or a twentieth of the tick rate if that
// is less.
//
// [controller] of the machine file and --set override derived parameters, for example to study a
// mismatch of machine and controller.

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

// The machine file

typedef struct {
    char name[64];
    sim_lathe_config_t lathe;    ///< the truth
    bool has_belief;             ///< the file has a key of [believed.SECTION]
    sim_lathe_config_t believed; ///< with has_belief: the lathe as the controller knows it
    sim_wishes_t controller;
} sim_config_t;

/// The default machine.
sim_config_t sim_config_defaults(void);

/// @return the lathe from which the controller's parameters are derived
static inline const sim_lathe_config_t *sim_config_believed(const sim_config_t *config)
{
    return config->has_belief ? &config->believed : &config->lathe;
}

/// The keys that hold a number or a choice, for tools.
/// @return a line per key: section, key, number|whole|sign|choice, least, most, default (of a
/// choice
///         its index), choices in quotes, meaning; separated by tabs
const char *sim_config_keys(void);

/// Read a machine file of at most 1 MiB, without NUL bytes, over the present contents of *config.
/// @return false and *e on the first error
bool sim_config_load(sim_config_t *config, const char *path, common_error_t *e);

/// Read the text of a machine file from memory.
/// @param text  TOML of `size` bytes
/// @param name  for messages
/// @return      as sim_config_load()
bool sim_config_read(sim_config_t *config, const char *text, size_t size, const char *name,
                     common_error_t *e);

// Parameters of a controller

/// Bring all parameters into force at once. The interrupt must have taken the last change.
/// @return false and *e, with an acceptable value, when one is refused
bool sim_params_apply(cam_machine_t *machine, const cam_params_t *params, common_error_t *e);

// Whether a slow spindle counts as stopped for the controller.
//
// Below stopped_mrpm a spindle counts as stopped: with such a mean speed homing never ends, and a
// cut ends in the fault spindle_stopped when the speed stays below it for longer than stopped_ms.
// A modulated spindle may be that slow in a part of each turn. The check uses the speed demanded
// by the table. Just below the limit, lag and ripple of the spindle may still end the cut, and the
// noise of a coarse encoder may hide a slow spindle from the controller.

/// @return [s] longest time within a turn below stopped_mrpm, over all heights and 1440 angles; two
///         turns if it is always below
double sim_slow_longest_s(const cam_table_t *table, const cam_params_t *params, double mean_rpm);

/// @return false when a spindle of that mean speed counts as stopped
bool sim_slow_is_turning(const cam_table_t *table, const cam_params_t *params, double mean_rpm);

/// @param feasibility  for the mean speed, within all limits
/// @return             false and *e, with the remedy, when that speed is too slow
bool sim_slow_check(const cam_table_t *table, const cam_params_t *params,
                    const cam_refusal_t *feasibility, common_error_t *e);

#endif
