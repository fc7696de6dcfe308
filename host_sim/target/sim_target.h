// SPDX-License-Identifier: Apache-2.0
/// sim_target: processors that can run the firmware while the machine is simulated here.
#ifndef SIM_TARGET_H
#define SIM_TARGET_H

#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t

typedef struct {
    const char *name;   ///< of the board, for user and emulator
    const char *preset; ///< CMake preset that builds its image
} sim_target_t;

/// @return NULL and *e when there is no such target
const sim_target_t *sim_target_find(const char *name, common_error_t *e);

/// @return false when the image cannot be read; *e explains how to build it
bool sim_target_check_image(const sim_target_t *target, const char *image, common_error_t *e);

/// Find the image built along with this program, in the build folder of its preset.
/// @param path  buffer of `size` bytes
/// @return      false and *e when the location of this program is not known
bool sim_target_image(const sim_target_t *target, char *path, size_t size, common_error_t *e);

#endif
