// SPDX-License-Identifier: Apache-2.0
/// sim_config: the machine file is read. It is TOML as far as a machine needs it:
///
///     # comment
///     [section]
///     key = 1.5          # number, true, false or "string"
///
/// Every key has a default; machines/default.toml lists and explains them all. Unknown keys, keys
/// given twice, and values that are no number or out of range are refused, and the message names
/// file, line, key, value and remedy. [controller] takes any parameter of cam_param.h.
///
/// [believed.SECTION] takes the keys of every other section but [machine] and [controller]: what
/// the controller is configured for, where that is not the truth. A key that is not given there is
/// believed to be what it is.
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

/// @return the lathe that the parameters of the controller are derived from
static inline const sim_lathe_config_t *sim_config_believed(const sim_config_t *config)
{
    return config->has_belief ? &config->believed : &config->lathe;
}

/// Read a machine file of at most 1 MiB, without NUL bytes, over the present content of *config.
/// @return false and *e on the first thing wrong
bool sim_config_load(sim_config_t *config, const char *path, common_error_t *e);

/// Read the text of a machine file, which is nowhere on a disk.
/// @param text  TOML of `size` bytes; changed by nobody
/// @param name  for messages
/// @return      as sim_config_load()
bool sim_config_read(sim_config_t *config, const char *text, size_t size, const char *name,
                     common_error_t *e);

#endif
