// SPDX-License-Identifier: Apache-2.0
/// sim_config: reads machine files, in a subset of TOML:
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

#include "sim_controller.h" // sim_wishes_t
#include "common_error.h"   // common_error_t
#include "sim_lathe.h"      // sim_lathe_config_t
#include <stdbool.h>        // bool
#include <stddef.h>         // size_t

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

/// Read a machine file of at most 1 MiB, without NUL bytes, over the present contents of *config.
/// @return false and *e on the first error
bool sim_config_load(sim_config_t *config, const char *path, common_error_t *e);

/// Read the text of a machine file from memory.
/// @param text  TOML of `size` bytes
/// @param name  for messages
/// @return      as sim_config_load()
bool sim_config_read(sim_config_t *config, const char *text, size_t size, const char *name,
                     common_error_t *e);

#endif
